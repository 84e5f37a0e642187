#include "edit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "borders/relax.h"
#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "pieces.h"

namespace isimp {
namespace {

constexpr int kEditSweeps = 40;  // limit: sweeps of the borders after an edit
// tuned edits
constexpr double kStays = 0.2;   // share of a region's area that an edit may change before the region loses its own
                                 // plane
constexpr double kTurns = 0.17;  // likewise its normal: 10 degrees

const Partition& checked(const Mesh& mesh, const Partition& partition) {
  check_is_of(mesh, partition);
  const auto regions = partition.region_seed.size();
  if (partition.region_sum.size() != regions || partition.region_normal.size() != regions)
    throw InvalidInput("the partition has " + std::to_string(regions) + " regions, but sums of " +
                       std::to_string(partition.region_sum.size()) + " and normals of " +
                       std::to_string(partition.region_normal.size()));
  return partition;
}

/// Whether the sums have as many faces as the labels name, at least one each.
[[maybe_unused]] bool fits(const Partition& p) {
  std::vector<std::int32_t> faces(p.region_sum.size(), 0);
  for (const std::int32_t r : p.face_region) {
    if (r < kNone || r >= static_cast<std::int32_t>(faces.size())) return false;
    if (r != kNone) ++faces[r];
  }
  for (std::size_t r = 0; r < faces.size(); ++r)
    if (faces[r] == 0 || faces[r] != p.region_sum[r].faces) return false;
  return p.region_seed.size() == faces.size();
}

}  // namespace

Edit::Edit(const Mesh& mesh, const Partition& partition)
    : surface(mesh, partition.guided),
      graph(surface.graph()),
      result(checked(mesh, partition)),
      labels{result.face_region.data(), &graph} {
  hold(result.region_locked);
  if (!result.region_held.empty()) sums_ = result.region_sum;
}

std::int32_t Edit::at(std::int32_t face) const {
  if (face < 0 || face >= graph.size())
    throw InvalidInput("face must be in [0, " + std::to_string(graph.size()) + "), got " + std::to_string(face));
  return graph.graph_face[face];
}

std::int32_t Edit::region_at(std::int32_t face) const {
  const std::int32_t region = result.face_region[graph.mesh_face[at(face)]];
  if (region == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
  if (locked(region)) throw InvalidInput("the region of face " + std::to_string(face) + " is locked: unlock it first");
  return region;
}

std::vector<std::int32_t> Edit::take_region(std::int32_t i) {
  ISIMP_ASSERT(labels.get(i) >= 0, "a region that is taken out is neither held nor left out");
  const std::int32_t all = result.region_sum[labels.get(i)].faces;
  std::vector<std::int32_t> faces = take_out(graph, labels, i);
  if (static_cast<std::int64_t>(faces.size()) != all)
    throw InvalidInput("the region of face " + std::to_string(graph.mesh_face[i]) +
                       " is in several pieces: " + std::to_string(faces.size()) + " of its " + std::to_string(all) +
                       " faces hang together with that face; only connected regions can be edited");
  return faces;
}

void Edit::restart(const Partition& partition) {
  result = partition;
  if (!result.region_held.empty()) sums_ = result.region_sum;
  hold(result.region_locked);
  labels.region = result.face_region.data();
}

void Edit::hold(std::vector<std::uint8_t> regions) {
  held_ = std::move(regions);
  if (!held_.empty()) held_.resize(result.region_sum.size(), 0);
  labels.held = held_;
}

void Edit::hold_all_but(std::span<const std::int32_t> regions) {
  std::vector<std::uint8_t> others(result.region_sum.size(), 1);
  for (const std::int32_t r : regions) others[r] = 0;
  hold(std::move(others));
}

std::int32_t Edit::add_region() {
  result.region_sum.emplace_back();
  result.region_seed.push_back(kNone);
  if (!result.region_locked.empty()) result.region_locked.push_back(0);
  if (!result.region_held.empty()) {
    result.region_held.push_back(0);
    if (!result.region_cell.empty()) result.region_cell.emplace_back();
    result.region_normal.emplace_back(Vec3::Zero());
    result.region_offset.push_back(0);
    sums_.emplace_back();
  }
  hold(std::move(held_));
  return static_cast<std::int32_t>(result.region_sum.size()) - 1;
}

void Edit::remove_region(std::int32_t region) {
  ISIMP_ASSERT(std::find(result.face_region.begin(), result.face_region.end(), region) == result.face_region.end(),
               "a region that is taken away has no faces");
  const auto at = static_cast<std::ptrdiff_t>(region);
  result.region_sum.erase(result.region_sum.begin() + at);
  result.region_seed.erase(result.region_seed.begin() + at);
  if (!result.region_locked.empty()) result.region_locked.erase(result.region_locked.begin() + at);
  if (!result.region_held.empty()) {
    result.region_held.erase(result.region_held.begin() + at);
    if (!result.region_cell.empty()) result.region_cell.erase(result.region_cell.begin() + at);
    result.region_normal.erase(result.region_normal.begin() + at);
    result.region_offset.erase(result.region_offset.begin() + at);
    sums_.erase(sums_.begin() + at);
  }
  hold(result.region_locked);
  for (std::int32_t& r : result.face_region) r -= r > region;
}

void Edit::move(std::int32_t i, std::int32_t to) {
  ISIMP_ASSERT(labels.get(i) >= 0 && labels.get(i) != to, "a face moves from a region that is not held to another one");
  result.region_sum[labels.get(i)].remove(graph.faces[i]);
  result.region_sum[to].add(graph.faces[i]);
  labels.set(i, to);
}

std::vector<std::int32_t> Edit::relax(std::span<const std::int32_t> faces, std::int32_t pinned, Job& job) {
  Relaxation<EditLabels> relaxation(graph, labels, result.region_sum, border_weight_of(result, graph), Threads(1),
                                    surface.relative_weight());
  relaxation.pin(pinned);
  Distances distances(surface, result.metric, result.region_count());
  if (result.metric != Metric::normals) {
    distances.forget(result.region_sum.size());
    relaxation.measure(&distances);
  }
  for (const std::int32_t face : faces) {
    relaxation.push_if_border(face);
    for (const std::int32_t j : graph.neighbours[face])
      if (j != graph.size()) relaxation.push_if_border(j);
  }
  relaxation.run(kEditSweeps, job);
  return relaxation.pushed();
}

void Edit::reconnect(std::span<const std::int32_t> changed) {
  std::vector<std::int32_t> around;  // adjacent faces, by region
  for (const std::int32_t face : changed)
    for (const std::int32_t j : graph.neighbours[face])
      if (labels.get(j) >= 0 && labels.get(j) != labels.get(face)) around.push_back(j);
  std::stable_sort(around.begin(), around.end(),
                   [&](std::int32_t a, std::int32_t b) { return labels.get(a) < labels.get(b); });
  std::vector<std::int32_t> loose;
  for (std::size_t begin = 0, end = 0; begin < around.size(); begin = end) {
    const std::int32_t region = labels.get(around[begin]);
    while (end < around.size() && labels.get(around[end]) == region) ++end;
    const std::vector<std::int32_t> cut = cut_off(graph, labels, std::span(around).subspan(begin, end - begin));
    for (const std::int32_t face : cut) result.region_sum[region].remove(graph.faces[face]);
    loose.insert(loose.end(), cut.begin(), cut.end());
  }
  for (const std::int32_t face : loose) labels.set(face, kOpen);
  std::vector<std::int32_t> touched;
  if (!loose.empty()) flood_from_around(graph, labels, loose, result.region_sum, touched);
  ISIMP_ASSERT(std::all_of(loose.begin(), loose.end(), [&](std::int32_t face) { return labels.get(face) >= 0; }),
               "what is cut off is beside the region that cut it off");
  hints.insert(hints.end(), loose.begin(), loose.end());
}

double Edit::error() const {
  double total = 0.0;
  for (const RegionSum& s : result.region_sum) total += s.error();
  return total;
}

void Edit::keep_planes() {
  if (result.region_held.empty()) result.region_offset.clear();
  for (std::size_t r = 0; r < result.region_held.size(); ++r) {
    const RegionSum &now = result.region_sum[r], &before = sums_[r];
    const double turned = (now.normal() - before.normal()).norm(), more = std::abs(now.weight - before.weight);
    const bool is_same = now.faces == before.faces && turned <= 1e-9 && more <= 1e-9 * before.weight;
    const bool by_hand =
        !result.is_snapped(static_cast<std::int32_t>(r)) && turned <= kTurns && more <= kStays * before.weight;
    if (is_same || by_hand) continue;
    result.region_held[r] = 0;
    if (!result.region_cell.empty()) result.region_cell[r] = {};  // what an edit changes leaves its patch
  }
  result.regularity.reset();
}

Partition Edit::finish() {
  const auto regions = static_cast<std::int32_t>(result.region_sum.size());
  ISIMP_ASSERT(fits(result), "labels are of regions, with as many faces as their sums have");
  hold({});
  keep_planes();
  result.region_normal.resize(result.region_sum.size());
  std::vector<std::int32_t> lost;
  for (std::int32_t r = 0; r < regions; ++r) {
    if (!result.is_held(r)) result.region_normal[r] = result.region_sum[r].normal();
    const std::int32_t seed = result.region_seed[r];
    if (seed == kNone || result.face_region[seed] != r) lost.push_back(r);
  }
  result.error = error() * graph.area;
  result.history.assign(1, result.error);
  result.bound = result.distance_max = 0.0;  // an edit uses the error and keeps no bound
  for (const std::int32_t r : lost) reseed(r);
  place_free_planes(surface.mesh(), result);
  return std::move(result);
}

void Edit::reseed(std::int32_t region) {
  std::int32_t start = kNone;
  for (const std::int32_t face : hints)
    if (labels.get(face) == region) start = face;
  if (start == kNone)  // it moved away from the touched faces: rare, so all faces are searched
    start = graph.graph_face[std::find(result.face_region.begin(), result.face_region.end(), region) -
                             result.face_region.begin()];
  const std::vector<std::int32_t> faces = take_out(graph, labels, start);
  for (const std::int32_t face : faces) labels.set(face, region);
  result.region_seed[region] = graph.mesh_face[nearest_of(graph, faces, NormalMetric::fit(result.region_sum[region]))];
}

}  // namespace isimp
