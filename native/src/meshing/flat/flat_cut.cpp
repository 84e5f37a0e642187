#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "flat/flat.h"
#include "isimp/core/forest.h"

namespace isimp::meshing::flat {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertices = CGAL::Triangulation_vertex_base_with_info_2<std::int32_t, Kernel>;
using Faces =
    CGAL::Triangulation_face_base_with_info_2<int, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<Vertices, Faces>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::No_constraint_intersection_tag>;

bool has_twice(const std::vector<Loop>& loops) {
  std::vector<std::int32_t> all;
  for (const Loop& loop : loops) all.insert(all.end(), loop.begin(), loop.end());
  std::sort(all.begin(), all.end());
  return std::adjacent_find(all.begin(), all.end()) != all.end();
}

/// Numbers the faces by how many loops are between them and the outside.
void count_loops(Triangulation& plane) {
  for (const auto face : plane.all_face_handles()) face->info() = kNone;
  std::vector<Triangulation::Face_handle> now{plane.infinite_face()}, next;
  for (int depth = 0; !now.empty(); ++depth, now = std::exchange(next, {})) {
    while (!now.empty()) {
      const auto face = now.back();
      now.pop_back();
      if (face->info() != kNone) continue;
      face->info() = depth;
      for (int k = 0; k < 3; ++k) {
        const auto other = face->neighbor(k);
        if (other->info() == kNone) (plane.is_constrained({face, k}) ? next : now).push_back(other);
      }
    }
  }
}

/// The triangles between the loops; empty where loops cross or vertices coincide.
std::vector<Loop> triangles_of(const Mesh& mesh, const Plane& plane, const std::vector<Loop>& loops) {
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  Triangulation made;
  std::unordered_map<std::int32_t, Triangulation::Vertex_handle> known;
  for (const Loop& loop : loops) {
    for (const std::int32_t vertex : loop) {
      if (known.contains(vertex)) continue;
      const Vec3 p = mesh.vertices()[vertex] - plane.centre;
      const std::size_t before = made.number_of_vertices();
      const auto handle = made.insert(Kernel::Point_2(p.dot(u), p.dot(v)));
      if (made.number_of_vertices() == before) return {};
      handle->info() = vertex;
      known.emplace(vertex, handle);
    }
  }
  try {
    for (const Loop& loop : loops) {
      for (std::size_t i = 0; i < loop.size(); ++i)
        made.insert_constraint(known.at(loop[i]), known.at(loop[(i + 1) % loop.size()]));
    }
  } catch (const Triangulation::Intersection_of_constraints_exception&) {
    return {};
  }
  if (made.dimension() < 2) return {};
  count_loops(made);
  std::vector<Loop> triangles;
  for (const auto face : made.finite_face_handles()) {
    if (face->info() % 2 == 1)
      triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return triangles;
}

/// An edge that two polygons share: a < b.
struct Shared {
  double length;
  std::int32_t a, b, p, q;
};

std::vector<Shared> shared_edges(const Mesh& mesh, const std::vector<Loop>& polygons) {
  std::vector<Shared> edges;
  for (std::size_t p = 0; p < polygons.size(); ++p) {
    const Loop& loop = polygons[p];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto [a, b] = std::minmax(loop[i], loop[(i + 1) % loop.size()]);
      edges.push_back({0, a, b, static_cast<std::int32_t>(p), kNone});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Shared& x, const Shared& y) { return std::tie(x.a, x.b, x.p) < std::tie(y.a, y.b, y.p); });
  std::vector<Shared> shared;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const Shared& x = edges[i];
    if (x.a != edges[i + 1].a || x.b != edges[i + 1].b) continue;
    shared.push_back({(mesh.vertices()[x.a] - mesh.vertices()[x.b]).squaredNorm(), x.a, x.b, x.p, edges[i + 1].p});
  }
  std::sort(shared.begin(), shared.end(), [](const Shared& x, const Shared& y) {
    return x.length != y.length ? x.length > y.length : std::tie(x.a, x.b) < std::tie(y.a, y.b);
  });
  return shared;
}

/// Two polygons as one, if an edge is all that they share; else empty.
Loop united(const Loop& p, const Loop& q, std::int32_t a, std::int32_t b) {
  Loop left = p, right = q;
  std::sort(left.begin(), left.end());
  std::sort(right.begin(), right.end());
  Loop common;
  std::set_intersection(left.begin(), left.end(), right.begin(), right.end(), std::back_inserter(common));
  if (common.size() != 2) return {};
  const auto after = [](const Loop& loop, std::int32_t v) {
    return std::find(loop.begin(), loop.end(), v) - loop.begin();
  };
  // p runs from `from` to `to` along the edge, q the other way.
  std::int32_t from = a, to = b;
  if (p[(after(p, from) + 1) % p.size()] != to) std::swap(from, to);
  Loop one;
  for (std::size_t i = 0; i < p.size(); ++i) one.push_back(p[(after(p, to) + i) % p.size()]);
  for (std::size_t i = 1; i + 1 < q.size(); ++i) one.push_back(q[(after(q, from) + i) % q.size()]);
  return one;
}

}  // namespace

std::vector<Loop> joined(const Mesh& mesh, std::vector<Loop> polygons) {
  isimp::detail::Forest home(polygons.size());
  for (const Shared& edge : shared_edges(mesh, polygons)) {
    const std::int32_t p = home.root(edge.p), q = home.root(edge.q);
    if (p == q) continue;
    Loop one = united(polygons[p], polygons[q], edge.a, edge.b);
    if (one.empty()) continue;
    home.join(p, q);
    polygons[std::max(p, q)].clear();
    polygons[std::min(p, q)] = std::move(one);
  }
  std::erase_if(polygons, [](const Loop& loop) { return loop.empty(); });
  return polygons;
}

std::vector<Loop> cut(const Mesh& mesh, const Plane& plane, std::vector<Loop> loops) {
  const auto is_short = [](const Loop& loop) { return loop.size() < 3; };
  if (loops.empty() || std::any_of(loops.begin(), loops.end(), is_short)) return {};
  if (loops.size() == 1 && !has_twice(loops)) return loops;
  if (!(plane.normal.squaredNorm() > 0)) return {};
  return joined(mesh, triangles_of(mesh, plane, loops));
}

}  // namespace isimp::meshing::flat
