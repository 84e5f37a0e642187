#pragma once

#include "ease.h"
#include "findings.h"
#include "isimp/core/job.h"
#include "state.h"

namespace isimp::meshing {

/// Takes back what was done beyond need: removes diagonals and unites pieces that were parted with neighbours of the
/// same region, wherever no polygon becomes faulty by it. Many at a time that are not near each other; those by which
/// something became faulty are done again. What is plainly going to be faulty is not tried. Then corners are eased
/// (ease.h), and what they are free to do without now is tried again.
/// \param scope  diagonals and unions of other pieces are not tried
/// \return how many polygons are gone
/// Cost: up to eighty rounds of `State::update` and `Findings::judge`.
std::int32_t coarsen(State& state, Findings& findings, Scope scope, Job& job);

}  // namespace isimp::meshing
