#pragma once

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/findings.h"
#include "place/ease.h"

namespace isimp::meshing {

/// By how much the scan misses the planes of the pieces, the mean of all.
struct Misses {
  double error = 0;   ///< sum of area * |n_face - n_piece|^2
  double square = 0;  ///< sum of area * square distance
};
Misses mean_misses(const State& state);

/// Takes back what was done beyond need: removes diagonals and unites pieces that were parted with neighbours, wherever
/// no polygon becomes faulty by it. Neighbours of the same region come first. One of another region has to be no smaller and
/// near the same plane, and the region that gives keeps a piece; what a region had apart from the rest stays in it. Many
/// at a time that are not near each other; those by which something became faulty are done again. What is plainly going
/// to be faulty is not tried. Then corners are eased (ease.h), and what they are free to do without now is tried again.
/// \param usual  what regions miss: that by which a union of two regions may rise is a share of it
/// \param scope  diagonals and unions of other pieces are not tried
/// \return how many polygons are gone
/// Cost: up to eighty rounds of `State::update` and `Findings::judge`.
std::int32_t coarsen(State& state, Findings& findings, const Misses& usual, Scope scope, Job& job);

}  // namespace isimp::meshing
