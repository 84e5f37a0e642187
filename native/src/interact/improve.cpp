// Moves regions from places where they are worth little to places where they are worth much.
#include <numeric>
#include <string>
#include <utility>

#include "edit.h"
#include "hierarchy/teleport.h"
#include "isimp/core/errors.h"
#include "isimp/interact/heuristics.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/soundness.h"

namespace isimp {
namespace {

constexpr int kImproveSweeps = 200;  // limit: sweeps of the borders before the first teleport
// tuned edits
constexpr int kTries = 50;  // limit: teleports in a row without gain that end a round

/// The regions that may change, by graph index; all other faces count as left out.
Regions free_regions(const Edit& edit, std::vector<std::int32_t>& region_of) {
  Regions regions;
  std::vector<std::int32_t> number(edit.result.region_sum.size(), kNone);
  for (std::int32_t r = 0; r < edit.result.region_count(); ++r) {
    if (edit.locked(r)) continue;
    number[r] = static_cast<std::int32_t>(region_of.size());
    region_of.push_back(r);
    regions.sum.push_back(edit.result.region_sum[r]);
  }
  regions.label.assign(edit.graph.faces.size(), kNone);
  for (std::int32_t i = 0; i < edit.graph.size(); ++i)
    if (const std::int32_t r = edit.labels.get(i); r >= 0) regions.label[i] = number[r];
  return regions;
}

}  // namespace

Partition improve(const Mesh& mesh, const Partition& partition, Job& job) {
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  Job::Stage stage(job, "improving", 0.0, 1.0);
  std::vector<std::int32_t> region_of, component;
  if (const std::int32_t loose = find_unconnected(edit.surface, partition.face_region, partition.region_count());
      loose != kNone)
    throw InvalidInput("region " + std::to_string(loose) +
                       " is in several pieces: only connected regions can be improved");
  Regions regions = free_regions(edit, region_of);
  if (region_of.empty()) return partition;
  const Components components = find_components(edit.surface, partition.region_count(), 0.0, job);
  for (const std::int32_t r : region_of) component.push_back(edit.surface.component()[partition.region_seed[r]]);
  const GraphLabels labels{regions.label.data()};
  const auto by_metric = [&] {
    if (partition.metric == Metric::normals) return regions.error();
    Distances distances(edit.surface, partition.metric, partition.region_count());
    distances.sum_up(labels, regions.sum, job);
    return error_by(distances, regions.sum);
  };
  const double before = regions.error(), before_by_metric = by_metric();
  Relaxation<GraphLabels> relaxation(graph, labels, regions.sum, border_weight_of(partition, graph), Threads(1),
                                     edit.surface.relative_weight());
  for (std::int32_t i = 0; i < graph.size(); ++i) relaxation.push_if_border(i);
  relaxation.run(kImproveSweeps, job);
  job.report(0.3);
  Teleport(graph, components, regions, std::move(component), relaxation).run(kTries, 1.0, job);
  relax_by(partition.metric, edit.surface, labels, regions.sum, relaxation, partition.smooth, partition.region_count(),
           job);
  if (regions.error() >= before || by_metric() >= before_by_metric) return partition;
  for (std::int32_t i = 0; i < graph.size(); ++i)
    if (regions.label[i] >= 0) edit.labels.set(i, region_of[regions.label[i]]);
  for (std::size_t k = 0; k < region_of.size(); ++k) edit.result.region_sum[region_of[k]] = regions.sum[k];
  const std::vector<std::int32_t> nearest = nearest_faces(graph, regions, job);
  for (std::size_t k = 0; k < region_of.size(); ++k)
    edit.result.region_seed[region_of[k]] = graph.mesh_face[nearest[k]];
  Partition result = edit.finish();
  result.history.insert(result.history.begin(), partition.error);
  return result;
}

}  // namespace isimp
