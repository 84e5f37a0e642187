#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace isimp::detail {

/// Disjoint sets of nodes whose joins can be undone in reverse order. Without path compression, so that a join changes
/// one node.
/// Cost: O(log n) for a root or a join, O(1) for each join that is undone.
class UndoForest {
 public:
  explicit UndoForest(std::size_t n) : up_(n), size_(n, 1) { std::iota(up_.begin(), up_.end(), 0); }
  [[nodiscard]] std::int32_t root(std::int32_t i) const {
    while (up_[i] != i) i = up_[i];
    return i;
  }
  /// Makes the sets of two nodes one.
  /// \return whether they were two
  bool join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    if (size_[a] < size_[b]) std::swap(a, b);
    up_[b] = a;
    size_[a] += size_[b];
    joined_.push_back(b);
    return true;
  }
  /// How many joins there are, for `undo`.
  [[nodiscard]] std::size_t joins() const { return joined_.size(); }
  /// Undoes the last joins until `left` of them remain.
  void undo(std::size_t left) {
    for (; joined_.size() > left; joined_.pop_back()) {
      const std::int32_t b = joined_.back();
      size_[up_[b]] -= size_[b];
      up_[b] = b;
    }
  }

 private:
  std::vector<std::int32_t> up_, size_, joined_;  // joined_: roots that are none any more
};

}  // namespace isimp::detail
