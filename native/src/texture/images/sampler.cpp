#include "images/sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "isimp/core/errors.h"

namespace isimp::detail {
namespace {

constexpr float kEdge = 1e-4F;  // rounding: rounding beyond an image's edge is no repetition

void check(const Mesh& mesh, const Appearance& look) {
  const auto faces = static_cast<std::size_t>(mesh.face_count());
  if (look.uv.size() != 6 * faces || look.image.size() != faces ||
      (!look.colors.empty() && look.colors.size() != 12 * faces) || (!look.known.empty() && look.known.size() != faces))
    throw InvalidInput("the texture's arrays are not of this mesh, which has " + std::to_string(faces) + " faces");
  for (std::size_t f = 0; f < faces; ++f)
    if (look.image[f] < kNone || look.image[f] >= static_cast<std::int32_t>(look.pictures.size()))
      throw InvalidInput("face " + std::to_string(f) + " uses image " + std::to_string(look.image[f]) +
                         ", but there are " + std::to_string(look.pictures.size()));
  for (std::size_t i = 0; i < look.pictures.size(); ++i) {
    const Picture& p = look.pictures[i];
    const auto values = 4 * static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height);
    if (values == 0 || std::max(p.bytes.size(), p.words.size()) != values)
      throw InvalidInput("image " + std::to_string(i) + " has no pixels, or not width x height of them");
  }
}

template <class T>
Rgba pixel_at(const T* p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), static_cast<float>(p[3])};
}

#ifdef __SSE2__
/// The same numbers, four at once, which compilers do not find.
Rgba pixel_at(const std::uint8_t* p) {
  std::int32_t bytes;
  std::memcpy(&bytes, p, 4);
  const __m128i zero = _mm_setzero_si128();
  const __m128i wide = _mm_unpacklo_epi16(_mm_unpacklo_epi8(_mm_cvtsi32_si128(bytes), zero), zero);
  Rgba pixel;
  _mm_store_ps(pixel.data(), _mm_cvtepi32_ps(wide));
  return pixel;
}
#endif

template <class T>
Rgba bilinear(const T* pixels, std::int32_t w, std::int32_t h, float x, float y, bool repeat) {
  // At least -0.5; truncation is much cheaper than floor.
  std::int32_t x0 = static_cast<std::int32_t>(x + 1) - 1, y0 = static_cast<std::int32_t>(y + 1) - 1;
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  std::int32_t x1 = x0 + 1, y1 = y0 + 1;
  if (x0 < 0 || y0 < 0 || x1 >= w || y1 >= h) {
    const auto within = [&](std::int32_t i, std::int32_t n) {
      if (!repeat) return std::clamp(i, 0, n - 1);
      return i < 0 ? n - 1 : i >= n ? 0 : i;
    };
    x0 = within(x0, w);
    y0 = within(y0, h);
    x1 = within(x1, w);
    y1 = within(y1, h);
  }
  const T* upper = pixels + 4 * static_cast<std::size_t>(y0) * w;
  const T* lower = pixels + 4 * static_cast<std::size_t>(y1) * w;
  const Rgba above = (1 - a) * pixel_at(upper + 4 * x0) + a * pixel_at(upper + 4 * x1);
  const Rgba below = (1 - a) * pixel_at(lower + 4 * x0) + a * pixel_at(lower + 4 * x1);
  return (1 - b) * above + b * below;
}

}  // namespace

