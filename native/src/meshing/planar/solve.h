#pragma once

#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "planar/meet.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Finds planes on which as many corners as possible can be: planes are fitted together with corners, those that are given
/// and keep too many corners from the planes round them are let go, and corners that did not fit are left out then.
/// \param is_new  by unit: the planes of others stay where they are
/// Cost: some sixty rounds of `fit`.
void solve(std::vector<Unit>& units, const Around& around, const Places& places, const std::vector<bool>& is_new,
           const Threads& threads, const Job& job);

}  // namespace isimp::meshing::planar
