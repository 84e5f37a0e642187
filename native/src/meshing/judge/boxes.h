#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "isimp/core/job.h"

namespace isimp::meshing {

/// A box with sides along the axes. It is exact, as all coordinates in a search are float32.
struct Box {
  Eigen::Array4f low = Eigen::Array4f::Zero(), high = low;  ///< the fourth is 0, so that four are compared at once
  [[nodiscard]] bool apart(const Box& other) const {
    // The sign of a difference is never rounded away.
    return (low - other.high).max(other.low - high).maxCoeff() > 0;
  }
  /// The box of nothing, apart from all.
  static Box nowhere() {
    Box box;
    box.low.head<3>().setConstant(std::numeric_limits<float>::infinity());
    box.high = -box.low;
    return box;
  }
  void include(const Box& other) {
    low = low.min(other.low);
    high = high.max(other.high);
  }
  [[nodiscard]] bool operator==(const Box& other) const {
    return (low == other.low).all() && (high == other.high).all();
  }
};

/// A box and the index of its content, a chart or a face of the scan.
struct NumberedBox {
  Box box;
  std::int32_t index;
};

/// A tree of boxes that finds all boxes that meet a given one: halved at the median of the middles, along the axis of
/// their largest spread, down to a few boxes.
/// Cost: O(n log n) to make; a search, about O(log n + boxes that it meets).
class BoxTree {
 public:
  BoxTree() = default;
  /// \param job  polled, if given
  explicit BoxTree(std::vector<NumberedBox> all, const Job* job = nullptr);

  [[nodiscard]] std::size_t size() const { return all_.size(); }
  /// Whether the box at some place passes the test; stops at the first.
  /// \param misses  whether nothing inside a box can pass
  /// \param test    of a place
  template <class Misses, class Test>
  [[nodiscard]] bool any_place(Misses misses, Test test) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      if (misses(node.around)) {
        n = static_cast<std::size_t>(node.after);
        continue;
      }
      for (std::int32_t i = node.begin; i < node.end; ++i)
        if (test(i)) return true;
      ++n;
    }
    return false;
  }
  /// Whether some box has a place in common with `a` and passes the test; stops at the first.
  template <class Test>
  [[nodiscard]] bool any(const Box& a, Test test) const {
    return any_place([&](const Box& around) { return around.apart(a); },
                     [&](std::int32_t i) { return !all_[i].box.apart(a) && test(all_[i]); });
  }
  /// Whether some box of this tree has a place in common with one of another and both pass the test; stops at the
  /// first.
  template <class Test>
  [[nodiscard]] bool any_pair(const BoxTree& other, Test test) const {
    std::vector<std::pair<std::int32_t, std::int32_t>> left;  // pairs of nodes still to be visited, with their subtrees
    if (!nodes_.empty() && !other.nodes_.empty()) left.emplace_back(0, 0);
    while (!left.empty()) {
      const auto [n, m] = left.back();
      left.pop_back();
      const Node &a = nodes_[n], &b = other.nodes_[m];
      if (a.around.apart(b.around)) continue;
      const bool is_leaf = a.begin < a.end, is_other_leaf = b.begin < b.end;
      if (is_leaf && is_other_leaf) {
        for (std::int32_t i = a.begin; i < a.end; ++i) {
          if (all_[i].box.apart(b.around)) continue;
          for (std::int32_t j = b.begin; j < b.end; ++j)
            if (!all_[i].box.apart(other.all_[j].box) && test(all_[i], other.all_[j])) return true;
        }
      } else if (is_other_leaf || (!is_leaf && a.after - n >= b.after - m)) {
        left.insert(left.end(), {{n + 1, m}, {nodes_[n + 1].after, m}});
      } else {
        left.insert(left.end(), {{n, m + 1}, {n, other.nodes_[m + 1].after}});
      }
    }
    return false;
  }
  [[nodiscard]] const NumberedBox& at(std::int32_t place) const { return all_[place]; }
  /// Replaces the box at a place and updates the boxes that contain it. The order of the tree does not change.
  /// Cost: O(log n).
  void move(std::int32_t place, const Box& box);

 private:
  struct Node {
    Box around;
    std::int32_t begin, end;  ///< range of the entries of a leaf; empty in other nodes
    std::int32_t after;       ///< the next node if the subtree of this one is skipped
    std::int32_t parent;
  };

  /// Nodes stand before those below them.
  void make(std::int32_t begin, std::int32_t end, std::int32_t parent, const Job* job);
  [[nodiscard]] Box around(std::int32_t node) const;

  std::vector<NumberedBox> all_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> leaf_;  // by place
};

/// Boxes that come and move one by one, each with an index.
class MovingBoxes {
 public:
  /// Sets the box at an index; an index that was not set has an empty box. To be followed by `settle` before a search.
  void set(std::int32_t index, const Box& box);
  /// Makes ready for searches.
  /// Cost: about O(log n) for each box set, as the tree is rebuilt only when a share of all boxes is new.
  void settle();
  /// Calls fn(index) for each box that has a place in common with `a`.
  template <class Function>
  void for_each_near(const Box& a, Function fn) const {
    for (const BoxTree* tree : {&tree_, &fresh_tree_})
      (void)tree->any(a, [&](const NumberedBox& e) {
        fn(e.index);
        return false;
      });
  }

 private:
  std::vector<Box> boxes_;
  std::vector<std::int32_t> place_;  // by index: in the tree, -1 where it is not
  std::vector<std::int32_t> moved_;  // since `settle`
  std::vector<std::int32_t> fresh_;  // indices that came since the tree was made
  BoxTree tree_, fresh_tree_;
};

}  // namespace isimp::meshing
