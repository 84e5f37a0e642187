#include "isimp/texture/occlusion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "images/flood.h"
#include "images/ray_tree.h"
#include "images/relief.h"
#include "isimp/core/errors.h"
#include "isimp/core/threads.h"
#include "isimp/core/to_integer.h"

namespace isimp {
namespace {

// tuned texture
constexpr std::int32_t kGroup = 3;  // texels a side that share all directions
constexpr float kLift = 1e-5F;      // rounding: share of the diagonal by which rays start above their face

/// Directions about z, cosine-weighted: points of a spiral that cover the disc evenly, lifted to the hemisphere (Malley's
/// method; the spiral turns by the golden ratio). Each texel of a group uses every ninth one.
std::vector<Eigen::Vector3f> directions(std::int32_t count) {
  std::vector<Eigen::Vector3f> all(count);
  for (std::int32_t i = 0; i < count; ++i) {
    const double height = (i + 0.5) / count, turn = std::fmod(i * 0.6180339887498949, 1.0) * 2 * std::numbers::pi;
    const double r = std::sqrt(height);
    all[i] = {static_cast<float>(r * std::cos(turn)), static_cast<float>(r * std::sin(turn)),
              static_cast<float>(std::sqrt(1 - height))};
  }
  return all;
}

/// Turns z to a unit vector (Duff and others 2017, Building an orthonormal basis, revisited).
Eigen::Matrix3f frame_of(const Eigen::Vector3f& n) {
  const float sign = std::copysign(1.0F, n.z()), a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
  Eigen::Matrix3f frame;
  frame.col(0) = Eigen::Vector3f(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  frame.col(1) = Eigen::Vector3f(b, sign + n.y() * n.y() * a, -n.y());
  frame.col(2) = n;
  return frame;
}

/// Counts the rays that meet no face.
class Tracer {
 public:
  /// \param some  the faces that stop rays
  Tracer(const Mesh& mesh, std::span<const std::int32_t> some, const TextureOptions& options, Job& job)
      : mesh_(mesh),
        normals_(detail::vertex_normals(mesh)),
        tree_(mesh, some, job),
        each_(std::max(1, options.occlusion_rays / (kGroup * kGroup))),
        directions_(directions(each_ * kGroup * kGroup)),
        reach_(options.occlusion_distance ? static_cast<float>(*options.occlusion_distance)
                                          : std::numeric_limits<float>::infinity()) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const std::int32_t f : some)
      for (const std::int32_t v : mesh.triangles()[f]) {
        low = low.cwiseMin(mesh.vertices()[v]);
        high = high.cwiseMax(mesh.vertices()[v]);
      }
    lift_ = kLift * static_cast<float>((high - low).norm());
  }

  /// \param k  index of the texel in its group
  /// \return the share of the rays that nothing stops
  [[nodiscard]] float open(std::int32_t face, float b, float c, std::int32_t k) const {
    const Triangle& t = mesh_.triangles()[face];
    const auto v = mesh_.vertices();
    const Eigen::Vector3f u = (v[t[1]] - v[t[0]]).cast<float>(), w = (v[t[2]] - v[t[0]]).cast<float>();
    Eigen::Vector3f flat = u.cross(w), smooth = detail::smooth_normal(mesh_, normals_, face, b, c);
    if (!(flat.norm() > 0)) flat = smooth;
    if (!(smooth.norm() > 0)) smooth = flat;
    if (!(flat.norm() > 0)) return 1;
    flat.normalize();
    smooth.normalize();
    const Eigen::Vector3f origin = v[t[0]].cast<float>() + b * u + c * w + lift_ * flat;
    const Eigen::Matrix3f frame = frame_of(smooth);
    std::int32_t away = 0;
    for (std::int32_t i = 0; i < each_; ++i) {
      Eigen::Vector3f d = frame * directions_[i * kGroup * kGroup + k];
      const float below = d.dot(flat);
      if (below < 0) d -= 2 * below * flat;  // else the face's own neighbours would stop it
      away += tree_.hits(origin, d, reach_, face) ? 0 : 1;
    }
    return static_cast<float>(away) / static_cast<float>(each_);
  }

