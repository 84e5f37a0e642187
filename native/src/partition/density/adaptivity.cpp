#include "density/adaptivity.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "density/normal_filter.h"
#include "hierarchy/contraction.h"
#include "isimp/core/tiny.h"
#include "isimp/partition/noise.h"

namespace isimp {
namespace {

// tuned adaptivity
constexpr double kRadius = 0.01;        // share of the size
constexpr double kStepsARadius = 6.0;   // averagings over neighbouring faces until normals have spread by one edge
constexpr double kClusterSteps = 0.58;  // averagings over clusters of one face each that spread as far as one of these
constexpr int kFewestSteps = 12;        // for which faces are still joined into larger clusters
constexpr double kQuiet = 0.2;          // share of the area that is taken to be rough by noise alone
constexpr double kFloor = 0.1;          // share of the mean that is added to each
constexpr double kMostDensity = 8.0;    // largest factor on the density

/// Faces, or clusters of a few, that normals spread over.
struct NormalField {
  MergeGraph graph;  ///< its sums: of area * normal
  std::vector<float> area;
  std::vector<std::int32_t> cluster;  ///< (n) of each face
};

NormalField faces_of(const FaceGraph& faces, Job& job) {
  NormalField field;
  const Array<FaceRecord> filtered =
      filtered_faces(faces, kFilterPasses, filter_range(median_bend(faces)), Threads(1), job);
  const std::int32_t n = faces.size();
  field.graph.sum.resize(static_cast<std::size_t>(n));
  field.graph.first.assign(1, 0);
  for (std::int32_t i = 0; i < n; ++i) {
    const FaceRecord& f = filtered[i];
    field.graph.sum[i] = {f.area * f.nx, f.area * f.ny, f.area * f.nz, f.area};
    field.area.push_back(f.area);
    for (const std::int32_t j : faces.neighbours[i])
      if (j != n) field.graph.neighbour.push_back(j);
    field.graph.first.push_back(static_cast<std::int32_t>(field.graph.neighbour.size()));
  }
  field.cluster.resize(static_cast<std::size_t>(n));
  std::iota(field.cluster.begin(), field.cluster.end(), 0);
  return field;
}

/// Joins each cluster with a neighbour that is still alone, the smallest.
void join_pairs(NormalField& field, const Threads& threads, Job& job) {
  const std::int32_t n = field.graph.size();
  std::vector<std::int32_t> map(static_cast<std::size_t>(n), kNone);
  std::int32_t count = 0;
  for (std::int32_t u = 0; u < n; ++u) {
    if (map[u] != kNone) continue;
    std::int32_t mate = kNone;
    for (const std::int32_t v : field.graph.around(u))
      if (map[v] == kNone && v != u && (mate == kNone || field.area[v] < field.area[mate])) mate = v;
    map[u] = count;
    if (mate != kNone) map[mate] = count;
    ++count;
  }
  std::vector<float> area(static_cast<std::size_t>(count), 0.0F);
  for (std::int32_t u = 0; u < n; ++u) area[map[u]] += field.area[u];
  field.graph = contract(field.graph, map, count, threads, job);
  field.area = std::move(area);
  for (std::int32_t& c : field.cluster) c = map[c];
}

/// The deviation of the normals around each cluster: 1 - the length of their mean.
std::vector<double> roughness(const NormalField& field, int steps, Job& job) {
  const MergeGraph& graph = field.graph;
  std::vector<Vec3> now(graph.sum.size()), next(graph.sum.size());
  for (std::size_t u = 0; u < now.size(); ++u)
    if (field.area[u] > 0)
      now[u] = Vec3(graph.sum[u].x, graph.sum[u].y, graph.sum[u].z) / field.area[u];
    else
      now[u].setZero();
  for (int step = 0; step < steps; ++step) {
    job.report(static_cast<double>(step) / steps);
    for (std::int32_t u = 0; u < graph.size(); ++u) {
      Vec3 sum = now[u] * field.area[u];
      double area = field.area[u];
      for (const std::int32_t v : graph.around(u)) {
        sum += now[v] * field.area[v];
        area += field.area[v];
      }
      next[u] = area > 0 ? Vec3(sum / area) : now[u];
    }
    now.swap(next);
  }
  std::vector<double> rough(now.size());
  for (std::size_t u = 0; u < now.size(); ++u) rough[u] = std::max(0.0, 1 - now[u].norm());
  return rough;
}

/// The value below which a share of the area lies.
double quantile(const std::vector<double>& values, const std::vector<float>& area, double share) {
  std::vector<std::int32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::int32_t a, std::int32_t b) { return std::pair(values[a], a) < std::pair(values[b], b); });
  const double wanted = share * std::accumulate(area.begin(), area.end(), 0.0);
  double sum = 0.0;
  for (const std::int32_t u : order)
    if ((sum += area[u]) >= wanted) return values[u];
  return 0.0;
}

}  // namespace

std::vector<float> adaptive_weights(const Surface& surface, double adaptivity, const Threads& threads, Job& job) {
  const Mesh& mesh = surface.mesh();
  NormalField field = [&] {
    const Job::Stage smoothing(job, "finding details", 0.0, 0.6);
    return faces_of(surface.graph(), job);
  }();
  const double edges = kRadius * surface_size(mesh) / std::max(mean_edge(mesh), kTiny);
  double steps = std::clamp(kStepsARadius * edges * edges, 3.0, 4000.0);
  const double all = field.graph.size();
  while (steps * kClusterSteps * field.graph.size() / all > 2 * kFewestSteps) {
    const std::int32_t before = field.graph.size();
    join_pairs(field, threads, job);
    if (field.graph.size() == before) break;  // each component is one cluster already
  }
  if (field.graph.size() < all) steps *= kClusterSteps * field.graph.size() / all;

  const Job::Stage spreading(job, "finding details", 0.7, 0.9);
  std::vector<double> rough = roughness(field, static_cast<int>(std::lround(steps)), job);
  const double quiet = quantile(rough, field.area, kQuiet) / 2;
  double mean = 0.0, total = 0.0;
  for (std::size_t u = 0; u < rough.size(); ++u) {
    rough[u] = std::max(0.0, rough[u] - quiet);
    mean += rough[u] * field.area[u];
    total += field.area[u];
  }
  std::vector<float> weight(field.cluster.size(), 1.0F);
  if (!(mean > 1e-9 * total)) return weight;  // flat everywhere
  mean /= total;
  double weighted = 0.0;
  for (std::size_t u = 0; u < rough.size(); ++u) {
    rough[u] = std::clamp(std::pow((rough[u] + kFloor * mean) / ((1 + kFloor) * mean), adaptivity), 1 / kMostDensity,
                          kMostDensity);
    weighted += rough[u] * field.area[u];
  }
  for (std::size_t i = 0; i < weight.size(); ++i)
    weight[i] = static_cast<float>(rough[field.cluster[i]] * total / weighted);
  return weight;
}

}  // namespace isimp
