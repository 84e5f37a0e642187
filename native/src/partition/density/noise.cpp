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
constexpr std::size_t kFewest = 250;        // vertices; a mesh of fewer is no scan
constexpr std::int32_t kPollEvery = 0xffff;

// Of white noise the operator leaves 1.26 times as much the second time as the first. Where it leaves less, the mesh is a
// coarse one of a curved shape; where more, of a shape with creases between flat parts.
constexpr double kShape = 0.85, kNoise = 1.0, kNoiseToo = 1.6, kShapeToo = 2.0;  // twice over once
constexpr double kFelt = 0.06, kStrong = 0.1;  // of an edge's length: from here on it matters, and fully

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

/// From 0 to 1 on the way from a to b.
double ramp(double x, double a, double b) { return std::clamp((x - a) / (b - a), 0.0, 1.0); }

/// The median of the lengths along the normals, of the vertices away from borders; 0 for too few.
double median_along(const Mesh& mesh, std::span<const Vec3> values, std::span<const Vec3> normals, Job& job) {
  std::vector<double> left;
  left.reserve(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    if ((v & kPollEvery) == 0) job.poll();
    const std::int32_t h = mesh.vertex_halfedge()[v];
    const double length = normals[v].norm();
    if (h == kNone || mesh.opposite(h) == kNone || !(length > 0)) continue;
    left.push_back(std::abs(values[v].dot(normals[v])) / length);
  }
  if (left.size() < kFewest) return 0.0;
  const auto middle = left.begin() + static_cast<std::ptrdiff_t>(left.size() / 2);
  std::nth_element(left.begin(), middle, left.end());
  return *middle;
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
  const std::vector<Vec3> once = umbrella(mesh, vertices, job), twice = umbrella(mesh, once, job);
  std::vector<Vec3> normals(vertices.size(), Vec3::Zero());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & kPollEvery) == 0) job.poll();
    const Triangle& t = mesh.triangles()[f];
    const Vec3 cross = (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]);
    for (const std::int32_t v : t) normals[v] += cross;
  }
  const double of_twice = median_along(mesh, twice, normals, job);
  const double noise = of_twice / kMedianOfNormal / kTwiceUmbrella, edge = mean_edge(mesh);
  job.poll();
  if (!(noise > 0) || noise > kMostNoise * edge) return 0.0;
  const double doubt = ramp(noise, kFelt * edge, kStrong * edge);
  if (doubt == 0) return noise;
  const double ratio = of_twice / std::max(median_along(mesh, once, normals, job), 1e-300);
  const double trust = ramp(ratio, kShape, kNoise) * (1 - ramp(ratio, kNoiseToo, kShapeToo));
  return noise * (1 - doubt * (1 - trust));
}

}  // namespace isimp
