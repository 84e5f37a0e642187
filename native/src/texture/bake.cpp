#include "isimp/texture/bake.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "flood.h"
#include "isimp/core/errors.h"
#include "sampler.h"
#include "view.h"

namespace isimp {
namespace {

using detail::Hit;
using detail::PolygonView;
using detail::TexelBox;

constexpr std::int32_t kLeastSamples = 2, kMostSamples = 4;  // a side of a texel
constexpr float kSeen = 1.5F;  // texels of the gutter that show at an edge, between pixels
constexpr float kFar = std::numeric_limits<float>::infinity();

/// What the baking of all polygons has in common.
struct Scene {
  const Mesh& mesh;
  const PolygonMesh& polygons;
  const Atlas& atlas;
  detail::Neighbourhood near;
  Array<std::int32_t> owner;
  float band;  // texels

  Scene(const Mesh& m, const Partition& partition, const PolygonMesh& poly, const Atlas& a,
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
    near = detail::find_neighbourhood(mesh, partition, known);
    owner = detail::find_owners(polygons, atlas, threads, job);
    band = static_cast<float>(options.band) * static_cast<float>(atlas.side) / 2048;
  }
};

/// The samples of one tile of a polygon.
struct Samples {
  std::vector<std::int32_t> index;  // (n * width by n * height) of the view's faces
  std::vector<float> depth;
  std::vector<float> edge;  // (width by height) distance of each texel from the polygon's edges
  TexelBox box;
  std::int32_t n = 1;
};

/// What a texel shows: samples that were drawn, and the share of the closest point in place of them.
struct Texel {
  std::int32_t x, y;  // from the bottom
  std::int32_t polygon;
  bool inside;
  float closest;  // 0 to 1
};

/// Draws a tile and calls shade(texel, samples) for each texel that its polygon owns.
template <class Shade>
void do_tile(const Scene& scene, const PolygonView& view, std::int32_t q, std::int32_t t, std::int32_t n,
             Samples& samples, Shade& shade) {
  samples.box = view.tile(t);
  samples.n = n;
  view.draw(t, n, samples.index, samples.depth);
  const TexelBox& box = samples.box;
  samples.edge.assign(static_cast<std::size_t>(box.width()) * box.height(), kFar);
  if (scene.band > 0)
    detail::measure_edges(detail::outline_of(scene.polygons, scene.atlas, q), box, scene.band, samples.edge);
  for (std::int32_t y = box.y0; y < box.y1; ++y)
    for (std::int32_t x = box.x0; x < box.x1; ++x) {
      const std::int32_t owner = scene.owner[static_cast<std::size_t>(y) * scene.atlas.side + x];
      if (owner == kNone || detail::polygon_of(owner) != q) continue;
      const float edge = samples.edge[static_cast<std::size_t>(y - box.y0) * box.width() + (x - box.x0)];
      float blend = scene.band <= 0 ? 0.0F : std::clamp(1 - edge / scene.band, 0.0F, 1.0F);
      if (owner < 0 && scene.band > 0) blend = edge <= kSeen ? 1.0F : 0.0F;
      shade(Texel{x, y, q, owner >= 0, blend}, samples);
    }
}

/// Bakes all polygons: small ones share the threads, and so do the tiles of large ones. `make_shade(view, q)` makes
/// what is called for each texel, `samples_of(q)` is how many samples a side one has.
template <class SamplesOf, class MakeShade>
void for_all(const Scene& scene, const Threads& threads, Job& job, SamplesOf samples_of, MakeShade make_shade) {
  const std::int32_t count = scene.polygons.polygon_count();
  const auto look = [&](PolygonView& view, std::int32_t q) {
    ChartFrame frame = scene.atlas.frame[q];
    frame.origin -= scene.mesh.origin();
    view.look(frame,
              detail::box_of_outline(detail::outline_of(scene.polygons, scene.atlas, q), scene.atlas.gutter,
                                     scene.atlas.side),
              scene.polygons.polygon_region[q]);
  };
  std::vector<std::int32_t> small, large;
  for (std::int32_t q = 0; q < count; ++q) {
    const TexelBox box = detail::box_of_outline(detail::outline_of(scene.polygons, scene.atlas, q), scene.atlas.gutter,
                                                scene.atlas.side);
    if (box.width() <= 0 || box.height() <= 0) continue;
    const bool one_thread_does = std::max(box.width(), box.height()) <= 4 * PolygonView::kTile;
    (one_thread_does ? small : large).push_back(q);
  }
  std::atomic<std::int32_t> done{0};
  PolygonView shared(scene.mesh, scene.near);
  for (const std::int32_t q : large) {
    job.report(static_cast<double>(done++) / count);
    look(shared, q);
    const std::int32_t tiles = shared.tile_count();
    threads.share(tiles, [&](const auto& next) {
      Samples samples;
      auto shade = make_shade(shared, q);
      for (std::int32_t t = next(); t < tiles; t = next()) {
        job.poll();
        do_tile(scene, shared, q, t, samples_of(q), samples, shade);
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
      for (std::int32_t t = 0; t < view.tile_count(); ++t) do_tile(scene, view, q, t, samples_of(q), samples, shade);
    }
  });
}

/// Unit normals of the vertices, each face by its area.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3> sum(mesh.vertex_count(), Vec3::Zero());
  const auto v = mesh.vertices();
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 n = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
    for (const std::int32_t vertex : t) sum[vertex] += n;
  }
  std::vector<Eigen::Vector3f> normals(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) normals[i] = sum[i].normalized().cast<float>();
  return normals;
}

/// The scan's normals in the tangent frame of a polygon.
class NormalLook {
 public:
  NormalLook(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, const ChartFrame& frame)
      : mesh_(mesh),
        normals_(normals),
        u_(frame.u.normalized().cast<float>()),
        v_(frame.v.normalized().cast<float>()),
        n_(frame.n.cast<float>()) {}

