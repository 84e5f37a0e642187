#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "complex/transaction.h"
#include "isimp/core/sorted.h"
#include "judge/findings.h"

namespace isimp::meshing {

/// Tries a change of labels, corners or diagonals. The change stays if no polygon has a new fault or a new intersection
/// by it, else it is undone. Corners that exist do not move. `Findings::renew_hits` must follow the last trial.
/// \param pieces  pieces that vanish by the change or get other diagonals
/// \param whole  a piece that must have no fault afterwards, kNone for none
/// \param change  makes the change; returns false if it cannot be made, after which it is undone
/// \return whether the change stays
/// Cost: `State::update_in_place` and `Findings::accepts` of the changed polygons.
template <class Change>
bool attempt(State& state, Findings& findings, std::vector<std::int32_t> pieces, std::int32_t whole, Change change) {
  Transaction transaction(state);
  if (!change()) return false;
  std::vector<std::int32_t> near = state.update_in_place(pieces);
  near.insert(near.end(), pieces.begin(), pieces.end());
  sort_unique(near);
  if (!findings.accepts(near, whole)) return false;
  transaction.commit();
  return true;
}

}  // namespace isimp::meshing
