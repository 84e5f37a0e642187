#include "isimp/interact/paint.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "edit.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

std::string the_region_of(std::int32_t face) { return "the region of face " + std::to_string(face); }

/// Removes regions that have no face left.
void remove_empty(Edit& edit) {
  for (std::int32_t r = edit.result.region_count() - 1; r >= 0; --r)
    if (edit.result.region_sum[r].faces == 0) edit.remove_region(r);
}

/// Labels open faces that can be reached from the target, or from the first of them.
/// \return the faces that can't
std::vector<std::int32_t> spread(const Edit& edit, std::span<const std::int32_t> open, std::int32_t target) {
  const FaceGraph& graph = edit.graph;
  std::vector<std::int32_t> reached;
  const auto take = [&](std::int32_t i) {
    edit.labels.set(i, target);
    reached.push_back(i);
  };
  if (edit.result.region_sum[target].faces == 0)
    take(open.front());
  else
    for (const std::int32_t i : open) {
      const auto& near = graph.neighbours[i];
      if (std::any_of(near.begin(), near.end(), [&](std::int32_t j) { return edit.labels.get(j) == target; })) take(i);
    }
  for (std::size_t k = 0; k < reached.size(); ++k)
    for (const std::int32_t j : graph.neighbours[reached[k]])
      if (edit.labels.get(j) == kOpen) take(j);
  std::vector<std::int32_t> left;
  for (const std::int32_t i : open)
    if (edit.labels.get(i) == kOpen) left.push_back(i);
  return left;
}

/// Adds open faces of a region to the regions around it.
/// \return the faces that moved
std::vector<std::int32_t> give_away(Edit& edit, std::vector<std::int32_t> open, std::int32_t region) {
  const std::vector<std::uint8_t> before = edit.held();
  std::vector<std::uint8_t> closed = before;
  closed.resize(edit.result.region_sum.size(), 0);
  closed[region] = 1;
  edit.hold(std::move(closed));
  std::vector<std::int32_t> touched, gone;
  flood_from_around(edit.graph, edit.labels, open, edit.result.region_sum, touched);
  edit.hold(before);
  for (const std::int32_t i : open)
    if (edit.labels.get(i) == kOpen) {
      edit.labels.set(i, region);
      edit.result.region_sum[region].add(edit.graph.faces[i]);
    } else {
      gone.push_back(i);
    }
  return gone;
}

void open_face(Edit& edit, std::int32_t i) {
  edit.result.region_sum[edit.labels.get(i)].remove(edit.graph.faces[i]);
  edit.labels.set(i, kOpen);
}

/// The faces of a region. Its labels are cleared by the walk and restored.
std::vector<std::int32_t> faces_of(Edit& edit, std::int32_t face) {
  const std::int32_t region = edit.labels.get(face);
  std::vector<std::int32_t> faces = edit.take_region(face);
  for (const std::int32_t i : faces) edit.labels.set(i, region);
  return faces;
}

void check_rings(std::int32_t rings) {
  if (rings < 1) throw InvalidInput("rings must be at least 1, got " + std::to_string(rings));
}

}  // namespace

