// The umbrella operator: Kobbelt, Campagna, Vorsatz, Seidel: Interactive multi-resolution modeling, 1998.

#include "density/noise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace isimp {
namespace {

constexpr double kMedianOfNormal = 0.6745;  // median of |x|, x normal with deviation 1
constexpr double kTwiceUmbrella = 1.359;    // deviation of what is left of such noise where six edges meet
constexpr double kMostNoise = 0.5;          // of an edge's length
constexpr std::size_t kFewest = 50;         // vertices; a mesh of fewer is no scan
constexpr std::int32_t kPollEvery = 0xffff;

struct Ring {
  Vec3 sum = Vec3::Zero();
  std::int32_t count = 0;
};

/// Subtracts from each vector the mean over the vertices that half-edges lead to.
std::vector<Vec3> umbrella(const Mesh& mesh, std::span<const Vec3> values, Job& job) {
  std::vector<Ring> rings(values.size());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & kPollEvery) == 0) job.poll();
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      Ring& ring = rings[mesh.from(h)];
      ring.sum += values[mesh.to(h)];
      ++ring.count;
    }
  }
  std::vector<Vec3> result(values.size(), Vec3::Zero());
  for (std::size_t v = 0; v < values.size(); ++v) {
    if ((v & kPollEvery) == 0) job.poll();
    if (rings[v].count > 0) result[v] = values[v] - rings[v].sum / rings[v].count;
  }
  return result;
}

}  // namespace

double surface_size(const Mesh& mesh) {
  const auto vertices = mesh.vertices();
  const Vec3 origin = vertices[mesh.triangles()[0][0]];  // near the surface, so that far-off scenes lose no digits
  double area = 0.0, squares = 0.0;
  Vec3 first = Vec3::Zero();
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 a = vertices[t[0]] - origin, b = vertices[t[1]] - origin, c = vertices[t[2]] - origin;
    const double share = (b - a).cross(c - a).norm() / 2;
    area += share;
    first += share / 3 * (a + b + c);
    squares += share / 12 * (a.squaredNorm() + b.squaredNorm() + c.squaredNorm() + (a + b + c).squaredNorm());
  }
  if (!(area > 0)) return mesh.diagonal();
  return 3 * std::sqrt(std::max(0.0, squares / area - (first / area).squaredNorm()));
}

double mean_edge(const Mesh& mesh) { return std::sqrt(mesh.graph().area / mesh.face_count() * 4 / std::sqrt(3.0)); }

double estimate_noise(const Mesh& mesh, Job& job) {
  const auto vertices = mesh.vertices();
  const std::vector<Vec3> twice = umbrella(mesh, umbrella(mesh, vertices, job), job);
  std::vector<Vec3> normals(vertices.size(), Vec3::Zero());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & kPollEvery) == 0) job.poll();
    const Triangle& t = mesh.triangles()[f];
    const Vec3 cross = (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]);
    for (const std::int32_t v : t) normals[v] += cross;
  }
  std::vector<double> left;
  left.reserve(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if ((v & kPollEvery) == 0) job.poll();
    const std::int32_t h = mesh.vertex_halfedge()[v];
    const double length = normals[v].norm();
    if (h == kNone || mesh.opposite(h) == kNone || !(length > 0)) continue;
    left.push_back(std::abs(twice[v].dot(normals[v])) / length);
  }
  if (left.size() < kFewest) return 0.0;
  const auto middle = left.begin() + static_cast<std::ptrdiff_t>(left.size() / 2);
  std::nth_element(left.begin(), middle, left.end());
  job.poll();
  const double noise = *middle / kMedianOfNormal / kTwiceUmbrella;
  return noise > kMostNoise * mean_edge(mesh) ? 0.0 : noise;
}

}  // namespace isimp
