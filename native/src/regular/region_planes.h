#pragma once

#include <vector>

#include "complex/planes.h"
#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp::regular {

using meshing::Plane;

/// rounding: difference of two normals that are one direction; as a share of the diagonal, also of two offsets that are one.
constexpr double kSame = 1e-9;

/// A region of a partition as a plane: the best fit, and the given plane.
struct RegionPlane {
  Plane scan;
  double faces = 1;
  Vec3 normal = Vec3::UnitZ();  ///< of best fit, through the centre of `scan`
  Vec3 snapped = normal;        ///< normal of the given plane snapped * x = `offset`
  double offset = 0;

  [[nodiscard]] double best_offset() const { return normal.dot(scan.centre); }
};

/// The planes of best fit of all regions; one without area has scan.area 0.
/// Cost: O(F).
std::vector<RegionPlane> region_planes(const Mesh& mesh, const Partition& partition);

/// The upward direction, of length 1.
/// \throws InvalidInput  it has no direction: zero or not finite
Vec3 unit_up(const Vec3& up);

/// Mean square distance of a region from a plane.
double squared_distance(const RegionPlane& region, const Vec3& normal, double offset);

/// The root mean square distance of regions from their planes of best fit that half of the area has at most.
double median_distance(const std::vector<RegionPlane>& regions);

/// Directions, planes and distances of the given planes. The counts of kinds are left 0.
/// \param diagonal  of the mesh
/// Cost: O(R^2).
Regularity summary_of(const std::vector<RegionPlane>& regions, double diagonal, const Job& job);

}  // namespace isimp::regular
