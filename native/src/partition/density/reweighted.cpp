#include "density/reweighted.h"

#include <utility>

#include "density/adaptivity.h"
#include "inherited.h"
#include "isimp/core/threads.h"
#include "isimp/partition/regions.h"
#include "make_partition.h"
#include "parts.h"

namespace isimp {

Surface reweighted(const Surface& surface, const PartitionOptions& options, Job& job) {
  return surface.weighted(adaptive_weights(surface, options.adaptivity, Threads(options.threads), job));
}

Partition on_original_weights(const Surface& surface, Partition of_reweighted, const PartitionOptions& options,
                              Job& job) {
  const FaceGraph& graph = surface.graph();
  const Threads threads(options.threads);
  Regions regions;
  regions.label.assign(graph.faces.size(), kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i) regions.label[i] = of_reweighted.face_region[graph.mesh_face[i]];
  regions.sum.resize(of_reweighted.region_sum.size());
  sum_regions(graph, regions, job, threads);
  Parts parts;
  parts.asked = of_reweighted.proxies_asked;
  parts.needed = of_reweighted.proxies_needed;
  parts.left_out = of_reweighted.parts_left_out;
  parts.area_left_out = of_reweighted.area_left_out;
  Partition result = make_partition(surface, parts, regions, {regions.error()}, threads, job);
  if (of_reweighted.bound > 0) {
    result.region_normal = std::move(of_reweighted.region_normal);
    result.region_offset = std::move(of_reweighted.region_offset);
    restate_error(graph, result);
  }
  take_how_found(result, of_reweighted);
  return result;
}

}  // namespace isimp
