#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "complex.h"

namespace isimp::meshing {

/// The mesh vertices that have become corners. A corner keeps its number, also when no polygon uses it any more.
struct Corners {
  explicit Corners(std::int32_t vertices) : of_vertex(vertices, kNone) {}
  /// The corner at a mesh vertex, a new one if there is none.
  std::int32_t at(std::int32_t v);
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(vertex.size()); }

  std::vector<std::int32_t> of_vertex;  ///< (V) kNone where there is none
  std::vector<std::int32_t> vertex;     ///< (C) the mesh vertex
  std::vector<double> pull;             ///< (C) share of its radius that the repair has left the corner
  std::vector<double> radius;           ///< (C) how far it may be from its mesh vertex
  std::vector<Vec3> position;           ///< (C)
};

/// Extra edges across a piece, by the two mesh vertices.
using Diagonals = std::vector<std::vector<std::array<std::int32_t, 2>>>;

/// The polygons as arrays.
struct Polygons {
  std::vector<std::int32_t> start;                 ///< (Q + 1) where each begins in `corners`
  std::vector<std::int32_t> corners;               ///< (L)
  std::vector<std::int32_t> piece;                 ///< (Q) in rising order
  std::vector<std::int32_t> first_of;              ///< (pieces + 1) the first polygon of each piece
  std::vector<std::int32_t> around_start, around;  ///< (C + 1), (L) the polygons round each corner, in rising order

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(piece.size()); }
  [[nodiscard]] std::span<const std::int32_t> of(std::int32_t q) const {
    return std::span(corners).subspan(start[q], start[q + 1] - start[q]);
  }
  [[nodiscard]] std::span<const std::int32_t> at(std::int32_t c) const {
    return std::span(around).subspan(around_start[c], around_start[c + 1] - around_start[c]);
  }
};

/// One polygon a piece, and one more for each of its diagonals. A diagonal that a chord or another diagonal has taken
/// the place of is dropped.
/// \param before  the polygons so far; those of pieces that did not change and have no diagonals are taken over
/// \param changed  pieces whose chords or diagonals changed; those that lost a diagonal are added here
Polygons collect_polygons(const Complex& complex, const Labels& labels, const Polygons& before, Diagonals& diagonals,
                          Corners& corners, std::vector<std::int32_t>& changed);

/// Vector area of a polygon: its direction is the polygon's normal, its length the area.
/// Source: Newell's method.
Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

/// The largest distance of a corner from the plane through the corners' mean with Newell's normal.
double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

}  // namespace isimp::meshing
