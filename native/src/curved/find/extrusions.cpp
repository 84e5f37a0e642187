// Extrusions of a free profile: a moulding or a can is cylinders and planes of one direction that no gate keeps alone.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "find/find.h"
#include "fit/numbers.h"
#include "fit/surfaces.h"

namespace isimp::curved {
namespace {

class Extrusions {
 public:
  Extrusions(const Faces& faces, const Points& points, const std::vector<Found>& found, const std::vector<bool>& kept,
             const Some& label, const Nearness& near)
      : f_(faces), p_(points), found_(found), kept_(kept), label_(label), near_(near), own_(owners(points, found)) {}

  std::optional<std::vector<Found>> run() {
    std::vector<bool> is_used(found_.size(), false), is_tried = is_used;
    std::vector<Found> made, out;
    for (std::size_t k = 0; k < found_.size(); ++k) {
      if (is_tried[k] || found_[k].surface.kind != CurvedKind::cylinder) continue;
      const Some group = group_of(k, is_used);
      for (const std::int32_t i : group) is_tried[i] = true;
      std::optional<Found> one = fitted(group);
      if (!one) continue;
      for (const std::int32_t i : group) is_used[i] = true;
      made.push_back(std::move(*one));
    }
    if (made.empty()) return std::nullopt;
    for (std::size_t k = 0; k < found_.size(); ++k)
      if (!is_used[k]) out.push_back(found_[k]);
    std::move(made.begin(), made.end(), std::back_inserter(out));
    return out;
  }

 private:
  /// The surfaces that continue a cylinder smoothly along one direction, from one to the next, also over free points.
  [[nodiscard]] Some group_of(std::size_t first, const std::vector<bool>& is_used) const {
    const Vec3& axis = found_[first].surface.axis;
    std::vector<bool> is_in = is_used, is_met(p_.area.size(), false);
    Some group, points;
    const auto add = [&](std::int32_t k) {
      is_in[k] = true;
      group.push_back(k);
      points.insert(points.end(), found_[k].points.begin(), found_[k].points.end());
    };
    add(static_cast<std::int32_t>(first));
    for (std::size_t k = 0; k < points.size(); ++k)
      for (const std::int32_t j : p_.near[points[k]]) {
        const std::int32_t other = own_[j];
        if (is_met[j] || std::abs(p_.normal[j].dot(axis)) > kSquare) continue;
        is_met[j] = true;
        if (other == kNone)
          points.push_back(j);
        else if (!is_in[other] && is_along(other, axis))
          add(other);
      }
    std::sort(group.begin(), group.end());
    return group;
  }

  /// Whether a surface is a plane along a direction, or a curved one whose normals are square to it. A part of a cylinder
  /// may pass for a sphere.
  [[nodiscard]] bool is_along(std::int32_t k, const Vec3& axis) const {
    const Found& f = found_[k];
    if (f.is_plane()) return std::abs(f.surface.axis.dot(axis)) < kSquare;
    if (kept_[k] && f.surface.kind != CurvedKind::cylinder) return false;
    double square = 0;
    for (const std::int32_t i : f.points) square += std::abs(p_.normal[i].dot(axis)) < kSquare ? p_.area[i] : 0;
    return square > kMost * f.area;
  }

  /// Some faces, at equal steps.
  template <class IsIn>
  [[nodiscard]] Samples samples(IsIn is_in) const {
    Some all, some;
    for (std::int32_t i = 0; i < f_.size(); ++i)
      if (is_in(i)) all.push_back(i);
    const std::size_t step = all.size() / kMostSamples + 1;
    for (std::size_t k = 0; k < all.size(); k += step) some.push_back(all[k]);
    return samples_of(f_, some);
  }

  [[nodiscard]] std::optional<Found> fitted(const Some& group) const {
    if (group.size() < 2) return std::nullopt;
    Found now;
    for (const std::int32_t k : group)
      now.points.insert(now.points.end(), found_[k].points.begin(), found_[k].points.end());
    const std::size_t first = now.points.size();
    for (std::size_t before = 0; before < now.points.size();) {
      before = now.points.size();
      std::vector<bool> is_in(p_.area.size(), false);
      for (const std::int32_t i : now.points) is_in[i] = true;
      const Samples s = samples([&](std::int32_t i) { return p_.of_face[i] != kNone && is_in[p_.of_face[i]]; });
      auto surface = fit(CurvedKind::extrusion, s);
      if (!surface || (before == first && !is_nearer(*surface, group))) return std::nullopt;
      now.surface = std::move(*surface);
      now.rms = rms(now.surface, s);
      take_in(now);
    }
    now.area = p_.area_of(now.points);
    return now;
  }

  /// Whether an extrusion is nearer than kept cylinders to their faces, even if each of these is fitted to its own. One
  /// that it misses counts as near, since the profile may lack an end.
  [[nodiscard]] bool is_nearer(const CurvedSurface& extrusion, const Some& group) const {
    double its = 0, theirs = 0;
    for (const std::int32_t k : group) {
      if (!kept_[k] || found_[k].is_plane()) continue;
      const Samples s = samples([&](std::int32_t i) { return label_[i] == k; });
      its += found_[k].area * std::pow(std::min(rms(extrusion, s), near_.distance), 2);
      theirs += found_[k].area * std::pow(rms(fit(found_[k].surface.kind, s).value_or(found_[k].surface), s), 2);
    }
    return its <= theirs;
  }

  /// Adds free points that are on an extrusion and next to its points.
  void take_in(Found& f) const {
    std::vector<bool> is_in(p_.area.size(), false);
    for (const std::int32_t i : f.points) is_in[i] = true;
    const Locator on(f.surface);
    for (std::size_t k = 0; k < f.points.size(); ++k)
      for (const std::int32_t j : p_.near[f.points[k]]) {
        if (is_in[j] || own_[j] != kNone || p_.area[j] <= 0) continue;
        if (!near_.has(on.residual(p_.centre[j]), p_.normal[j], kReach, kReach)) continue;
        is_in[j] = true;
        f.points.push_back(j);
      }
    std::sort(f.points.begin(), f.points.end());
  }

  const Faces& f_;
  const Points& p_;
  const std::vector<Found>& found_;
  const std::vector<bool>& kept_;
  const Some& label_;
  const Nearness& near_;
  Some own_;  // by point: its surface
};

}  // namespace

std::optional<std::vector<Found>> with_extrusions(const Faces& faces, const Points& points,
                                                  const std::vector<Found>& found, const std::vector<bool>& kept,
                                                  const Some& label, const Nearness& near) {
  return Extrusions(faces, points, found, kept, label, near).run();
}

}  // namespace isimp::curved
