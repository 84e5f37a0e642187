#include "isimp/tiles/patches.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "components.h"
#include "hierarchy/hierarchy.h"
#include "hierarchy/optimise.h"
#include "hierarchy/region_graph.h"
#include "isimp/core/errors.h"
#include "patches_of.h"

namespace isimp::tiles {

Patches patches_of(const Mesh& mesh, std::vector<std::int32_t> label, std::vector<RegionSum> sum) {
  const FaceGraph& graph = mesh.graph();
  Patches result;
  result.sum = std::move(sum);
  for (RegionSum& s : result.sum) {
    s.x *= graph.area;
    s.y *= graph.area;
    s.z *= graph.area;
    s.weight *= graph.area;
  }
  label.push_back(kNone);
  std::vector<std::int32_t> borders;
  for (std::int32_t i = 0; i < graph.size(); ++i)
    for (const std::int32_t j : graph.neighbours[i])
      if (label[j] != label[i]) {
        borders.push_back(i);
        break;
      }
  const MergeGraph touching = graph_of_regions(graph, label, result.sum.size(), {}, borders);
  const std::vector<double> length = border_lengths(mesh, label, borders, touching, Threads(1));
  const double unit = std::sqrt(graph.area);
  for (std::int32_t u = 0; u < touching.size(); ++u)
    for (std::int32_t k = touching.first[u]; k < touching.first[u + 1]; ++k) {
      if (touching.neighbour[k] < u) continue;
      result.pair.push_back({u, touching.neighbour[k]});
      result.length.push_back(unit * length[k]);
    }
  label.pop_back();
  result.label = std::move(label);
  return result;
}

Patches patches(const Mesh& mesh, std::int32_t size, double smooth, Job& job) {
  if (size < 1) throw InvalidInput("a patch must have at least 1 face, got " + std::to_string(size));
  const Surface surface(mesh);
  const std::int32_t count = std::max(1, mesh.face_count() / size);
  const Threads threads(1);
  Regions regions;
  {
    const Hierarchy hierarchy = build_hierarchy(surface, count, job, {.coarsest = nodes_for(count)});
    const Components components = find_components(surface, count, 0.0, job, hierarchy.components);
    regions = optimise(surface, hierarchy, components, smooth, threads, job, Finish::plain);
  }
  regions.label.pop_back();
  return patches_of(mesh, std::move(regions.label), std::move(regions.sum));
}

}  // namespace isimp::tiles
