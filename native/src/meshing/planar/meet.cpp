#include "planar/meet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "isimp/core/sorted.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"

namespace isimp::meshing::planar {
namespace {

constexpr std::size_t kMostPlanes = 7;  ///< limit: planes at a corner that are tried in all combinations
constexpr int kRefinements = 3;         ///< work: of a least squares point
constexpr double kRank = 1e-7;          ///< rounding: singular values below this share of the largest fix nothing
// tuned planar
constexpr double kOfMissed = 0.5;  ///< weight of the plane of a polygon that is cut already
constexpr double kOfArea = 0.5;    ///< weight of a unit's share of the area at a corner, added to 1

struct Candidate {
  std::int32_t unit, place;
  double weight;
};

/// The point nearest to `from` on all of some planes; the least squares point if they do not meet.
Vec3 nearest_on(std::span<const Unit* const> planes, const Vec3& from) {
  const auto miss = [&](const Unit* u) { return u->offset - u->normal.dot(from); };
  if (planes.size() == 1) return from + miss(planes[0]) * planes[0]->normal;
  if (planes.size() == 2) {
    const Vec3 &a = planes[0]->normal, &b = planes[1]->normal;
    const double det = a.cross(b).squaredNorm(), same = a.dot(b), r = miss(planes[0]), s = miss(planes[1]);
    if (det > kRank) return from + ((r - same * s) * a + (s - same * r) * b) / det;
  }
  if (planes.size() == 3) {
    const Vec3 &a = planes[0]->normal, &b = planes[1]->normal, &c = planes[2]->normal;
    const Vec3 bc = b.cross(c);
    const double det = a.dot(bc);
    if (std::abs(det) > 1e-3)
      return from + (miss(planes[0]) * bc + miss(planes[1]) * c.cross(a) + miss(planes[2]) * a.cross(b)) / det;
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Unit* u : planes) sum += u->normal * u->normal.transpose();
  const Spectrum<3> spectrum = spectrum_of(sum);
  // The squares of the singular values lose half of the digits. Each further step on the remainder gains them back.
  Vec3 at = from;
  for (int step = 0; step < kRefinements; ++step) {
    Vec3 pull = Vec3::Zero();
    for (const Unit* u : planes) pull += (u->offset - u->normal.dot(at)) * u->normal;
    for (int k = 0; k < 3; ++k)
      if (spectrum.values[k] > kRank * kRank * spectrum.values[2])
        at += spectrum.vectors.col(k).dot(pull) / spectrum.values[k] * spectrum.vectors.col(k);
  }
  return at;
}

class Corner {
 public:
  Corner(const std::vector<Unit>& units, std::span<const Around::Use> uses, const Places& places, std::int32_t corner)
      : units_(units), places_(places), corner_(corner), tolerance_(kOnPlane * places.diagonal) {
    double area = 0;
    for (const auto& [u, place] : uses) area += units[u].scan.area;
    for (const auto& [u, place] : uses) {
      if (!units[u].binds()) continue;
      const double one = units[u].missed ? kOfMissed : 1;
      all_.push_back({u, place, one * (1 + kOfArea * units[u].scan.area / std::max(area, kTiny))});
    }
    std::stable_sort(all_.begin(), all_.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
    if (all_.size() > kMostPlanes) all_.resize(kMostPlanes);
  }

  /// \return the planes that the corner is on, as bits
  std::uint32_t place(Vec3& at) {
    best_at_ = places_.start[corner_];
    const auto n = static_cast<int>(all_.size());
    const std::uint32_t full = (1U << n) - 1;
    if (touched() == full) {  // it need not move
      at = best_at_;
      return full;
    }
    if (places_.reach[corner_] > 0) {
      if (n > 0) attempt(full);
      for (int size = n - 1; size > 0 && best_ == 0; --size)
        for (std::uint32_t set = 1; set < full; ++set)
          if (std::popcount(set) == size) attempt(set);
    }
    at = best_at_;
    return best_ | touched();
  }

  [[nodiscard]] const std::vector<Candidate>& all() const { return all_; }

 private:
  void attempt(std::uint32_t set) {
    planes_.clear();
    double weight = 0;
    for (std::size_t i = 0; i < all_.size(); ++i)
      if (set >> i & 1) {
        planes_.push_back(&units_[all_[i].unit]);
        weight += all_[i].weight;
      }
    if (weight < best_weight_) return;
    const Vec3 x = nearest_on(planes_, places_.start[corner_]);
    if (!x.allFinite() || !places_.allows(corner_, x)) return;
    for (const Unit* u : planes_)
      if (std::abs(u->normal.dot(x) - u->offset) > tolerance_) return;
    const double distance = (x - places_.start[corner_]).norm();
    if (weight == best_weight_ && distance >= best_distance_) return;
    best_ = set;
    best_weight_ = weight;
    best_distance_ = distance;
    best_at_ = x;
  }

  /// All planes that the best place lies on, also planes that were not chosen, such as two units of one wall.
  [[nodiscard]] std::uint32_t touched() const {
    std::uint32_t set = 0;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const Unit& u = units_[all_[i].unit];
      if (std::abs(u.normal.dot(best_at_) - u.offset) <= tolerance_) set |= 1U << i;
    }
    return set;
  }

