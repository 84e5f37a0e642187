#pragma once

#include <array>
#include <cmath>
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
  explicit Waiting(std::size_t count = 0) : has_(count, false) {}
  void add(std::int32_t i) {
    if (!has_[i]) some_.push_back(i);
    has_[i] = true;
  }
  [[nodiscard]] bool has(std::int32_t i) const { return has_[i]; }
  /// Removes all.
  /// \return them in rising order
  std::vector<std::int32_t> take();

 private:
  std::vector<bool> has_;
  std::vector<std::int32_t> some_;
};

/// A try to make polygons planar: planes, and limits of corners. The state has the places of corners and the cuts.
struct Draft {
  /// Finds the planes.
  Draft(State& state, const Job& job);
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  /// Puts the waiting corners on their planes. Their units are cut in the next round.
  void place(const Job& job);
  /// The place of one corner on its planes.
  [[nodiscard]] Vec3 meet(std::int32_t corner) const { return meet_at(corner, units, around, places); }
  /// Whether a corner is on the plane of a unit.
  [[nodiscard]] bool is_on(const Unit& unit, std::int32_t corner) const {
    return std::abs(unit.normal.dot(state.corners.position[corner]) - unit.offset) <= kOnPlane * places.diagonal;
  }
  /// Whether a polygon is planar.
  [[nodiscard]] bool is_flat(std::span<const std::int32_t> polygon) const {
    return planar::is_flat(polygon, state.corners.position, places.diagonal);
  }
  /// Reduces the reach of a corner, which is placed again in the next round.
  void lower(std::int32_t corner, double reach);
  /// Lists a unit and its corners for the next round.
  void ask(std::int32_t unit);
  /// The distance of a corner from its start.
  [[nodiscard]] double moved(std::int32_t corner) const {
    return (state.corners.position[corner] - places.start[corner]).norm();
  }
  /// The number of polygons that cuts have added to a unit.
  [[nodiscard]] std::int32_t added(const Unit& unit) const {
    return static_cast<std::int32_t>(state.diagonals[unit.chart].size());
  }

  State& state;
  Logged<Unit> units;                 ///< in the order of their charts
  std::vector<std::int32_t> unit_of;  ///< by chart: the unit that its polygons are cut from
  Places places;
  Around around;
  /// By corner: the corners above it that an edge of a polygon joins it with. An edge of two polygons stands twice.
  Logged<std::vector<std::int32_t>> beyond;
  Waiting moving, dirty;  ///< corners to be placed, and units to be cut, in the next round
};

}  // namespace isimp::meshing::planar
