#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"

/// A bound that the polygons keep too: the distance of the scan from them, and the search for a smaller one.
namespace isimp {

/// The distance of a point from a triangle: from its plane if the foot lies inside, else from its sides.
double distance_to_triangle(const Vec3& point, const std::array<Vec3, 3>& triangle);

/// How distances are measured.
struct DistanceOptions {
  double enough = 0.0;       ///< scene units; a vertex this near to polygons of its own regions is not searched further
  std::int32_t threads = 0;  ///< as PartitionOptions::threads
  std::int32_t block = 1 << 10;  ///< vertices that a thread takes at a time; the result does not depend on it
};

/// (V) The distance of each vertex of the scan from the polygons, scene units; NaN where no face of it has a
/// region of which polygons are made.
///
/// The triangles of its own regions come first; if the distance to them is more than `enough`, all triangles are
/// searched. So a distance of at most `enough` may be less in truth.
/// \throws InvalidInput  the partition is of another mesh, or the polygons are of another partition
/// Cost: each vertex times the triangles of its regions; where that is too far, the triangles in a box of that size.
std::vector<double> scan_distances(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons,
                                   const DistanceOptions& options, Job& job);

/// The search for polygons near enough to the scan: borders and corners may use up half of the bound, then less; if
/// that is not enough, regions are made again with a lower bound, and so on.
class BoundSearch {
 public:
  struct Step {
    bool anew;          ///< make the partition again with `share` of its bound; else make polygons
    double share;       ///< for polygons: the share of the partition's bound half of which borders and corners use up
    double begin, end;  ///< progress in [0, 1]: each step gets half of the rest, as the number of steps is unknown
  };

  /// \param allowed  the distance that is near enough, scene units
  /// \param anew     whether another partition can be computed
  BoundSearch(double allowed, bool anew);

  /// nullopt: polygons are near enough, or all steps were tried.
  std::optional<Step> next();
  /// Must be called after each step that makes polygons.
  /// \return whether these polygons are nearer than all before
  bool take(double distance);
  [[nodiscard]] double allowed() const { return allowed_; }
  /// The number of times that polygons were made.
  [[nodiscard]] std::int32_t tries() const { return tries_; }

 private:
  Step step(bool anew, double share);

  double allowed_;
  bool anew_, found_ = false;
  std::size_t next_share_ = 0;
  double next_bound_;
  double done_ = 0.0;
  std::int32_t tries_ = 0;
  std::optional<double> least_;
};

/// The options with which polygons stay within half a bound of the planes of their regions; not looser than the given
/// ones.
MeshingOptions tightened(const Mesh& mesh, const Partition& partition, double bound, const MeshingOptions& given);

}  // namespace isimp
