#pragma once

namespace isimp::meshing {

/// rounding: share of the diagonal: a shorter way of a corner, or distance from a plane, is none.
constexpr double kNoLength = 1e-9;

}  // namespace isimp::meshing
