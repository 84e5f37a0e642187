#include "snap_directions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "isimp/core/symmetric.h"

namespace isimp::regular {
namespace {

// tuned regular
constexpr int kFrames = 3;            ///< directions of walls, each with the directions square to it
constexpr double kMostOfArea = 0.75;  ///< share of the area along or square to an upward direction of its own
constexpr double kTimesOfUp = 2;  ///< least area along or square to such a direction, over the area of the given one
constexpr std::size_t kLargest = 12;  ///< regions among which an upward direction is searched

/// The normal that some regions fit best together.
Vec3 fitted_normal(const std::vector<Region>& regions, const Some& some) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::int32_t r : some) sum += regions[r].scan.area * regions[r].scan.spread;
  return spectrum_of(sum).vectors.col(0);
}

/// The parts of `some` for which a test holds and does not hold, each in the order of `some`.
template <class Test>
std::pair<Some, Some> parted(const Some& some, Test test) {
  std::pair<Some, Some> parts;
  for (const std::int32_t r : some) (test(r) ? parts.first : parts.second).push_back(r);
  return parts;
}

/// A region with a slope, and the direction along the walls in which it rises.
struct Slope {
  std::int32_t region;
  double rise, azimuth;
};

class Directions {
 public:
  Directions(std::vector<Region>& regions, const Some& all, const Limits& limits, const Compass& compass,
             const Job& job)
      : regions_(regions), all_(all), limits_(limits), compass_(compass), job_(job) {}

  void run() {
    Some left = all_;
    std::erase_if(left, [&](std::int32_t r) { return is_by_hand(r) || regions_[r].chosen == kPlaneFree; });
    if (compass_.has_up()) {
      take(left, Kind::level, [&](const Region&) { return compass_.up(); });
      snap_upright(left);
      snap_slopes(left);
    }
    snap_parallel(left);
  }

 private:
  [[nodiscard]] bool is_by_hand(std::int32_t r) const { return regions_[r].is_by_hand(); }
  [[nodiscard]] bool may(std::int32_t r, const Vec3& n) const { return limits_.allow(regions_[r], n); }

  /// Snaps the allowed ones to target(region), and removes them from `left`.
  /// \return the snapped ones
  template <class Target>
  Some take(Some& left, Kind kind, Target target) {
    job_.poll();
    auto [took, rest] = parted(left, [&](std::int32_t r) { return may(r, target(regions_[r])); });
    for (const std::int32_t r : took) regions_[r].snap(target(regions_[r]), kind);
    left = std::move(rest);
    return took;
  }

  /// Snaps regions to target(region) in place of their earlier target, if most of them may be; the others do not
  /// change.
  /// \return whether they were
  template <class Target>
  bool retake(const Some& took, Some& left, Kind kind, Target target) {
    const auto [some, others] = parted(took, [&](std::int32_t r) { return may(r, target(regions_[r])); });
    if (2 * others.size() >= took.size()) return false;
    for (const std::int32_t r : some) regions_[r].snap(target(regions_[r]), kind);
    for (const std::int32_t r : others) regions_[r].release();
    left.insert(left.end(), others.begin(), others.end());
    std::sort(left.begin(), left.end(), [&](auto a, auto b) {
      return std::pair(-regions_[a].scan.area, a) < std::pair(-regions_[b].scan.area, b);
    });
    return true;
  }

  [[nodiscard]] std::vector<const RegionPlane*> planes_of(const Some& some) const {
    std::vector<const RegionPlane*> planes;
    for (const std::int32_t r : some) planes.push_back(&regions_[r]);
    return planes;
  }

  /// Snaps upright regions along frames: first the frames of planes set by hand, then those with the largest area of
  /// votes, then one frame for each remaining region.
  void snap_upright(Some& left) {
    auto [upright, rest] = parted(left, [&](std::int32_t r) {
      const Vec3& n = regions_[r].normal;
      return std::abs(n.dot(compass_.up())) < std::sin(kWider * limits_.angle) && may(r, compass_.levelled(n));
    });
    left = std::move(rest);
    const auto along = [this](double frame) {
      return [this, frame](const Region& r) {
        return compass_.toward(Compass::nearest(frame, compass_.azimuth(r.normal)));
      };
    };
    const auto take_along = [&, &some = upright](double frame) {
      Some took = take(some, Kind::upright, along(frame));
      const double fitted = compass_.fitted(planes_of(took), frame);
      return retake(took, some, Kind::upright, along(fitted)) ? fitted : frame;
    };
    for (const std::int32_t lead : all_) {
      if (!is_by_hand(lead) || std::abs(regions_[lead].snapped.dot(compass_.up())) > kSame) continue;
      frames_.push_back(compass_.azimuth(regions_[lead].snapped));
      take(upright, Kind::upright, along(frames_.back()));
    }
    for (int k = 0; k < kFrames && !upright.empty(); ++k) {
      const std::size_t before = upright.size();
      const double frame = take_along(compass_.vote(planes_of(upright), limits_.angle));
      if (upright.size() == before) break;
      frames_.push_back(frame);
    }
    while (!upright.empty()) {
      const std::size_t before = upright.size();
      const std::int32_t first = upright[0];
      const double frame = compass_.azimuth(regions_[first].normal);
      take_along(frame);
      if (upright.size() < before) continue;
      regions_[first].snap(compass_.toward(frame), Kind::upright);
      upright.erase(upright.begin());
    }
  }

