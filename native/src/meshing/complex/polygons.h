#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "complex/complex.h"

namespace isimp::meshing {

/// The mesh vertices that have become corners. A corner keeps its number, also when no polygon uses it any more. It
/// stands for one vertex, or for several that share it.
struct Corners {
  explicit Corners(std::int32_t vertices) : of_vertex(vertices, kNone) {}
  /// The corner at a mesh vertex, a new one if there is none.
  std::int32_t at(std::int32_t v);
  /// Makes the corner at one of some vertices stand for all of them.
  void share(std::int32_t v, std::span<const std::int32_t> vertices);
  [[nodiscard]] bool is_shared(std::span<const std::int32_t> vertices) const {
    return of_vertex[vertices.front()] == of_vertex[vertices.back()];
  }
  /// Ends that.
  void part(std::int32_t v, std::span<const std::int32_t> vertices);
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(vertex.size()); }
  /// Calls fn(array) for each array of corners that a transaction takes back.
  template <class Self, class Function>
  static void for_each_array(Self& self, Function fn) {
    fn(self.of_vertex);
    fn(self.vertex);
    fn(self.radius);
    fn(self.position);
  }

  Logged<std::int32_t> of_vertex;  ///< (V) kNone where there is none
  Logged<std::int32_t> vertex;     ///< (C) the mesh vertex, the nearest of several
  Logged<double> radius;           ///< (C) how far it may be from its mesh vertex
  Logged<Vec3> position;           ///< (C)
  /// Corners that would move by less keep their position bit by bit, so that the polygons at them need not be judged
  /// again.
  double still = 0;
};

/// Extra edges across a chart, by the two mesh vertices.
using Diagonals = Logged<std::vector<std::array<std::int32_t, 2>>>;

/// The polygons: one a chart, and one more for each of its diagonals. A polygon has a number; the polygons of a chart
/// have consecutive numbers. A number lasts until the chart is collected again.
class Polygons {
 public:
  /// Numbers that are in use or were.
  [[nodiscard]] std::int32_t numbers() const { return static_cast<std::int32_t>(loops_.size()); }
  [[nodiscard]] std::int32_t count() const { return in_use_[0]; }
  /// How many a chart has; 0 for one that is no more.
  [[nodiscard]] std::int32_t count_of(std::int32_t chart) const {
    return chart < static_cast<std::int32_t>(charts_.size()) ? charts_[chart].count : 0;
  }
  /// The first of a chart's.
  [[nodiscard]] std::int32_t first_of(std::int32_t chart) const { return charts_[chart].first; }
  [[nodiscard]] std::int32_t chart(std::int32_t q) const { return loops_[q].chart; }
  /// The corners of a polygon, in order.
  [[nodiscard]] std::span<const std::int32_t> of(std::int32_t q) const {
    return {corners_.data() + loops_[q].begin, static_cast<std::size_t>(loops_[q].size)};
  }
  [[nodiscard]] bool in_transaction() const { return loops_.in_transaction(); }
  /// Whether a polygon uses a corner; within a transaction: whether one did as it began.
  [[nodiscard]] bool was_used(std::int32_t c) const {
    return c < static_cast<std::int32_t>(around_.size_before()) && !around_.before(c).empty();
  }
  /// The polygons at a corner, in the order of their charts.
  [[nodiscard]] std::span<const std::int32_t> at(std::int32_t c) const { return around_[c]; }
  /// Calls fn(q) for each polygon of a chart.
  template <class Function>
  void for_each_of(std::int32_t chart, Function fn) const {
    const std::int32_t count = count_of(chart);
    for (std::int32_t i = 0; i < count; ++i) fn(charts_[chart].first + i);
  }

  /// The corners of some charts' polygons, in rising order.
  [[nodiscard]] std::vector<std::int32_t> corners_of(std::span<const std::int32_t> charts) const;
  /// The charts with a polygon at one of some corners, in rising order.
  [[nodiscard]] std::vector<std::int32_t> charts_at(std::span<const std::int32_t> corners) const;

  /// Rebuilds the polygons of changed charts. A diagonal is dropped if a chord or another diagonal joins the same ends.
  /// \param changed  charts whose chords or diagonals changed, or that are no more; charts that lose a diagonal are
  ///                 added
  /// Cost: O(polygons of these and at their corners); also O(charts) if no chart has a diagonal.
  void collect(const Complex& complex, const Labels& labels, Diagonals& diagonals, Corners& corners,
               std::vector<std::int32_t>& changed);
  /// Removes unused numbers, if they are more than half. Not within a transaction.
  void close_gaps();
  /// Calls fn(array) for each array of polygons that a transaction takes back.
  template <class Self, class Function>
  static void for_each_array(Self& self, Function fn) {
    fn(self.loops_);
    fn(self.corners_);
    fn(self.charts_);
    fn(self.around_);
    fn(self.in_use_);
  }

 private:
  struct Loop {
    std::int32_t begin, size, chart;
  };
  struct Row {
    std::int32_t first = 0, count = 0;
  };
  void remove(std::int32_t chart);
  void add(std::int32_t chart, std::span<const std::vector<std::int32_t>> cycles, Corners& corners);
  /// The charts that have one of some edges as a diagonal, as it was when their polygons were built.
  [[nodiscard]] std::vector<std::int32_t> with_diagonals(std::span<const std::array<std::int32_t, 2>> edges,
                                                         const Diagonals& diagonals, const Corners& corners) const;

  Logged<Loop> loops_;                        // by number
  Logged<std::int32_t> corners_;              // corners of all loops, with gaps where loops were removed
  Logged<Row> charts_;                        // by chart
  Logged<std::vector<std::int32_t>> around_;  // by corner
  Logged<std::int32_t> in_use_{2, 0};         // polygons, and their corners
};

/// Vector area of a polygon: its direction is the polygon's normal, its length the area.
/// Source: Newell's method.
Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

/// The largest distance of a corner from the plane through the corners' mean with Newell's normal.
double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

}  // namespace isimp::meshing