 private:
  const Mesh& mesh_;
  std::vector<Eigen::Vector3f> normals_;
  detail::RayTree tree_;
  std::int32_t each_;
  std::vector<Eigen::Vector3f> directions_;
  float reach_, lift_ = 0;
};

void check(const Mesh& mesh, const BakeMap& map) {
  const std::size_t pixels = static_cast<std::size_t>(map.side) * map.rows;
  if (map.polygon.size() != pixels || map.face.size() != pixels || map.barycentric.size() != 2 * pixels)
    throw InvalidInput("the map has not side x rows texels");
  for (const std::int32_t f : map.face)
    if (f < kNone || f >= mesh.face_count())
      throw InvalidInput("the map shows face " + std::to_string(f) + ", but the mesh has " +
                         std::to_string(mesh.face_count()));
}

/// A grey pixel: the mean of the texels around this one that belong to the same polygon.
void smooth(const BakeMap& map, const Array<float>& open, std::size_t at, std::uint8_t* rgba) {
  const auto x = static_cast<std::int32_t>(at % map.side), y = static_cast<std::int32_t>(at / map.side);
  constexpr std::int32_t kReach = kGroup / 2;  // unit
  float sum = 0, count = 0;
  for (std::int32_t j = std::max(0, y - kReach); j <= std::min(map.rows - 1, y + kReach); ++j)
    for (std::int32_t i = std::max(0, x - kReach); i <= std::min(map.side - 1, x + kReach); ++i) {
      const std::size_t near = static_cast<std::size_t>(j) * map.side + i;
      if (map.polygon[near] != map.polygon[at]) continue;
      sum += open[near];
      ++count;
    }
  const auto value = to_integer(std::round(sum / count * 255), std::uint8_t{0}, std::uint8_t{255});
  rgba[0] = rgba[1] = rgba[2] = value;
  rgba[3] = 255;
}

}  // namespace

Array<std::uint8_t> occlusion(const Mesh& mesh, const Partition& partition, const BakeMap& map,
                              const TextureOptions& options, Job& job) {
  check_fields(options);
  check_is_of(mesh, partition);
  check(mesh, map);
  const Threads threads(options.threads);
  std::vector<std::int32_t> some;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (partition.kept_region(f) != kNone) some.push_back(f);
  const Tracer tracer(mesh, some, options, job);
  const std::size_t pixels = map.polygon.size();
  std::vector<std::size_t> texels;
  for (std::size_t i = 0; i < pixels; ++i)
    if (map.polygon[i] != kNone) texels.push_back(i);
  if (texels.size() > std::numeric_limits<std::int32_t>::max())
    throw InvalidInput("occlusion has at most 2^31 - 1 texels, this atlas has " + std::to_string(texels.size()));
  const auto count = static_cast<std::int32_t>(texels.size());
  Array<float> open(pixels);
  std::atomic<std::int32_t> done{0};
  const std::thread::id caller = std::this_thread::get_id();
  const auto each = [&](auto body) {
    threads.blocks(count, 4096, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      for (std::int32_t i = begin; i < end; ++i) {
        if (i % 64 == 0) job.poll();
        body(texels[i]);
      }
      done += end - begin;
      if (std::this_thread::get_id() == caller) job.report(done / (2.0 * std::max(count, 1)));
    });
  };
  each([&](std::size_t at) {
    const auto x = static_cast<std::int32_t>(at % map.side), y = static_cast<std::int32_t>(at / map.side);
    const std::int32_t f = map.face[at];
    open[at] = f == kNone ? 1.0F
                          : tracer.open(f, map.barycentric[2 * at], map.barycentric[2 * at + 1],
                                        x % kGroup + kGroup * (y % kGroup));
  });
  Array<std::uint8_t> rgba(4 * pixels);
  each([&](std::size_t at) { smooth(map, open, at, rgba.data() + 4 * at); });
  Array<std::int32_t> owner(pixels);  // rows from the bottom
  for (std::int32_t y = 0; y < map.rows; ++y)
    std::copy_n(map.polygon.begin() + static_cast<std::ptrdiff_t>(y) * map.side, map.side,
                owner.begin() + static_cast<std::ptrdiff_t>(map.rows - 1 - y) * map.side);
  for (std::int32_t tile = 0; tile < map.rows / map.side; ++tile)
    detail::flood(owner, map.side, tile, detail::Rgba::Constant(255), rgba, job);
  Array<std::uint8_t> grey(pixels);
  for (std::size_t i = 0; i < pixels; ++i) grey[i] = rgba[4 * i];
  return grey;
}

}  // namespace isimp
