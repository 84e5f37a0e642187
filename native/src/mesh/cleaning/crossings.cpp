// Finds triangles that cross others.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "cleaning/close.h"
#include "isimp/core/to_integer.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/mesh/meet.h"

namespace isimp::detail {
namespace {

Box box_of(const Corners& t) { return {t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])}; }

bool overlap(const Box& a, const Box& b) {
  return (a.min().array() <= b.max().array()).all() && (b.min().array() <= a.max().array()).all();
}

/// Some boxes in the cells of a grid, about one a cell and axis.
class Cells {
 public:
  explicit Cells(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
    for (const Box& b : boxes_) reach_.extend(b);
    side_ = to_integer(4 * std::cbrt(static_cast<double>(boxes_.size())), 1, 64);
    for (scale(); side_ > 1 && !is_small(); scale()) side_ /= 2;
    start_.assign(static_cast<std::size_t>(side_) * side_ * side_ + 1, 0);
    const auto each = [&](auto fn) {
      for (std::size_t i = 0; i < boxes_.size(); ++i)
        find(range_of(boxes_[i]), [&](std::size_t cell, const Cell&) {
          fn(cell, static_cast<std::int32_t>(i));
          return false;
        });
    };
    each([&](std::size_t cell, std::int32_t) { ++start_[cell + 1]; });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    inside_.resize(start_.back());
    std::vector<std::size_t> fill(start_.begin(), start_.end() - 1);
    each([&](std::size_t cell, std::int32_t i) { inside_[fill[cell]++] = i; });
  }

  /// Whether fn(index) is true of one of the boxes that touch a box. It is called at most once for each.
  template <class Function>
  bool any(const Box& box, Function fn) const {
    if (boxes_.empty() || !overlap(box, reach_)) return false;
    const Range range = range_of(box);
    return find(range, [&](std::size_t at, const Cell& cell) {
      return std::any_of(inside_.begin() + static_cast<std::ptrdiff_t>(start_[at]),
                         inside_.begin() + static_cast<std::ptrdiff_t>(start_[at + 1]), [&](std::int32_t i) {
                           return overlap(box, boxes_[i]) && is_first(cell, range, boxes_[i]) && fn(i);
                         });
    });
  }

 private:
  using Cell = std::array<int, 3>;
  using Range = std::array<Cell, 2>;  // the lowest and the highest cell

  void scale() {
    for (int k = 0; k < 3; ++k) {
      const double length = boxes_.empty() ? 0 : reach_.max()[k] - reach_.min()[k];
      per_length_[k] = length > 0 ? side_ / length : 0;
    }
  }

  /// Whether the boxes are in few cells: large ones would be in nearly all.
  [[nodiscard]] bool is_small() const {
    std::size_t cells = 0;
    for (const Box& b : boxes_) {
      const auto [low, high] = range_of(b);
      std::size_t own = 1;
      for (int k = 0; k < 3; ++k) own *= static_cast<std::size_t>(std::max(high[k] - low[k] + 1, 0));
      cells += own;
    }
    return cells <= 64 * boxes_.size();  // a box is in 64 cells at most, on average
  }

  [[nodiscard]] int cell_of(double at, int axis) const {
    return to_integer((at - reach_.min()[axis]) * per_length_[axis], 0, side_ - 1);
  }

  [[nodiscard]] Range range_of(const Box& box) const {
    Range range{};
    for (int k = 0; k < 3; ++k) {
      range[0][k] = cell_of(box.min()[k], k);
      range[1][k] = cell_of(box.max()[k], k);
    }
    return range;
  }

  /// Whether a cell is the lowest one of a range that a box touches, too.
  [[nodiscard]] bool is_first(const Cell& cell, const Range& range, const Box& box) const {
    for (int k = 0; k < 3; ++k)
      if (cell[k] != range[0][k] && cell[k] != cell_of(box.min()[k], k)) return false;
    return true;
  }

  /// Whether fn(index, cell) is true of a cell of a range.
  template <class Function>
  bool find(const Range& range, Function fn) const {
    const auto& [low, high] = range;
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z)
          if (fn((static_cast<std::size_t>(x) * side_ + y) * side_ + z, Cell{x, y, z})) return true;
    return false;
  }

  std::vector<Box> boxes_;
  Box reach_;
  int side_ = 1;
  std::array<double, 3> per_length_{};
  std::vector<std::size_t> start_;  // by cell: where its boxes start in `inside_`
  std::vector<std::int32_t> inside_;
};

}  // namespace

std::vector<std::int32_t> find_near(const MeshArrays& arrays, const std::vector<std::int32_t>* among,
                                    const std::vector<Eigen::AlignedBox3d>& boxes, const Threads& threads, Job& job) {
  const Cells cells(boxes);
  const std::size_t count = among ? among->size() : arrays.triangles.size();
  return rising(gather<std::int32_t>(threads, count, job, [&](std::size_t i, auto& found) {
    const std::int32_t f = among ? (*among)[i] : static_cast<std::int32_t>(i);
    const auto& [a, b, c] = arrays.triangles[f];
    const Box box = box_of({arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]});
    if (cells.any(box, [](std::int32_t) { return true; })) found.push_back(f);
  }));
}

std::vector<char> find_crossed(const MeshArrays& arrays, const std::vector<std::int32_t>& others,
                               const std::vector<char>& removed, std::size_t fresh, Job& job) {
  const auto corners = [&](std::int32_t f) {
    const auto& [a, b, c] = arrays.triangles[f];
    return Corners{arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]};
  };
  const auto all = static_cast<std::int32_t>(arrays.triangles.size()), old = all - static_cast<std::int32_t>(fresh);
  std::vector<Box> patches(fresh);
  std::vector<char> solid(fresh), crossed(fresh, 0);
  for (std::size_t i = 0; i < fresh; ++i) {
    const Corners s = corners(old + static_cast<std::int32_t>(i));
    patches[i] = box_of(s);
    solid[i] = has_area(s);
  }
  const Cells cells(std::move(patches));
  std::size_t tests = 0;
  for (const std::int32_t g : others) {
    if (removed[g]) continue;
    const Corners t = corners(g);
    std::optional<bool> is_solid;
    cells.any(box_of(t), [&](std::int32_t i) {
      if (++tests % kPollEvery == 0) job.poll();
      const std::int32_t f = old + i;
      if (f == g || crossed[i] || !solid[i]) return false;
      if (!is_solid) is_solid = has_area(t);
      if (*is_solid) crossed[i] = meet_elsewhere(arrays.triangles[f], corners(f), arrays.triangles[g], t);
      return false;
    });
  }
  return crossed;
}

}  // namespace isimp::detail
