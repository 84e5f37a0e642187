#pragma once

#include <cstdint>

namespace isimp {

/// How naive flooding finds the regions nearest to a face.
enum class Search {
  grid,   ///< by a grid of the regions' centres
  brute,  ///< by looking at them all, as the thesis has it: O(F P); the same regions
};

/// The most regions that a face may look at in naive flooding.
inline constexpr std::int32_t kMostNearest = 32;

}  // namespace isimp
