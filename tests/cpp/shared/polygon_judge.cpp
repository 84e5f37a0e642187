#include "polygon_judge.h"

#include <cstddef>

#include "isimp/mesh/part_of.h"
#include "tests.h"

namespace isimp::judge {

std::vector<Loop> polygons_of(const PolygonMesh& mesh) {
  std::vector<Loop> polygons;
  for (std::size_t q = 0; q < mesh.loop_start.size(); ++q) {
    const auto end = q + 1 < mesh.loop_start.size() ? mesh.loop_start[q + 1] : mesh.loops.size();
    polygons.emplace_back(mesh.loops.begin() + mesh.loop_start[q],
                          mesh.loops.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return polygons;
}

namespace {

struct Groups {
  explicit Groups(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  std::size_t root(std::size_t i) const { return parent[i] == i ? i : root(parent[i]); }
  void join(std::size_t a, std::size_t b) { parent[root(a)] = root(b); }
  std::size_t count() const {
    std::size_t n = 0;
    for (std::size_t i = 0; i < parent.size(); ++i) n += parent[i] == i;
    return n;
  }
  std::vector<std::size_t> parent;
};

/// Defects that a polygon can have on its own.
void look_at_polygons(const PolygonMesh& mesh, const std::vector<Loop>& polygons, double size, Figures& v) {
  std::set<Loop> known;
  for (std::size_t q = 0; q < polygons.size(); ++q) {
    const Loop& loop = polygons[q];
    const std::string name = "polygon " + std::to_string(q);
    if (loop.size() < 3) v.defects += name + " has fewer than three corners; ";
    Loop sorted = loop;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) v.defects += name + " repeats a vertex; ";
    if (!known.insert(sorted).second) v.defects += name + " has the corners of another; ";
    Vec3 area = Vec3::Zero(), centre = Vec3::Zero();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 &a = mesh.vertices[loop[i]], &b = mesh.vertices[loop[(i + 1) % loop.size()]];
      area += (a - mesh.vertices[loop[0]]).cross(b - mesh.vertices[loop[0]]) / 2;
      centre += a / static_cast<double>(loop.size());
    }
    v.area += area.norm();
    if (area.norm() < 1e-14 * size * size) {
      v.defects += name + " has no area; ";
      continue;
    }
    for (const std::int32_t i : loop)
      v.bend_max = std::max(v.bend_max, std::abs((mesh.vertices[i] - centre).dot(area.normalized())));
  }
}

/// Edges, fans, components and borders.
void look_at_edges(const PolygonMesh& mesh, const std::vector<Loop>& polygons, Figures& v) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> directed;  // edge -> its corner, numbered through
  std::vector<std::size_t> next, owner;
  std::size_t corner = 0;
  for (std::size_t q = 0; q < polygons.size(); ++q) {
    const Loop& loop = polygons[q];
    const std::size_t first = corner;
    for (std::size_t i = 0; i < loop.size(); ++i, ++corner) {
      const std::pair<std::int32_t, std::int32_t> edge{loop[i], loop[(i + 1) % loop.size()]};
      if (!directed.emplace(edge, corner).second)
        v.defects += "edge " + std::to_string(edge.first) + "-" + std::to_string(edge.second) + " runs twice one way; ";
      next.push_back(i + 1 < loop.size() ? corner + 1 : first);
      owner.push_back(q);
    }
  }
  Groups fans(corner), parts(polygons.size()), borders(mesh.vertices.size());
  std::int64_t edges = 0;
  std::map<std::int32_t, int> border_ends;
  for (const auto& [edge, c] : directed) {
    const auto other = directed.find({edge.second, edge.first});
    if (other == directed.end()) {
      ++edges;
      ++v.border_edges;
      ++border_ends[edge.first];
      ++border_ends[edge.second];
      borders.join(edge.first, edge.second);
      continue;
    }
    edges += edge.first < edge.second;
    fans.join(c, next[other->second]);
    parts.join(owner[c], owner[other->second]);
  }
  for (const auto& [vertex, ends] : border_ends)
    if (ends != 2) v.defects += "vertex " + std::to_string(vertex) + " has " + std::to_string(ends) + " border edges; ";
  if (fans.count() != mesh.vertices.size())
    v.defects += std::to_string(fans.count()) + " fans for " + std::to_string(mesh.vertices.size()) + " vertices; ";
  v.components = static_cast<std::int64_t>(parts.count());
  v.euler = static_cast<std::int64_t>(mesh.vertices.size() + polygons.size()) - edges;
  std::set<std::size_t> loops;
  for (const auto& [vertex, ends] : border_ends) loops.insert(borders.root(vertex));
  v.border_loops = static_cast<std::int64_t>(loops.size());
}

}  // namespace

Figures look_at(const PolygonMesh& mesh) {
  Figures v;
  const std::vector<Loop> polygons = polygons_of(mesh);
  std::vector<bool> used(mesh.vertices.size(), false);
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const std::int32_t i : mesh.loops) {
    if (i < 0 || i >= static_cast<std::int32_t>(mesh.vertices.size())) {
      v.defects = "a corner names vertex " + std::to_string(i);
      return v;
    }
    used[i] = true;
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!used[i]) v.defects += "vertex " + std::to_string(i) + " is unused; ";
    if (!mesh.vertices[i].allFinite()) v.defects += "vertex " + std::to_string(i) + " is not finite; ";
    low = low.cwiseMin(mesh.vertices[i]);
    high = high.cwiseMax(mesh.vertices[i]);
  }
  look_at_polygons(mesh, polygons, (high - low).norm(), v);
  look_at_edges(mesh, polygons, v);
  return v;
}

std::string defects_against(const PolygonMesh& mesh, const Mesh& scan, const Partition& partition) {
  Figures v = look_at(mesh);
  // The kept part of the scan, as polygons of its own.
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < scan.face_count(); ++f)
    if (partition.kept_region(f) != kNone) faces.push_back(f);
  const Mesh part = part_of(scan, faces, job());
  PolygonMesh kept;
  kept.vertices.assign(part.vertices().begin(), part.vertices().end());
  for (const Triangle& t : part.triangles()) {
    kept.loop_start.push_back(static_cast<std::int32_t>(kept.loops.size()));
    kept.loops.insert(kept.loops.end(), t.begin(), t.end());
  }
  Figures s;
  look_at_edges(kept, polygons_of(kept), s);
  const auto compare = [&](const char* what, std::int64_t got, std::int64_t wanted) {
    if (got != wanted)
      v.defects += std::string(what) + " " + std::to_string(got) + ", scan " + std::to_string(wanted) + "; ";
  };
  compare("euler", v.euler, s.euler);
  compare("components", v.components, s.components);
  compare("border loops", v.border_loops, s.border_loops);
  if (mesh.report.euler != v.euler) v.defects += "the report's euler is " + std::to_string(mesh.report.euler) + "; ";
  if (mesh.report.closed != (v.border_edges == 0)) v.defects += "the report is wrong about closed; ";
  if (!mesh.report.manifold) v.defects += "the report says it is not manifold; ";
  return v.defects;
}

PolygonMesh sound(const Mesh& scan, const Partition& partition) {
  PolygonMesh polygons = polygonize(scan, partition, {}, job());
  EXPECT_EQ(defects_against(polygons, scan, partition), "");
  return polygons;
}

}  // namespace isimp::judge
