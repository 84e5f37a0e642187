#include "isimp/regular/hold_planes.h"

#include <cmath>
#include <string>
#include <vector>

#include "isimp/core/errors.h"
#include "kept_planes.h"
#include "region_planes.h"
#include "round_axes.h"

namespace isimp::regular {
namespace {

void check_number(const char* what, std::int32_t number, std::size_t count) {
  if (number < 0 || static_cast<std::size_t>(number) >= count)
    throw InvalidInput(std::string(what) + " must be in [0, " + std::to_string(count) + "), got " +
                       std::to_string(number));
}

bool is_unit(const Vec3& v) { return std::abs(v.norm() - 1) <= kSame; }  // also false where it is not finite

void check(const Partition& partition, std::span<const HeldPlane> planes, std::span<const HeldRound> round) {
  for (const HeldPlane& plane : planes) {
    check_number("region", plane.region, partition.region_seed.size());
    const std::string name = "the plane of region " + std::to_string(plane.region);
    if (!is_unit(plane.normal) || !std::isfinite(plane.offset)) throw InvalidInput(name + " is none");
    const bool is_cell = !partition.region_held.empty() && partition.region_held[plane.region] == kPlaneRound;
    if (is_cell || partition.is_left_out(plane.region)) throw InvalidInput(name + " can't be held");
  }
  for (const HeldRound& part : round) {
    check_number("the round part", part.number, partition.curved.size());
    if (!is_unit(part.axis) || !part.point.allFinite() || !(part.radius > 0) || !std::isfinite(part.radius))
      throw InvalidInput("the axis of round part " + std::to_string(part.number) + " is none");
  }
}

/// As hold_planes, on the components that have regions.
Partition held(const Mesh& mesh, const Partition& partition, std::span<const HeldPlane> planes,
               std::span<const HeldRound> round, Job& job) {
  Job::Stage whole(job, "aligning planes", 0.0, 1.0);
  std::vector<RegionPlane> regions = region_planes(mesh, partition);
  Partition out = partition;
  out.bound = out.distance_max = 0;  // as after an edit
  out.region_held.resize(regions.size(), 0);
  out.region_offset.resize(regions.size());
  RoundAxes axes(mesh, partition, regions);
  for (const HeldRound& part : round) axes.place(part.number, part.point - mesh.origin(), part.axis, part.radius);
  for (const CellPlane& cell : axes.cells()) {
    out.region_normal[cell.region] = cell.normal;
    out.region_offset[cell.region] = cell.offset + cell.normal.dot(mesh.origin());
  }
  RegularAxes counts;
  axes.store(out.curved, counts);
  for (const HeldPlane& plane : planes) {
    if (out.region_held[plane.region] != kPlaneByHand) out.region_held[plane.region] = kPlaneSnapped;
    out.region_normal[plane.region] = plane.normal;
    out.region_offset[plane.region] = plane.offset;
  }
  place_free_planes(mesh, out);
  if (!out.regularity) return out;
  for (std::int32_t r = 0; r < out.region_count(); ++r) {
    regions[r].snapped = out.region_normal[r];
    regions[r].offset = out.offset_from(mesh.origin(), r);
  }
  const Regularity found = summary_of(regions, mesh.diagonal(), job);
  out.regularity->directions = found.directions;
  out.regularity->planes = found.planes;
  out.regularity->rms = found.rms;
  return out;
}

}  // namespace
}  // namespace isimp::regular

namespace isimp {

Partition hold_planes(const Mesh& mesh, const Partition& partition, std::span<const HeldPlane> planes,
                      std::span<const HeldRound> round, Job& job) {
  check_is_of(mesh, partition);
  regular::check(partition, planes, round);
  return regular::on_kept_planes(
      mesh, partition,
      [&](const Mesh& kept, const Partition& part) { return regular::held(kept, part, planes, round, job); }, job);
}

}  // namespace isimp
