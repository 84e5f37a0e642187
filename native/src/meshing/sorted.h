#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isimp::meshing {

/// Puts numbers in rising order, each once.
inline void sort_unique(std::vector<std::int32_t>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace isimp::meshing
