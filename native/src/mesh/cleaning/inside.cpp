#include "cleaning/inside.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "isimp/core/forest.h"

namespace isimp::detail {
namespace {

constexpr int kProbes = 8;               ///< limit: at least this many vertices of a component are probed
constexpr std::size_t kContainers = 64;  ///< limit: the largest components are those that may contain others

/// A connected component.
struct Part {
  Eigen::AlignedBox3d box;
  bool closed = true, inner = false;
  std::vector<std::int32_t> faces;
  std::vector<std::int32_t> probes;  ///< some vertices
};

std::vector<Part> parts_of(const MeshArrays& arrays, const Topology& topology, Job& job) {
  Forest forest(arrays.vertices.size());
  for (const Triangle& t : arrays.triangles) {
    forest.join(t[0], t[1]);
    forest.join(t[0], t[2]);
  }
  job.poll();
  std::vector<Part> parts;
  std::vector<std::int32_t> number(arrays.vertices.size(), kNone);
  for (std::size_t f = 0; f < arrays.triangles.size(); ++f) {
    std::int32_t& part = number[forest.root(arrays.triangles[f][0])];
    if (part == kNone) {
      part = static_cast<std::int32_t>(parts.size());
      parts.emplace_back();
    }
    parts[part].faces.push_back(static_cast<std::int32_t>(f));
    for (int k = 0; k < 3; ++k) parts[part].closed &= topology.opposite[3 * f + k] != kNone;
  }
  for (Part& part : parts) {
    const std::size_t step = std::max<std::size_t>(part.faces.size() / kProbes, 1);
    for (std::size_t k = 0; k < part.faces.size(); ++k) {
      const Triangle& t = arrays.triangles[part.faces[k]];
      for (const std::int32_t v : t) part.box.extend(arrays.vertices[v]);
      if (k % step == 0) part.probes.push_back(t[0]);
    }
  }
  return parts;
}

/// On which side of the line from a to b a place is, as seen along x; an edge has the same answer from both its faces.
bool is_left(const Vec3& a, const Vec3& b, const Vec3& p) {
  const bool turned = std::pair(b.y(), b.z()) < std::pair(a.y(), a.z());
  const Vec3 &low = turned ? b : a, &high = turned ? a : b;
  const double side = (high.y() - low.y()) * (p.z() - low.z()) - (high.z() - low.z()) * (p.y() - low.y());
  return (side >= 0) != turned;
}

/// Whether the line from p towards larger x meets a triangle.
bool is_met(const std::array<Vec3, 3>& t, const Vec3& p) {
  const bool left = is_left(t[0], t[1], p);
  if (left != is_left(t[1], t[2], p) || left != is_left(t[2], t[0], p)) return false;
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  if (normal.x() == 0) return false;
  return (normal.dot(t[0] - p)) / normal.x() > 0;
}

/// Marks the candidates that are inside a closed part.
void mark_inside(const MeshArrays& arrays, const Part& around, std::vector<Part*> candidates, Job& job) {
  std::erase_if(candidates, [&](const Part* part) { return !around.box.contains(part->box); });
  if (candidates.empty()) return;
  std::vector<std::pair<Vec3, std::pair<Part*, bool>>> probes;  // by their y; whether they are inside
  for (Part* part : candidates)
    for (const std::int32_t v : part->probes) probes.push_back({arrays.vertices[v], {part, false}});
  std::stable_sort(probes.begin(), probes.end(),
                   [](const auto& a, const auto& b) { return a.first.y() < b.first.y(); });
  std::size_t done = 0;
  for (const std::int32_t f : around.faces) {
    if (done++ % kPollEvery == 0) job.poll();
    const auto& [a, b, c] = arrays.triangles[f];
    const std::array<Vec3, 3> t{arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]};
    const auto [least, most] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
    const auto first = std::lower_bound(probes.begin(), probes.end(), least,
                                        [](const auto& probe, double y) { return probe.first.y() < y; });
    for (auto probe = first; probe != probes.end() && probe->first.y() <= most; ++probe)
      probe->second.second ^= is_met(t, probe->first);
  }
  for (Part* part : candidates) part->inner = true;
  for (const auto& [place, found] : probes) found.first->inner &= found.second;
}

}  // namespace

std::vector<std::uint8_t> inner_faces(const MeshArrays& arrays, const Topology& topology, Job& job) {
  std::vector<Part> parts = parts_of(arrays, topology, job);
  std::vector<Part*> order;
  order.reserve(parts.size());
  for (Part& part : parts) order.push_back(&part);
  const auto size = [](const Part* part) { return part->box.diagonal().squaredNorm(); };
  std::stable_sort(order.begin(), order.end(), [&](const Part* a, const Part* b) { return size(a) > size(b); });
  std::vector<std::uint8_t> marks;
  for (std::size_t k = 0; k < std::min(order.size(), kContainers); ++k) {
    job.poll();
    if (!order[k]->closed || order[k]->inner) continue;
    std::vector<Part*> smaller(order.begin() + static_cast<std::ptrdiff_t>(k) + 1, order.end());
    std::erase_if(smaller, [](const Part* part) { return part->inner; });
    mark_inside(arrays, *order[k], std::move(smaller), job);
  }
  for (const Part& part : parts) {
    if (!part.inner) continue;
    marks.resize(arrays.triangles.size(), 0);
    for (const std::int32_t f : part.faces) marks[f] = 1;
  }
  return marks;
}

}  // namespace isimp::detail
