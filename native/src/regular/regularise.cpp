#include "isimp/regular/regularise.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "compass.h"
#include "even_spacing.h"
#include "isimp/core/errors.h"
#include "isimp/core/sorted.h"
#include "islands.h"
#include "region_planes.h"
#include "round_axes.h"

namespace isimp {
namespace {

using namespace regular;
using Some = std::vector<std::int32_t>;  ///< regions, the largest first

constexpr double kOfMedian = 1.2;      ///< the default length, times the median distance of a region from its plane
constexpr double kUnsure = 2;          ///< times that distance * sqrt(3 / faces): uncertainty of a region's plane
constexpr double kMostAdded = 0.1;     ///< share of the root mean square distance that all planes together may add by
                                       ///< default
constexpr double kLeastLength = 1e-5;  ///< share of the diagonal
constexpr double kSure = 0.6;          ///< below this share of the length, up to kWider times the angle is allowed
constexpr double kWider = 3;
constexpr int kFrames = 3;      ///< directions of walls, each with the directions square to it
constexpr double kSame = 1e-9;  ///< difference of two normals that are one direction
constexpr double kAnywhere = std::numeric_limits<double>::infinity();

/// The kind of each snapped plane.
enum class Kind : std::uint8_t { free, level, upright, slope, parallel, by_hand };

struct Region : RegionPlane {
  Kind kind = Kind::free;
  std::uint8_t chosen = 0;  ///< kPlaneByHand or kPlaneRound: its plane stays; kPlaneFree: it stays free; else 0
};

/// Snaps planes. The axis of a round part takes part as a plane that is square to it.
class Regulariser {
 public:
  Regulariser(const Mesh& mesh, const Partition& partition, const RegulariseOptions& options, const Vec3& up)
      : Regulariser(mesh, partition, region_planes(mesh, partition), options, up) {}

  Regulariser(const Mesh& mesh, const Partition& partition, const std::vector<RegionPlane>& planes,
              const RegulariseOptions& options, const Vec3& up)
      : mesh_(mesh),
        angle_(options.angle * std::numbers::pi / 180),
        is_even_(options.even_spacing),
        depth_(options.merge_islands),
        compass_(up),
        planes_(planes.size()),
        round_(mesh, partition, planes) {
    const double noise = median_distance(planes);
    for (const RegionPlane& plane : planes) {
      const std::size_t i = regions_.size();
      Region& r = regions_.emplace_back(Region{plane});
      if (partition.region_held.empty() || partition.region_held[i] == kPlaneSnapped) continue;
      r.chosen = partition.region_held[i];
      if (r.chosen == 0 || r.chosen == kPlaneFree) continue;
      r.kind = Kind::by_hand;
      r.snapped = partition.region_normal[i];
      r.offset = partition.region_offset[i];
    }
    for (std::size_t g = 0; g < round_.size(); ++g) regions_.emplace_back(Region{round_.axis(g)});
    least_ = kLeastLength * mesh.diagonal();
    length_ = options.length.value_or(std::max(kOfMedian * noise, least_));
    has_budget_ = !options.length;
    if (has_budget_) unsure_ = kUnsure * noise;
  }

  void run() {
    Some left = numbers_below(static_cast<std::int32_t>(regions_.size()));
    largest_first(left);
    std::erase_if(left, [&](auto r) { return regions_[r].scan.area <= 0 || regions_[r].chosen == kPlaneRound; });
    Some all = left;
    std::erase_if(left, [&](std::int32_t r) { return is_by_hand(r) || regions_[r].chosen == kPlaneFree; });
    if (compass_.has_up()) {
      take(left, Kind::level, [&](const Region&) { return compass_.up(); });
      snap_upright(left, all);
      snap_slopes(left);
    }
    snap_parallel(left, all);
    std::erase_if(all, [&](std::int32_t r) { return is_axis(r); });
    for (const std::int32_t r : all)
      if (!is_by_hand(r)) regions_[r].offset = regions_[r].snapped.dot(regions_[r].scan.centre);
    align_offsets(all);
    if (is_even_) space_evenly(all);
    move_round();
    if (has_budget_) release(all);
  }

