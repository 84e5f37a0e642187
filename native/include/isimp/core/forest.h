#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace isimp::detail {

/// Disjoint sets of nodes (union-find). The root of a set is its lowest node.
class Forest {
 public:
  explicit Forest(std::size_t n) : up_(n) { std::iota(up_.begin(), up_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (up_[i] != i) i = up_[i] = up_[up_[i]];
    return i;
  }
  /// Merges the sets of two nodes.
  /// \return whether they were two
  bool join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    up_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<std::int32_t> up_;
};

}  // namespace isimp::detail
