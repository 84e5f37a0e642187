#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"
#include "isimp/meshing/options.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// The defects of a polygon.
enum class Defect : std::uint8_t {
  crossing,      ///< two of its edges meet
  no_area,       ///< thinner than a millionth of the diagonal
  flipped,       ///< faces away from the scan
  bent,          ///< by more than MeshingOptions::flatness
  intersecting,  ///< meets another polygon
  excused,       ///< meets another where the scan meets itself too; without another, a face of the scan without area
};

struct ListedDefect {
  std::int32_t polygon = 0;
  Defect kind = Defect::crossing;
  std::int32_t other = kNone;  ///< the polygon it meets; -1 for defects of its own
  auto operator<=>(const ListedDefect&) const = default;
};

/// The work of meshing, as counts that are the same on every machine and any number of threads.
struct MeshingWork {
  std::int64_t faces = 0;     ///< faces of the scan that were visited to find the faces of charts
  std::int64_t corners = 0;   ///< placements of corners
  std::int64_t polygons = 0;  ///< judgements of polygons
  bool operator==(const MeshingWork&) const = default;
};

/// The result of MeshingOptions::planar.
struct PlanarReport {
  bool asked = false;
  bool planar = false;               ///< every polygon is planar to a millionth of the diagonal, rounded to float32 too
  double whole = 0;                  ///< share of the polygons that were not cut, or would not have been
  std::int32_t faces_added = 0;      ///< faces added by cutting off corners; the sum of the counts below
  std::int32_t added_for_apart = 0;  ///< planes at a corner do not meet within reach
  std::int32_t added_for_crossing = 0, added_for_flipped = 0, added_for_meeting = 0;  ///< defect of the uncut polygon
  bool left_off = false;  ///< more than MeshingOptions::planar_most would have been cut: polygons are as without planar
  bool operator==(const PlanarReport&) const = default;
};

/// The result of straight rims; see MeshingOptions::straight_rims.
struct RimReport {
  double reach = 0;                      ///< how far rims may leave the border, scene units; 0: they follow it
  std::int32_t edges = 0;                ///< edges of polygons at the rim
  double area_added = 0, area_lost = 0;  ///< area between the border and the rims, scene units squared
  bool operator==(const RimReport&) const = default;
};

/// The counts of the result, and its defects.
struct MeshingReport {
  std::int32_t polygons = 0, corners = 0, vertices = 0;
  std::int32_t regions = 0;
  std::int32_t regions_split = 0;  ///< regions that became more than one polygon
  /// Polygons beyond one a region, by cause; the count for holes includes walls that were parted from their plate.
  std::int32_t split_for_unconnected = 0, split_for_holes = 0, split_for_handles = 0, split_for_pinches = 0,
               split_for_closed = 0, split_for_repair = 0;
  std::int32_t merged_without_area = 0;  ///< charts of regions that a neighbour took over, as they had no area
  std::int32_t joined_junctions = 0;     ///< pairs of vertices of three regions that became one vertex of four or five
  bool closed = false;                   ///< every edge has two polygons
  bool manifold = false;                 ///< every edge one or two, every vertex one fan, consistently oriented
  std::int64_t euler = 0;
  double planarity_max = 0.0, planarity_mean = 0.0;  ///< scene units; the mean is weighted by area
  double distance_max = 0.0;  ///< largest distance of a corner from the vertex it stands for, scene units
  std::int32_t crossing = 0, flipped = 0, bent = 0;  ///< remaining polygons; polygons of no area count as crossing
  std::int64_t intersecting = 0;                     ///< pairs of polygons that intersect though their regions do not
  std::int64_t excused = 0;                          ///< pairs of polygons whose regions intersect in the scan itself
  bool excused_at_least = false;  ///< there are more excused pairs: a million of the scan's faces were counted
  std::int32_t without_area = 0;  ///< polygons that are a face of the scan that has no area itself
  std::vector<ListedDefect>
      imperfect;  ///< the first 1,000 defects of each kind, by polygon, in rising order; a pair is listed under both
  std::int32_t repair_rounds = 0;
  MeshingWork work;
  bool repair_capped = false;  ///< a remaining defect needs more splits than repair_budget allows
  PlanarReport planar;
  std::int32_t concave = 0;           ///< polygons with a corner beyond 180 degrees, seen along their own normal
  std::int32_t cut_to_be_convex = 0;  ///< polygons added by MeshingOptions::convex
  RimReport rims;
  std::int32_t boxes = 0;          ///< boxes that replace regions; `polygons`, `corners`, `vertices` count them
  std::int32_t planes_let_go = 0;  ///< size of PolygonMesh::planes_let_go
  bool operator==(const MeshingReport&) const = default;
};

/// A mesh of simple polygons without holes.
struct PolygonMesh {
  std::vector<Vec3> vertices;            ///< (W) in the caller's coordinates, not relative to Mesh::origin
  std::vector<std::int32_t> loops;       ///< (L) vertex of each corner, polygon after polygon
  std::vector<std::int32_t> loop_start;  ///< (Q) where each polygon begins in `loops`; it ends where the next begins
  std::vector<std::int32_t> polygon_region;  ///< (Q)
  std::vector<double> planarity;             ///< (Q) largest distance of a corner from the polygon's plane, scene units
  std::vector<std::int32_t> source_vertex;   ///< (W) vertex of the mesh each stands for
  /// Regions whose plane `regularise` had snapped and polygons do not keep to, in rising order: a polygon would have a
  /// defect, or with MeshingOptions::planar, too many faces.
  std::vector<std::int32_t> planes_let_go;
  MeshingReport report;

  [[nodiscard]] std::int32_t polygon_count() const { return static_cast<std::int32_t>(loop_start.size()); }
  /// Where polygon q ends in `loops`.
  [[nodiscard]] std::int32_t loop_end(std::int32_t q) const {
    return q + 1 < polygon_count() ? loop_start[q + 1] : static_cast<std::int32_t>(loops.size());
  }
};

/// Turns the regions of a partition into polygons that meet edge to edge. Where faces without a region, or of a region
/// that is left out, border others, the polygons end there as at a border of the scan. Boxes that replace regions follow the
/// polygons of the others.
///
/// \throws InvalidInput  the partition is not one of this mesh; an option out of its range; all regions are left
///                       out
/// \throws Cancelled     nothing was made
/// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 4.
PolygonMesh polygonize(const Mesh& mesh, const Partition& partition, const MeshingOptions& options, Job& job);

}  // namespace isimp