  void add(const Hit& hit, float weight) {
    if (hit.face == kNone) return;
    const Triangle& t = mesh_.triangles()[hit.face];
    sum_ += weight * ((1 - hit.b - hit.c) * normals_[t[0]] + hit.b * normals_[t[1]] + hit.c * normals_[t[2]]);
  }
  /// Writes the mean and forgets it.
  void take(std::uint8_t* rgb) {
    Eigen::Vector3f local(sum_.dot(u_), sum_.dot(v_), std::max(sum_.dot(n_), 0.02F * sum_.norm()));
    const float length = local.norm();
    local = length > 1e-12F ? Eigen::Vector3f(local / length) : Eigen::Vector3f::UnitZ();
    for (int k = 0; k < 3; ++k) rgb[k] = static_cast<std::uint8_t>(local[k] * 127.5F + 128.0F);
    sum_.setZero();
  }

 private:
  const Mesh& mesh_;
  const std::vector<Eigen::Vector3f>& normals_;
  Eigen::Vector3f u_, v_, n_;
  Eigen::Vector3f sum_ = Eigen::Vector3f::Zero();
};

/// Where colours and normals of the texels go, and what was counted.
struct Canvas {
  Texture& texture;
  const detail::Sampler& sampler;
  const std::vector<Eigen::Vector3f>& normals;
  std::atomic<std::int64_t> texels{0}, searched{0}, unknown{0};

  [[nodiscard]] std::size_t pixel(const Texel& texel) const {
    return static_cast<std::size_t>(texture.side - 1 - texel.y) * texture.side + texel.x;
  }
};

class ColourShade {
 public:
  ColourShade(const Scene& scene, const PolygonView& view, std::int32_t q, Canvas& canvas)
      : view_(view), canvas_(canvas), normal_(scene.mesh, canvas.normals, scene.atlas.frame[q]) {}
  ColourShade(const ColourShade&) = delete;
  ColourShade& operator=(const ColourShade&) = delete;
  ~ColourShade() {
    canvas_.texels += texels_;
    canvas_.searched += searched_;
    canvas_.unknown += unknown_;
  }

