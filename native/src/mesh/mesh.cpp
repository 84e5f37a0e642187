#include "isimp/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "isimp/core/errors.h"
#include "pieces.h"
#include "soup.h"
#include "topology.h"

namespace isimp {
namespace {

using detail::for_each_index;

const char* const kHint = "; clean(...) repairs this";
constexpr double kFarthest = 1e30;  // areas, their squares and sums of them stay finite

/// Bad input is reported even if the job was cancelled before the call, so that nothing is polled here.
void check_arrays(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) throw InvalidInput("the mesh has no faces");
  const auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (triangles.size() > most / 3 || vertices.size() > most)
    throw InvalidInput("the mesh has " + std::to_string(triangles.size()) + " faces and " +
                       std::to_string(vertices.size()) +
                       " vertices; at most 715,827,882 and 2,147,483,647 are supported");
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (!(vertices[v].cwiseAbs().maxCoeff() <= kFarthest) || vertices[v].hasNaN())
      throw InvalidInput("vertex " + std::to_string(v) + " has a coordinate that is not finite" +
                         (vertices[v].allFinite() ? " to us: beyond 1e30" : "") + kHint);
  const auto n = static_cast<std::int32_t>(vertices.size());
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    for (const std::int32_t v : t)
      if (v < 0 || v >= n)
        throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(n) + " vertices");
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      throw InvalidInput("face " + std::to_string(f) + " names vertex " + std::to_string(t[0] == t[1] ? t[0] : t[2]) +
                         " twice" + kHint);
  }
}

/// What to subtract from coordinates in a box, so that they are of about its size. Differences are exact: where there
/// is a shift, it and each coordinate are within a factor of two (Sterbenz's lemma), and so are the sums that lead
/// back.
Vec3 shift_to_zero(const Box& box) {
  const double diagonal = box.diagonal().norm();
  Vec3 shift = Vec3::Zero();
  if (!(diagonal > 0)) return shift;
  const double step = std::exp2(std::floor(std::log2(diagonal)) - 1);
  const Vec3 middle = box.center();
  for (int k = 0; k < 3; ++k)
    if (std::abs(middle[k]) >= 2 * diagonal) shift[k] = std::nearbyint(middle[k] / step) * step;
  return shift;
}

std::vector<std::int32_t> identity(std::size_t n) {
  std::vector<std::int32_t> result(n);
  std::iota(result.begin(), result.end(), 0);
  return result;
}

}  // namespace

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, Job& job)
    : Mesh(std::move(vertices), std::move(triangles), {}, {}, {}, job) {}

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, std::vector<std::int32_t> source_face,
           std::vector<std::int32_t> source_vertex, RepairReport repairs, Job& job)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      source_face_(std::move(source_face)),
      source_vertex_(std::move(source_vertex)) {
  check_arrays(vertices_, triangles_);
  const Job::Part part(job, "reading the mesh", 0.0, 1.0);
  detail::Topology topology = [&] {
    const Job::Part edges(job, "reading the mesh", 0.0, 0.5);
    return detail::find_topology(vertices_.size(), triangles_, job);
  }();
  if (!topology.flaw.empty()) throw InvalidInput(topology.flaw + kHint);
  complete(std::move(topology), std::move(repairs), job);
}

Mesh::Mesh(detail::Parts parts, detail::Topology topology, RepairReport repairs, Job& job)
    : vertices_(std::move(parts.vertices)),
      triangles_(std::move(parts.triangles)),
      source_face_(std::move(parts.source_face)),
      source_vertex_(std::move(parts.source_vertex)) {
  complete(std::move(topology), std::move(repairs), job);
}

