#include "isimp/tiles/patches.h"

#include <algorithm>
#include <string>

#include "hierarchy/region_graph.h"
#include "isimp/core/errors.h"
#include "isimp/partition/partition.h"
#include "isimp/simplify/partitioner.h"

namespace isimp::tiles {

Patches patches(const Mesh& mesh, std::int32_t size, double smooth, Job& job) {
  if (size < 1) throw InvalidInput("a patch must have at least 1 face, got " + std::to_string(size));
  PartitionOptions options;
  options.proxies = std::max(1, mesh.face_count() / size);
  options.smooth = smooth;
  options.leave_out = 0;
  options.threads = 1;
  const Partition part = partition(Surface(mesh), options, job);
  const FaceGraph& graph = mesh.graph();
  Patches result;
  result.sum = part.region_sum;
  for (RegionSum& s : result.sum) {
    s.x *= graph.area;
    s.y *= graph.area;
    s.z *= graph.area;
    s.weight *= graph.area;
  }
  std::vector<std::int32_t> label(static_cast<std::size_t>(graph.size()) + 1, kNone), borders;
  for (std::int32_t i = 0; i < graph.size(); ++i) label[i] = part.face_region[graph.mesh_face[i]];
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

}  // namespace isimp::tiles
