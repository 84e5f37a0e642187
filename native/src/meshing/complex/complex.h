#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "complex/planes.h"
#include "discs/labels.h"
#include "discs/logged.h"
#include "discs/polyline.h"
#include "isimp/core/job.h"

namespace isimp::meshing {

/// How far a boundary may leave the chord that stands for it, scene units.
struct ChordTolerance {
  double most = 0;            ///< between two charts
  double most_on_border = 0;  ///< on the border of the mesh
  double rim = 0;             ///< tolerance for nine tenths of a ragged border; 0: the border is not ragged
  double of_area = 0;         ///< the chords of a chart may leave out or add this share of its area
  double least_sine = 0;      ///< distances count the less, the flatter the two charts meet, but at least this much
};

/// Which vertices on the boundaries between charts are corners, and so which polygons there are.
///
/// A chord runs from corner to corner along the boundary of two charts (or of one and the border); it is named by its
/// first half-edge, on either side. A vertex where other than two boundary edges meet is always a corner, so a corner
/// needs no more than a flag at its vertex for both sides of a chord to agree.
class Complex {
 public:
  Complex(const Labels& labels, const Logged<Plane>& planes);

  ChordTolerance tolerance;

  /// Chooses corners on the boundaries of the given charts, after their labels changed. All charts must be discs.
  /// \param charts  in rising order
  /// \param loops  the boundary half-edges of each, in order
  void refresh(std::span<const std::int32_t> charts, std::vector<std::vector<std::int32_t>> loops, const Job& job);
  /// Adds corners until every polygon has three, no two chords have the same ends, no two polygons the same corners.
  /// Where no corner is left to add (two triangles of the mesh), polygons may stay alike: see `judge`. The check covers
  /// only charts that have a corner in common with a changed chart, as no other can have become irregular.
  /// \return the charts whose corners have changed since this was last called, in rising order
  std::vector<std::int32_t> make_regular();
  /// Makes a boundary vertex a corner.
  void add_corner(std::int32_t vertex);
  /// Makes a vertex no corner any more, unless it has to be one.
  /// \return whether it could be
  bool drop_corner(std::int32_t vertex);
  /// Forgets a chart that is no more.
  void forget(std::int32_t chart);
  /// How far the boundary leaves a chord at most; -1 if there is no vertex between its ends.
  [[nodiscard]] double depth(std::int32_t chord) const;
  /// Makes the vertex between two corners a corner that is farthest from the chord.
  /// \return whether there is one
  bool bend(std::int32_t chord);

  /// First half-edges of a chart's chords, in order.
  [[nodiscard]] std::span<const std::int32_t> chords(std::int32_t chart) const { return chords_[chart]; }
  [[nodiscard]] std::span<const std::int32_t> loop(std::int32_t chart) const { return loops_[chart]; }
  /// The number of boundary edges at a vertex, edges on the border of the mesh included.
  [[nodiscard]] int boundary_edges(std::int32_t vertex) const;
  [[nodiscard]] bool is_corner(std::int32_t vertex) const { return corner_[vertex] != 0; }
  /// The vertices that `bend` made corners, some of them perhaps more than once or dropped since.
  [[nodiscard]] const std::vector<std::int32_t>& bent() const { return bent_; }
  /// Whether some chord has these two vertices as its ends.
  [[nodiscard]] bool has_chord(std::int32_t a, std::int32_t b) const;

  /// Calls fn(array) for each array of a complex that a transaction takes back.
  template <class Self, class Function>
  static void for_each_array(Self& self, Function fn) {
    fn(self.corner_);
    fn(self.loops_);
    fn(self.chords_);
    fn(self.bent_);
  }
  /// Whether corners have changed since `make_regular`.
  [[nodiscard]] bool is_pending() const { return !dirty_.empty() || !changed_.empty(); }
  void drop_pending() {
    dirty_.clear();
    changed_.clear();
  }

 private:
  [[nodiscard]] bool is_anchor(std::int32_t vertex) const { return boundary_edges(vertex) != 2; }
  /// Whether the triangle of three places in a loop has a sharp corner.
  [[nodiscard]] bool is_sharp(std::span<const std::int32_t> loop, const std::array<std::size_t, 3>& at) const;
  /// Where a chord begins in the loop of its chart.
  [[nodiscard]] std::size_t place_of(std::int32_t chord) const;
  /// The points from corner to corner.
  /// \param at  where the first is in the loop
  void collect_line(std::span<const std::int32_t> loop, std::size_t at, std::vector<Vec3>& line) const;
  /// Makes the vertex a corner that is some steps behind a place in a loop.
  void add_corner(std::span<const std::int32_t> loop, std::size_t at) {
    add_corner(mesh_.from(loop[at < loop.size() ? at : at - loop.size()]));
  }
  void add_anchors(std::span<const std::int32_t> loop);
  void seed_ring(std::int32_t chart);
  void subdivide_chords(std::int32_t chart, std::span<const std::int32_t> charts);
  void keep_shape(std::int32_t chart);
  /// The sine of the angle at which the two charts of a chord meet, at least tolerance.least_sine; 1 on the border.
  [[nodiscard]] double sine_at(std::int32_t chord) const;
  void mark_dirty(std::int32_t vertex);
  void collect_dirty();
  bool add_third_corners();
  [[nodiscard]] std::vector<std::int32_t> with_neighbours(std::span<const std::int32_t> charts) const;
  // Both compare only chords and charts whose corners are all marked in vertex_marks.
  bool part_multi_edges(std::span<const std::int32_t> charts);
  bool part_duplicates(std::span<const std::int32_t> charts);

  const Labels& labels_;
  const Mesh& mesh_;
  const Logged<Plane>& planes_;
  Logged<std::uint8_t> corner_;               ///< (V)
  Logged<std::vector<std::int32_t>> loops_;   ///< boundary half-edges of each chart, in order
  Logged<std::vector<std::int32_t>> chords_;  ///< the half-edges of loops_ that start at a corner
  Logged<std::int32_t> bent_;
  std::vector<std::int32_t> dirty_;    ///< charts whose chords_ are out of date
  std::vector<std::int32_t> changed_;  ///< charts whose chords_ were, and were not yet made regular
  std::vector<Vec3> line_;             ///< points of the current chord
};

}  // namespace isimp::meshing
