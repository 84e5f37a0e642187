#include "isimp/regular/align_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/core/options.h"
#include "isimp/core/symmetric.h"
#include "kept_planes.h"
#include "region_planes.h"

namespace isimp::regular {
namespace {

// tuned regular
constexpr double kAllowed = 0.01;    ///< share of the diagonal
constexpr double kDirection = 0.05;  ///< length of a normal's part: below it, the direction of the turn is unknown

/// Regions with the face that named each, in the order of the faces.
struct Chosen {
  std::vector<std::int32_t> regions, faces;
};

Chosen chosen(const Partition& partition, std::span<const std::int32_t> faces) {
  if (faces.empty()) throw InvalidInput("there is no face: name one of each region");
  const auto count = static_cast<std::int32_t>(partition.face_region.size());
  Chosen found;
  for (const std::int32_t face : faces) {
    if (face < 0 || face >= count)
      throw InvalidInput("face must be in [0, " + std::to_string(count) + "), got " + std::to_string(face));
    const std::int32_t region = partition.face_region[face];
    if (region == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
    if (std::find(found.regions.begin(), found.regions.end(), region) != found.regions.end()) continue;
    found.regions.push_back(region);
    found.faces.push_back(face);
  }
  return found;
}

std::string in_short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// One plane for several regions, facing as the first.
/// \throws InvalidInput  none of them has an area
Plane together(const std::vector<RegionPlane>& planes, const Chosen& of) {
  const auto has_area = [&](std::int32_t r) { return planes[r].scan.area > 0; };
  if (std::none_of(of.regions.begin(), of.regions.end(), has_area))
    throw InvalidInput("the region of face " + std::to_string(of.faces[0]) +
                       " and the others have no area, so no plane fits them");
  Plane all = planes[of.regions[0]].scan;
  for (std::size_t k = 1; k < of.regions.size(); ++k) {
    const Plane& b = planes[of.regions[k]].scan;
    const double area = all.area + b.area, share = b.area / area;
    const Vec3 between = b.centre - all.centre;
    all.spread = (1 - share) * all.spread + share * b.spread + share * (1 - share) * between * between.transpose();
    all.centre += share * between;
    all.area = area;
  }
  const Vec3 n = spectrum_of(all.spread).vectors.col(0);
  all.normal = n.dot(planes[of.regions[0]].normal) < 0 ? Vec3(-n) : n;
  return all;
}

/// The part of a vector that is square to an axis, of length 1; none if the vector is along it.
std::optional<Vec3> square_to(const Vec3& axis, const Vec3& n) {
  const Vec3 rest = n - n.dot(axis) * axis;
  const double length = rest.norm();
  if (length < kDirection) return std::nullopt;
  return Vec3(rest / length);
}

/// The target normal of a region, not yet facing as the region; none if it can't be turned there. A held plane is
/// turned from its present normal, so that an upright one stays upright when it is made perpendicular to another.
std::optional<Vec3> target(Align to, const RegionPlane& region, const Vec3& lead, const Vec3& up) {
  switch (to) {
    case Align::level:
      return std::abs(region.normal.dot(up)) < kDirection ? std::nullopt : std::optional(up);
    case Align::upright:
      return square_to(up, region.snapped);
    case Align::perpendicular:
      return square_to(lead, region.snapped);
    case Align::parallel:
    case Align::coplanar:
      return std::abs(region.normal.dot(lead)) < kDirection ? std::nullopt : std::optional(lead);
    case Align::free:
      return region.normal;
  }
  return std::nullopt;
}

void count_kinds(Regularity& found, const Partition& part, const std::vector<RegionPlane>& planes, const Vec3& up) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].scan.area <= 0) continue;
    const double rise = std::abs(planes[i].snapped.dot(up));
    const bool is_snapped = part.region_held[i] == kPlaneSnapped;
    ++(part.region_held[i] == kPlaneByHand ? found.by_hand
       : !is_snapped                       ? found.free
       : rise > 1 - kSame                  ? found.level
       : rise < kSame                      ? found.upright
                                           : found.parallel);
  }
}

bool is_by_lead(Align to) { return to == Align::parallel || to == Align::perpendicular; }

