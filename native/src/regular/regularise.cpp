#include "isimp/regular/regularise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "compass.h"
#include "isimp/core/check.h"
#include "isimp/core/sorted.h"
#include "kept_planes.h"
#include "region_planes.h"
#include "round_axes.h"
#include "snap_directions.h"

namespace isimp::regular {
namespace {

// tuned regular
constexpr double kOfMedian = 1.2;   ///< the default length, times the median distance of a region from its plane
constexpr double kUnsure = 3.5;     ///< times that distance * sqrt(3 / faces): uncertainty of a region's plane
constexpr double kMostAdded = 0.1;  ///< share of the root mean square distance that all planes together may add by
                                    ///< default
constexpr double kSure = 0.6;       ///< share of a given length: regions that move by less hardly move

/// Times the turn of half of the area: the largest turn of a plane by default. Where half of the area turns little, a
/// plane that is some degrees off its neighbours was made so.
constexpr double kTimesUsual = 10;
constexpr double kLeastTurn = std::numbers::pi / 180;  ///< a turn that is always allowed
constexpr double kLeastLength = 1e-5;                  ///< rounding: share of the diagonal

/// The regions of a partition, then one for each axis of its round parts.
std::vector<Region> regions_of(const Partition& partition, const std::vector<RegionPlane>& planes,
                               const RoundAxes& round, const Vec3& origin) {
  std::vector<Region> regions;
  for (const RegionPlane& plane : planes) {
    const std::size_t i = regions.size();
    Region& r = regions.emplace_back(Region{plane});
    if (partition.region_held.empty() || partition.region_held[i] == kPlaneSnapped) continue;
    r.chosen = partition.region_held[i];
    if (r.chosen == 0 || r.chosen == kPlaneFree) continue;
    r.kind = Kind::by_hand;
    r.snapped = partition.region_normal[i];
    r.offset = partition.offset_from(origin, static_cast<std::int32_t>(i));
  }
  for (std::size_t g = 0; g < round.size(); ++g) regions.emplace_back(Region{round.axis(g)});
  return regions;
}

Limits limits_of(const std::vector<RegionPlane>& planes, const RegulariseOptions& options, double diagonal) {
  Limits limits;
  limits.angle = limits.usual = options.angle * std::numbers::pi / 180;
  const double noise = median_distance(planes);
  limits.length = options.length.value_or(std::max(kOfMedian * noise, kLeastLength * diagonal));
  if (options.length) {
    limits.hardly = kSure * limits.length;
  } else {
    limits.unsure = kUnsure * noise;
  }
  return limits;
}

/// The turn that snapped planes have at most on half of their area.
double median_turn(const std::vector<Region>& regions, const Some& all) {
  std::vector<std::pair<double, double>> turns;
  double area = 0;
  for (const std::int32_t r : all) {
    if (regions[r].is_free() || regions[r].is_by_hand()) continue;
    turns.emplace_back(std::acos(std::min(1.0, regions[r].normal.dot(regions[r].snapped))), regions[r].scan.area);
    area += regions[r].scan.area;
  }
  std::sort(turns.begin(), turns.end());
  double sum = 0;
  for (const auto& [turn, share] : turns)
    if (2 * (sum += share) >= area) return turn;
  return 0;
}

/// The regions that have a plane of their own, the largest first.
Some largest_first(const std::vector<Region>& regions) {
  Some some = numbers_below(static_cast<std::int32_t>(regions.size()));
  std::erase_if(some, [&](auto r) { return regions[r].scan.area <= 0 || regions[r].chosen == kPlaneRound; });
  std::stable_sort(some.begin(), some.end(),
                   [&](auto a, auto b) { return regions[a].scan.area > regions[b].scan.area; });
  return some;
}

/// Makes nearly equal planes of one direction one plane: the one set by hand if there is one.
void align_offsets(std::vector<Region>& regions, Some all, const Limits& limits, const Job& job) {
  std::stable_partition(all.begin(), all.end(), [&](std::int32_t r) { return regions[r].is_by_hand(); });
  std::vector<bool> done(regions.size(), false);
  for (const std::int32_t lead : all) {
    if (done[lead] || regions[lead].is_free()) continue;
    job.poll();
    double sum = 0, area = 0;
    Some group;
    for (const std::int32_t r : all) {
      const Region& other = regions[r];
      const bool same = !done[r] && !other.is_free() && (r == lead || !other.is_by_hand()) &&
                        (other.snapped - regions[lead].snapped).norm() <= kSame &&
                        std::abs(other.offset - regions[lead].offset) < limits.reach(other);
      if (!same) continue;
      group.push_back(r);
      sum += other.scan.area * other.offset;
      area += other.scan.area;
    }
    const double offset = regions[lead].is_by_hand() ? regions[lead].offset : sum / area;
    for (const std::int32_t r : group) {
      regions[r].snapped = regions[lead].snapped;
      regions[r].offset = offset;
      done[r] = true;
    }
  }
}

/// Moves round parts to the axes that were snapped.
/// \param axes  one for each group of round parts
void move_round(RoundAxes& round, std::span<const Region> axes, const Limits& limits) {
  std::vector<double> reach;
  for (std::size_t g = 0; g < round.size(); ++g) {
    if (!axes[g].is_free()) round.turn(g, axes[g].snapped);
    reach.push_back(limits.reach(axes[g]));
  }
  round.share(reach);
}

/// Releases the planes that add most to the error, until all together add no more than kMostAdded.
/// \param all  planes of the partition that may be released, or were set by hand
/// \param least  smaller distances count as none
void release(std::vector<Region>& regions, const Some& all, RoundAxes& round, double least) {
  const auto first_axis = static_cast<std::int32_t>(regions.size() - round.size());
  double before = 0, now = 0, area = 0;
  std::vector<std::pair<double, std::int32_t>> order;
  for (const std::int32_t i : all) {
    const Region& r = regions[i];
    if (r.is_by_hand()) continue;  // set by a person
    area += r.scan.area;
    const double best = r.scan.area * squared_distance(r, r.normal, r.best_offset()),
                 snapped = r.scan.area * squared_distance(r, r.snapped, r.offset);
    before += best;
    now += snapped;
    if (!r.is_free()) order.emplace_back(best - snapped, i);
  }
  for (std::size_t g = 0; g < round.size(); ++g) {
    const double first = round.before(g), more = round.added(g);
    area += regions[first_axis + g].scan.area;
    before += first;
    now += first + more;
    if (more > 0) order.emplace_back(-more, first_axis + static_cast<std::int32_t>(g));
  }
  std::sort(order.begin(), order.end());
  const double most = (1 + kMostAdded) * (1 + kMostAdded) * std::max(before, area * least * least);
  for (const auto& [less, i] : order) {
    if (now <= most) return;
    now += less;
    regions[i].release();
    if (i >= first_axis) round.release(i - first_axis);
    regions[i].offset = regions[i].snapped.dot(regions[i].scan.centre);
  }
}

/// Stores the axes of round parts in a partition, and the planes of their cells in its regions. Removes the axes from
/// the regions.
RegularAxes store_round(Partition& out, const RoundAxes& round, std::vector<Region>& regions) {
  RegularAxes axes;
  for (const CellPlane& cell : round.cells()) {
    regions[cell.region].snapped = cell.normal;
    regions[cell.region].offset = cell.offset;
  }
  round.store(out.curved, axes);
  std::int32_t* const counts[] = {&axes.free, &axes.upright, &axes.level, &axes.parallel,
                                  &axes.parallel};  // a plane is square to its axis
  for (std::size_t r = regions.size() - round.size(); r < regions.size(); ++r)
    ++*counts[static_cast<std::size_t>(regions[r].kind)];
  regions.resize(regions.size() - round.size());
  return axes;
}

/// Calls fn(region, vertex) for each corner of each face that has a region.
template <class Function>
void for_each_corner(const Mesh& mesh, const Partition& part, Function fn) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (const std::int32_t r = part.face_region[f]; r != kNone)
      for (const std::int32_t v : mesh.triangles()[f]) fn(r, mesh.vertices()[v]);
}

/// Returns planes that leave the bound, and free planes, to the partition's own planes, which keep it.
void keep_bound(const Mesh& mesh, const Partition& partition, std::vector<Region>& regions) {
  std::vector<double> off(partition.region_seed.size(), 0);
  for_each_corner(mesh, partition, [&](std::int32_t r, const Vec3& p) {
    off[r] = std::max(off[r], std::abs(regions[r].snapped.dot(p) - regions[r].offset));
  });
  for (std::size_t r = 0; r < off.size(); ++r) {
    if (off[r] <= partition.bound && !regions[r].is_free()) continue;
    regions[r].kind = Kind::free;
    regions[r].snapped = partition.region_normal[r];
    regions[r].offset = partition.offset_from(mesh.origin(), static_cast<std::int32_t>(r));
  }
}

/// The largest distance of a vertex from the plane of its region.
double largest_distance(const Mesh& mesh, const Partition& part) {
  std::vector<double> offset;
  offset.reserve(static_cast<std::size_t>(part.region_count()));
  for (std::int32_t r = 0; r < part.region_count(); ++r) offset.push_back(part.offset_from(mesh.origin(), r));
  double most = 0;
  for_each_corner(mesh, part, [&](std::int32_t r, const Vec3& p) {
    most = std::max(most, std::abs(part.region_normal[r].dot(p) - offset[r]));
  });
  return most;
}

void store_planes(Partition& out, std::span<const Region> regions, const Vec3& origin) {
  out.region_offset.resize(regions.size());
  out.region_held.assign(regions.size(), 0);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Region& r = regions[i];
    if (r.scan.area <= 0) continue;
    const std::uint8_t snapped = r.is_free() ? 0 : kPlaneSnapped;
    out.region_held[i] = r.chosen != 0 ? r.chosen : snapped;
    out.region_offset[i] = r.offset + r.snapped.dot(origin);
    ISIMP_ASSERT(std::abs(r.snapped.squaredNorm() - 1) < 1e-6, "normals are unit vectors");
    out.region_normal[i] = r.snapped;
  }
}

