// The umbrella operator: Kobbelt, Campagna, Vorsatz, Seidel: Interactive multi-resolution modeling, 1998.

#include "isimp/partition/noise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "isimp/core/tiny.h"
#include "parts.h"

namespace isimp {
namespace {

constexpr double kMedianOfNormal = 0.6745;  // unit: median of |x|, x normal with deviation 1
constexpr double kTwiceUmbrella = 1.359;    // unit: deviation of the remainder of such noise where six edges meet
// tuned noise
constexpr double kMostNoise = 0.5;       // share of an edge's length
constexpr std::size_t kFewest = 250;     // vertices; a mesh of fewer is no scan
constexpr std::int32_t kSample = 20000;  // work: vertices that show whether there is noise
constexpr double kClear = 2;             // the sample decides if it differs from the limit by this factor
// tuned grids
constexpr double kOfCell = 0.12;  // share of the cell of a grid that is left of its steps

// tuned noise
// The second application of the operator to white noise leaves 1.26 times as much as the first. Where it leaves less,
// the mesh is a coarse one of a curved shape; where more, of a shape with creases between flat parts.
constexpr double kShape = 0.85;    // twice over once, up to which it is all shape
constexpr double kNoise = 1.0;     // twice over once, from which it is all noise
constexpr double kNoiseToo = 1.6;  // twice over once, up to which it is all noise
constexpr double kShapeToo = 2.0;  // twice over once, from which it is all shape

// Noise is the same at long edges and at short ones; the remainder of a shape grows with them.
constexpr double kSpread = 2.0;  // least ratio of the edges of the outer quarters that shows it
constexpr double kSteady = 0.5;  // power of the edges' length, up to which it is noise
constexpr double kGrows = 0.75;  // power of the edges' length, from which it is shape
constexpr double kFelt = 0.06;   // share of an edge's length, from which the remainder matters
constexpr double kStrong = 0.1;  // share of an edge's length, from which it matters fully
constexpr double kOutside = -1;  // mark: no length

struct Ring {
  Vec3 sum = Vec3::Zero();
  std::int32_t count = 0;
};

/// The value at a used vertex minus the mean over the vertices at the ends of its half-edges.
template <class Value>
Vec3 umbrella_at(const Mesh& mesh, std::int32_t v, const Value& value) {
  Ring ring;
  for_each_leaving(mesh, v, [&](std::int32_t h) {
    ring.sum += value(mesh.to(h));
    ++ring.count;
  });
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

/// Rises from 0 at a to 1 at b.
double ramp(double x, double a, double b) { return std::clamp((x - a) / (b - a), 0.0, 1.0); }

/// The sum of the vector areas of the faces at a vertex.
Vec3 normal_at(const Mesh& mesh, std::int32_t v) {
  const auto vertices = mesh.vertices();
  Vec3 normal = Vec3::Zero();
  for_each_leaving(mesh, v, [&](std::int32_t h) {
    const Vec3 &a = vertices[v], &b = vertices[mesh.to(h)], &c = vertices[mesh.from(Mesh::prev(h))];
    normal += (b - a).cross(c - a);
  });
  return normal;
}

/// The median of the lengths along the normals, of every step-th vertex if it is away from borders; 0 for too few.
/// \param value  value(v) for a vertex
template <class Value>
double median_along(const Mesh& mesh, std::int32_t step, const Value& value, const Threads& threads, Job& job) {
  std::vector<double> lengths(static_cast<std::size_t>((mesh.vertex_count() - 1) / step + 1), kOutside);
  threads.run(static_cast<std::int32_t>(lengths.size()), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) {
      if ((i & kPollMask) == 0) job.poll();
      const std::int32_t v = i * step;
      if (!is_inner(mesh, v)) continue;
      const Vec3 normal = normal_at(mesh, v);
      if (const double length = normal.norm(); length > 0) lengths[i] = std::abs(value(v).dot(normal)) / length;
    }
  });
  std::erase(lengths, kOutside);
  return median_of(std::move(lengths));
}

/// The power of the edges' length with which the lengths along the normals grow, from the quarters of the vertices with
/// the shortest and the longest edges; 0 where these hardly differ, or for too few vertices away from borders.
/// \param value  value(v) for a vertex
template <class Value>
double growth_of(const Mesh& mesh, const Value& value, Job& job) {
  std::vector<std::pair<double, double>> found;  // mean edge, length along the normal
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((v & kPollMask) == 0) job.poll();
    if (!is_inner(mesh, v)) continue;
    const Vec3 normal = normal_at(mesh, v);
    if (!(normal.norm() > 0)) continue;
    double sum = 0;
    int count = 0;
    for_each_leaving(mesh, v, [&](std::int32_t h) {
      sum += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[v]).norm();
      ++count;
    });
    found.emplace_back(sum / count, std::abs(value(v).dot(normal)) / normal.norm());
  }
  const std::size_t quarter = found.size() / 4;
  if (quarter < kFewest / 4) return 0.0;
  std::sort(found.begin(), found.end());
  const auto middle = [&](std::size_t first) {
    std::vector<double> lengths;
    for (std::size_t i = first; i < first + quarter; ++i) lengths.push_back(found[i].second);
    std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(quarter / 2), lengths.end());
    return std::pair{found[first + quarter / 2].first, lengths[quarter / 2]};
  };
  const auto [short_edge, at_short] = middle(0);
  const auto [long_edge, at_long] = middle(found.size() - quarter);
  if (!(long_edge > kSpread * short_edge) || !(at_long > 0)) return 0.0;
  return at_short > 0 ? std::log(at_long / at_short) / std::log(long_edge / short_edge) : kGrows;
}

