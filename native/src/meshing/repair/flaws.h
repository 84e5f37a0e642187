#pragma once

#include "complex/state.h"
#include "judge/findings.h"
#include "repair/repair.h"

namespace isimp::meshing {

/// Counts and lists the faults that the judge has found.
/// \param outcome  the function sets its counts and list of faults, and its work
void list_flaws(const State& state, const Findings& findings, RepairOutcome& outcome, const Job& job);

}  // namespace isimp::meshing