  Partition result(const Partition& partition) {
    Partition out = partition;
    RegularAxes axes;
    take_round(out, axes);
    out.region_offset.resize(regions_.size());
    out.region_held.assign(regions_.size(), 0);
    Regularity found = summary_of({regions_.begin(), regions_.end()});
    for (std::size_t i = 0; i < regions_.size(); ++i) {
      const Region& r = regions_[i];
      if (r.scan.area <= 0) continue;
      const std::uint8_t snapped = r.kind == Kind::free ? 0 : kPlaneSnapped;
      out.region_held[i] = r.chosen != 0 ? r.chosen : snapped;
      out.region_offset[i] = r.offset;
      out.region_normal[i] = r.snapped;
    }
    if (depth_ > 0) merge_islands(out, found);
    for (const Region& r : regions_)
      if (r.scan.area > 0 && r.chosen != kPlaneRound) count(found, r.kind);
    found.length = length_;
    found.even = even_;
    found.axes = axes;
    out.regularity = found;
    return out;
  }

 private:
  [[nodiscard]] bool is_axis(std::int32_t r) const { return static_cast<std::size_t>(r) >= planes_; }

  /// Moves round parts to the axes that were snapped.
  void move_round() {
    std::vector<double> reach;
    for (std::size_t g = 0; g < round_.size(); ++g) {
      const Region& axis = regions_[planes_ + g];
      if (axis.kind != Kind::free) round_.turn(g, axis.snapped);
      reach.push_back(length_ + unsure(axis));
    }
    round_.share(reach);
  }

  /// Sets the planes of cells and the axes of their parts. Then there are only planes of regions.
  void take_round(Partition& out, RegularAxes& axes) {
    for (const CellPlane& cell : round_.cells()) {
      regions_[cell.region].snapped = cell.normal;
      regions_[cell.region].offset = cell.offset;
    }
    round_.store(out.curved, axes);
    std::int32_t* const counts[] = {&axes.free, &axes.upright, &axes.level, &axes.parallel,
                                    &axes.parallel};  // a plane is square to its axis
    for (std::size_t r = planes_; r < regions_.size(); ++r) ++*counts[static_cast<std::size_t>(regions_[r].kind)];
    regions_.resize(planes_);
  }

  /// Makes islands and their rims parts of their walls.
  void merge_islands(Partition& out, Regularity& found) {
    std::vector<RegionPlane*> planes;
    for (Region& r : regions_) planes.push_back(&r);
    std::vector<Region> left;
    for (const std::int32_t r : regular::merge_islands(mesh_, out, planes, depth_)) left.push_back(regions_[r]);
    regions_.swap(left);
    const double before = std::exchange(found, summary_of({regions_.begin(), regions_.end()})).rms_before;
    found.rms_before = before;
    found.islands_merged = static_cast<std::int32_t>(left.size() - regions_.size());
  }

  static void count(Regularity& found, Kind kind) {
    std::int32_t* const counts[] = {&found.free,   &found.level,    &found.upright,
                                    &found.slopes, &found.parallel, &found.by_hand};  // in the order of Kind
    ++*counts[static_cast<std::size_t>(kind)];
  }

  [[nodiscard]] bool is_by_hand(std::int32_t r) const { return regions_[r].kind == Kind::by_hand; }

  /// The increase of the root mean square distance of a region when its plane is turned about its middle.
  [[nodiscard]] double added(const Region& r, const Vec3& n) const {
    return std::sqrt(std::max(0.0, n.dot(r.scan.spread * n) - r.normal.dot(r.scan.spread * r.normal)));
  }
  /// The uncertainty of the plane of a region by noise: the fewer faces, the larger.
  [[nodiscard]] double unsure(const Region& r) const { return unsure_ * std::sqrt(3 / r.faces); }
  [[nodiscard]] bool may(std::int32_t i, const Vec3& n) const {
    const Region& r = regions_[i];
    const double same = std::abs(r.normal.dot(n)), cost = added(r, n);
    if (same >= std::cos(angle_)) return cost < length_ + unsure(r);
    return same >= std::cos(kWider * angle_) && cost < kSure * length_ + unsure(r);
  }
  void set(std::int32_t i, const Vec3& n, Kind kind) {
    regions_[i].snapped = regions_[i].normal.dot(n) < 0 ? Vec3(-n) : n;
    regions_[i].kind = kind;
  }

