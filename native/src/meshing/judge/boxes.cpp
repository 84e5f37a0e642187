#include "judge/boxes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "isimp/core/sorted.h"
#include "isimp/core/types.h"

namespace isimp::meshing {

namespace {
constexpr std::size_t kFewNew = 32,
                      kShareNew = 4;  ///< work: kFewNew + all / kShareNew boxes may be new before the tree is rebuilt
}  // namespace

BoxTree::BoxTree(std::vector<NumberedBox> all, const Job* job) : all_(std::move(all)), leaf_(all_.size()) {
  if (!all_.empty()) make(0, static_cast<std::int32_t>(all_.size()), kNone, job);
}

void BoxTree::make(std::int32_t begin, std::int32_t end, std::int32_t parent, const Job* job) {
  if (job != nullptr && (nodes_.size() & 0xfff) == 0) job->poll();
  Box around = all_[begin].box;
  std::array<float, 3> low{}, high{};  // range of the middles, times 2
  for (int k = 0; k < 3; ++k) low[k] = high[k] = around.low[k] + around.high[k];
  for (std::int32_t i = begin + 1; i < end; ++i) {
    const Box& box = all_[i].box;
    around.include(box);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], box.low[k] + box.high[k]);
      high[k] = std::max(high[k], box.low[k] + box.high[k]);
    }
  }
  const auto node = static_cast<std::int32_t>(nodes_.size());
  const bool is_leaf = end - begin <= 8;
  nodes_.push_back({around, begin, is_leaf ? end : begin, 0, parent});
  if (is_leaf) {
    std::fill(leaf_.begin() + begin, leaf_.begin() + end, node);
  } else {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const std::int32_t half = begin + (end - begin) / 2;
    std::nth_element(all_.begin() + begin, all_.begin() + half, all_.begin() + end,
                     [&](const NumberedBox& x, const NumberedBox& y) {
                       return x.box.low[axis] + x.box.high[axis] < y.box.low[axis] + y.box.high[axis];
                     });
    make(begin, half, node, job);
    make(half, end, node, job);
  }
  nodes_[node].after = static_cast<std::int32_t>(nodes_.size());
}

Box BoxTree::around(std::int32_t node) const {
  const Node& n = nodes_[node];
  Box box = Box::nowhere();
  for (std::int32_t i = n.begin; i < n.end; ++i) box.include(all_[i].box);
  for (std::int32_t below = node + 1; below < n.after; below = nodes_[below].after) box.include(nodes_[below].around);
  return box;
}

void BoxTree::move(std::int32_t place, const Box& box) {
  all_[place].box = box;
  for (std::int32_t node = leaf_[place]; node != kNone; node = nodes_[node].parent) {
    const Box now = around(node);
    if (now == nodes_[node].around) return;
    nodes_[node].around = now;
  }
}

void MovingBoxes::set(std::int32_t index, const Box& box) {
  if (static_cast<std::int32_t>(boxes_.size()) <= index) {
    boxes_.resize(index + 1, Box::nowhere());
    place_.resize(index + 1, kNone);
  }
  if (boxes_[index] == box) return;
  boxes_[index] = box;
  moved_.push_back(index);
}

void MovingBoxes::settle() {
  sort_unique(moved_);
  bool any_fresh = false;
  for (const std::int32_t i : moved_) {
    if (place_[i] != kNone) continue;
    fresh_.push_back(i);
    any_fresh = true;
  }
  sort_unique(fresh_);
  // If many boxes have moved, a new tree costs less than the moves.
  if (fresh_.size() > kFewNew + boxes_.size() / kShareNew || moved_.size() > kFewNew + boxes_.size() / kShareNew) {
    std::vector<NumberedBox> all;
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      if (!boxes_[i].apart(boxes_[i])) all.push_back({boxes_[i], static_cast<std::int32_t>(i)});
    tree_ = BoxTree(std::move(all));
    std::fill(place_.begin(), place_.end(), kNone);
    for (std::size_t k = 0; k < tree_.size(); ++k)
      place_[tree_.at(static_cast<std::int32_t>(k)).index] = static_cast<std::int32_t>(k);
    fresh_.clear();
    fresh_tree_ = {};
    moved_.clear();
    return;
  }
  for (const std::int32_t i : moved_) {
    if (place_[i] != kNone) {
      tree_.move(place_[i], boxes_[i]);
    } else {
      any_fresh = true;
    }
  }
  moved_.clear();
  if (!any_fresh) return;
  std::vector<NumberedBox> some;
  for (const std::int32_t i : fresh_)
    if (!boxes_[i].apart(boxes_[i])) some.push_back({boxes_[i], i});
  fresh_tree_ = BoxTree(std::move(some));
}

}  // namespace isimp::meshing
