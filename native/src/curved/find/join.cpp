// Joins adjacent patches that lie on one surface, and replaces surfaces by simpler ones that fit nearly as well.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "find/find.h"
#include "fit/numbers.h"
#include "fit/surfaces.h"

namespace isimp::curved {
namespace {

class Joiner {
 public:
  Joiner(std::vector<Found> found, const Points& points, const Nearness& near)
      : found_(std::move(found)), p_(points), near_(near) {}

  std::vector<Found> run(Job& job) {
    while (join_one()) job.poll();
    for (int k = 0; k < 3; ++k) take_in();
    for (std::size_t k = 0, n = found_.size(); k < n; ++k)
      if (found_[k].surface.kind == CurvedKind::revolution && !simplify(k)) split(k);
    return std::move(found_);
  }

 private:
  /// The share of the area of some points that a surface explains.
  /// \param turn  times that of the nearness
  [[nodiscard]] double explained(const CurvedSurface& s, const Some& some, double turn = kReach) const {
    double area = 0;
    const Locator on(s);
    for (const std::int32_t i : some)
      if (is_explained(on, i, turn)) area += p_.area[i];
    return area / p_.area_of(some);
  }

  [[nodiscard]] bool is_explained(const Locator& on, std::int32_t i, double turn = kReach) const {
    return near_.has(on.residual(p_.centre[i]), p_.normal[i], kReach, turn);
  }

  /// The points, of some, that a surface explains. A long region along a parallel has its centre inside the surface,
  /// and the profile would end there.
  [[nodiscard]] Samples explained_samples(const CurvedSurface& s, Some some) const {
    const Locator on(s);
    std::erase_if(some, [&](std::int32_t i) { return !is_explained(on, i); });
    return samples_of(p_, some);
  }

  bool join_one() {
    const Some own = owners(p_, found_);
    std::map<std::pair<std::int32_t, std::int32_t>, int> count;
    for (std::int32_t a = 0; a < p_.count(); ++a)
      for (const std::int32_t b : p_.near[a])
        if (own[a] != kNone && own[a] < own[b]) ++count[{own[a], own[b]}];
    std::vector<std::pair<int, std::pair<std::int32_t, std::int32_t>>> pairs;
    pairs.reserve(count.size());
    for (const auto& [pair, n] : count) pairs.emplace_back(-n, pair);
    std::sort(pairs.begin(), pairs.end());
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const auto& p) { return try_pair(p.second.first, p.second.second); });
  }

  bool try_pair(std::int32_t i, std::int32_t j) {
    const Found &a = found_[i], &b = found_[j];
    if (a.is_plane() && b.is_plane()) return false;
    Found both;
    both.points = a.points;
    both.points.insert(both.points.end(), b.points.begin(), b.points.end());
    std::sort(both.points.begin(), both.points.end());
    const Samples s = samples_of(p_, both.points);
    const auto surface = fit(CurvedKind::revolution, s);
    if (!surface) return false;
    const bool is_one = a.surface.kind == CurvedKind::revolution || b.surface.kind == CurvedKind::revolution;
    if (!is_seen(*surface, s) || !(is_one || surface->closed || turn_share(*surface, s) > kMost)) return false;
    if (explained(*surface, a.points) < kMost || explained(*surface, b.points) < kMost) return false;
    const Samples rest = explained_samples(*surface, both.points);
    both.surface = fit(CurvedKind::revolution, rest).value_or(*surface);
    if (explained(both.surface, both.points) < explained(*surface, both.points)) both.surface = *surface;
    both.area = a.area + b.area;
    both.rms = rms(both.surface, rest);
    const double apart = std::sqrt((a.area * a.rms * a.rms + b.area * b.rms * b.rms) / both.area);
    if (!is_one && !a.is_plane() && !b.is_plane() && both.rms > std::max(kNearlyAsWell * apart, kGood * near_.distance))
      return false;  // two simple surfaces, such as a cylinder and the cone on it
    found_.erase(found_.begin() + std::max(i, j));
    found_.erase(found_.begin() + std::min(i, j));
    found_.push_back(std::move(both));
    return true;
  }

  void take_in() {
    Some own = owners(p_, found_);
    for (std::size_t k = 0; k < found_.size(); ++k) {
      Found& f = found_[k];
      if (f.is_plane()) continue;
      const Locator on(f.surface);
      for (std::size_t at = 0; at < f.points.size(); ++at)
        for (const std::int32_t j : p_.near[f.points[at]]) {
          if (own[j] != kNone || p_.area[j] <= 0) continue;
          if (!is_explained(on, j)) continue;
          own[j] = static_cast<std::int32_t>(k);
          f.points.push_back(j);
        }
      std::sort(f.points.begin(), f.points.end());
      f.area = p_.area_of(f.points);
      const Samples s = explained_samples(f.surface, f.points);
      if (f.surface.closed && turn_share(f.surface, s) < kMost) continue;  // its pipes fix the axis of a bend better
      const auto again = fit(f.surface.kind, s);
      const double before = rms(f.surface, s);
      if (!again || rms(*again, s) >= 1.025 * before) continue;
      f.surface = *again;
      f.rms = rms(f.surface, s);
    }
  }

  /// The first simple surface that explains some points with at most a given root mean square distance.
  [[nodiscard]] std::optional<Found> simple(const Some& some, double most) const {
    if (some.size() < kLeastPoints) return std::nullopt;
    const Samples s = samples_of(p_, some);
    for (const CurvedKind kind : {CurvedKind::cylinder, CurvedKind::sphere, CurvedKind::cone}) {
      const auto surface = fit(kind, s);
      if (!surface || explained(*surface, some, 1) < kMost) continue;
      const double then = rms(*surface, s);
      if (then < most) return Found{*surface, some, p_.area_of(some), then};
    }
    return std::nullopt;
  }

  [[nodiscard]] double allowed(const Found& f) const {
    return std::max(kNearlyAsWell * rms(f.surface, explained_samples(f.surface, f.points)), kGood * near_.distance);
  }

  bool simplify(std::size_t k) {
    std::optional<Found> one = simple(found_[k].points, allowed(found_[k]));
    if (one) found_[k] = std::move(*one);
    return one.has_value();
  }

  /// Replaces a revolution by two simple surfaces, such as the cylinder and the cone of a silo.
  void split(std::size_t k) {
    const CurvedSurface& surface = found_[k].surface;
    const std::optional<double> at = profile_break(surface);
    if (!at) return;
    std::array<Some, 2> halves;
    const Locator on(surface);
    for (const std::int32_t i : found_[k].points) halves[on.at(p_.centre[i]).along < *at ? 0 : 1].push_back(i);
    const double most = allowed(found_[k]);
    std::optional<Found> low = simple(halves[0], most), high = simple(halves[1], most);
    if (!low || !high) return;
    found_[k] = std::move(*low);
    found_.push_back(std::move(*high));
  }

  std::vector<Found> found_;
  const Points& p_;
  const Nearness& near_;
};

}  // namespace

std::vector<Found> joined(std::vector<Found> found, const Points& points, const Nearness& near, Job& job) {
  return Joiner(std::move(found), points, near).run(job);
}

}  // namespace isimp::curved