Sampler::Sampler(const Mesh& mesh, const Appearance& appearance) : look_(appearance) {
  check(mesh, appearance);
  repeats_.resize(appearance.image.size());
  for (std::size_t f = 0; f < repeats_.size(); ++f)
    for (std::size_t k = 6 * f; k < 6 * f + 6; ++k)
      if (appearance.uv[k] < -kEdge || appearance.uv[k] > 1 + kEdge) repeats_[f] = 1;
  double area = 0;
  std::array<double, 4> sum{};
  const auto v = mesh.vertices();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.triangles()[f];
    const double a = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm();
    if (!(a > 0) || (!look_.known.empty() && look_.known[f] == 0)) continue;
    const Rgba colour = (*this)(f, 1 / 3.0F, 1 / 3.0F);
    for (int k = 0; k < 4; ++k) sum[k] += a * colour[k];
    area += a;
  }
  for (int k = 0; k < 4; ++k) mean_[k] = area > 0 ? static_cast<float>(sum[k] / area) : 128.0F;
  if (!(area > 0)) mean_[3] = 255;
}

Rgba Sampler::operator()(std::int32_t face, float b, float c) const {
  if (look_.image[face] >= 0) return from_picture(face, b, c);
  if (look_.colors.empty()) return {204, 204, 204, 255};
  const std::uint8_t* p = look_.colors.data() + 12 * static_cast<std::size_t>(face);
  return (1 - b - c) * pixel_at(p) + b * pixel_at(p + 4) + c * pixel_at(p + 8);
}

Rgba Sampler::from_picture(std::int32_t face, float b, float c) const {
  const Picture& picture = look_.pictures[look_.image[face]];
  const float* t = look_.uv.data() + 6 * static_cast<std::size_t>(face);
  const float a = 1 - b - c;
  float u = a * t[0] + b * t[2] + c * t[4], v = a * t[1] + b * t[3] + c * t[5];
  if (!std::isfinite(u) || !std::isfinite(v)) u = v = 0;
  const bool repeat = repeats_[face] != 0;
  if (repeat) {
    u -= std::floor(u);
    v -= std::floor(v);
  }
  const float x = std::clamp(u, 0.0F, 1.0F) * static_cast<float>(picture.width) - 0.5F;
  const float y = (1 - std::clamp(v, 0.0F, 1.0F)) * static_cast<float>(picture.height) - 0.5F;
  return in(picture, x, y, repeat);
}

Rgba Sampler::in(const Picture& picture, float x, float y, bool repeat) {
  if (!picture.bytes.empty()) return bilinear(picture.bytes.data(), picture.width, picture.height, x, y, repeat);
  return bilinear(picture.words.data(), picture.width, picture.height, x, y, repeat) / 257;
}

Rgba Sampler::at_pixel(std::int32_t image, float x, float y) const {
  const Picture& picture = look_.pictures[image];
  const auto within = [](float at, std::int32_t size) {  // any pixel if not a number
    return at > -0.5F ? std::min(at, static_cast<float>(size) - 0.5F) : -0.5F;
  };
  return in(picture, within(x, picture.width), within(y, picture.height), false);
}

std::optional<std::array<Eigen::Vector2f, 3>> Sampler::corner_pixels(std::int32_t face) const {
  if (look_.image[face] < 0 || repeats_[face] != 0) return std::nullopt;
  const Picture& picture = look_.pictures[look_.image[face]];
  std::array<Eigen::Vector2f, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const float* t = look_.uv.data() + 6 * static_cast<std::size_t>(face) + 2 * k;
    if (!std::isfinite(t[0]) || !std::isfinite(t[1])) return std::nullopt;
    corners[k] = {t[0] * static_cast<float>(picture.width) - 0.5F,
                  (1 - t[1]) * static_cast<float>(picture.height) - 0.5F};
  }
  return corners;
}

double Sampler::pixels(std::int32_t face) const {
  const std::int32_t image = look_.image[face];
  if (image < 0) return 0;
  const float* t = look_.uv.data() + 6 * static_cast<std::size_t>(face);
  const double turned = (t[2] - t[0]) * (t[5] - t[1]) - (t[4] - t[0]) * (t[3] - t[1]);
  const double pixels = std::abs(turned) / 2 * look_.pictures[image].width * look_.pictures[image].height;
  return std::isfinite(pixels) ? pixels : 0;
}

}  // namespace isimp::detail
