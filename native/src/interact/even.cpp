// Relaxes all borders of a partition evenly.
#include <algorithm>
#include <string>

#include "borders/relax.h"
#include "edit.h"
#include "isimp/core/errors.h"
#include "isimp/interact/heuristics.h"

namespace isimp {
namespace {

constexpr int kEvenSweeps = 200;  // limit: enough for a border that moves one face a sweep
// tuned edits
constexpr double kLeastError = 5e-3;  // share of the area: below it, borders of exact shapes would have no weight

}  // namespace

Partition even_borders(const Mesh& mesh, const Partition& partition, double strength, Job& job) {
  if (!(strength >= 0 && strength <= 1))
    throw InvalidInput("strength must be in [0, 1], got " + std::to_string(strength));
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  const Job::Stage stage(job, "evening out", 0.0, 1.0);
  const double error = (graph.area > 0 ? partition.error / graph.area : 0.0) + partition.off_planes;
  const BorderWeight weight =
      border_weight(std::max(error, kLeastError), strength, graph.size(), partition.region_count());
  Relaxation<EditLabels> relaxation(graph, edit.labels, edit.result.region_sum, weight, Threads(1),
                                    edit.surface.relative_weight());
  Distances distances(edit.surface, partition.metric, partition.region_count());
  if (partition.metric != Metric::normals) {
    distances.sum_up(edit.labels, edit.result.region_sum, job);
    relaxation.measure(&distances);
  }
  for (std::int32_t i = 0; i < graph.size(); ++i)
    if (edit.labels.get(i) >= 0) relaxation.push_if_border(i);
  if (relaxation.run(kEvenSweeps, job) == 0) return partition;
  edit.hints = relaxation.pushed();
  return edit.finish();
}

}  // namespace isimp