  void set_free(std::int32_t i) {
    regions_[i].snapped = regions_[i].normal;
    regions_[i].kind = Kind::free;
  }
  void largest_first(Some& some) const {
    std::sort(some.begin(), some.end(), [&](auto a, auto b) {
      return std::pair(-regions_[a].scan.area, a) < std::pair(-regions_[b].scan.area, b);
    });
  }

  /// Snaps the allowed ones to target(region), and removes them from `left`.
  /// \return the snapped ones
  template <class Target>
  Some take(Some& left, Kind kind, Target target) {
    Some took, rest;
    for (const std::int32_t r : left) {
      const Vec3 n = target(regions_[r]);
      if (may(r, n)) {
        set(r, n, kind);
        took.push_back(r);
      } else {
        rest.push_back(r);
      }
    }
    left = std::move(rest);
    return took;
  }

  /// Snaps regions to target(region) in place of their earlier target, if most of them may be; the others do not
  /// change.
  /// \return whether they were
  template <class Target>
  bool retake(const Some& took, Some& left, Kind kind, Target target) {
    Some others;
    for (const std::int32_t r : took)
      if (!may(r, target(regions_[r]))) others.push_back(r);
    if (2 * others.size() >= took.size()) return false;
    for (const std::int32_t r : took) set(r, target(regions_[r]), kind);
    for (const std::int32_t r : others) set_free(r);
    left.insert(left.end(), others.begin(), others.end());
    largest_first(left);
    return true;
  }

  [[nodiscard]] std::vector<const RegionPlane*> planes_of(const Some& some) const {
    std::vector<const RegionPlane*> planes;
    for (const std::int32_t r : some) planes.push_back(&regions_[r]);
    return planes;
  }

  /// \param all  regions; any of them set by hand lead
  void snap_upright(Some& left, const Some& all) {
    Some upright, rest;
    for (const std::int32_t r : left) {
      const Vec3& n = regions_[r].normal;
      const bool is = std::abs(n.dot(compass_.up())) < std::sin(kWider * angle_) && may(r, compass_.levelled(n));
      (is ? upright : rest).push_back(r);
    }
    const auto along = [this](double frame) {
      return [this, frame](const Region& r) {
        return compass_.toward(Compass::nearest(frame, compass_.azimuth(r.normal)));
      };
    };
    const auto take_along = [&](double frame) {
      Some took = take(upright, Kind::upright, along(frame));
      const double fitted = compass_.fitted(planes_of(took), frame);
      return retake(took, upright, Kind::upright, along(fitted)) ? fitted : frame;
    };
    for (const std::int32_t lead : all) {
      if (!is_by_hand(lead) || std::abs(regions_[lead].snapped.dot(compass_.up())) > kSame) continue;
      frames_.push_back(compass_.azimuth(regions_[lead].snapped));
      take(upright, Kind::upright, along(frames_.back()));
    }
    for (int k = 0; k < kFrames && !upright.empty(); ++k) {
      const std::size_t before = upright.size();
      const double frame = take_along(compass_.vote(planes_of(upright), angle_));
      if (upright.size() == before) break;
      frames_.push_back(frame);
    }
    while (!upright.empty()) {
      const std::size_t before = upright.size();
      const std::int32_t first = upright[0];
      const double frame = compass_.azimuth(regions_[first].normal);
      take_along(frame);
      if (upright.size() < before) continue;
      set(first, compass_.toward(frame), Kind::upright);
      upright.erase(upright.begin());
    }
    left = std::move(rest);
  }

