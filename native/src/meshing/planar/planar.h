// Makes polygons exactly planar.
#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "isimp/meshing/polygonize.h"
#include "judge/defects.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

struct PlanarOutcome {
  PlanarReport report;
  std::vector<std::int32_t> let_go;  ///< regions whose snapped planes were released, in rising order
  /// Charts with a polygon that could not be made planar, or not without a defect. If there is one, nothing has changed.
  std::vector<std::int32_t> stuck;
};

/// Makes every polygon planar: planes and corners are moved together so that corners lie on all their planes. A corner
/// that can't, within reach, is cut off its polygon by a triangle. No defect is added. A defective polygon (1) moves its
/// corners less, (2) is triangulated, (3) returns to its old positions. A chart is stuck if it has a defect there too. A
/// polygon that is planar at its old place is never cut for a defect.
/// \param is_last  stuck polygons keep their old shape, though it is not planar
/// \param defects  of the present state; up to date afterwards, unless a chart is stuck
/// Cost: about twenty sparse solves in three unknowns a polygon, and a judgement of the changed charts in each round.
PlanarOutcome make_planar(State& state, Defects& defects, bool is_last, const Job& job);

/// Whether all polygons are planar.
bool is_planar(const State& state);

}  // namespace isimp::meshing::planar
