#include "images/shade.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

// tuned texture
constexpr float kSteep = 0.25F;  // texels: narrower faces are sampled by weights, which end at their edges

/// Twice the area over the longest edge: the width of a face in the plane.
float width_of(const FlatFace& f) {
  float longest = 0;
  for (int k = 0, m = 2; k < 3; m = k++) longest = std::max(longest, std::hypot(f.x[k] - f.x[m], f.y[k] - f.y[m]));
  return longest > 0 ? 1 / (f.over * longest) : 0;
}

void store(const Rgba& colour, std::uint8_t* rgba) {
  for (int k = 0; k < 4; ++k) rgba[k] = to_integer(colour[k] + 0.5F, std::uint8_t{0}, std::uint8_t{255});
}

}  // namespace

ColourShade::ColourShade(const Scene& scene, const PolygonView& view, std::int32_t q, Canvas& canvas)
    : mesh_(scene.mesh),
      view_(view),
      canvas_(canvas),
      looks_(view.faces().size()),
      polygon_(q),
      with_normals_(!canvas.texture.normal.empty()),
      with_layers_(!canvas.layers.empty() || canvas.relief) {
  layer_sums_.resize(canvas.layers.size());
  const ChartFrame& frame = scene.atlas.frame[q];
  tangent_.row(0) = frame.u.normalized().cast<float>();
  tangent_.row(1) = frame.v.normalized().cast<float>();
  tangent_.row(2) = frame.n.cast<float>();
}

ColourShade::~ColourShade() {
  // Threads that bake squares of the same polygon add to the same numbers.
  PolygonTexels& all = canvas_.texture.texels[polygon_];
  std::atomic_ref(all.inside) += counts_.inside;
  std::atomic_ref(all.searched) += counts_.searched;
  std::atomic_ref(all.unknown) += counts_.unknown;
}

void ColourShade::operator()(const Texel& texel, const Samples& samples) {
  sum_.setZero();
  for (Rgba& sum : layer_sums_) sum.setZero();
  weight_ = 0;
  bool searched = false;
  if (texel.closest < 1) searched = add_drawn(texel, samples);
  if (texel.closest > 0) add(texel.hit, texel.closest);
  const bool unknown = weight_ <= 0;
  const std::size_t pixel = canvas_.pixel(texel);
  store(unknown ? canvas_.sampler.mean() : Rgba(sum_ / weight_), canvas_.texture.color.data() + 4 * pixel);
  for (std::size_t l = 0; l < layer_sums_.size(); ++l)
    store(unknown ? canvas_.layers[l].mean() : Rgba(layer_sums_[l] / weight_),
          canvas_.texture.layers[l].data() + 4 * pixel);
  if (with_normals_) take_normal(canvas_.texture.normal.data() + 3 * pixel);
  if (!texel.inside) return;
  ++counts_.inside;
  counts_.searched += searched ? 1 : 0;
  counts_.unknown += unknown ? 1 : 0;
}

/// Adds the samples that were drawn; returns whether a place had to be searched for. Samples of one face share their
/// normal.
bool ColourShade::add_drawn(const Texel& texel, const Samples& samples) {
  const std::int32_t n = samples.n, width = samples.box.width() * n;
  const float share = (1 - texel.closest) / static_cast<float>(n * n), step = 1 / static_cast<float>(n);
  bool missing = false;
  const std::size_t first = static_cast<std::size_t>(texel.y - samples.box.y0) * n * width +
                            static_cast<std::size_t>(texel.x - samples.box.x0) * n;
  for (std::int32_t j = 0; j < n; ++j)
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t index = samples.index[first + static_cast<std::size_t>(j) * width + i];
      if (index == kNone) {
        missing = true;
        continue;
      }
      const float x = static_cast<float>(texel.x) + (static_cast<float>(i) + 0.5F) * step;
      const float y = static_cast<float>(texel.y) + (static_cast<float>(j) + 0.5F) * step;
      const FaceLook& face = look(index);
      if (face.steepness == FaceLook::Steepness::steep) {
        add(view_.at(index, x, y), share);
        continue;
      }
      const float dx = x - face.x, dy = y - face.y;
      const Eigen::Vector2f pixel = face.pixel + dx * face.per_x + dy * face.per_y;
      sum_ += share * canvas_.sampler.at_pixel(face.image, pixel.x(), pixel.y());
      weight_ += share;
      if (with_layers_) add_layers(view_.at(index, x, y), share);
      if (!with_normals_ || canvas_.relief) continue;
      normal_ += share * (face.normal + dx * face.normal_per_x + dy * face.normal_per_y);
    }
  if (missing) add_searched(texel, samples, share);
  return missing;
}