  /// Ridges and eaves level and along the walls, and equal slopes.
  void snap_slopes(Some& left) {
    struct Slope {
      std::int32_t region;
      double rise, azimuth;
    };
    std::vector<Slope> slopes;
    Some rest;
    for (const std::int32_t r : left) {
      const Vec3& n = regions_[r].normal;
      const double rise = std::atan2(n.dot(compass_.up()), compass_.levelled(n).dot(n));
      bool found = false;
      for (const double frame : frames_) {
        const double to = Compass::nearest(frame, compass_.azimuth(n));
        if (!may(r, std::cos(rise) * compass_.toward(to) + std::sin(rise) * compass_.up())) continue;
        slopes.push_back({r, rise, to});
        found = true;
        break;
      }
      if (!found) rest.push_back(r);
    }
    left = std::move(rest);
    while (!slopes.empty()) {
      const double lead = std::abs(slopes[0].rise);
      double sum = 0, weight = 0;
      for (const Slope& s : slopes)
        if (std::abs(std::abs(s.rise) - lead) < angle_) {
          sum += regions_[s.region].scan.area * std::abs(s.rise);
          weight += regions_[s.region].scan.area;
        }
      const double mean = weight > 0 ? sum / weight : lead;
      const auto target = [&](const Slope& s, double rise) {
        return Vec3(std::cos(rise) * compass_.toward(s.azimuth) +
                    std::copysign(std::sin(rise), s.rise) * compass_.up());
      };
      std::vector<Slope> others;
      for (std::size_t k = 0; k < slopes.size(); ++k) {
        const Slope& s = slopes[k];
        const Vec3 n = target(s, mean);
        if (std::abs(std::abs(s.rise) - lead) < angle_ && may(s.region, n)) {
          set(s.region, n, Kind::slope);
        } else if (k == 0) {
          set(s.region, target(s, lead), Kind::slope);
        } else {
          others.push_back(s);
        }
      }
      slopes = std::move(others);
    }
  }

  /// The normal that some regions fit best together.
  [[nodiscard]] Vec3 fitted_normal(const Some& some) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const std::int32_t r : some) sum += regions_[r].scan.area * regions_[r].scan.spread;
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(0);
  }

  void snap_parallel(Some& left, const Some& all) {
    for (const std::int32_t lead : all)
      if (is_by_hand(lead)) take(left, Kind::parallel, [&](const Region&) { return regions_[lead].snapped; });
    while (!left.empty()) {
      const std::int32_t first = left[0];
      Vec3 n = regions_[first].normal;
      left.erase(left.begin());
      Some took = take(left, Kind::parallel, [&](const Region&) { return n; });
      if (took.empty()) continue;
      set(first, n, Kind::parallel);
      took.insert(took.begin(), first);
      Vec3 fitted = fitted_normal(took);
      retake(took, left, Kind::parallel, [&](const Region&) { return fitted; });
    }
  }

  /// Regions of one direction with nearly the same plane get one plane: the one set by hand if there is one.
  void align_offsets(Some all) {
    std::stable_partition(all.begin(), all.end(), [&](std::int32_t r) { return is_by_hand(r); });
    std::vector<bool> done(regions_.size(), false);
    for (const std::int32_t lead : all) {
      if (done[lead] || regions_[lead].kind == Kind::free) continue;
      double sum = 0, area = 0;
      Some group;
      for (const std::int32_t r : all) {
        const Region& other = regions_[r];
        const bool same = !done[r] && other.kind != Kind::free && (r == lead || !is_by_hand(r)) &&
                          (other.snapped - regions_[lead].snapped).norm() <= kSame &&
                          std::abs(other.offset - regions_[lead].offset) < length_ + unsure(other);
        if (!same) continue;
        group.push_back(r);
        sum += other.scan.area * other.offset;
        area += other.scan.area;
      }
      const double offset = is_by_hand(lead) ? regions_[lead].offset : sum / area;
      for (const std::int32_t r : group) {
        regions_[r].snapped = regions_[lead].snapped;
        regions_[r].offset = offset;
        done[r] = true;
      }
    }
  }

  /// Moves parallel planes to equal distances.
  void space_evenly(const Some& all) {
    std::vector<bool> done(regions_.size(), false);
    for (const std::int32_t lead : all) {
      if (done[lead] || regions_[lead].kind == Kind::free) continue;
      const Vec3 axis = regions_[lead].snapped;
      Some parallel;
      for (const std::int32_t r : all) {
        if (done[r] || regions_[r].kind == Kind::free || regions_[r].snapped.cross(axis).norm() > kSame) continue;
        done[r] = true;
        parallel.push_back(r);
      }
      space_evenly_along(axis, parallel);
    }
  }

