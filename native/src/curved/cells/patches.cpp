#include "cells/patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "find/face_labels.h"
#include "fit/numbers.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr double kOfTolerance = 0.3;  ///< times the tolerance: how near data is to its surface
constexpr double kOfNoise = 2.5;      ///< times the noise: how near data is to its surface at the least
constexpr double kNearTurn = 14 * std::numbers::pi / 180;  ///< between the normals of data and of its surface
constexpr int kFitSteps = 3;                               ///< steps of the last fit

/// The regions of a partition, as patches are compared with them.
class Before {
 public:
  Before(const Faces& faces, const Partition& part)
      : f_(faces), part_(part), area_(part.region_seed.size()), middle_(part.region_seed.size(), Vec3::Zero()) {
    for (std::int32_t i = 0; i < faces.size(); ++i)
      if (const std::int32_t r = region(i); r != kNone) {
        area_[r] += faces.area(i);
        middle_[r] += faces.area(i) * faces.centre(i);
      }
    for (std::size_t r = 0; r < area_.size(); ++r) middle_[r] /= std::max(area_[r], kTiny);
  }

  [[nodiscard]] std::int32_t region(std::int32_t i) const { return part_.face_region[f_.graph().mesh_face[i]]; }

  /// The number of regions that some faces make up: the sum of the share of each region's area that is theirs.
  [[nodiscard]] double regions_in(const Some& some) const {
    double sum = 0;
    for (const std::int32_t i : some)
      if (const double whole = area_[region(i)]; whole > 0) sum += f_.area(i) / whole;
    return sum;
  }

  /// The sum of area times squared distance of some faces from the planes of their regions.
  [[nodiscard]] double cost(const Some& some) const {
    double sum = 0;
    for (const std::int32_t i : some) {
      const std::int32_t r = region(i);
      if (r == kNone) continue;
      sum += f_.area(i) * std::pow(part_.region_normal[r].dot(f_.centre(i) - middle_[r]), 2);
    }
    return sum;
  }

 private:
  const Faces& f_;
  const Partition& part_;
  std::vector<double> area_;
  std::vector<Vec3> middle_;
};

/// The planes that are adjacent to a surface, and the number of edges to each.
std::map<std::int32_t, int> planes_beside(const Faces& faces, const Scene& scene, const Some& some) {
  std::map<std::int32_t, int> beside;
  for (const std::int32_t i : some)
    for (const std::int32_t j : faces.graph().neighbours[i]) {
      const std::int32_t k = j == faces.size() ? kNone : scene.label[j];
      if (k != kNone && scene.found[k].is_plane()) ++beside[k];
    }
  return beside;
}

/// A sphere's axis: the normal of the plane with the longest common border, else upright.
Vec3 sphere_axis(const Scene& scene, const std::map<std::int32_t, int>& beside) {
  std::int32_t best = kNone;
  for (const auto& [k, edges] : beside)
    if (best == kNone || edges > beside.at(best)) best = k;
  return best == kNone ? Vec3::UnitZ() : scene.found[best].surface.axis;
}

/// The largest plane along an axis, at which a segment looks.
Vec3 across(const Scene& scene, const Vec3& axis) {
  const Found* best = nullptr;
  for (const Found& f : scene.found)
    if (f.is_plane() && std::abs(f.surface.axis.dot(axis)) < kSquare && (best == nullptr || f.area > best->area))
      best = &f;
  if (best == nullptr) return frame(axis)[0];
  return (best->surface.axis - best->surface.axis.dot(axis) * axis).normalized();
}

void set_tangents(const Scene& scene, const std::map<std::int32_t, int>& beside, double near, RoundPatch& patch) {
  CurvedProxy& p = patch.proxy;
  if (p.kind != CurvedKind::cylinder || p.full) return;
  for (const auto& [k, edges] : beside) {
    const CurvedSurface& plane = scene.found[k].surface;
    const double gap = std::abs((p.point - plane.point).dot(plane.axis)) - p.radius;
    if (std::abs(plane.axis.dot(p.axis)) > kSquare || std::abs(gap) > kAlike * near) continue;
    const Vec3 to = p.side * (plane.axis - plane.axis.dot(p.axis) * p.axis);
    const double angle = std::atan2(to.dot(p.axis.cross(p.across)), to.dot(p.across));
    const double first = turned(angle - p.phase), last = turned(angle - p.phase - p.span);
    if (std::abs(first) <= std::abs(last) && patch.tangent[0] == kNone) {
      patch.tangent[0] = k;
      patch.first_angle = p.phase + first;
    } else if (std::abs(last) < std::abs(first) && patch.tangent[1] == kNone) {
      patch.tangent[1] = k;
      patch.last_angle = p.phase + p.span + last;
    }
  }
}

/// By surface: its faces.
std::vector<Some> members_of(const Faces& faces, const Scene& scene) {
  std::vector<Some> members(scene.found.size());
  for (std::int32_t i = 0; i < faces.size(); ++i)
    if (scene.label[i] != kNone) members[scene.label[i]].push_back(i);
  return members;
}

