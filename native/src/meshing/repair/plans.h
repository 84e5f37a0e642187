#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isimp::meshing {

/// The actions against the defects of a piece.
enum class Action : std::uint8_t {
  none,
  pull_concerned,  ///< move the corners concerned halfway back to the scan
  pull_all,        ///< move all corners of the piece halfway back
  add_anchor,      ///< add a corner on one of two chords that cross, else split
  add_diagonal,    ///< split one polygon of the piece between two of its corners, else split the piece
  split,           ///< split the piece in two
};

/// A plan: the actions for the first, second, third ... time that a piece is found defective. The last one is repeated.
///
/// How often an action leaves the piece, or both halves of it, without a defect in the next round; scans, buildings and
/// nasty meshes of 5,000 to a million faces at 50, 300 and 1,000 regions (23,600 actions):
///
/// | piece      | pull_concerned | pull_all | add_anchor | add_diagonal | split |
/// |------------|----------------|----------|------------|--------------|-------|
/// | crossing   | .40            | .23      | .23        |              | .28   |
/// | flipped    |                | .56      |            | .05          | .38   |
/// | meeting    | .61            | .32      |            | .18          | .29   |
/// | bent       |                |          |            | .62          | .38   |
///
/// So the cheap action comes first, and splits follow twice for each further pull. Source: own trials.
using Plan = std::span<const Action>;

namespace plans {
using enum Action;
inline constexpr std::array kForCrossing{pull_concerned, add_anchor, pull_all, add_anchor, split,    pull_all, split,
                                         split,          pull_all,   split,    split,      pull_all, split,    split};
inline constexpr std::array kForFlipped{pull_all, pull_all, add_diagonal, split,    pull_all, split, split,
                                        pull_all, split,    split,        pull_all, split,    split};
inline constexpr std::array kForMeeting{pull_concerned, pull_all, pull_all, add_diagonal, split,    pull_all, split,
                                        split,          pull_all, split,    split,        pull_all, split,    split};
inline constexpr std::array kForBent{add_diagonal, add_diagonal, add_diagonal, split, add_diagonal, add_diagonal, split,
                                     add_diagonal, split,        add_diagonal, split, add_diagonal, split};
}  // namespace plans

inline constexpr int kAfterSplit = 5;  ///< index in its plan at which a piece continues after a split

}  // namespace isimp::meshing