  const std::vector<Unit>& units_;
  const Places& places_;
  const std::int32_t corner_;
  const double tolerance_;
  std::vector<Candidate> all_;
  std::vector<const Unit*> planes_;
  std::uint32_t best_ = 0;
  double best_weight_ = 0, best_distance_ = std::numeric_limits<double>::infinity();
  Vec3 best_at_ = Vec3::Zero();
};

}  // namespace

Around::Around(const std::vector<Unit>& units, std::int32_t corners) : start_(corners + 1, 0) {
  for (const Unit& u : units)
    for (const std::int32_t c : u.loop) ++start_[c + 1];
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  std::vector<std::int32_t> fill(start_.begin(), start_.end() - 1);
  uses_.resize(start_.back());
  for (std::size_t u = 0; u < units.size(); ++u)
    for (std::size_t i = 0; i < units[u].loop.size(); ++i)
      uses_[fill[units[u].loop[i]]++] = {static_cast<std::int32_t>(u), static_cast<std::int32_t>(i)};
}

std::vector<bool> within_rings(const std::vector<Unit>& units, const Around& around, std::vector<std::int32_t> rim,
                               int rings) {
  std::vector<bool> is_near(units.size(), false);
  for (; rings > 0; --rings) {
    std::vector<std::int32_t> next;
    for (const std::int32_t u : rim) {
      is_near[u] = true;
      for (const std::int32_t c : units[u].loop)
        for (const Around::Use& use : around.of(c))
          if (!is_near[use.unit]) next.push_back(use.unit);
    }
    sort_unique(next);
    rim = std::move(next);
  }
  return is_near;
}

Vec3 meet_at(std::int32_t corner, const std::vector<Unit>& units, const Around& around, const Places& places) {
  Vec3 at;
  Corner(units, around.of(corner), places, corner).place(at);
  return at;
}

Kept meet(const std::vector<Unit>& units, const Around& around, const Places& places, const Threads& threads,
          const Job& job, std::vector<Vec3>& at) {
  Kept kept(units.size());
  for (std::size_t u = 0; u < units.size(); ++u) kept[u].assign(units[u].loop.size(), 0);
  at.resize(places.start.size());
  const auto n = static_cast<std::int32_t>(places.start.size());
  threads.blocks(n, kBlock, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    job.poll();
    for (std::int32_t c = begin; c < end; ++c) {
      Corner corner(units, around.of(c), places, c);
      const std::uint32_t set = corner.place(at[c]);
      for (std::size_t i = 0; i < corner.all().size(); ++i)
        if (set >> i & 1) kept[corner.all()[i].unit][corner.all()[i].place] = 1;
    }
  });
  return kept;
}

}  // namespace isimp::meshing::planar