/// The surfaces fitted once more, to the faces themselves: one small region gives no exact normal, and the centres of small
/// regions lie a little inside a circle.
void fit_again(const Faces& faces, Scene& scene) {
  const std::vector<Some> members = members_of(faces, scene);
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (members[k].empty()) continue;
    Found& f = scene.found[k];
    const Samples s = samples_of(faces, members[k]);
    f.rms = rms(f.surface, s);
    if (has_profile(f.surface)) continue;
    CurvedSurface again = f.is_plane() ? *fit(CurvedKind::plane, s) : refined(f.surface, s, kFitSteps);
    const double then = rms(again, s);
    if (!f.is_plane() && !(again.radius > 0 && then < f.rms)) continue;
    f.surface = std::move(again);
    f.rms = then;
  }
}

/// Drops surfaces where the regions leave only the noise of a scan, and the surface leaves much more: sides of a prism.
void drop_prisms(const Faces& faces, const Before& before, Scene& scene, std::vector<bool>& kept) {
  const std::vector<Some> members = members_of(faces, scene);
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (members[k].empty() || scene.found[k].is_plane()) continue;
    double area = 0;
    for (const std::int32_t i : members[k]) area += faces.area(i);
    const double left = before.cost(members[k]) / area, rough = std::pow(scene.found[k].rms, 2);
    const double noise = std::pow(scene.near.noise, 2);
    if (left <= kQuarter * noise || left >= kHalf * std::min(rough, noise)) continue;
    kept[k] = false;
    scene.found[k].points.clear();
  }
}

/// Joins surfaces to extrusions, if the gates keep one of these; else the scene stays as it is.
void add_extrusions(const Faces& faces, Scene& scene, std::vector<bool>& kept, Job& job) {
  auto found = with_extrusions(faces, scene.points, scene.found, kept, scene.label, scene.near);
  if (!found) return;
  Scene next{scene.points, scene.near, std::move(*found), {}, {}};
  next.label = face_labels(faces, next.points, next.found, next.near, job);
  fit_again(faces, next);
  std::vector<bool> is_kept = kept_surfaces(faces, next.points, next.found, next.label, next.near);
  const auto is_good = [&](std::size_t k) { return is_kept[k] && next.found[k].surface.kind == CurvedKind::extrusion; };
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    if (!is_good(k)) continue;
    scene = std::move(next);
    kept = std::move(is_kept);
    return;
  }
}

}  // namespace

Scene find_patches(const Faces& faces, const Partition& part, std::span<const std::int32_t> small,
                   const RoundLengths& lengths, std::span<const std::uint8_t> stays, Job& job) {
  const Nearness near{std::max(kOfTolerance * lengths.tolerance, kOfNoise * lengths.noise), kNearTurn,
                      faces.mesh().diagonal(), lengths.noise};
  std::vector<std::uint8_t> locked;
  if (!part.region_locked.empty() || !stays.empty()) {
    locked.resize(static_cast<std::size_t>(faces.size()));
    for (std::int32_t i = 0; i < faces.size(); ++i) {
      const std::int32_t f = faces.graph().mesh_face[i], r = part.face_region[f];
      const bool is_locked = r != kNone && !part.region_locked.empty() && part.region_locked[r] != 0;
      locked[i] = is_locked || (!stays.empty() && stays[f] != 0);
    }
  }
  Scene scene{points_of(faces, small, locked, job), near, {}, {}, {}};
  // Bends first: a pipe and a part of its bend may pass for one surface of revolution.
  scene.found = with_bends(find_surfaces(scene.points, near, job), scene.points, near);
  scene.found = joined(std::move(scene.found), scene.points, near, job);
  if (std::all_of(scene.found.begin(), scene.found.end(), [](const Found& f) { return f.is_plane(); })) return scene;
  scene.label = face_labels(faces, scene.points, scene.found, near, job);
  fit_again(faces, scene);
  std::vector<bool> kept = kept_surfaces(faces, scene.points, scene.found, scene.label, near);
  const Before before(faces, part);
  drop_prisms(faces, before, scene, kept);
  add_extrusions(faces, scene, kept, job);
  for (std::int32_t i = 0; i < faces.size(); ++i)
    if (std::int32_t& k = scene.label[i];
        k != kNone && ((!kept[k] && !scene.found[k].is_plane()) || before.region(i) == kNone))
      k = kNone;
  std::vector<Some> members = members_of(faces, scene);
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (members[k].empty() || scene.found[k].is_plane()) continue;
    CurvedProxy proxy;
    static_cast<CurvedSurface&>(proxy) = scene.found[k].surface;
    const auto beside = planes_beside(faces, scene, members[k]);
    if (proxy.kind == CurvedKind::sphere) proxy.axis = sphere_axis(scene, beside);
    if (proxy.kind != CurvedKind::extrusion) proxy.across = across(scene, proxy.axis);
    const double cells = std::max(1.0, std::round(before.regions_in(members[k]))), cost = before.cost(members[k]);
    PatchFaces patch(faces, proxy, std::move(members[k]));
    set_span(proxy, patch);
    begin_at_border(faces, proxy, patch, cells);
    scene.patches.push_back({std::move(proxy), static_cast<std::int32_t>(k), std::move(patch), cells, cost});
    set_tangents(scene, beside, near.distance, scene.patches.back());
  }
  return scene;
}

}  // namespace isimp::curved
