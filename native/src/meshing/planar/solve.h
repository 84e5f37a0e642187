#pragma once

#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "planar/meet.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Finds planes on which as many corners as possible can be: fits planes together with corners, releases snapped planes
/// that keep too many corners from their other planes, and repeats the fit without the corners that did not fit.
/// \param places  its largest moves are lowered at the corners of released planes
/// Cost: about sixty rounds of `fit`.
void solve(std::vector<Unit>& units, const Around& around, Places& places, const Threads& threads, const Job& job);

}  // namespace isimp::meshing::planar