  void operator()(const Texel& texel, const Samples& samples) {
    sum_ = {};
    weight_ = 0;
    bool searched = false;
    if (texel.closest < 1) searched = add_drawn(texel, samples);
    if (texel.closest > 0) {
      const std::size_t column = static_cast<std::size_t>(texel.x - samples.box.x0) * samples.n + samples.n / 2;
      const std::size_t row = static_cast<std::size_t>(texel.y - samples.box.y0) * samples.n + samples.n / 2;
      const std::int32_t drawn = samples.index[row * samples.box.width() * samples.n + column];
      // The last texel's face helps the next one's search, within a row of a tile: what threads did before must not tell.
      const bool beside = texel.x > samples.box.x0 && texel.x == last_x_ + 1 && texel.y == last_y_;
      const Hit hit = view_.closest(static_cast<float>(texel.x) + 0.5F, static_cast<float>(texel.y) + 0.5F,
                                    {beside ? last_ : kNone, drawn});
      add(hit, texel.closest);
      last_x_ = texel.x;
      last_y_ = texel.y;
      last_ = hit.index;
    }
    const bool unknown = weight_ <= 0;
    const detail::Rgba mean = canvas_.sampler.mean();
    std::uint8_t* rgba = canvas_.texture.color.data() + 4 * canvas_.pixel(texel);
    for (int k = 0; k < 4; ++k)
      rgba[k] = static_cast<std::uint8_t>(std::clamp((unknown ? mean[k] : sum_[k] / weight_) + 0.5F, 0.0F, 255.0F));
    if (!canvas_.texture.normal.empty()) normal_.take(canvas_.texture.normal.data() + 3 * canvas_.pixel(texel));
    if (!texel.inside) return;
    ++texels_;
    searched_ += searched ? 1 : 0;
    unknown_ += unknown ? 1 : 0;
  }

 private:
  /// Adds what was drawn; returns whether a place had to be searched for.
  bool add_drawn(const Texel& texel, const Samples& samples) {
    const std::int32_t n = samples.n, width = samples.box.width() * n;
    const float share = (1 - texel.closest) / static_cast<float>(n * n), step = 1 / static_cast<float>(n);
    bool searched = false;
    for (std::int32_t j = 0; j < n; ++j) {
      const std::size_t row = static_cast<std::size_t>((texel.y - samples.box.y0) * n + j) * width;
      for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t index = samples.index[row + (texel.x - samples.box.x0) * n + i];
        const float x = static_cast<float>(texel.x) + (static_cast<float>(i) + 0.5F) * step;
        const float y = static_cast<float>(texel.y) + (static_cast<float>(j) + 0.5F) * step;
        if (index != kNone) {
          add(view_.at(index, x, y), share);
        } else {
          add(view_.closest(x, y), share);
          searched = true;
        }
      }
    }
    return searched;
  }

  void add(const Hit& hit, float weight) {
    if (hit.face == kNone) return;
    const detail::Rgba colour = canvas_.sampler(hit.face, hit.b, hit.c);
    for (int k = 0; k < 4; ++k) sum_[k] += weight * colour[k];
    weight_ += weight;
    if (!canvas_.texture.normal.empty()) normal_.add(hit, weight);
  }

  const PolygonView& view_;
  Canvas& canvas_;
  NormalLook normal_;
  detail::Rgba sum_{};
  float weight_ = 0;
  std::int32_t last_x_ = kNone, last_y_ = kNone, last_ = kNone;
  std::int64_t texels_ = 0, searched_ = 0, unknown_ = 0;
};

