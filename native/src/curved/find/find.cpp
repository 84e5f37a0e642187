#include "find/find.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "fit/numbers.h"

namespace isimp::curved {
namespace {

constexpr double kDegree = std::numbers::pi / 180;  // unit
// tuned round
constexpr std::int32_t kSeeds = 20;          ///< a round
constexpr int kGrows = 4;                    ///< times that a surface is fitted again to the points that it reaches
constexpr double kLeastTurn = 0.3;           ///< least seen share of a full turn, of a revolution
constexpr double kWorst = 0.35;              ///< share of the score that a surface loses at the greatest mean distance
constexpr double kStillFree = 0.7;           ///< share of the area of a find that no other surface has taken
constexpr double kUntouched = 1 - 1e-9;      ///< rounding: the same for a second and further find of the same seeds
constexpr double kNotMuchSmaller = 0.4;      ///< times the area of the first find of some seeds: of others
constexpr double kPlaneTurn = 9 * kDegree;   ///< between the normals of a plane and of its points
constexpr std::array kBalls = {10, 30, 80};  ///< points to which a first surface is fitted
constexpr std::array kKinds = {CurvedKind::sphere, CurvedKind::cylinder, CurvedKind::cone, CurvedKind::revolution};

// Factors on the score: of kinds that explain the points alike, the simplest one is chosen. Free forms have 1.
constexpr double kPreferPlane = 1.25;    ///< factor on the score of a plane
constexpr double kPreferCylinder = 1.1;  ///< factor on the score of a cylinder
constexpr double kPreferOther = 1.05;    ///< factor on the score of a cone and of a sphere

double preference(CurvedKind kind) {
  switch (kind) {
    case CurvedKind::plane:
      return kPreferPlane;
    case CurvedKind::cylinder:
      return kPreferCylinder;
    case CurvedKind::cone:
    case CurvedKind::sphere:
      return kPreferOther;
    case CurvedKind::revolution:
    case CurvedKind::extrusion:
      return 1;
  }
  return 1;
}

struct Candidate {
  double score = 0;
  Found found;
};

class SurfaceSearch {
 public:
  SurfaceSearch(const Points& points, const Nearness& near)
      : p_(points), near_(near), is_free_(points.area.size(), true) {
    for (std::int32_t i = 0; i < points.count(); ++i)
      if (points.area[i] <= 0) is_free_[i] = false;
  }

  std::vector<Found> run(Job& job) {
    std::vector<Found> found;
    for (int round = 0;; ++round) {
      job.poll();
      const Some seeds = seeds_of(round);
      if (seeds.empty()) break;
      for (std::size_t k = 0; k < seeds.size(); ++k) try_seed(seeds[k], k % 2 == 0);
      std::optional<Found> best = choose(kStillFree);
      if (!best || best->area < kSpeck * total()) break;
      // Others of the same seeds are as good if they lose nothing to it and are not much smaller.
      for (const double least = std::max(kNotMuchSmaller * best->area, kSpeck * total()); best && best->area >= least;
           best = choose(kUntouched)) {
        for (const std::int32_t i : best->points) is_free_[i] = false;
        found.push_back(std::move(*best));
      }
      drop_taken();
    }
    return found;
  }

 private:
  /// Free points at equal steps of the sum of the roots of their areas: a large plane is one point among many specks of
  /// noise. The seeds of a round halve the steps of earlier rounds.
  [[nodiscard]] Some seeds_of(int round) const {
    double sum = 0;
    std::int32_t free = 0;
    for (std::int32_t i = 0; i < p_.count(); ++i)
      if (is_free_[i]) {
        sum += std::sqrt(p_.area[i]);
        ++free;
      }
    const std::int32_t count = std::min(kSeeds, free), pairs = round / 2;
    const double shift = std::fmod(0.5 * round + 0.25 * pairs, 1.0);
    Some seeds;
    double done = 0;
    for (std::int32_t i = 0, k = 0; i < p_.count() && k < count; ++i) {
      if (!is_free_[i]) continue;
      done += std::sqrt(p_.area[i]);
      if ((k + shift) * sum / count >= done) continue;
      seeds.push_back(i);
      while (k < count && (k + shift) * sum / count < done) ++k;
    }
    return seeds;
  }

  [[nodiscard]] double total() const {
    double sum = 0;
    for (const double a : p_.area) sum += a;
    return sum;
  }

  /// Free points near a given point, in the order of a breadth-first search.
  [[nodiscard]] Some ball(std::int32_t seed, std::size_t count) const {
    Some some = {seed};
    std::vector<bool> met(is_free_.size(), false);
    met[seed] = true;
    for (std::size_t k = 0; k < some.size() && some.size() < count; ++k)
      for (const std::int32_t j : p_.near[some[k]]) {
        if (!is_free_[j] || met[j] || some.size() >= count) continue;
        met[j] = true;
        some.push_back(j);
      }
    return some;
  }

  void try_seed(std::int32_t seed, bool revolutions) {
    const Some few = ball(seed, 8);
    if (!is_known(CurvedKind::plane, few))
      if (const auto plane = fit(CurvedKind::plane, samples_of(p_, few))) add(grow(*plane, seed));
    std::array<bool, kKinds.size()> is_open{true, true, true, true};
    for (const int size : kBalls) {
      const Some some = ball(seed, static_cast<std::size_t>(size));
      if (some.size() < kLeastPoints) continue;
      const Samples samples = samples_of(p_, some);
      for (std::size_t k = 0; k < kKinds.size(); ++k) {
        const CurvedKind kind = kKinds[k];
        if (!is_open[k] || (kind == CurvedKind::revolution && !revolutions) || is_known(kind, some)) continue;
        const auto first = fit(kind, samples);
        if (!first || first->radius > near_.size) continue;
        is_open[k] = has_profile(*first) || rms(*first, samples) < kAlike * near_.distance;
        if (!is_open[k]) continue;
        std::optional<Found> grown = grow(*first, seed);
        if (grown && is_curved(*grown)) add(std::move(grown));
      }
      if (some.size() < static_cast<std::size_t>(size)) break;
    }
  }

