#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace isimp {

/// Puts numbers, or pairs of them, in rising order, each once.
template <class T>
void sort_unique(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

/// 0, 1, ... n - 1.
inline std::vector<std::int32_t> numbers_below(std::int32_t n) {
  std::vector<std::int32_t> all(n);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace isimp
