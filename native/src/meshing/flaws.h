#pragma once

#include "findings.h"
#include "repair.h"
#include "state.h"

namespace isimp::meshing {

/// Counts what the judge finds wrong, and lists it.
/// \param outcome  of which this and the work are filled in
void list_flaws(const State& state, const Findings& findings, RepairOutcome& outcome);

}  // namespace isimp::meshing