/// Adds the closest places for samples that no face was drawn to, four at once.
void ColourShade::add_searched(const Texel& texel, const Samples& samples, float share) {
  const std::int32_t n = samples.n, width = samples.box.width() * n;
  const float step = 1 / static_cast<float>(n);
  const std::size_t first = static_cast<std::size_t>(texel.y - samples.box.y0) * n * width +
                            static_cast<std::size_t>(texel.x - samples.box.x0) * n;
  // A face found in this row of this square helps; the result must not depend on the threads.
  if (texel.y != last_y_ || texel.x < last_x_ || last_x_ < samples.box.x0) last_ = kNone;
  for (std::int32_t j = 0; j < n; j += 2)
    for (std::int32_t i = 0; i < n; i += 2) {
      Quad quad{static_cast<float>(texel.x) + (static_cast<float>(i) + 0.5F) * step,
                static_cast<float>(texel.y) + (static_cast<float>(j) + 0.5F) * step, step, 0};
      for (std::int32_t k = 0; k < 4; ++k) {
        const std::int32_t a = i + k % 2, b = j + k / 2;
        if (a < n && b < n && samples.index[first + static_cast<std::size_t>(b) * width + a] == kNone)
          quad.wanted |= 1U << k;
      }
      if (quad.wanted == 0) continue;
      const std::array<Hit, 4> hits =
          view_.closest(quad, {last_, texel.closest > 0 ? texel.hit.index : kNone}, samples.visited);
      for (std::int32_t k = 0; k < 4; ++k) {
        if ((quad.wanted >> k & 1) == 0) continue;
        add(hits[k], share);
        last_ = hits[k].index;
      }
    }
  last_x_ = texel.x;
  last_y_ = texel.y;
}

void ColourShade::add(const Hit& hit, float weight) {
  if (hit.face == kNone) return;
  sum_ += weight * canvas_.sampler(hit.face, hit.b, hit.c);
  weight_ += weight;
  if (with_layers_) add_layers(hit, weight);
  if (with_normals_ && !canvas_.relief)
    normal_ += weight * smooth_normal(mesh_, canvas_.normals, hit.face, hit.b, hit.c);
}

void ColourShade::add_layers(const Hit& hit, float weight) {
  for (std::size_t l = 0; l < layer_sums_.size(); ++l)
    layer_sums_[l] += weight * canvas_.layers[l](hit.face, hit.b, hit.c);
  if (canvas_.relief) normal_ += weight * (*canvas_.relief)(hit.face, hit.b, hit.c);
}

const FaceLook& ColourShade::look(std::int32_t index) {
  FaceLook& face = looks_[index];
  if (face.steepness != FaceLook::Steepness::unknown) return face;
  face.steepness = FaceLook::Steepness::steep;
  const FlatFace& f = view_.faces()[index];
  if (!(width_of(f) > kSteep)) return face;
  const auto pixels = canvas_.sampler.corner_pixels(f.face);
  if (!pixels) return face;
  // The weights of corners 1 and 2 grow by these in a texel.
  const float b_x = (f.y[2] - f.y[0]) * f.over, b_y = (f.x[0] - f.x[2]) * f.over;
  const float c_x = (f.y[0] - f.y[1]) * f.over, c_y = (f.x[1] - f.x[0]) * f.over;
  const auto& p = *pixels;
  face.x = f.x[0];
  face.y = f.y[0];
  face.image = canvas_.sampler.image(f.face);
  face.pixel = p[0];
  face.per_x = b_x * (p[1] - p[0]) + c_x * (p[2] - p[0]);
  face.per_y = b_y * (p[1] - p[0]) + c_y * (p[2] - p[0]);
  if (with_normals_) {
    const Triangle& t = mesh_.triangles()[f.face];
    const Eigen::Vector3f n = canvas_.normals[t[0]], b = canvas_.normals[t[1]] - n, c = canvas_.normals[t[2]] - n;
    face.normal = n;
    face.normal_per_x = b_x * b + c_x * c;
    face.normal_per_y = b_y * b + c_y * c;
  }
  face.steepness = FaceLook::Steepness::flat;
  return face;
}

/// Writes the mean normal in the polygon's tangent frame, and forgets it.
void ColourShade::take_normal(std::uint8_t* rgb) {
  Eigen::Vector3f local = tangent_ * normal_;
  local.z() = std::max(local.z(), 0.02F * normal_.norm());
  const float length = local.norm();
  local = length > 1e-12F ? Eigen::Vector3f(local / length) : Eigen::Vector3f::UnitZ();
  for (int k = 0; k < 3; ++k) rgb[k] = static_cast<std::uint8_t>(local[k] * 127.5F + 128.0F);
  normal_.setZero();
}

}  // namespace isimp::detail
