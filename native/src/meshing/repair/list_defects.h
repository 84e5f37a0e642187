#pragma once

#include "complex/state.h"
#include "judge/defects.h"
#include "repair/repair.h"

namespace isimp::meshing {

/// Counts and lists the defects that the judge has found.
/// \param outcome  the function sets its counts and list of defects, and its work
void list_defects(const State& state, const Defects& defects, RepairOutcome& outcome, const Job& job);

}  // namespace isimp::meshing
