#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex.h"

namespace isimp::meshing {

/// The polygons as arrays: corner c stands for mesh vertex vertex[c].
struct Polygons {
  std::vector<std::int32_t> start;                 ///< (Q + 1) where each begins in `corners`
  std::vector<std::int32_t> corners;               ///< (L)
  std::vector<std::int32_t> piece;                 ///< (Q)
  std::vector<std::int32_t> vertex;                ///< (C) in order of first use
  std::vector<std::int32_t> around_start, around;  ///< (C + 1), (L) the polygons round each corner, in rising order

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(piece.size()); }
  [[nodiscard]] std::int32_t corner_count() const { return static_cast<std::int32_t>(vertex.size()); }
  [[nodiscard]] std::span<const std::int32_t> of(std::int32_t q) const {
    return std::span(corners).subspan(start[q], start[q + 1] - start[q]);
  }
  [[nodiscard]] std::span<const std::int32_t> at(std::int32_t c) const {
    return std::span(around).subspan(around_start[c], around_start[c + 1] - around_start[c]);
  }
};

/// One polygon a piece.
Polygons collect_polygons(const Complex& complex, const Labels& labels);

/// Vector area of a polygon: its direction is the polygon's normal, its length the area.
/// Source: Newell's method.
Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

/// The largest distance of a corner from the plane through the corners' mean with Newell's normal.
double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position);

}  // namespace isimp::meshing
