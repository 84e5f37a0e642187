#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "complex/state.h"
#include "planar/meet.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// A set of numbers that wait for the next round.
class Waiting {
 public:
  explicit Waiting(std::size_t count) : has_(count, false) {}
  void add(std::int32_t i) {
    if (!has_[i]) some_.push_back(i);
    has_[i] = true;
  }
  [[nodiscard]] bool has(std::int32_t i) const { return has_[i]; }
  /// All, in the order in which they were added.
  [[nodiscard]] const std::vector<std::int32_t>& all() const { return some_; }
  /// Removes all.
  /// \return them in rising order
  std::vector<std::int32_t> take();

 private:
  std::vector<bool> has_;
  std::vector<std::int32_t> some_;
};

/// The planes and corners of a try to make polygons planar.
struct Draft {
  explicit Draft(const State& state);
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  /// Puts the waiting corners on their planes. Their units are cut in the next round.
  void place(State& state, const Job& job);
  /// The place of one corner on its planes; sets its entries of `kept`.
  Vec3 meet(std::int32_t corner) { return meet_at(corner, units, around, places, kept); }
  /// Reduces the reach of a corner, which is placed again in the next round.
  void lower(std::int32_t corner, double reach);
  /// Lists a unit and its corners for the next round.
  void ask(std::int32_t unit);
  /// The distance of a corner from its start.
  [[nodiscard]] double moved(std::int32_t corner) const { return (at[corner] - places.start[corner]).norm(); }
  /// The unit that the polygons of a chart are cut from.
  [[nodiscard]] std::int32_t unit_of(std::int32_t chart) const { return first[chart]; }

  std::vector<Unit> units;          ///< in the order of their charts
  std::vector<std::int32_t> first;  ///< by chart: its first unit
  Places places;
  const Around around;
  std::vector<Vec3> at;  ///< by corner
  Kept kept;
  Waiting moving, dirty;  ///< corners to be placed, and units to be cut, in the next round
};

}  // namespace isimp::meshing::planar
