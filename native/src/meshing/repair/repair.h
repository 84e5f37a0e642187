#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/judge.h"

namespace isimp::meshing {

/// The result of the repair: remaining defects, and counts of its actions.
struct RepairOutcome {
  std::int32_t crossing = 0, flipped = 0, bent = 0;  ///< polygons
  std::int64_t intersecting = 0, excused = 0;  ///< pairs of polygons; excused: their regions intersect in the scan
  bool excused_at_least = false;               ///< whether counting stopped at kMostCounted
  std::int32_t without_area = 0;               ///< polygons that are a face of the scan without area
  std::int32_t rounds = 0;
  std::int32_t joined = 0;  ///< pairs of junctions
  MeshingWork work;
  bool capped = false;  ///< something is left, and more splits were wanted than allowed
  PlanarReport planar;
  std::int32_t concave = 0, cut_to_be_convex = 0;
  RimReport rims;
  std::vector<std::int32_t> let_go;  ///< as PolygonMesh::planes_let_go
  /// As in MeshingReport, but polygons are numbered as in State and a pair is listed once.
  std::vector<ListedDefect> defects;
};

constexpr std::size_t kMostListed = 1000;         ///< limit: defects of a kind that a report lists
constexpr std::int64_t kMostCounted = 1'000'000;  ///< limit: pairs of the scan's own faces that are counted

/// Finds polygons that cross themselves, are flipped, are bent or intersect, and changes them and their neighbours
/// until none is left or nothing helps: pulls corners back to the mesh, adds corners, splits charts.
/// Then undoes changes that were not needed. Remaining defective polygons are replaced by the scan's own faces.
RepairOutcome repair(State& state, Job& job);

}  // namespace isimp::meshing
