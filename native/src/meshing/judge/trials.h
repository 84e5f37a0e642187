#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "complex/transaction.h"
#include "isimp/core/sorted.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Whether the corners of changed polygons keep their places, are placed again or are moved by the change itself. A
/// polygon that two halves make may be too bent at their corners' places, and flat at others.
enum class Places { kept, fresh, moved };

/// Tries a change of labels, corners or diagonals, or of corners' places. The change stays if no polygon has a new defect
/// or a new intersection by it, else it is undone. `Defects::renew_hits` must follow the last trial.
/// \param charts  charts that vanish by the change or get other diagonals; all charts at corners that it moves. The change
///                may list them.
/// \param whole  a chart that must have no defect afterwards, kNone for none
/// \param change  makes the change; returns false if it cannot be made
/// \param others  arrays outside the state that the change writes to
/// \return whether the change stays
/// Cost: `State::update_in_place` or `update`, and `Defects::accepts` of the changed polygons.
template <class Change, class... Arrays>
bool attempt(State& state, Defects& defects, const std::vector<std::int32_t>& charts, std::int32_t whole, Change change,
             Places places = Places::kept, Arrays&... others) {
  Transaction transaction(state, others...);
  if (!change()) return false;
  std::vector<std::int32_t> near;
  if (places != Places::moved) near = places == Places::kept ? state.update_in_place(charts) : state.update(charts);
  near.insert(near.end(), charts.begin(), charts.end());
  sort_unique(near);
  if (!defects.accepts(near, whole)) return false;
  transaction.commit();
  return true;
}

}  // namespace isimp::meshing
