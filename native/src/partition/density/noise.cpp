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
constexpr std::int32_t kSample = 20000;    // vertices that tell whether there is noise ...
constexpr std::size_t kPollSample = 1024;  // ... with a poll every so many ...
constexpr double kClear = 2;               // ... where the answer is clear by this factor

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

/// The same at one vertex, of values that a function gives.
template <class Value>
Vec3 umbrella_at(const Mesh& mesh, std::int32_t v, const Value& value) {
  Ring ring;
  const std::int32_t start = mesh.vertex_halfedge()[v];
  for (std::int32_t h = start; h != kNone;) {
    ring.sum += value(mesh.to(h));
    ++ring.count;
    h = mesh.next_outgoing(h);
    if (h == start) break;
  }
  return value(v) - ring.sum / ring.count;
}

/// Whether a vertex is inside the surface.
bool is_inner(const Mesh& mesh, std::size_t v) {
  const std::int32_t h = mesh.vertex_halfedge()[v];
  return h != kNone && mesh.opposite(h) != kNone;
}

/// The median; 0 for too few.
double median_of(std::vector<double> values) {
  if (values.size() < kFewest) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The median of the lengths along the normals, of the vertices away from borders; 0 for too few.
double median_along(const Mesh& mesh, std::span<const Vec3> values, std::span<const Vec3> normals, Job& job) {
  std::vector<double> left;
  left.reserve(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    if ((v & kPollEvery) == 0) job.poll();
    const double length = normals[v].norm();
    if (!is_inner(mesh, v) || !(length > 0)) continue;
    left.push_back(std::abs(values[v].dot(normals[v])) / length);
  }
  return median_of(std::move(left));
}

/// The noise, from what the operator leaves of some vertices in the median when it is applied twice; before the doubt
/// whether it is shape.
double plain_noise(double of_twice, double edge) {
  const double noise = of_twice / kMedianOfNormal / kTwiceUmbrella;
  return noise > 0 && noise <= kMostNoise * edge ? noise : 0.0;
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
  const double edge = mean_edge(mesh), noise = plain_noise(of_twice, edge);
  job.poll();
  if (noise == 0) return 0.0;
  const double doubt = ramp(noise, kFelt * edge, kStrong * edge);
  if (doubt == 0) return noise;
  const double ratio = of_twice / std::max(median_along(mesh, once, normals, job), 1e-300);
  const double trust = ramp(ratio, kShape, kNoise) * (1 - ramp(ratio, kNoiseToo, kShapeToo));
  return noise * (1 - doubt * (1 - trust));
}

bool is_noisier(const Mesh& mesh, double least, Job& job) {
  const std::int32_t step = mesh.vertex_count() / kSample;
  if (step > 1) {
    const auto vertices = mesh.vertices();
    const auto once = [&](std::int32_t v) { return umbrella_at(mesh, v, [&](std::int32_t w) { return vertices[w]; }); };
    std::vector<double> left;
    for (std::int32_t v = 0; v < mesh.vertex_count(); v += step) {
      if (left.size() % kPollSample == 0) job.poll();
      if (!is_inner(mesh, v)) continue;
      Vec3 normal = Vec3::Zero();
      const std::int32_t start = mesh.vertex_halfedge()[v];
      for (std::int32_t h = start; h != kNone;) {
        const Vec3 &a = vertices[v], &b = vertices[mesh.to(h)], &c = vertices[mesh.from(Mesh::prev(h))];
        normal += (b - a).cross(c - a);
        h = mesh.next_outgoing(h);
        if (h == start) break;
      }
      const double length = normal.norm();
      if (length > 0) left.push_back(std::abs(umbrella_at(mesh, v, once).dot(normal)) / length);
    }
    const double edge = mean_edge(mesh), noise = plain_noise(median_of(std::move(left)), edge);
    if (noise > 0 && noise < least / kClear) return false;
    if (noise > least * kClear && noise < kFelt * edge) return true;
  }
  return estimate_noise(mesh, job) > least;
}

}  // namespace isimp