  /// The normal of a slope with another rise.
  [[nodiscard]] Vec3 normal_of(const Slope& s, double rise) const {
    return std::cos(rise) * compass_.toward(s.azimuth) + std::copysign(std::sin(rise), s.rise) * compass_.up();
  }

  /// Removes the regions that may rise along a frame from `left`.
  [[nodiscard]] std::vector<Slope> slopes_of(Some& left) const {
    std::vector<Slope> slopes;
    std::erase_if(left, [&](std::int32_t r) {
      const Vec3& n = regions_[r].normal;
      const double rise = std::atan2(n.dot(compass_.up()), compass_.levelled(n).dot(n));
      return std::any_of(frames_.begin(), frames_.end(), [&](double frame) {
        const double to = Compass::nearest(frame, compass_.azimuth(n));
        if (!may(r, std::cos(rise) * compass_.toward(to) + std::sin(rise) * compass_.up())) return false;
        slopes.push_back({r, rise, to});
        return true;
      });
    });
    return slopes;
  }

  /// Ridges and eaves level and along the walls, and equal slopes.
  void snap_slopes(Some& left) {
    std::vector<Slope> slopes = slopes_of(left);
    while (!slopes.empty()) {
      const double lead = std::abs(slopes[0].rise);
      const auto is_near = [&](const Slope& s) { return std::abs(std::abs(s.rise) - lead) < limits_.angle; };
      double sum = 0, weight = 0;
      for (const Slope& s : slopes)
        if (is_near(s)) {
          sum += regions_[s.region].scan.area * std::abs(s.rise);
          weight += regions_[s.region].scan.area;
        }
      const double mean = weight > 0 ? sum / weight : lead;
      job_.poll();
      std::vector<Slope> others;
      for (std::size_t k = 0; k < slopes.size(); ++k) {
        const Slope& s = slopes[k];
        const Vec3 n = normal_of(s, mean);
        if (is_near(s) && may(s.region, n)) {
          regions_[s.region].snap(n, Kind::slope);
        } else if (k == 0) {
          regions_[s.region].snap(normal_of(s, lead), Kind::slope);
        } else {
          others.push_back(s);
        }
      }
      slopes = std::move(others);
    }
  }

  void snap_parallel(Some& left) {
    for (const std::int32_t lead : all_)
      if (is_by_hand(lead)) take(left, Kind::parallel, [&](const Region&) { return regions_[lead].snapped; });
    while (!left.empty()) {
      const std::int32_t first = left[0];
      Vec3 n = regions_[first].normal;
      left.erase(left.begin());
      Some took = take(left, Kind::parallel, [&](const Region&) { return n; });
      if (took.empty()) continue;
      regions_[first].snap(n, Kind::parallel);
      took.insert(took.begin(), first);
      Vec3 fitted = fitted_normal(regions_, took);
      retake(took, left, Kind::parallel, [&](const Region&) { return fitted; });
    }
  }

  std::vector<Region>& regions_;
  const Some& all_;
  const Limits& limits_;
  const Compass& compass_;
  const Job& job_;
  std::vector<double> frames_;  // azimuths of walls
};

}  // namespace

double Limits::by_noise(const RegionPlane& region) const { return unsure * std::sqrt(3 / region.faces); }

double Limits::reach(const RegionPlane& region) const { return length + by_noise(region); }

bool Limits::allow(const RegionPlane& region, const Vec3& n) const {
  const Eigen::Matrix3d& spread = region.scan.spread;
  const double same = std::abs(region.normal.dot(n)),
               added = std::sqrt(std::max(0.0, n.dot(spread * n) - region.normal.dot(spread * region.normal)));
  if (same >= std::cos(kWider * angle) && added < hardly + by_noise(region)) return true;
  return same >= std::cos(usual) && added < reach(region);
}

Vec3 up_or_own(const std::vector<Region>& regions, const Some& all, const Limits& limits, const Vec3& up) {
  const bool is_led = std::any_of(all.begin(), all.end(), [&](std::int32_t r) { return regions[r].is_by_hand(); });
  if (up.squaredNorm() == 0 || is_led) return up;
  const auto area_about = [&](const Vec3& axis) {
    const Compass compass(axis);
    double sum = 0;
    for (const std::int32_t r : all) {
      const Region& region = regions[r];
      if (limits.allow(region, axis) || limits.allow(region, compass.levelled(region.normal))) sum += region.scan.area;
    }
    return sum;
  };
  double area = 0, most = kTimesOfUp * area_about(up);
  for (const std::int32_t r : all) area += regions[r].scan.area;
  Vec3 best = up;
  for (const std::int32_t r : std::span(all).first(std::min(all.size(), kLargest))) {
    const double sum = area_about(regions[r].normal);
    if (sum <= most || sum < kMostOfArea * area) continue;
    most = sum;
    best = regions[r].normal;
  }
  if (best == up) return up;
  Some level = all;
  std::erase_if(level, [&](std::int32_t r) { return !limits.allow(regions[r], best); });
  const Vec3 fitted = fitted_normal(regions, level);
  return fitted.dot(best) < 0 ? Vec3(-fitted) : fitted;
}

void snap_directions(std::vector<Region>& regions, const Some& all, const Limits& limits, const Compass& compass,
                     const Job& job) {
  Directions(regions, all, limits, compass, job).run();
}

}  // namespace isimp::regular
