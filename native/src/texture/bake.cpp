#include "isimp/texture/bake.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "images/flood.h"
#include "images/sampler.h"
#include "images/samples.h"
#include "images/shade.h"
#include "isimp/core/check.h"
#include "isimp/core/to_integer.h"

namespace isimp {
namespace {

using detail::Hit;
using detail::PolygonView;
using detail::Samples;
using detail::Scene;
using detail::Texel;
using detail::TexelBox;

// tuned texture
constexpr std::int32_t kLeastSamples = 2;  // least number of samples a side of a texel
constexpr std::int32_t kMostSamples = 4;   // largest number of samples a side of a texel

/// Bakes all polygons: small ones share the threads, and so do the squares of large ones. `make_shade(view, q)` returns
/// the function for each texel, `samples_of(q)` the number of samples along a side.
template <class SamplesOf, class MakeShade>
void for_all(const Scene& scene, const Threads& threads, Job& job, SamplesOf samples_of, MakeShade make_shade) {
  const std::int32_t count = scene.polygons.polygon_count();
  const auto look = [&](PolygonView& view, std::int32_t q) {
    ChartFrame frame = scene.atlas.frame[q];
    frame.origin -= scene.mesh.origin();
    view.look(frame, detail::box_of_outline(scene.polygons, scene.atlas, q), scene.polygons.polygon_region[q],
              scene.lean_of(q));
  };
  std::vector<std::int32_t> small, large;
  for (std::int32_t q = 0; q < count; ++q) {
    const TexelBox box = detail::box_of_outline(scene.polygons, scene.atlas, q);
    if (box.width() <= 0 || box.height() <= 0) continue;
    const bool one_thread_does = std::max(box.width(), box.height()) <= 4 * PolygonView::kSquare;
    (one_thread_does ? small : large).push_back(q);
  }
  std::atomic<std::int32_t> done{0};
  PolygonView shared(scene.mesh, scene.near);
  for (const std::int32_t q : large) {
    job.report(static_cast<double>(done++) / count);
    look(shared, q);
    const std::int32_t squares = shared.square_count();
    threads.share(squares, [&](const auto& next) {
      Samples samples;
      auto shade = make_shade(shared, q);
      for (std::int32_t t = next(); t < squares; t = next()) {
        job.poll();
        detail::bake_square(scene, shared, q, t, samples_of(q), samples, shade);
      }
    });
  }
  const auto rest = static_cast<std::int32_t>(small.size());
  threads.share(rest, [&](const auto& next) {
    PolygonView view(scene.mesh, scene.near);
    Samples samples;
    for (std::int32_t i = next(); i < rest; i = next()) {
      job.poll();
      const std::int32_t q = small[i];
      look(view, q);
      auto shade = make_shade(view, q);
      for (std::int32_t t = 0; t < view.square_count(); ++t)
        detail::bake_square(scene, view, q, t, samples_of(q), samples, shade);
    }
  });
}

/// As many samples a side as the scan's images have pixels a texel, within limits.
std::vector<std::int32_t> sample_counts(const Scene& scene, const detail::Sampler& sampler, const Threads& threads) {
  std::vector<std::int32_t> counts(scene.polygons.loop_start.size(), 0);
  threads.share(static_cast<std::int32_t>(counts.size()), [&](const auto& next) {
    const auto v = scene.mesh.vertices();
    for (std::int32_t q = next(); q < static_cast<std::int32_t>(counts.size()); q = next()) {
      const std::int32_t r = scene.polygons.polygon_region[q];
      double pixels = 0, area = 0;
      for (std::int32_t i = scene.near.start[r]; i < scene.near.start[r + 1]; ++i) {
        const Triangle& t = scene.mesh.triangles()[scene.near.faces[i]];
        pixels += sampler.pixels(scene.near.faces[i]);
        area += (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm() / 2;
      }
      const double texels = area * scene.atlas.scale * scene.atlas.scale;
      const double ratio = texels > 0 ? std::sqrt(pixels / texels) : 0;
      counts[q] = to_integer(std::ceil(ratio), kLeastSamples, kMostSamples);
    }
  });
  return counts;
}

void flood_all(const Scene& scene, const detail::Canvas& canvas, const Threads& threads, Texture& texture, Job& job) {
  const auto images = static_cast<std::int32_t>(texture.layers.size()) + 1;
  const std::int32_t tiles = scene.atlas.tiles;
  threads.share(images * tiles, [&](const auto& next) {
    for (std::int32_t i = next(); i < images * tiles; i = next()) {
      const std::int32_t l = i / tiles - 1;
      detail::flood(scene.owner, texture.side, i % tiles, l < 0 ? canvas.sampler.mean() : canvas.layers[l].mean(),
                    l < 0 ? texture.color : texture.layers[l], job);
    }
  });
  if (!texture.normal.empty()) detail::flood_normals(scene.owner, texture.side, texture.normal);
}

}  // namespace

Texture bake(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
             const Appearance& appearance, const TextureOptions& options, Job& job, const MaterialLayers& layers) {
  const Threads threads(options.threads);
  const detail::Sampler sampler(mesh, appearance);
  const Scene scene(mesh, partition, polygons, atlas, appearance.known, options, threads, job);
  const std::vector<Eigen::Vector3f> normals =
      options.normals ? detail::vertex_normals(mesh) : std::vector<Eigen::Vector3f>();
  Texture texture;
  texture.side = atlas.side;
  texture.height = atlas.height();
  const std::size_t pixels = scene.owner.size();
  texture.color.resize(4 * pixels);
  texture.texels.resize(polygons.loop_start.size());
  if (options.normals) texture.normal.resize(3 * pixels);
  detail::Canvas canvas{texture, sampler, normals, {}, {}};
  for (const Appearance& layer : layers.images) {
    canvas.layers.emplace_back(mesh, layer);
    texture.layers.emplace_back().resize(4 * pixels);
  }
  if (options.normals && layers.relief) canvas.relief.emplace(mesh, normals, *layers.relief);
  const std::vector<std::int32_t> counts = sample_counts(scene, sampler, threads);
  const Job::Stage stage(job, "baking", 0, options.occlusion ? 0.3 : 0.9);
  for_all(
      scene, threads, job, [&](std::int32_t q) { return counts[q]; },
      [&](const PolygonView& view, std::int32_t q) { return detail::ColourShade(scene, view, q, canvas); });
  flood_all(scene, canvas, threads, texture, job);
  return texture;
}

BakeMap bake_map(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
                 const TextureOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Scene scene(mesh, partition, polygons, atlas, {}, options, threads, job);
  const std::size_t pixels = scene.owner.size();
  BakeMap map;
  map.side = atlas.side;
  map.rows = atlas.height();
  map.polygon.resize(pixels);
  map.face.resize(pixels);
  map.barycentric.resize(2 * pixels);
  for (std::int32_t y = 0; y < map.rows; ++y)
    for (std::int32_t x = 0; x < map.side; ++x) {
      const std::int32_t owner = scene.owner_of(x, y);
      map.polygon[static_cast<std::size_t>(map.rows - 1 - y) * map.side + x] = owner >= 0 ? owner : kNone;
    }
  std::fill(map.face.begin(), map.face.end(), kNone);
  std::fill(map.barycentric.begin(), map.barycentric.end(), 0.0F);
  for_all(
      scene, threads, job, [](std::int32_t) { return 1; },
      [&](const PolygonView& view, std::int32_t) {
        return [&map, &view](const Texel& texel, const Samples& samples) {
          const std::int32_t index = samples.middle(texel.x - samples.box.x0, texel.y - samples.box.y0);
          const auto x = static_cast<float>(texel.x) + 0.5F, y = static_cast<float>(texel.y) + 0.5F;
          const Hit hit = texel.closest > 0.5F ? texel.hit : index == kNone ? view.closest(x, y) : view.at(index, x, y);
          const std::size_t pixel = static_cast<std::size_t>(map.rows - 1 - texel.y) * map.side + texel.x;
          ISIMP_ASSERT(texel.closest >= 0 && texel.closest <= 1, "the weight of the closest point is a share");
          ISIMP_ASSERT(hit.face >= 0, "every texel of a polygon has a face of the scan");
          map.face[pixel] = hit.face;
          map.barycentric[2 * pixel] = hit.b;
          map.barycentric[2 * pixel + 1] = hit.c;
        };
      });
  return map;
}

}  // namespace isimp