  void space_evenly_along(const Vec3& axis, const Some& parallel) {
    std::vector<ParallelPlane> planes;
    std::vector<std::size_t> plane_of;
    for (const std::int32_t r : parallel) {
      const Region& region = regions_[r];
      const bool along = region.snapped.dot(axis) > 0;
      const double offset = along ? region.offset : -region.offset, middle = axis.dot(region.scan.centre),
                   reach = length_ + unsure(region);
      const auto same = std::find_if(planes.begin(), planes.end(), [&](const ParallelPlane& plane) {
        return plane.faces_along == along && std::abs(plane.offset - offset) <= kSame * (1 + std::abs(offset));
      });
      plane_of.push_back(static_cast<std::size_t>(same - planes.begin()));
      if (same == planes.end()) planes.push_back({offset, -kAnywhere, kAnywhere, 0, along, false});
      ParallelPlane& plane = planes[plane_of.back()];
      plane.area += region.scan.area;
      plane.low = std::max(plane.low, std::min(offset, middle - reach));
      plane.high = std::min(plane.high, std::max(offset, middle + reach));
      if (is_by_hand(r)) plane.is_fixed = true;
    }
    for (ParallelPlane& plane : planes)
      if (plane.is_fixed) plane.low = plane.high = plane.offset;
    const EvenSpacing found = even_spacing(planes, length_);
    even_ += found.planes;
    for (std::size_t k = 0; k < parallel.size(); ++k) {
      const std::size_t i = plane_of[k];
      if (found.offset[i] != planes[i].offset)
        regions_[parallel[k]].offset = planes[i].faces_along ? found.offset[i] : -found.offset[i];
    }
  }

  /// Releases the planes that add most to the error, until all together add no more than kMostAdded.
  void release(const Some& all) {
    double before = 0, now = 0, area = 0;
    std::vector<std::pair<double, std::int32_t>> order;
    for (const std::int32_t i : all) {
      const Region& r = regions_[i];
      if (is_by_hand(i)) continue;  // set by a person
      area += r.scan.area;
      const double best = r.scan.area * squared_distance(r, r.normal, r.best_offset()),
                   snapped = r.scan.area * squared_distance(r, r.snapped, r.offset);
      before += best;
      now += snapped;
      if (r.kind != Kind::free) order.emplace_back(best - snapped, i);
    }
    for (std::size_t g = 0; g < round_.size(); ++g) {
      const double first = round_.before(g), more = round_.added(g);
      area += regions_[planes_ + g].scan.area;
      before += first;
      now += first + more;
      if (more > 0) order.emplace_back(-more, static_cast<std::int32_t>(planes_ + g));
    }
    std::sort(order.begin(), order.end());
    const double most = (1 + kMostAdded) * (1 + kMostAdded) * std::max(before, area * least_ * least_);
    for (const auto& [less, i] : order) {
      if (now <= most) return;
      now += less;
      set_free(i);
      if (is_axis(i)) round_.release(i - planes_);
      regions_[i].offset = regions_[i].snapped.dot(regions_[i].scan.centre);
    }
  }

  const Mesh& mesh_;
  const double angle_;
  const bool is_even_;
  const double depth_;       // depth of rims behind which islands become part of their wall; 0: none do
  std::int32_t even_ = 0;    // planes at equal distances
  bool has_budget_ = false;  // else each plane's own length is the only bound
  double length_ = 0, unsure_ = 0;
  double least_ = 0;  // smaller distances count as none
  Compass compass_;
  std::size_t planes_;  // number of the partition's regions
  RoundAxes round_;
  std::vector<Region> regions_;  // those of the partition, then one for each axis
  std::vector<double> frames_;
};

}  // namespace

Partition regularise(const Mesh& mesh, const Partition& partition, const RegulariseOptions& options, Job& job,
                     const std::optional<Vec3>& up_direction) {
  check_fields(options);
  check_is_of(mesh, partition);
  const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), Vec3::Zero()};
  const Vec3 up = up_direction ? unit_up(*up_direction) : axes[static_cast<int>(options.up)];
  Job::Stage whole(job, "regularising", 0.0, 1.0);
  Regulariser regulariser(mesh, partition, options, up);
  job.report(0.5);
  regulariser.run();
  job.poll();
  return regulariser.result(partition);
}

}  // namespace isimp
