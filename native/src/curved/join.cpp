// Joins adjacent patches that lie on one surface, and replaces surfaces by simpler ones that fit nearly as well.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "find.h"

namespace isimp::curved {
namespace {

constexpr int kSmoothBorders = 4;  ///< between two surfaces that may be one
constexpr std::size_t kSmall = 8;  ///< points of a plane that may be part of a revolution
constexpr double kKept = 0.85;     ///< share of each that the common surface must explain
constexpr double kFurther = 1.5;   ///< times the nearness, to be explained
constexpr double kTurnsMore = 1.3;
constexpr double kAllRound = 0.9;  ///< least share of a full turn to join two that are no revolutions
constexpr double kWorst = 0.8;     ///< share of the nearness: largest root mean square distance of the common surface
constexpr double kReach = 1.4;     ///< times the nearness, to be taken in
constexpr double kNearlyAsWell = 1.3;  ///< a simpler kind may be that much worse ...
constexpr double kAnyway = 0.2;        ///< ... or this share of the nearness

class Joiner {
 public:
  Joiner(std::vector<Found> found, const Points& points, const Nearness& near)
      : found_(std::move(found)), p_(points), near_(near) {}

  std::vector<Found> run(Job& job) {
    while (join_one()) job.poll();
    dissolve_planes();
    for (int k = 0; k < 3; ++k) take_in();
    for (Found& f : found_)
      if (f.surface.kind == CurvedKind::revolution) simplify(f);
    return std::move(found_);
  }

 private:
  [[nodiscard]] Some owners() const {
    Some own(p_.area.size(), kNone);
    for (std::size_t k = 0; k < found_.size(); ++k)
      for (const std::int32_t i : found_[k].points) own[i] = static_cast<std::int32_t>(k);
    return own;
  }

  /// The share of the area of some points that a surface explains.
  [[nodiscard]] double explained(const CurvedSurface& s, const Some& some, double turn) const {
    double area = 0;
    for (const std::int32_t i : some) {
      const Residual r = residual(s, p_.centre[i]);
      if (std::abs(r.distance) < kFurther * near_.distance && r.normal.dot(p_.normal[i]) > std::cos(turn))
        area += p_.area[i];
    }
    return area / p_.area_of(some);
  }

  bool join_one() {
    const Some own = owners();
    std::map<std::pair<std::int32_t, std::int32_t>, int> count;
    for (const auto& [a, b] : p_.edges)
      if (own[a] != kNone && own[b] != kNone && own[a] != own[b]) ++count[std::minmax(own[a], own[b])];
    std::vector<std::pair<int, std::pair<std::int32_t, std::int32_t>>> pairs;
    for (const auto& [pair, n] : count)
      if (n >= kSmoothBorders) pairs.emplace_back(-n, pair);
    std::sort(pairs.begin(), pairs.end());
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const auto& p) { return try_pair(p.second.first, p.second.second); });
  }

  bool try_pair(std::int32_t i, std::int32_t j) {
    const Found &a = found_[i], &b = found_[j];
    if (a.is_plane() && b.is_plane()) return false;
    if ((a.is_plane() || b.is_plane()) && std::min(a.points.size(), b.points.size()) > kSmall) return false;
    Found both;
    both.points = a.points;
    both.points.insert(both.points.end(), b.points.begin(), b.points.end());
    std::sort(both.points.begin(), both.points.end());
    const Samples s = samples_of(p_, both.points);
    const auto surface = fit(CurvedKind::revolution, s);
    if (!surface) return false;
    const double turn = kTurnsMore * near_.turn;
    const bool is_one = a.surface.kind == CurvedKind::revolution || b.surface.kind == CurvedKind::revolution;
    if (!is_seen(*surface, s) || !(is_one || surface->closed || turn_share(*surface, s) > kAllRound)) return false;
    if (explained(*surface, a.points, turn) < kKept || explained(*surface, b.points, turn) < kKept) return false;
    both.surface = *surface;
    both.area = a.area + b.area;
    both.rms = rms(*surface, s);
    if (both.rms > kWorst * near_.distance) return false;
    found_.erase(found_.begin() + std::max(i, j));
    found_.erase(found_.begin() + std::min(i, j));
    found_.push_back(std::move(both));
    return true;
  }

  /// Joins planes with a larger adjacent revolution or sphere that explains them, as the flat top of a torus.
  void dissolve_planes() {
    for (std::size_t k = 0; k < found_.size();) {
      const std::size_t into = found_[k].is_plane() ? dissolves_in(k) : found_.size();
      if (into == found_.size()) {
        ++k;
        continue;
      }
      Found& to = found_[into];
      to.points.insert(to.points.end(), found_[k].points.begin(), found_[k].points.end());
      std::sort(to.points.begin(), to.points.end());
      to.area += found_[k].area;
      found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  [[nodiscard]] std::size_t dissolves_in(std::size_t plane) const {
    const Some own = owners();
    for (std::size_t k = 0; k < found_.size(); ++k) {
      const Found& f = found_[k];
      if (f.surface.kind != CurvedKind::revolution && f.surface.kind != CurvedKind::sphere) continue;
      if (f.area < 2 * found_[plane].area) continue;
      const auto touches = [&](std::int32_t i) {
        return std::any_of(p_.near[i].begin(), p_.near[i].end(),
                           [&](std::int32_t j) { return own[j] == static_cast<std::int32_t>(k); });
      };
      const Some& some = found_[plane].points;
      if (explained(f.surface, some, 1.6 * near_.turn) > 0.8 && std::any_of(some.begin(), some.end(), touches))
        return k;
    }
    return found_.size();
  }

  void take_in() {
    Some own = owners();
    for (std::size_t k = 0; k < found_.size(); ++k) {
      Found& f = found_[k];
      if (f.is_plane()) continue;
      for (std::size_t at = 0; at < f.points.size(); ++at)
        for (const std::int32_t j : p_.near[f.points[at]]) {
          if (own[j] != kNone || p_.area[j] <= 0) continue;
          const Residual r = residual(f.surface, p_.centre[j]);
          if (std::abs(r.distance) >= kReach * near_.distance ||
              r.normal.dot(p_.normal[j]) <= std::cos(kReach * near_.turn))
            continue;
          own[j] = static_cast<std::int32_t>(k);
          f.points.push_back(j);
        }
      std::sort(f.points.begin(), f.points.end());
      f.area = p_.area_of(f.points);
      const Samples s = samples_of(p_, f.points);
      const auto again = fit(f.surface.kind, s);
      const double before = rms(f.surface, s);
      if (!again || rms(*again, s) >= 1.025 * before) continue;
      f.surface = *again;
      f.rms = rms(f.surface, s);
    }
  }

  void simplify(Found& f) const {
    const Samples s = samples_of(p_, f.points);
    const double now = rms(f.surface, s);
    for (const CurvedKind kind : {CurvedKind::cylinder, CurvedKind::sphere, CurvedKind::cone}) {
      const auto simple = fit(kind, s);
      if (!simple || explained(*simple, f.points, near_.turn) < 0.97) continue;
      const double then = rms(*simple, s);
      if (then >= std::max(kNearlyAsWell * now, kAnyway * near_.distance)) continue;
      f.surface = *simple;
      f.rms = then;
      return;
    }
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
