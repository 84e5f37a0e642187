#include "images/samples.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "isimp/core/errors.h"

namespace isimp::detail {
namespace {

// tuned texture
constexpr float kSeen = 1.5F;  // texels of the gutter that show at an edge, between pixels

/// Finds the texels of a polygon. Their weight of the closest point is 0.
/// \return whether there are any
bool find_own(const Scene& scene, std::int32_t q, Samples& samples) {
  const TexelBox& box = samples.box;
  samples.closest.assign(static_cast<std::size_t>(box.width()) * box.height(), -1);
  samples.wanted.assign(box.height(), {});
  bool any = false;
  for (std::int32_t j = 0; j < box.height(); ++j)
    for (std::int32_t i = 0; i < box.width(); ++i) {
      const std::int32_t owner = scene.owner_of(box.x0 + i, box.y0 + j);
      if (owner == kNone || polygon_of(owner) != q) continue;
      samples.closest[static_cast<std::size_t>(j) * box.width() + i] = 0;
      Span& span = samples.wanted[j];
      if (span.end == 0) span.begin = i;
      span.end = i + 1;
      any = true;
    }
  return any;
}

/// Finds the band in which the colours of a square blend into those of the closest points.
void find_band(const Scene& scene, std::int32_t q, Samples& samples) {
  if (!(scene.band > 0)) return;
  const TexelBox& box = samples.box;
  samples.edge.assign(samples.closest.size(), std::numeric_limits<float>::infinity());
  measure_edges(outline_of(scene.polygons, scene.atlas, q), box, scene.band, samples.edge);
  for (std::int32_t j = 0; j < box.height(); ++j)
    for (std::int32_t i = samples.wanted[j].begin; i < samples.wanted[j].end; ++i) {
      const std::size_t at = static_cast<std::size_t>(j) * box.width() + i;
      float& share = samples.closest[at];
      if (share < 0) continue;
      const float edge = samples.edge[at];
      if (scene.owner_of(box.x0 + i, box.y0 + j) < 0)
        share = edge <= kSeen ? 1.0F : 0.0F;
      else
        share = std::clamp(1 - edge / scene.band, 0.0F, 1.0F);
    }
}

}  // namespace

Scene::Scene(const Mesh& m, const Partition& partition, const PolygonMesh& poly, const Atlas& a,
             std::span<const std::uint8_t> known, const TextureOptions& options, const Threads& threads, Job& job)
    : mesh(m), polygons(poly), atlas(a) {
  check_fields(options);
  if (static_cast<std::int32_t>(partition.face_region.size()) != mesh.face_count())
    throw InvalidInput("the partition has " + std::to_string(partition.face_region.size()) +
                       " faces, but the mesh has " + std::to_string(mesh.face_count()));
  if (atlas.corner.size() != poly.loops.size() || atlas.frame.size() != poly.loop_start.size())
    throw InvalidInput("the atlas is not of these polygons");
  for (const std::int32_t r : poly.polygon_region)
    if (r < 0 || r >= partition.region_count())
      throw InvalidInput("a polygon is of region " + std::to_string(r) + ", but there are " +
                         std::to_string(partition.region_count()));
  near = find_neighbourhood(mesh, partition, known);
  owner = find_owners(polygons, atlas, threads, job);
  slopes = corner_slopes(polygons, atlas);
  band = static_cast<float>(options.band) * static_cast<float>(atlas.side) / 2048;
}

Lean Scene::lean_of(std::int32_t q) const { return {outline_of(polygons, atlas, q), slopes_of(polygons, slopes, q)}; }

bool draw_square(const Scene& scene, const PolygonView& view, std::int32_t q, std::int32_t t, std::int32_t n,
                 Samples& samples) {
  samples.box = view.square(t);
  samples.n = n;
  if (!find_own(scene, q, samples)) return false;
  view.draw(t, n, samples.wanted, samples.index, samples.depth);
  find_band(scene, q, samples);
  return true;
}

/// The last quad's face helps the next one's search, within a row: the result must not depend on the threads.
void search_rows(const PolygonView& view, std::int32_t row, Samples& samples) {
  const TexelBox& box = samples.box;
  const std::int32_t width = box.width(), rows = std::min(2, box.height() - row);
  samples.hits.resize(2 * (static_cast<std::size_t>(width) + 1));
  std::int32_t last = kNone;
  // Quads begin at even texels of the square.
  std::int32_t begin = samples.wanted[row].begin, end = samples.wanted[row].end;
  if (rows == 2 && samples.wanted[row + 1].end > 0) {
    begin = end > 0 ? std::min(begin, samples.wanted[row + 1].begin) : samples.wanted[row + 1].begin;
    end = std::max(end, samples.wanted[row + 1].end);
  }
  for (std::int32_t x = begin / 2 * 2; x < end; x += 2) {
    Quad quad{static_cast<float>(box.x0 + x) + 0.5F, static_cast<float>(box.y0 + row) + 0.5F, 1, 0};
    std::int32_t drawn = kNone;
    for (std::int32_t k = 0; k < 4; ++k) {
      const std::int32_t i = x + k % 2, j = row + k / 2;
      if (i >= width || k / 2 >= rows || !(samples.closest[static_cast<std::size_t>(j) * width + i] > 0)) continue;
      quad.wanted |= 1U << k;
      if (drawn == kNone) drawn = samples.middle(i, j);
    }
    if (quad.wanted == 0) continue;
    const std::array<Hit, 4> hits = view.closest(quad, {last, drawn}, samples.visited);
    for (std::int32_t k = 0; k < 4; ++k) {
      samples.hits[static_cast<std::size_t>(k / 2) * (width + 1) + x + k % 2] = hits[k];
      if ((quad.wanted >> k & 1) != 0) last = hits[k].index;
    }
  }
}

}  // namespace isimp::detail
