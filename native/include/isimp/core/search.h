#pragma once

#include <cstdint>

namespace isimp {

/// How naive flooding finds the regions nearest to a face.
enum class Search {
  grid,   ///< by a grid of the regions' centres
  brute,  ///< by a search of all of them, as in the thesis: O(F P); the same regions
};

/// The most regions that naive flooding compares for a face.
inline constexpr std::int32_t kMostNearest = 32;

}  // namespace isimp