  /// Whether points are all on one good surface of a kind already.
  [[nodiscard]] bool is_known(CurvedKind kind, const Some& ball) const {
    return std::any_of(pool_.begin(), pool_.end(), [&](const Candidate& c) {
      const Found& f = c.found;
      return f.surface.kind == kind && f.rms < kGood * near_.distance &&
             std::all_of(ball.begin(), ball.end(),
                         [&](std::int32_t i) { return std::binary_search(f.points.begin(), f.points.end(), i); });
    });
  }

  void add(std::optional<Found> found) {
    if (!found) return;
    const double score =
        found->area * preference(found->surface.kind) * (1 - kWorst * std::min(1.0, found->rms / near_.distance));
    pool_.push_back({score, std::move(*found)});
  }

  [[nodiscard]] bool is_curved(const Found& f) const {
    if (f.points.size() < kLeastPoints) return false;
    const Samples s = samples_of(p_, f.points);
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = 0; i < s.size(); ++i) mean += s.weight[i] * s.normal[i];
    if (1 - mean.norm() < kFlat) return false;
    if (f.surface.kind != CurvedKind::revolution) return true;
    return is_seen(f.surface, s) && f.surface.radius >= 2 * near_.distance;
  }

  /// A surface with the free points that are on it and reached from the seed.
  [[nodiscard]] Found reached(const CurvedSurface& surface, std::int32_t seed) const {
    const double least = std::cos(surface.kind == CurvedKind::plane ? kPlaneTurn : near_.turn);
    const Locator on(surface);
    Found found{surface, {}, 0, 0};
    const auto is_on = [&](std::int32_t i) {
      const Residual r = on.residual(p_.centre[i]);
      if (std::abs(r.distance) >= near_.distance || r.normal.dot(p_.normal[i]) <= least) return false;
      found.area += p_.area[i];
      found.rms += p_.area[i] * r.distance * r.distance;
      return true;
    };
    Some& some = found.points;
    if (!is_on(seed)) return found;
    std::vector<bool> met(is_free_.size(), false);
    met[seed] = true;
    some.push_back(seed);
    for (std::size_t k = 0; k < some.size(); ++k)
      for (const std::int32_t j : p_.near[some[k]]) {
        if (!is_free_[j] || met[j]) continue;
        met[j] = true;
        if (is_on(j)) some.push_back(j);
      }
    std::sort(some.begin(), some.end());
    found.rms = std::sqrt(found.rms / found.area);
    return found;
  }

  [[nodiscard]] std::optional<Found> grow(CurvedSurface surface, std::int32_t seed) const {
    std::optional<Found> best;
    for (int round = 0; round < kGrows; ++round) {
      Found now = reached(surface, seed);
      if (now.points.empty()) return best;
      if (best && now.area <= best->area * (1 + kSpeck)) return best->area >= now.area ? best : now;
      best = std::move(now);
      if (best->points.size() < kLeastPoints) return best;
      const auto again = fit(surface.kind, samples_of(p_, best->points));
      if (!again) return best;
      surface = *again;
    }
    return best;
  }

  [[nodiscard]] double free_area(const Found& f) const {
    double area = 0;
    for (const std::int32_t i : f.points) area += is_free_[i] ? p_.area[i] : 0;
    return area;
  }

  /// \param share  the least share of a candidate that is free
  [[nodiscard]] std::optional<Found> choose(double share) const {
    const Candidate* best = nullptr;
    double most = 0;
    for (const Candidate& c : pool_) {
      if (c.score <= most) continue;
      const double area = free_area(c.found);
      if (area < share * c.found.area) continue;
      const double score = c.score * area / c.found.area;
      if (score <= most) continue;
      most = score;
      best = &c;
    }
    if (best == nullptr) return std::nullopt;
    Found found = best->found;
    std::erase_if(found.points, [&](std::int32_t i) { return !is_free_[i]; });
    found.area = p_.area_of(found.points);
    return found;
  }

  void drop_taken() {
    std::erase_if(pool_, [&](const Candidate& c) { return free_area(c.found) <= kStillFree * c.found.area; });
  }

  const Points& p_;
  const Nearness& near_;
  std::vector<bool> is_free_;
  std::vector<Candidate> pool_;
};

}  // namespace

Some owners(const Points& points, const std::vector<Found>& found) {
  Some own(points.area.size(), kNone);
  for (std::size_t k = 0; k < found.size(); ++k)
    for (const std::int32_t i : found[k].points) own[i] = static_cast<std::int32_t>(k);
  return own;
}

double turn_share(const CurvedSurface& surface, const Samples& samples) {
  constexpr std::size_t kSteps = 36;  // work
  std::array<bool, kSteps> seen{};
  const auto [u, w] = frame(surface.axis);
  for (const Vec3& x : samples.place) {
    const Vec3 v = x - surface.point;
    const double a = (std::atan2(v.dot(w), v.dot(u)) + std::numbers::pi) / (2 * std::numbers::pi);
    seen[std::min(kSteps - 1, static_cast<std::size_t>(a * kSteps))] = true;
  }
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / kSteps;
}

bool is_seen(const CurvedSurface& surface, const Samples& samples) {
  return turn_share(surface, samples) >= kLeastTurn;
}

std::vector<Found> find_surfaces(const Points& points, const Nearness& near, Job& job) {
  return SurfaceSearch(points, near).run(job);
}

}  // namespace isimp::curved
