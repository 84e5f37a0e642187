// Resolves vertices that a chart touches more than once.
#include <algorithm>
#include <span>

#include "discs/discs.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

/// A hand-over of more faces than this is no small change of the regions any more.
constexpr std::size_t kLargestSector = 8;

/// Consecutive faces at a vertex that have the same label.
struct Sector {
  std::int32_t label;
  std::vector<std::int32_t> faces;
};

struct Fan {
  std::vector<Sector> sectors;
  bool closed = false;  ///< the last one is followed by the first
};

Fan sectors_of(const Labels& labels, std::int32_t vertex) {
  Fan fan;
  for_each_leaving(labels.mesh, vertex, [&](std::int32_t h) {
    const std::int32_t l = labels.label[h / 3];
    if (fan.sectors.empty() || fan.sectors.back().label != l) fan.sectors.push_back({l, {}});
    fan.sectors.back().faces.push_back(h / 3);
  });
  fan.closed = labels.mesh.opposite(labels.mesh.vertex_halfedge()[vertex]) != kNone;
  if (fan.closed && fan.sectors.size() > 1 && fan.sectors.front().label == fan.sectors.back().label) {
    Sector& first = fan.sectors.front();
    first.faces.insert(first.faces.begin(), fan.sectors.back().faces.begin(), fan.sectors.back().faces.end());
    fan.sectors.pop_back();
  }
  return fan;
}

struct HandOver {
  const Sector *sector, *to;
};

std::vector<HandOver> hand_overs(const Fan& fan) {
  std::vector<HandOver> result;
  const auto n = static_cast<int>(fan.sectors.size());
  for (int i = 0; i < n; ++i)
    for (const int step : {-1, 1}) {
      int j = i + step;
      if (fan.closed) j = (j + n) % n;
      if (j < 0 || j >= n || j == i || fan.sectors[i].faces.size() > kLargestSector) continue;
      if (fan.sectors[i].label != fan.sectors[j].label) result.push_back({&fan.sectors[i], &fan.sectors[j]});
    }
  std::stable_sort(result.begin(), result.end(), [](const HandOver& a, const HandOver& b) {
    return a.sector->faces.size() < b.sector->faces.size();
  });
  return result;
}

/// Whether a wall would get faces, or lose some to a chart, that look another way: it was parted since one polygon
/// can't stand for both.
bool spoils_wall(const Labels& labels, const HandOver& h) {
  const auto is_wall = [&](const Sector* s) { return labels.charts[s->label].cause == Cause::wall; };
  const auto look = [&](const Sector* s) {
    const FaceGraph& graph = labels.mesh.graph();
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t f : s->faces) {
      const FaceRecord& r = graph.faces[graph.graph_face[f]];
      sum += r.area * Vec3(r.nx, r.ny, r.nz);
    }
    return sum.normalized();
  };
  return (is_wall(h.sector) || is_wall(h.to)) && look(h.sector).dot(look(h.to)) < kSameWay;
}

/// By how much V - E + F of a chart rises when some faces come to it that are not its own (yet, or any more).
/// Cost: O(faces at their corners).
int rise_of_euler(const Labels& labels, std::int32_t chart, std::span<const std::int32_t> faces) {
  const Mesh& mesh = labels.mesh;
  const auto added = [&](std::int32_t f) { return std::find(faces.begin(), faces.end(), f) != faces.end(); };
  const auto has = [&](std::int32_t f) { return labels.label[f] == chart && !added(f); };
  std::vector<std::int32_t> vertices;
  auto rise = static_cast<int>(faces.size());
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      vertices.push_back(mesh.from(h));
      const std::int32_t o = mesh.opposite(h);
      const bool old = o != kNone && has(o / 3), counted = o != kNone && o < h && added(o / 3);
      if (!old && !counted) --rise;
    }
  sort_unique(vertices);
  for (const std::int32_t v : vertices) {
    bool old = false;
    for_each_leaving(mesh, v, [&](std::int32_t h) { old = old || has(h / 3); });
    if (!old) ++rise;
  }
  return rise;
}

/// Whether faces of a connected chart hang on the rest of it by one edge alone, so that it stays connected without
/// them.
bool hangs_on_one_edge(const Labels& labels, std::span<const std::int32_t> faces) {
  int edges = 0;
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      edges += labels.inner(h) && std::find(faces.begin(), faces.end(), labels.mesh.opposite(h) / 3) == faces.end();
  return edges == 1;
}

/// Moves some faces of a chart to another, if the chart stays connected and keeps a face of its region: it would be
/// counted to another region without one.
/// \return whether it does
bool give(Labels& labels, std::span<const std::int32_t> faces, std::int32_t to) {
  const std::int32_t from = labels.label[faces[0]], face = labels.charts[from].face;
  const auto is_own = [&](std::int32_t f) { return labels.face_region[f] == labels.charts[from].region; };
  const bool has_face = std::find(faces.begin(), faces.end(), face) != faces.end();
  const bool is_tip = !has_face && is_own(face) && hangs_on_one_edge(labels, faces);
  std::vector<std::int32_t> giver;
  if (!is_tip) giver = labels.faces_of(from);
  if (!is_tip && giver.size() <= faces.size()) return false;
  for (const std::int32_t f : faces) labels.label.set(f, to);
  if (is_tip) return true;
  std::erase_if(giver, [&](std::int32_t f) { return labels.label[f] != from; });
  const auto own = std::find_if(giver.begin(), giver.end(), is_own);
  labels.charts.edit(from).face = own != giver.end() ? *own : giver[0];
  if (own != giver.end() && labels.faces_of(from).size() == giver.size()) return true;
  labels.charts.edit(from).face = face;
  for (const std::int32_t f : faces) labels.label.set(f, from);
  return false;
}

}  // namespace

// A connected chart with a boundary is a disc if V - E + F is 1, where a pinch counts as one vertex.
// So the faces at the sector decide whether a hand-over helps. Only the connectivity of the giver has to be checked.
std::vector<std::int32_t> hand_over_sector(Cutter& cutter, std::int32_t vertex) {
  Labels& labels = cutter.labels;
  const Fan fan = sectors_of(labels, vertex);
  for (const HandOver& h : hand_overs(fan)) {
    const auto& sector = h.sector;
    const std::int32_t from = sector->label, to = h.to->label;
    if (spoils_wall(labels, h)) continue;
    if (rise_of_euler(labels, to, sector->faces) <= rise_of_euler(labels, from, sector->faces)) continue;
    if (!give(labels, sector->faces, to)) continue;
    labels.touched.insert(labels.touched.end(), {from, to});
    return {from, to};
  }
  return {};
}

}  // namespace isimp::meshing
