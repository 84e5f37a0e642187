#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/moments.h"
#include "isimp/meshing/options.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// What is settled of a vertex before polygons are made, as on the border to a part whose polygons are there already.
enum class Fixed : std::uint8_t {
  no,
  place,   ///< where it becomes a corner, it stays at its place
  corner,  ///< it is a corner, at its place
};

/// The polygons of a part of a surface.
struct PolygonPart {
  PolygonMesh polygons;
  /// (F) of each face the first polygon of the piece that it is in, whose polygons stand in a row; kNone where it is in
  /// none.
  std::vector<std::int32_t> face_polygon;
};

/// As polygonize, of a part of a larger surface.
///
/// \param fixed  (V) of each vertex; empty: none is
/// \throws InvalidInput  as polygonize; `fixed` of another length; with MeshingOptions::planar, which moves all corners
PolygonPart polygonize_part(const Mesh& mesh, const Partition& partition, const MeshingOptions& options,
                            std::span<const SurfaceMoments> moments, std::span<const Fixed> fixed, Job& job);

/// Looks at the polygons of all parts together: fills in planarity, and what the report says of their number, planarity,
/// edges and fans; `crossing` and `intersecting` are those that no part could see: polygons that cross themselves, and
/// pairs from different parts that meet elsewhere than in what they share.
///
/// \param polygons  vertices, loops, loop_start and polygon_region are given
/// \param part      (Q) of each polygon
/// \throws InvalidInput  a part or a region for each polygon is missing, a corner names no vertex
/// Cost: O(corners log corners); no scan.
PolygonMesh judge_together(PolygonMesh polygons, std::span<const std::int32_t> part, const Job& job);

/// What tells where vertices lie that polygons of different parts share.
struct SeamPlaces {
  std::span<const Vec3> home;               ///< (W) where the scan's vertex lies that each vertex stands for
  std::span<const Vec3> vector_area;        ///< (Q) of the piece of surface that each polygon stands for
  std::span<const SurfaceMoments> moments;  ///< (Q) of it
  double diagonal = 0;                      ///< of the whole scan
  std::int32_t regions = 1;                 ///< of the whole scan
};

/// Puts the vertices that polygons of different parts share where the planes of all pieces round them meet, and makes
/// the polygons round them flat together with their other vertices, as `polygonize` does with all. Where that makes a
/// polygon faulty its vertices go back; where polygons of different parts meet, towards the scan.
///
/// \param polygons  as of judge_together
/// \return as of judge_together; in its report `flipped` and `bent` are polygons that were not so before
/// \throws InvalidInput  as judge_together; a place for a vertex or a polygon is missing; an option out of its range
/// Cost: O(polygons log polygons + corners round seams * rounds of flattening); no scan.
PolygonMesh settle_seams(PolygonMesh polygons, std::span<const std::int32_t> part, const SeamPlaces& places,
                         const MeshingOptions& options, const Job& job);

}  // namespace isimp
