#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// The target of the planes of chosen regions.
enum class Align : std::uint8_t {
  level,          ///< square to the upward direction
  upright,        ///< the nearest upright plane
  parallel,       ///< to the plane of the leading region
  perpendicular,  ///< to the plane of the leading region
  coplanar,       ///< one plane: that of the leading region if it is held, else the best fit of all
  free            ///< not held any more, also not by `regularise`: polygons fit them to the scan
};

/// Sets the planes of the regions of some faces. `polygonize` and `regularise` use them. An edit releases the planes of
/// the regions whose area it changes by a fifth or more. The first face's region leads: where others are made parallel
/// or perpendicular to it, its plane is held without a change. A plane is turned about the middle of its region.
///
/// \param faces   indices into mesh.triangles(), possibly several of one region
/// \param up      any length
/// \param length  the largest increase of the root mean square distance of a region, scene units; none: 1 % of the
///                diagonal
/// \return the partition with region_normal, region_offset, region_held and regularity set. regularity.length is
///         `length`, and snapped slopes count as parallel
/// \throws InvalidInput  no face; a face outside [0, F) or left out; one region where `to` needs two; a region that is
///                       square to the plane it should have; regions without area, which no plane fits; a plane that adds
///                       more than `length` ("needs X, allowed Y"); the partition is not one of this mesh; `up` has no
///                       direction, or `length` is not a finite number above 0
/// \throws Cancelled     nothing was made
/// Cost: O(F + R^2).
Partition align_planes(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, Align to,
                       const Vec3& up, std::optional<double> length, Job& job);

/// The plane of best fit of a region. Turning it about `centre` to another normal n adds
/// sqrt(n^T spread n - normal^T spread normal) to the root mean square distance of the region.
struct RegionFit {
  Vec3 normal;             ///< of length 1
  Vec3 centre;             ///< on it, relative to the mesh's origin
  Eigen::Matrix3d spread;  ///< covariance of the surface around `centre`
  double area = 0;         ///< 0: the region has no plane
};

/// \return (R) the fit of each region
/// \throws InvalidInput  the partition is not one of this mesh
/// Cost: O(F).
std::vector<RegionFit> region_fits(const Mesh& mesh, const Partition& partition);

}  // namespace isimp
