#include "isimp/interact/interact.h"

#include <algorithm>
#include <string>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/partition/local.h"
#include "isimp/partition/relax.h"

namespace isimp {
namespace {

constexpr int kRounds = 2;   // of fitting a region that is split
constexpr int kSweeps = 40;  // of the borders afterwards

void check(const Mesh& mesh, const Partition& partition, std::int32_t face) {
  const auto regions = partition.region_seed.size();
  if (partition.face_region.size() != static_cast<std::size_t>(mesh.face_count()) ||
      partition.region_sum.size() != regions || partition.region_normal.size() != regions)
    throw InvalidInput("the partition has " + std::to_string(partition.face_region.size()) +
                       " faces and the mesh has " + std::to_string(mesh.face_count()) +
                       ": it was made for another mesh");
  if (face < 0 || face >= mesh.face_count())
    throw InvalidInput("face must be in [0, " + std::to_string(mesh.face_count()) + "), got " + std::to_string(face));
}

/// A partition being edited: the copy that will be returned, its sums kept up to date.
struct Edit {
  Surface surface;
  const FaceGraph& graph;
  Partition result;
  MeshLabels labels;

  Edit(const Mesh& mesh, const Partition& p)
      : surface(mesh, p.guided), graph(surface.graph()), result(p), labels{result.face_region.data(), &graph} {}

  /// Relaxes the borders of these faces and what follows from that.
  void relax(std::span<const std::int32_t> faces, std::int32_t pinned, Job& job) {
    Relaxation<MeshLabels> relaxation(graph, labels, result.region_sum,
                                      border_weight(graph.area > 0 ? result.error / graph.area : 0.0));
    relaxation.pin(pinned);
    for (const std::int32_t face : faces) {
      relaxation.push_if_border(face);
      for (const std::int32_t j : graph.neighbours[face])
        if (j != graph.size()) relaxation.push_if_border(j);
    }
    relaxation.run(kSweeps, job);
  }

  /// Normals and error from the sums, and a new seed for each region that lost its own or has none yet.
  Partition finish() {
    const auto regions = static_cast<std::int32_t>(result.region_sum.size());
    result.region_seed.resize(result.region_sum.size(), kNone);
    result.region_normal.resize(result.region_sum.size());
    result.error = 0;
    std::vector<std::int32_t> lost;
    for (std::int32_t r = 0; r < regions; ++r) {
      const RegionSum& s = result.region_sum[r];
      result.region_normal[r] = s.normal();
      result.error += s.error();
      const std::int32_t seed = result.region_seed[r];
      if (seed == kNone || result.face_region[seed] != r) lost.push_back(r);
    }
    result.error *= graph.area;
    result.history.assign(1, result.error);
    for (const std::int32_t r : lost) reseed(r);
    return std::move(result);
  }

  /// Some face of each region that was touched, in the order of finding.
  std::vector<std::int32_t> hints;

 private:
  void reseed(std::int32_t region) {
    std::int32_t start = kNone;
    for (const std::int32_t face : hints)
      if (labels.get(face) == region) start = face;
    if (start == kNone)  // moved away from where it was touched: rare, so a search over all faces will do
      start = graph.graph_face[std::find(result.face_region.begin(), result.face_region.end(), region) -
                               result.face_region.begin()];
    const std::vector<std::int32_t> faces = take_out(graph, labels, start);
    for (const std::int32_t face : faces) labels.set(face, region);
    result.region_seed[region] =
        graph.mesh_face[nearest_of(graph, faces, NormalMetric::fit(result.region_sum[region]))];
  }
};

/// Makes a part that was left out one region.
void bring_back(Edit& edit, std::int32_t face, Job& job) {
  const auto fresh = edit.result.region_count();
  const std::vector<std::int32_t> faces = take_out(edit.graph, edit.labels, face);
  job.poll();
  RegionSum sum;
  double area = 0;
  for (const std::int32_t i : faces) {
    edit.labels.set(i, fresh);
    sum.add(edit.graph.faces[i]);
    area += edit.graph.faces[i].area;
  }
  edit.result.region_sum.push_back(sum);
  --edit.result.parts_left_out;
  edit.result.area_left_out = edit.result.parts_left_out > 0 ? std::max(0.0, edit.result.area_left_out - area) : 0.0;
  edit.hints = {face};
}

}  // namespace

Partition add_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  check(mesh, partition, face);
  Job::Part stage(job, "adding", 0.0, 1.0);
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  const std::int32_t start = graph.graph_face[face], old = partition.face_region[face];
  const std::int32_t fresh = partition.region_count();
  if (old == kNone) {
    bring_back(edit, start, job);
    return edit.finish();
  }
  if (partition.region_sum[old].faces < 2)
    throw InvalidInput("the region of face " + std::to_string(face) + " is that face alone: there is nothing to split");
  const std::vector<std::int32_t> faces = take_out(graph, edit.labels, start);
  Halves halves;
  halves.region = {old, fresh};
  halves.proxy = {NormalMetric::fit(partition.region_sum[old]), NormalMetric::proxy_of(graph.faces[start])};
  part_normals(graph, faces, halves.proxy, kRounds);
  halves.seed = {nearest_of(graph, faces, halves.proxy[0], start), start};
  flood_halves(graph, edit.labels, faces, halves, kRounds, true);
  edit.result.region_sum[old] = halves.sum[0];
  edit.result.region_sum.push_back(halves.sum[1]);
  edit.result.region_seed[old] = kNone;
  job.report(0.5);
  edit.relax(faces, start, job);
  edit.hints = faces;
  return edit.finish();
}

Partition delete_proxy(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  check(mesh, partition, face);
  const std::int32_t gone = partition.face_region[face];
  if (gone == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
  Job::Part stage(job, "deleting", 0.0, 1.0);
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  const std::vector<std::int32_t> faces = take_out(graph, edit.labels, graph.graph_face[face]);
  std::vector<std::int32_t> touched;
  if (!flood_from_around(graph, edit.labels, faces, edit.result.region_sum, touched))
    throw InvalidInput("the region of face " + std::to_string(face) +
                       " is the only one of its part: it can't be deleted");
  job.report(0.5);
  edit.relax(faces, kNone, job);
  const auto at = static_cast<std::ptrdiff_t>(gone);
  edit.result.region_sum.erase(edit.result.region_sum.begin() + at);
  edit.result.region_seed.erase(edit.result.region_seed.begin() + at);
  for (std::int32_t& r : edit.result.face_region) r -= r > gone;
  edit.hints = faces;
  return edit.finish();
}

}  // namespace isimp
