// Makes polygons exactly planar.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "isimp/meshing/polygonize.h"
#include "judge/findings.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Largest distance of a corner from its polygon's plane, as a share of the diagonal, in double and rounded to float32.
constexpr double kPlanar = 1e-6;

/// What was found for polygons, by their corners: what a try tells the next one, before which some pieces were split.
struct Memory {
  std::map<std::vector<std::int32_t>, Unit> units;
  std::vector<double> reach;  ///< by corner
};

struct Outcome {
  PlanarReport report;
  std::vector<std::int32_t> let_go;  ///< regions whose snapped planes were let go, in rising order
  std::vector<std::int32_t> stuck;   ///< pieces with a polygon that could not be made planar, or not without a fault
};

/// Makes every polygon planar: planes and corners are moved together so that corners lie on all planes round them; a
/// corner that can't, within reach, is cut off its polygon by a triangle. What was not faulty before is not afterwards:
/// what the judge finds at fault holds its corners back, is triangulated, and at last has the very triangles and the
/// places of corners that the judge found faultless before. Only where such a triangle can't be a polygon of its own
/// (it would face away, or an edge of it is one of other polygons) the piece is stuck. A polygon that is planar where it
/// was is never cut for a fault.
/// \param is_last  what is stuck stays as it was, though it is not planar
/// \param findings  of the state as it is; up to date afterwards
/// \param memory  of the try before, replaced by that of this one
/// Cost: some twenty sparse solves in three unknowns a polygon, and a judgement of what changes from round to round.
Outcome make_planar(State& state, Findings& findings, Memory& memory, bool is_last, const Job& job);

/// Whether all polygons are.
bool is_planar(const State& state);

}  // namespace isimp::meshing::planar