Regularity summary(const std::vector<Region>& regions, double diagonal, const Job& job) {
  return summary_of({regions.begin(), regions.end()}, diagonal, job);
}

void count(Regularity& found, Kind kind) {
  std::int32_t* const counts[] = {&found.free,   &found.level,    &found.upright,
                                  &found.slopes, &found.parallel, &found.by_hand};  // in the order of Kind
  ++*counts[static_cast<std::size_t>(kind)];
}

/// As regularise, on the components that have regions.
Partition regularised(const Mesh& mesh, const Partition& partition, const RegulariseOptions& options, Job& job,
                      const Vec3& up) {
  Job::Stage whole(job, "regularising", 0.0, 1.0);
  const std::vector<RegionPlane> planes = region_planes(mesh, partition);
  const double least = kLeastLength * mesh.diagonal();
  Limits limits = limits_of(planes, options, mesh.diagonal());
  RoundAxes round(mesh, partition, planes);
  std::vector<Region> regions = regions_of(partition, planes, round, mesh.origin());
  job.report(0.5);
  Some all = largest_first(regions);
  const Vec3 own = up_or_own(regions, all, limits, up);
  if (!options.length) {
    std::vector<Region> first = regions;
    snap_directions(first, all, limits, Compass(own), job);
    limits.usual = std::min(limits.angle, std::max(kLeastTurn, kTimesUsual * median_turn(first, all)));
  }
  snap_directions(regions, all, limits, Compass(own), job);
  for (Region& r : regions)  // level and upright are words about the scene
    if (own != up && !r.is_free() && !r.is_by_hand()) r.kind = Kind::parallel;
  std::erase_if(all, [&](std::int32_t r) { return static_cast<std::size_t>(r) >= planes.size(); });
  for (const std::int32_t r : all)
    if (!regions[r].is_by_hand()) regions[r].offset = regions[r].snapped.dot(regions[r].scan.centre);
  align_offsets(regions, all, limits, job);
  move_round(round, std::span(regions).subspan(planes.size()), limits);
  if (!options.length) release(regions, all, round, least);
  job.poll();

  Partition out = partition;
  const RegularAxes axes = store_round(out, round, regions);
  if (partition.bound > 0) keep_bound(mesh, partition, regions);
  store_planes(out, regions, mesh.origin());
  Regularity found = summary(regions, mesh.diagonal(), job);
  if (partition.bound > 0) out.distance_max = largest_distance(mesh, out);
  for (const Region& r : regions)
    if (r.scan.area > 0 && r.chosen != kPlaneRound) count(found, r.kind);
  found.length = limits.length;
  found.axes = axes;
  out.regularity = found;
  return out;
}

}  // namespace
}  // namespace isimp::regular

namespace isimp {

Partition regularise(const Mesh& mesh, const Partition& partition, const RegulariseOptions& options, Job& job,
                     const std::optional<Vec3>& up_direction) {
  check_fields(options);
  check_is_of(mesh, partition);
  const Vec3 ups[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), Vec3::Zero()};
  const Vec3 up = up_direction ? regular::unit_up(*up_direction) : ups[static_cast<int>(options.up)];
  return regular::on_kept_planes(
      mesh, partition,
      [&](const Mesh& kept, const Partition& part) { return regular::regularised(kept, part, options, job, up); }, job);
}

}  // namespace isimp
