#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isimp::meshing {

/// The actions against the defects of a chart.
enum class Action : std::uint8_t {
  pull,        ///< move the corners of the chart halfway back to the scan
  add_corner,  ///< add a corner on one of two chords that cross, else split
  split,       ///< split the chart in two
};

/// A plan: the actions for the first, second, third ... time that a chart is found defective.
///
/// How often an action leaves the chart, or both halves of it, without a defect in the next round; scans, buildings,
/// household things and nasty meshes at 30 to 1,000 regions (39,000 actions):
///
/// | chart      | pull | add_corner | split |
/// |------------|------|------------|-------|
/// | crossing   | .30  | .23        | .25   |
/// | flipped    | .59  |            | .33   |
/// | meeting    | .28  |            | .26   |
/// | bent       |      |            | .23   |
///
/// So pulls, which cost no polygon, come first. Source: own trials.
using Plan = std::span<const Action>;

namespace plans {
using enum Action;
inline constexpr std::array kForCrossing{pull,  add_corner, pull,  add_corner, split, pull,  split,
                                         split, pull,       split, split,      pull,  split, split};
inline constexpr std::array kForFlipped{pull, pull,  split, split, pull,  split, split,
                                        pull, split, split, pull,  split, split};
inline constexpr std::array kForMeeting{pull,  pull, pull,  split, split, pull,  split,
                                        split, pull, split, split, pull,  split, split};
inline constexpr std::array kForBent{split, split, split, split, split, split, split,
                                     split, split, split, split, split, split};
}  // namespace plans

// tuned plans
inline constexpr int kAfterSplit = 5;  ///< index in its plan at which a chart continues after a split

}  // namespace isimp::meshing
