#pragma once

#include "complex/state.h"
#include "judge/findings.h"
#include "repair/repair.h"

namespace isimp::meshing {

/// Counts what the judge finds wrong, and lists it.
/// \param outcome  of which this and the work are filled in
void list_flaws(const State& state, const Findings& findings, RepairOutcome& outcome);

}  // namespace isimp::meshing
