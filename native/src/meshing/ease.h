#pragma once

#include "findings.h"
#include "isimp/core/job.h"
#include "state.h"

namespace isimp::meshing {

/// Gives corners the freedom back that the repair took beyond need: those that were pulled back get all of their
/// radius, and those that `Complex::bend` added are dropped, all at once; then the corners of every polygon that became
/// faulty are made what they were, until there is none. Those that suffered for the sake of others get another chance
/// in a few turns, each with a share of them.
/// Cost: some twenty rounds of `State::update` and `Findings::judge`, each for what the one before changed.
void ease(State& state, Findings& findings, Job& job);

}  // namespace isimp::meshing
