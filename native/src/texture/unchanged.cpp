#include "unchanged.h"

#include <algorithm>

#include "isimp/core/errors.h"

namespace isimp::detail {
namespace {

/// The earlier region with the same faces, by region; kNone if there is none or no face is known.
std::vector<std::int32_t> same_regions(const Neighbourhood& now, const Neighbourhood& before,
                                       const Partition& earlier) {
  std::vector<std::int32_t> same(now.start.size() - 1, kNone);
  for (std::size_t r = 0; r < same.size(); ++r) {
    const auto faces = std::span(now.faces).subspan(now.start[r], now.start[r + 1] - now.start[r]);
    if (faces.empty()) continue;
    const std::int32_t p = earlier.face_region[faces.front()];
    if (p == kNone) continue;
    const auto others = std::span(before.faces).subspan(before.start[p], before.start[p + 1] - before.start[p]);
    if (std::equal(faces.begin(), faces.end(), others.begin(), others.end())) same[r] = p;
  }
  return same;
}

/// Whether a polygon of region r can show the same regions as a polygon of the earlier region p could.
bool same_near(const Neighbourhood& now, std::int32_t r, const Neighbourhood& before, std::int32_t p,
               const std::vector<std::int32_t>& same) {
  const auto here = std::span(now.near).subspan(now.near_start[r], now.near_start[r + 1] - now.near_start[r]);
  const auto there =
      std::span(before.near).subspan(before.near_start[p], before.near_start[p + 1] - before.near_start[p]);
  return std::equal(here.begin(), here.end(), there.begin(), there.end(),
                    [&](std::int32_t a, std::int32_t b) { return same[a] == b; });
}

/// Whether a polygon is drawn along the directions that an earlier one was.
bool same_directions(const Scene& scene, std::int32_t q, const EarlierBake& earlier, std::span<const Slope> slopes,
                     std::int32_t p) {
  const auto here = slopes_of(scene.polygons, scene.slopes, q), there = slopes_of(earlier.polygons, slopes, p);
  return std::equal(here.begin(), here.end(), there.begin(), there.end());
}

void check(const Scene& scene, const EarlierBake& earlier, const Texture& texture) {
  const auto fits = [](std::span<const std::uint8_t> before, const Array<std::uint8_t>& now) {
    return before.size() == now.size();
  };
  bool all = fits(earlier.color, texture.color) && fits(earlier.normal, texture.normal) &&
             earlier.layers.size() == texture.layers.size() &&
             earlier.texels.size() == earlier.polygons.loop_start.size() &&
             earlier.partition.face_region.size() == scene.mesh.triangles().size();
  for (std::size_t l = 0; all && l < texture.layers.size(); ++l) all = fits(earlier.layers[l], texture.layers[l]);
  if (!all) throw InvalidInput("the earlier texture has other images, or is not of this mesh");
}

}  // namespace

std::vector<std::int32_t> unchanged_polygons(const Scene& scene, std::span<const std::uint8_t> known,
                                             const EarlierBake& earlier, const Texture& texture, const Threads& threads,
                                             Job& job) {
  const Atlas &atlas = scene.atlas, &old = earlier.atlas;
  std::vector<std::int32_t> same(scene.polygons.loop_start.size(), kNone);
  if (atlas.side != old.side || atlas.tiles != old.tiles || atlas.gutter != old.gutter || atlas.scale != old.scale)
    return same;
  check(scene, earlier, texture);
  const std::vector<std::int32_t>& found = atlas.from;
  const Neighbourhood before = find_neighbourhood(scene.mesh, earlier.partition, known);
  const std::vector<std::int32_t> regions = same_regions(scene.near, before, earlier.partition);
  const std::vector<Slope> slopes = corner_slopes(earlier.polygons, old);
  for (std::int32_t q = 0; q < scene.polygons.polygon_count(); ++q) {
    const std::int32_t p = found[q];
    if (p == kNone || !(atlas.frame[q] == old.frame[p]) || !same_directions(scene, q, earlier, slopes, p)) continue;
    const std::int32_t r = scene.polygons.polygon_region[q], s = earlier.polygons.polygon_region[p];
    if (regions[r] == s && same_near(scene.near, r, before, s, regions)) same[q] = p;
  }
  const Array<std::int32_t> owner = find_owners(earlier.polygons, old, threads, job);
  for (std::size_t i = 0; i < owner.size(); ++i) {  // gutters of removed polygons may have become others'
    const std::int32_t now = scene.owner[i];
    if (now == kNone || same[polygon_of(now)] == kNone) continue;
    const std::int32_t p = same[polygon_of(now)];
    if (owner[i] != (now >= 0 ? p : -2 - p)) same[polygon_of(now)] = kNone;
  }
  return same;
}

}  // namespace isimp::detail