/// The noise, from the median over some vertices of the remainder when the operator is applied twice; before the doubt
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

double estimate_noise(const Mesh& mesh, const Threads& threads, Job& job) {
  if (mesh.report().cell > 0) return kOfCell * mesh.report().cell;
  const auto vertices = mesh.vertices();
  const auto place = [&](std::int32_t v) { return vertices[v]; };
  std::vector<Vec3> once(vertices.size(), Vec3::Zero());
  threads.run(mesh.vertex_count(), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t v = begin; v < end; ++v) {
      if ((v & kPollMask) == 0) job.poll();
      if (mesh.vertex_halfedge()[v] != kNone) once[v] = umbrella_at(mesh, v, place);
    }
  });
  const auto of_once = [&](std::int32_t v) { return once[v]; };
  const auto twice = [&](std::int32_t v) { return umbrella_at(mesh, v, of_once); };
  const double of_twice = median_along(mesh, 1, twice, threads, job);
  const double edge = mean_edge(mesh), noise = plain_noise(of_twice, edge);
  job.poll();
  if (noise == 0) return 0.0;
  const double doubt = ramp(noise, kFelt * edge, kStrong * edge);
  if (doubt == 0) return noise;
  const double ratio = of_twice / std::max(median_along(mesh, 1, of_once, threads, job), kTiny);
  const double trust = ramp(ratio, kShape, kNoise) * (1 - ramp(ratio, kNoiseToo, kShapeToo)) *
                       (1 - ramp(growth_of(mesh, twice, job), kSteady, kGrows));
  return noise * (1 - doubt * (1 - trust));
}

bool is_noisier(const Mesh& mesh, double least, Job& job) {
  const Threads threads(1);
  if (const std::int32_t step = mesh.vertex_count() / kSample; step > 1 && mesh.report().cell == 0) {
    const auto vertices = mesh.vertices();
    const auto place = [&](std::int32_t v) { return vertices[v]; };
    const auto once = [&](std::int32_t v) { return umbrella_at(mesh, v, place); };
    const auto twice = [&](std::int32_t v) { return umbrella_at(mesh, v, once); };
    const double edge = mean_edge(mesh), noise = plain_noise(median_along(mesh, step, twice, threads, job), edge);
    if (noise > 0 && noise < least / kClear) return false;
    if (noise > least * kClear && noise < kFelt * edge) return true;
  }
  return estimate_noise(mesh, threads, job) > least;
}

}  // namespace isimp
