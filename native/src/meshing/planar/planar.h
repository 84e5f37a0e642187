#pragma once

#include <cstdint>
#include <vector>

#include "findings.h"
#include "isimp/core/job.h"
#include "isimp/meshing/polygonize.h"
#include "state.h"

namespace isimp::meshing::planar {

/// Largest distance of a corner from its polygon's plane, as a share of the diagonal, in double and rounded to float32.
constexpr double kPlanar = 1e-6;

struct Outcome {
  PlanarReport report;
  std::vector<std::int32_t> stuck;  ///< pieces with a polygon that could not be made planar, or not without a fault
};

/// Makes every polygon planar: planes and corners are moved together so that corners lie on all planes round them; a
/// corner that can't, within reach, is cut off its polygon by a triangle. What was not faulty before is not afterwards:
/// what the judge finds at fault holds its corners back, or is triangulated where they were.
/// \param findings  of the state as it is; up to date afterwards
/// Cost: about fifty sparse solves in three unknowns a polygon, and a judgement of all polygons.
Outcome make_planar(State& state, Findings& findings, const Job& job);

/// Whether all polygons are.
bool is_planar(const State& state);

}  // namespace isimp::meshing::planar
