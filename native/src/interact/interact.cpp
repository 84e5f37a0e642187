#include "isimp/interact/interact.h"

#include <algorithm>
#include <string>

#include "bevel.h"
#include "dissolve.h"
#include "edit.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

// tuned edits
constexpr int kRounds = 2;  // rounds of fitting a region that is split

/// Makes a region of a part that was left out.
void bring_back(Edit& edit, std::int32_t face, Job& job) {
  const std::int32_t fresh = edit.add_region();
  const std::vector<std::int32_t> faces = take_out(edit.graph, edit.labels, face);
  job.poll();
  RegionSum& sum = edit.result.region_sum[fresh];
  double area = 0;
  for (const std::int32_t i : faces) {
    edit.labels.set(i, fresh);
    sum.add(edit.graph.faces[i]);
    area += edit.graph.faces[i].area;
  }
  --edit.result.parts_left_out;
  edit.result.area_left_out = edit.result.parts_left_out > 0 ? std::max(0.0, edit.result.area_left_out - area) : 0.0;
  edit.hints = {face};
}

/// Splits the region of a face in two, one of which keeps the face, and relaxes their borders.
void split_at(Edit& edit, const Partition& before, std::int32_t start, Job& job) {
  const FaceGraph& graph = edit.graph;
  const std::int32_t old = edit.labels.get(start);
  const std::vector<std::int32_t> faces = edit.take_region(start);
  const std::int32_t fresh = edit.add_region();
  Halves halves;
  halves.region = {old, fresh};
  halves.proxy = {NormalMetric::fit(before.region_sum[old]), NormalMetric::proxy_of(graph.faces[start])};
  part_normals(graph, faces, halves.proxy, kRounds);
  halves.seed = {nearest_of(graph, faces, halves.proxy[0], start), start};
  flood_halves(graph, edit.labels, faces, halves, kRounds, true);
  edit.result.region_sum[old] = halves.sum[0];
  edit.result.region_sum[fresh] = halves.sum[1];
  edit.result.region_seed[old] = kNone;
  job.report(0.5);
  edit.relax(faces, start, job);
  edit.hints = faces;
}

}  // namespace

Partition add_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  Edit edit(mesh, partition);
  const std::int32_t start = edit.at(face);
  Job::Stage stage(job, "adding", 0.0, 1.0);
  if (edit.labels.get(start) == kNone) {
    bring_back(edit, start, job);
    return edit.finish();
  }
  if (partition.region_sum[edit.region_at(face)].faces < 2)
    throw InvalidInput("the region of face " + std::to_string(face) + " is that face alone: there is nothing to split");
  if (!grow_bevel(edit, partition, start, job)) split_at(edit, partition, start, job);
  return edit.finish();
}

Partition delete_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  Edit edit(mesh, partition);
  const std::int32_t gone = edit.region_at(face);
  Job::Stage stage(job, "deleting", 0.0, 1.0);
  if (!dissolve(edit, gone, edit.at(face), job))
    throw InvalidInput("the region of face " + std::to_string(face) + " is the only one of its part" +
                       (partition.region_locked.empty() ? "" : " that is not locked") + ": it can't be deleted");
  return edit.finish();
}

}  // namespace isimp