Partition paint_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces,
                      std::int32_t onto, Job& job) {
  Edit edit(mesh, partition);
  Job::Stage stage(job, "painting", 0.0, 1.0);
  job.poll();
  const std::int32_t target =
      onto == kNone ? edit.add_region() : edit.result.face_region[edit.graph.mesh_face[edit.at(onto)]];
  if (target == kNone) throw InvalidInput("face " + std::to_string(onto) + " lies in a part that was left out");
  if (onto != kNone && edit.locked(target)) {
    std::vector<std::uint8_t> others = edit.held();
    others[target] = 0;
    edit.hold(std::move(others));
  }
  std::vector<std::int32_t> open;
  for (const std::int32_t face : faces) {
    const std::int32_t i = edit.at(face), r = edit.labels.get(i);
    if (r == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
    if (r < 0 || r == target) continue;
    open_face(edit, i);
    open.push_back(i);
  }
  if (open.empty())
    throw InvalidInput("there is nothing to paint: no face was given that is not locked or of the region already");
  const std::vector<std::int32_t> left = spread(edit, open, target);
  if (!left.empty())
    throw InvalidInput(
        "the faces to paint do not hang together: face " + std::to_string(edit.graph.mesh_face[left.front()]) +
        " is joined by no edge to " +
        (onto == kNone ? "face " + std::to_string(edit.graph.mesh_face[open.front()]) : the_region_of(onto)));
  for (const std::int32_t i : open) edit.result.region_sum[target].add(edit.graph.faces[i]);
  edit.hints = open;
  edit.reconnect(open);
  remove_empty(edit);
  return edit.finish();
}

Partition erase_faces(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces, Job& job) {
  Edit edit(mesh, partition);
  Job::Stage stage(job, "erasing", 0.0, 1.0);
  job.poll();
  if (faces.empty()) throw InvalidInput("there is no face to erase");
  const std::int32_t region = edit.region_at(faces.front());
  std::vector<std::int32_t> open;
  for (const std::int32_t face : faces) {
    const std::int32_t i = edit.at(face);
    if (edit.labels.get(i) != region) continue;
    open_face(edit, i);
    open.push_back(i);
  }
  const std::vector<std::int32_t> gone = give_away(edit, std::move(open), region);
  if (gone.empty())
    throw InvalidInput("the faces to erase touch no other region that could take them" +
                       std::string(partition.region_locked.empty() ? "" : " and is not locked"));
  edit.hints = gone;
  edit.reconnect(gone);
  remove_empty(edit);
  return edit.finish();
}

Partition grow_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job) {
  check_rings(rings);
  Edit edit(mesh, partition);
  const std::int32_t region = edit.region_at(face);
  Job::Stage stage(job, "growing", 0.0, 1.0);
  std::vector<std::int32_t> front = faces_of(edit, edit.at(face)), all;
  for (std::int32_t ring = 0; ring < rings; ++ring) {
    job.poll();
    std::vector<std::int32_t> next;
    for (const std::int32_t i : front)
      for (const std::int32_t j : edit.graph.neighbours[i]) {
        const std::int32_t r = edit.labels.get(j);
        if (r < 0 || r == region || edit.result.region_sum[r].faces < 2) continue;
        edit.move(j, region);
        next.push_back(j);
      }
    all.insert(all.end(), next.begin(), next.end());
    front = std::move(next);
  }
  if (all.empty()) throw InvalidInput(the_region_of(face) + " has no neighbour to take faces from");
  edit.hints = all;
  edit.reconnect(all);
  return edit.finish();
}

Partition shrink_region(const Mesh& mesh, const Partition& partition, std::int32_t face, std::int32_t rings, Job& job) {
  check_rings(rings);
  Edit edit(mesh, partition);
  const std::int32_t region = edit.region_at(face);
  Job::Stage stage(job, "shrinking", 0.0, 1.0);
  std::vector<std::int32_t> inside = faces_of(edit, edit.at(face)), all;
  for (std::int32_t ring = 0; ring < rings; ++ring) {
    job.poll();
    std::vector<std::int32_t> border, rest;
    for (const std::int32_t i : inside) {
      const auto& near = edit.graph.neighbours[i];
      const bool outer = std::any_of(near.begin(), near.end(), [&](std::int32_t j) {
        return edit.labels.get(j) >= 0 && edit.labels.get(j) != region;
      });
      (outer ? border : rest).push_back(i);
    }
    if (rest.empty()) throw InvalidInput(the_region_of(face) + " would vanish: delete it instead");
    if (border.empty()) throw InvalidInput(the_region_of(face) + " has no neighbour to give faces to");
    for (const std::int32_t i : border) open_face(edit, i);
    const std::vector<std::int32_t> gone = give_away(edit, std::move(border), region);
    all.insert(all.end(), gone.begin(), gone.end());
    inside = std::move(rest);
  }
  edit.hints = all;
  edit.reconnect(all);
  return edit.finish();
}

}  // namespace isimp