/// The planes of regions: the held ones, and the best fit of the others.
std::vector<RegionPlane> planes_as_held(const Mesh& mesh, const Partition& partition) {
  std::vector<RegionPlane> planes = region_planes(mesh, partition);
  for (std::int32_t i = 0; i < partition.region_count(); ++i)
    if (partition.is_held(i)) {
      planes[i].snapped = partition.region_normal[i];
      planes[i].offset = partition.offset_from(mesh.origin(), i);
    }
  return planes;
}

/// Sets the normal and offset of the planes of the chosen regions. is_held: whether the first one is held.
/// \throws InvalidInput  as align_planes
void align(std::vector<RegionPlane>& planes, const Chosen& of, Align to, const Vec3& up, double allowed, bool is_held) {
  Vec3 normal = planes[of.regions[0]].snapped;
  double offset = planes[of.regions[0]].offset;
  if (to == Align::coplanar && !is_held) {
    const Plane all = together(planes, of);
    normal = all.normal;
    offset = normal.dot(all.centre);
  }
  for (std::size_t k = 0; k < of.regions.size(); ++k) {
    RegionPlane& region = planes[of.regions[k]];
    const std::string name = "the region of face " + std::to_string(of.faces[k]);
    const bool leads = is_by_lead(to) && k == 0;  // its plane is held
    const std::optional<Vec3> n = leads ? normal : target(to, region, normal, up);
    if (!n) throw InvalidInput(name + " is square to the plane that it should have");
    const double sign = region.normal.dot(*n) < 0 ? -1 : 1;
    region.snapped = sign * *n;
    const bool has_offset = leads || to == Align::coplanar;
    region.offset = has_offset ? sign * offset : region.snapped.dot(region.scan.centre);
    const double added = std::sqrt(std::max(0.0, squared_distance(region, region.snapped, region.offset) -
                                                     squared_distance(region, region.normal, region.best_offset())));
    if (to != Align::free && added > allowed)
      throw InvalidInput(name + " needs " + in_short(added) + ", allowed " + in_short(allowed));
  }
}

/// As align_planes, on the components that have regions.
Partition aligned(const Mesh& mesh, const Partition& partition, const Chosen& of, Align to, const Vec3& up,
                  std::optional<double> length, Job& job) {
  Job::Stage whole(job, "aligning planes", 0.0, 1.0);
  std::vector<RegionPlane> planes = planes_as_held(mesh, partition);
  job.poll();
  const double allowed = length.value_or(kAllowed * mesh.diagonal());
  align(planes, of, to, up, allowed, partition.is_held(of.regions[0]));
  Partition out = partition;
  out.bound = out.distance_max = 0;  // as after an edit
  out.region_held.resize(planes.size(), 0);
  out.region_offset.resize(planes.size());
  for (const std::int32_t r : of.regions) {
    out.region_held[r] = to == Align::free ? kPlaneFree : kPlaneByHand;
    if (!out.region_cell.empty()) out.region_cell[r] = {};
    out.region_normal[r] = to == Align::free ? partition.region_sum[r].normal() : planes[r].snapped;
    out.region_offset[r] = planes[r].offset + planes[r].snapped.dot(mesh.origin());
  }
  place_free_planes(mesh, out);
  Regularity found = summary_of(planes, mesh.diagonal(), job);
  count_kinds(found, out, planes, up);
  found.length = allowed;
  out.regularity = found;
  return out;
}

}  // namespace
}  // namespace isimp::regular

namespace isimp {

Partition align_planes(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, Align to,
                       const Vec3& up_direction, std::optional<double> length, Job& job) {
  check_is_of(mesh, partition);
  const Vec3 up = regular::unit_up(up_direction);
  if (length && !above(0).holds(*length))
    throw InvalidInput("length must be " + words(above(0), Unit::length) + ", got " + regular::in_short(*length));
  const regular::Chosen of = regular::chosen(partition, faces);
  if ((regular::is_by_lead(to) || to == Align::coplanar) && of.regions.size() < 2)
    throw InvalidInput("all faces are in one region: name faces of two or more");
  return regular::on_kept_planes(
      mesh, partition,
      [&](const Mesh& kept, const Partition& part) { return regular::aligned(kept, part, of, to, up, length, job); },
      job);
}

std::vector<RegionFit> region_fits(const Mesh& mesh, const Partition& partition) {
  check_is_of(mesh, partition);
  std::vector<RegionFit> fits;
  for (const regular::RegionPlane& region : regular::region_planes(mesh, partition))
    fits.push_back({region.normal, region.scan.centre, region.scan.spread, region.scan.area});
  return fits;
}

}  // namespace isimp
