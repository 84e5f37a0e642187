#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "draw/view.h"
#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/texture/bake.h"

namespace isimp::detail {

/// The input that the baking of all polygons shares.
struct Scene {
  const Mesh& mesh;
  const PolygonMesh& polygons;
  const Atlas& atlas;
  Neighbourhood near;
  Array<std::int32_t> owner;
  std::vector<Slope> slopes;  ///< (L)
  float band;                 ///< texels

  /// \throws InvalidInput  parts that do not belong together
  Scene(const Mesh& m, const Partition& partition, const PolygonMesh& poly, const Atlas& a,
        std::span<const std::uint8_t> known, const TextureOptions& options, const Threads& threads, Job& job);

  /// The directions along which a polygon is drawn.
  [[nodiscard]] Lean lean_of(std::int32_t q) const;
  [[nodiscard]] std::int32_t owner_of(std::int32_t x, std::int32_t y) const {
    return owner[static_cast<std::size_t>(y) * atlas.side + x];
  }
};

/// The samples of a square of texels of one polygon.
struct Samples {
  std::vector<std::int32_t> index;  ///< (n * width by n * height) of the view's faces
  std::vector<float> depth;
  std::vector<float> edge;     ///< (width by height) distance of each texel from the polygon's edges
  std::vector<float> closest;  ///< (width by height) share of the closest point in each texel; -1: not the polygon's
  std::vector<Span> wanted;    ///< (height) the texels of each row that lie between the polygon's first and last
  std::vector<Hit> hits;       ///< (2 by width + 1) the closest points of two rows
  mutable Visited visited;     ///< for searches
  TexelBox box;
  std::int32_t n = 1;

  /// The visible face of the view in the middle of a texel of the box.
  [[nodiscard]] std::int32_t middle(std::int32_t i, std::int32_t j) const {
    const std::size_t row = static_cast<std::size_t>(j) * n + n / 2;
    return index[row * box.width() * n + static_cast<std::size_t>(i) * n + n / 2];
  }
};

/// The content of a texel: samples that were drawn, and the share of the closest point in place of them.
struct Texel {
  std::int32_t x, y;  ///< from the bottom
  std::int32_t polygon;
  bool inside;
  float closest;  ///< 0 to 1
  Hit hit;        ///< the closest point, where its share is above 0
};

/// Draws square t of polygon q with n x n samples a texel, and finds the band along its edges.
/// \return whether any texel is the polygon's
bool draw_square(const Scene& scene, const PolygonView& view, std::int32_t q, std::int32_t t, std::int32_t n,
                 Samples& samples);

/// Finds the closest points of the texels of two rows of a square that show them.
void search_rows(const PolygonView& view, std::int32_t row, Samples& samples);

/// Draws a square and calls shade(texel, samples) for each texel that its polygon owns, row by row.
template <class Shade>
void bake_square(const Scene& scene, const PolygonView& view, std::int32_t q, std::int32_t t, std::int32_t n,
                 Samples& samples, Shade& shade) {
  if (!draw_square(scene, view, q, t, n, samples)) return;
  const TexelBox& box = samples.box;
  const std::int32_t width = box.width();
  for (std::int32_t j = 0; j < box.height(); ++j) {
    if (j % 2 == 0) search_rows(view, j, samples);
    for (std::int32_t i = samples.wanted[j].begin; i < samples.wanted[j].end; ++i) {
      const float share = samples.closest[static_cast<std::size_t>(j) * width + i];
      if (share < 0) continue;
      const std::int32_t x = box.x0 + i, y = box.y0 + j;
      Texel texel{x, y, q, scene.owner_of(x, y) >= 0, share, {}};
      if (share > 0) texel.hit = samples.hits[static_cast<std::size_t>(j % 2) * (width + 1) + i];
      shade(texel, samples);
    }
  }
}

}  // namespace isimp::detail
