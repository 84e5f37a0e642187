#include "isimp/tiles/detail.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "checks.h"
#include "density/noise.h"
#include "hierarchy/choose_cut.h"
#include "hierarchy/dendrogram.h"
#include "hierarchy/detail_tree.h"
#include "hierarchy/features.h"
#include "isimp/core/errors.h"
#include "patches_of.h"

namespace isimp::tiles {
namespace {

/// Returns the nodes that are not left out, with areas as shares of `area`.
ClusterGraph clusters_of(const JoinedGraph& graph, const JoinedComponents& components, double area) {
  ClusterGraph clusters;
  std::vector<std::int32_t> number(graph.sum.size(), kNone);
  for (std::size_t u = 0; u < graph.sum.size(); ++u) {
    if (components.component[u] == kNone) continue;
    number[u] = static_cast<std::int32_t>(clusters.sum.size());
    const RegionSum& s = graph.sum[u];
    clusters.sum.push_back({s.x / area, s.y / area, s.z / area, s.weight / area, s.faces});
    clusters.component.push_back(components.component[u]);
  }
  clusters.first.assign(clusters.sum.size() + 1, 0);
  const auto each_pair = [&](const auto& visit) {
    for (const auto& [a, b] : graph.pair) {
      const std::int32_t u = number[a], v = number[b];
      if (u == v || u == kNone || v == kNone) continue;
      visit(u, v);
      visit(v, u);
    }
  };
  each_pair([&](std::int32_t u, std::int32_t) { ++clusters.first[u + 1]; });
  std::partial_sum(clusters.first.begin(), clusters.first.end(), clusters.first.begin());
  clusters.neighbour.resize(static_cast<std::size_t>(clusters.first.back()));
  std::vector<std::int32_t> next(clusters.first.begin(), clusters.first.end() - 1);
  each_pair([&](std::int32_t u, std::int32_t v) { clusters.neighbour[next[u]++] = v; });
  return clusters;
}

}  // namespace

Extent measure(const Mesh& mesh, Job& job) {
  Extent result;
  Vec3 first = Vec3::Zero();
  double squares = 0;
  const auto vertices = mesh.vertices();
  const Vec3 near = vertices[mesh.triangles()[0][0]];  // local origin, so that no digits are lost
  std::size_t done = 0;
  for (const Triangle& t : mesh.triangles()) {
    if ((done++ & 0xffff) == 0) job.poll();
    const Vec3 a = vertices[t[0]] - near, b = vertices[t[1]] - near, c = vertices[t[2]] - near;
    const double share = (b - a).cross(c - a).norm() / 2;
    result.area += share;
    first += share / 3 * (a + b + c);
    squares += share / 12 * (a.squaredNorm() + b.squaredNorm() + c.squaredNorm() + (a + b + c).squaredNorm());
  }
  if (result.area > 0) {
    first /= result.area;
    result.spread = std::max(0.0, squares / result.area - first.squaredNorm());
  }
  result.centre = mesh.origin() + near + first;
  result.noise = estimate_noise(mesh, Threads(1), job);
  return result;
}

Patches detail_patches(const Mesh& mesh, double tolerance, double noise, Job& job) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput("the tolerance must be above 0, got " + std::to_string(tolerance));
  if (!(noise >= 0) || !std::isfinite(noise))
    throw InvalidInput("the noise must be at least 0, got " + std::to_string(noise));
  const Surface surface(mesh);
  const double size = surface_size(mesh);
  Regions regions;
  {
    const DetailTree tree(surface, {size > 0 ? tolerance / size : kFinestDetail, noise, 0.0}, job);
    regions = tree.regions(surface, {merge_limit(tolerance, noise, kLeastNoise)}, Threads(1), job);
  }
  regions.label.pop_back();
  return patches_of(mesh, std::move(regions.label), std::move(regions.sum));
}

double least_cost(double tolerance, double noise) {
  // tuned tiles
  constexpr double kSpread = 1.5;  // the cut is chosen among costs down to this factor below the limit
  return merge_limit(tolerance, noise, kLeastNoise) / kSpread;
}

FoundRegions find_regions(const JoinedGraph& graph, const JoinedComponents& components, double tolerance, double noise,
                          bool snap, std::optional<double> cost, Job& job) {
  check_pairs(graph);
  check_components(graph, components);
  double area = 0;
  for (const RegionSum& s : graph.sum) area += s.weight / 2;
  if (!(area > 0)) area = 1;
  MergeLimits limits{.need = components.need};
  if (cost) limits.cost = *cost / area;
  ClusterGraph clusters = clusters_of(graph, components, area);
  // The sums are copied only where a gap may be judged by them.
  const std::vector<RegionSum> leaves = cost || !snap ? std::vector<RegionSum>() : clusters.sum;
  MergeTree tree = merge_all(std::move(clusters), limits, job);
  const auto left = static_cast<std::int32_t>(static_cast<std::size_t>(tree.leaves) - tree.merges());
  if (cost) return {left, *cost, false};
  std::vector<double> falling = tree.cost;
  std::sort(falling.begin(), falling.end(), std::greater<>());
  for (double& each : falling) each *= area;
  const Cut cut = choose_cut(falling, left, kNoCost * area, tolerance, tolerance, noise, snap, [&](double at) {
    return keeps_features(tree, leaves, merge_limit(tolerance, noise) / area, at / area);
  });
  const auto above = std::find_if(tree.cost.begin(), tree.cost.end(), [&](double c) { return c * area > cut.cost; });
  return {tree.leaves - static_cast<std::int32_t>(above - tree.cost.begin()), cut.cost, cut.snapped};
}

}  // namespace isimp::tiles
