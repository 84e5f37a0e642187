#include "surface/point_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isimp/core/to_integer.h"
#include "surface/parallel_loops.h"

namespace isimp::detail {
namespace {

constexpr double kRounding =
    2e-14;  // rounding: rounding of twice an area, as a share of the largest coordinate squared
constexpr std::size_t kFewKeys = 1 << 12;  // work: keys that are sorted by comparisons
constexpr int kKeyDigitBits = 11;          // work

/// Moves every bit of the lower sixteen to an even place.
std::uint64_t spread_to_even(std::uint64_t x) {
  x = (x | x << 8) & 0x00ff00ff;
  x = (x | x << 4) & 0x0f0f0f0f;
  x = (x | x << 2) & 0x33333333;
  return (x | x << 1) & 0x55555555;
}

/// The cell of a coordinate; any cell if it is not a number.
std::uint64_t cell(double x, double low, double scale) {
  return to_integer((x - low) * scale, std::uint64_t{0}, std::uint64_t{65535});
}

/// Sorts by the upper half of each key.
void sort_keys(std::vector<std::uint64_t>& keys, Job& job) {
  if (keys.size() <= kFewKeys) return std::sort(keys.begin(), keys.end());
  std::vector<std::uint64_t> other(keys.size());
  constexpr std::uint64_t kMask = (1 << kKeyDigitBits) - 1;  // unit
  for (int shift = 32; shift < 64; shift += kKeyDigitBits) {
    std::array<std::size_t, kMask + 2> next{};
    for_each_index(keys.size(), job, [&](std::size_t i) { ++next[(keys[i] >> shift & kMask) + 1]; });
    for (std::size_t d = 1; d < next.size(); ++d) next[d] += next[d - 1];
    for_each_index(keys.size(), job, [&](std::size_t i) { other[next[keys[i] >> shift & kMask]++] = keys[i]; });
    keys.swap(other);
  }
}

}  // namespace

void PointBoxes::build(const std::vector<Vec2>& place, const std::vector<std::int32_t>& points, Job& job) {
  points_ = points;
  slot_.resize(place.size());
  levels_.clear();
  if (points_.empty()) return;
  sort(place, job);
  for (std::size_t i = 0; i < points_.size(); ++i) slot_[static_cast<std::size_t>(points_[i])] = static_cast<int>(i);
  make_levels(place);
}

/// Sorts points along a curve, so that near points are near in the list (Morton).
void PointBoxes::sort(const std::vector<Vec2>& place, Job& job) {
  Vec2 low = place[static_cast<std::size_t>(points_[0])], high = low;
  farthest_ = 0.0;
  for (const Vec2& p : place) farthest_ = std::max(farthest_, p.cwiseAbs().maxCoeff());
  for (const std::int32_t i : points_) {
    low = low.cwiseMin(place[static_cast<std::size_t>(i)]);
    high = high.cwiseMax(place[static_cast<std::size_t>(i)]);
  }
  if (points_.size() <= kBranches) return;
  const double side = (high - low).maxCoeff(), scale = side > 0 ? 65535.0 / side : 0.0;
  std::vector<std::uint64_t> keys(points_.size());
  for_each_index(keys.size(), job, [&](std::size_t i) {
    const Vec2& p = place[static_cast<std::size_t>(points_[i])];
    const std::uint64_t x = cell(p.x(), low.x(), scale), y = cell(p.y(), low.y(), scale);
    const std::uint64_t at = spread_to_even(x) | spread_to_even(y) << 1;
    keys[i] = at << 32 | static_cast<std::uint32_t>(points_[i]);
  });
  sort_keys(keys, job);
  for (std::size_t i = 0; i < keys.size(); ++i) points_[i] = static_cast<std::int32_t>(keys[i] & 0x7fffffff);
}

void PointBoxes::make_levels(const std::vector<Vec2>& place) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();  // mark
  const Node nothing{kInfinite, -kInfinite, kInfinite, -kInfinite, 0};
  const auto boxes_for = [](std::size_t n) { return (n + kBranches - 1) / kBranches; };
  levels_.emplace_back(boxes_for(points_.size()), nothing);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec2& p = place[static_cast<std::size_t>(points_[i])];
    Node& node = levels_[0][i / kBranches];
    node = {std::min(node.left, p.x()), std::max(node.right, p.x()), std::min(node.low, p.y()),
            std::max(node.high, p.y()), node.count + 1};
  }
  while (levels_.back().size() > 1) {
    std::vector<Node> above(boxes_for(levels_.back().size()), nothing);
    for (std::size_t i = 0; i < levels_.back().size(); ++i) {
      const Node& n = levels_.back()[i];
      Node& node = above[i / kBranches];
      node = {std::min(node.left, n.left), std::max(node.right, n.right), std::min(node.low, n.low),
              std::max(node.high, n.high), node.count + n.count};
    }
    levels_.push_back(std::move(above));
  }
}

void PointBoxes::remove(std::int32_t point) {
  auto at = static_cast<std::size_t>(slot_[static_cast<std::size_t>(point)]);
  points_[at] = -1;
  for (std::vector<Node>& level : levels_) --level[at /= kBranches].count;
}

PointBoxes::Triangle2::Triangle2(const std::array<Vec2, 3>& corners, double farthest)
    : corners_(corners), margin_(kRounding * farthest * farthest) {
  const auto& [a, b, c] = corners;
  const auto [left, right] = std::minmax({a.x(), b.x(), c.x()});
  const auto [low, high] = std::minmax({a.y(), b.y(), c.y()});
  left_ = left - kRounding * farthest;
  right_ = right + kRounding * farthest;
  low_ = low - kRounding * farthest;
  high_ = high + kRounding * farthest;
}

bool PointBoxes::Triangle2::misses(const Node& box) const {
  if (box.right < left_ || box.left > right_ || box.high < low_ || box.low > high_) return true;
  for (std::size_t k = 0; k < 3; ++k) {  // is all of the box to the right of an edge?
    const Vec2 &a = corners_[k], &b = corners_[(k + 1) % 3];
    const Vec2 leftmost(b.y() > a.y() ? box.left : box.right, b.x() > a.x() ? box.high : box.low);
    if (turn(a, b, leftmost) < -margin_) return true;
  }
  return false;
}

}  // namespace isimp::detail