void Mesh::complete(detail::Topology topology, RepairReport repairs, Job& job) {
  if (source_face_.empty()) source_face_ = identity(triangles_.size());
  if (source_vertex_.empty()) source_vertex_ = identity(vertices_.size());
  opposite_ = std::move(topology.opposite);
  vertex_halfedge_ = std::move(topology.vertex_halfedge);
  find_components(topology.border, job);
  count_border_loops(topology.border);
  job.report(0.6);
  Box box;
  for_each_index(vertices_.size(), job, [&](std::size_t v) {
    if (vertex_halfedge_[v] != kNone) box.extend(vertices_[v]);
  });
  report_.diagonal = box.diagonal().norm();
  origin_ = shift_to_zero(box);
  if (!origin_.isZero(0)) {
    for (Vec3& v : vertices_) v -= origin_;
    box.translate(-origin_);
  }
  {
    const Job::Part faces(job, job.stage(), 0.6, 1.0);
    graph_ = make_face_graph(vertices_, triangles_, opposite_, box, job);
  }

  report_.repairs = std::move(repairs);
  report_.vertices = vertex_count();
  report_.faces = face_count();
  report_.area = graph_.area;
  report_.border_edges = static_cast<std::int64_t>(topology.border.size());
  report_.closed = topology.border.empty();
  report_.unused_vertices = topology.unused_vertices;
  const std::int64_t edges = (static_cast<std::int64_t>(opposite_.size()) + report_.border_edges) / 2;
  report_.euler = report_.vertices - report_.unused_vertices - edges + report_.faces;
  for (std::size_t f = 0; f < triangles_.size(); ++f) report_.zero_area_faces += graph_.faces[f].area == 0.0F;
}

/// Sets of vertices that grow together along edges. Since the faces of a vertex are one fan, faces that share a vertex
/// are joined across edges too; and there are only half as many vertices as faces.
///
/// First every vertex takes the lowest name among its face's vertices, face after face, without a branch. Few names are
/// left then, and few faces where different ones meet: only there are sets joined.
void Mesh::find_components(std::span<const std::int32_t> border, Job& job) {
  std::vector<std::int32_t> name = identity(vertices_.size());  // a vertex of the same set, never a higher one
  // From low to high, so that what a vertex points to points to the end already.
  const auto shorten = [&](std::vector<std::int32_t>& to) {
    for_each_index(to.size(), job, [&](std::size_t v) { to[v] = to[to[v]]; });
  };
  for_each_index(triangles_.size(), job, [&](std::size_t f) {
    const auto& [a, b, c] = triangles_[f];
    const std::int32_t lowest = std::min(name[a], std::min(name[b], name[c]));
    for (const std::int32_t v : triangles_[f]) name[v] = std::min(name[v], lowest);
  });
  shorten(name);
  std::vector<std::int32_t> up = name;  // each vertex's next in its set; a root is its own
  const auto find = [&](std::int32_t v) {
    while (up[v] != v) v = up[v] = up[up[v]];
    return v;
  };
  const auto join = [&](std::int32_t u, std::int32_t v) {
    if (u == v) return;
    const auto [first, second] = std::minmax({find(u), find(v)});
    up[second] = first;
  };
  for_each_index(triangles_.size(), job, [&](std::size_t f) {
    const auto& [a, b, c] = triangles_[f];
    join(name[a], name[b]);
    join(name[b], name[c]);
  });
  shorten(up);
  std::vector<std::int32_t> number(vertices_.size(), kNone);  // of the component, at its root
  component_.resize(triangles_.size());
  for_each_index(triangles_.size(), job, [&](std::size_t f) {
    std::int32_t& id = number[up[triangles_[f][0]]];
    if (id == kNone) id = report_.components++;
    component_[f] = id;
  });
  std::vector<char> open(report_.components, 0);
  for (const std::int32_t h : border) open[component_[face(h)]] = 1;
  report_.closed_components = static_cast<std::int32_t>(std::count(open.begin(), open.end(), 0));
}

void Mesh::count_border_loops(std::span<const std::int32_t> border) {
  if (border.empty()) return;
  std::vector<bool> seen(opposite_.size(), false);
  for (const std::int32_t h : border) {
    if (seen[h]) continue;
    ++report_.border_loops;
    for (std::int32_t g = h; !seen[g];) {
      seen[g] = true;
      g = vertex_halfedge_[to(g)];  // one fan, so the border half-edge that leaves the vertex is unique
    }
  }
}

}  // namespace isimp