/// As many samples a side as the scan's images have pixels a texel, within limits.
std::vector<std::int32_t> sample_counts(const Scene& scene, const detail::Sampler& sampler) {
  std::vector<std::int32_t> counts;
  for (const std::int32_t r : scene.polygons.polygon_region) {
    double pixels = 0, area = 0;
    for (std::int32_t i = scene.near.start[r]; i < scene.near.start[r + 1]; ++i) {
      const Triangle& t = scene.mesh.triangles()[scene.near.faces[i]];
      const auto v = scene.mesh.vertices();
      pixels += sampler.pixels(scene.near.faces[i]);
      area += (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm() / 2;
    }
    const double texels = area * scene.atlas.scale * scene.atlas.scale;
    const double ratio = texels > 0 ? std::sqrt(pixels / texels) : 0;
    counts.push_back(static_cast<std::int32_t>(std::clamp(std::ceil(ratio), 1.0 * kLeastSamples, 1.0 * kMostSamples)));
  }
  return counts;
}

}  // namespace

Texture bake(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
             const Appearance& appearance, const TextureOptions& options, Job& job) {
  const Threads threads(options.threads);
  const detail::Sampler sampler(mesh, appearance);
  const Scene scene(mesh, partition, polygons, atlas, appearance.known, options, threads, job);
  const std::vector<Eigen::Vector3f> normals = options.normals ? vertex_normals(mesh) : std::vector<Eigen::Vector3f>();
  Texture texture;
  texture.side = atlas.side;
  const std::size_t pixels = scene.owner.size();
  texture.color.resize(4 * pixels);
  if (options.normals) texture.normal.resize(3 * pixels);
  Canvas canvas{texture, sampler, normals};
  const std::vector<std::int32_t> counts = sample_counts(scene, sampler);
  const Job::Part part(job, "baking", 0, 0.9);
  for_all(
      scene, threads, job, [&](std::int32_t q) { return counts[q]; },
      [&](const PolygonView& view, std::int32_t q) { return ColourShade(scene, view, q, canvas); });
  texture.report = {canvas.texels, canvas.searched, canvas.unknown};
  detail::flood(scene.owner, atlas.side, sampler.mean(), texture, job);
  return texture;
}

BakeMap bake_map(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons, const Atlas& atlas,
                 const TextureOptions& options, Job& job) {
  const Threads threads(options.threads);
  const Scene scene(mesh, partition, polygons, atlas, {}, options, threads, job);
  const std::size_t pixels = scene.owner.size();
  BakeMap map;
  map.side = atlas.side;
  map.polygon.resize(pixels);
  map.face.resize(pixels);
  map.barycentric.resize(2 * pixels);
  map.height.resize(pixels);
  std::fill(map.polygon.begin(), map.polygon.end(), kNone);
  std::fill(map.face.begin(), map.face.end(), kNone);
  std::fill(map.barycentric.begin(), map.barycentric.end(), 0.0F);
  std::fill(map.height.begin(), map.height.end(), 0.0F);
  const auto scale = static_cast<float>(1 / atlas.scale);
  for_all(
      scene, threads, job, [](std::int32_t) { return 1; },
      [&](const PolygonView& view, std::int32_t) {
        return [&map, &view, scale](const Texel& texel, const Samples& samples) {
          const TexelBox& box = samples.box;
          const std::int32_t index =
              samples.index[static_cast<std::size_t>(texel.y - box.y0) * box.width() + (texel.x - box.x0)];
          const auto x = static_cast<float>(texel.x) + 0.5F, y = static_cast<float>(texel.y) + 0.5F;
          const Hit hit =
              index == kNone || texel.closest > 0.5F ? view.closest(x, y, {index, kNone}) : view.at(index, x, y);
          const std::size_t pixel = static_cast<std::size_t>(map.side - 1 - texel.y) * map.side + texel.x;
          if (texel.inside) map.polygon[pixel] = texel.polygon;
          map.face[pixel] = hit.face;
          map.barycentric[2 * pixel] = hit.b;
          map.barycentric[2 * pixel + 1] = hit.c;
          map.height[pixel] = hit.height * scale;
        };
      });
  return map;
}

}  // namespace isimp
