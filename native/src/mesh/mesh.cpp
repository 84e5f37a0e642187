#include "isimp/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "isimp/core/errors.h"

namespace isimp {
namespace {

const char* const kHint = "; clean(...) repairs this";

std::string edge_name(std::int32_t a, std::int32_t b) {
  return "the edge of vertices " + std::to_string(std::min(a, b)) + " and " + std::to_string(std::max(a, b));
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
  check_arrays();
  Job::Part part(job, "reading the mesh", 0.0, 1.0);
  if (source_face_.empty()) {
    source_face_.resize(triangles_.size());
    std::iota(source_face_.begin(), source_face_.end(), 0);
  }
  if (source_vertex_.empty()) {
    source_vertex_.resize(vertices_.size());
    std::iota(source_vertex_.begin(), source_vertex_.end(), 0);
  }
  report_.repairs = std::move(repairs);
  pair_halfedges(job);
  job.report(0.3);
  find_fans(job);
  job.report(0.5);
  find_components();
  job.report(0.7);
  graph_ = make_face_graph(vertices_, triangles_, opposite_);
  summarise();
}

void Mesh::check_arrays() const {
  if (triangles_.empty()) throw InvalidInput("the mesh has no faces");
  if (triangles_.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 3))
    throw InvalidInput("the mesh has " + std::to_string(triangles_.size()) +
                       " faces; at most 715,827,882 are supported");
  const auto n = static_cast<std::int32_t>(vertices_.size());
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    if (!vertices_[v].allFinite())
      throw InvalidInput("vertex " + std::to_string(v) + " has a coordinate that is not finite" + kHint);
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    const Triangle& t = triangles_[f];
    for (const std::int32_t v : t)
      if (v < 0 || v >= n)
        throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(n) + " vertices");
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      throw InvalidInput("face " + std::to_string(f) + " names vertex " + std::to_string(t[0] == t[1] ? t[0] : t[2]) +
                         " twice" + kHint);
  }
}

/// Counting sort of the half-edges on their smaller vertex, then pairs within each bucket (six entries on average).
void Mesh::pair_halfedges(Job& job) {
  const std::size_t half_edges = 3 * triangles_.size();
  opposite_.assign(half_edges, kNone);
  std::vector<std::int32_t> first(vertices_.size() + 1, 0), bucket(half_edges);
  const auto smaller = [&](std::size_t h) {
    const auto e = static_cast<std::int32_t>(h);
    return std::min(from(e), to(e));
  };
  for (std::size_t h = 0; h < half_edges; ++h) ++first[smaller(h) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::int32_t> fill(first.begin(), first.end() - 1);
  for (std::size_t h = 0; h < half_edges; ++h) bucket[fill[smaller(h)]++] = static_cast<std::int32_t>(h);
  job.poll();
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    for (std::int32_t i = first[v]; i < first[v + 1]; ++i)
      for (std::int32_t j = i + 1; j < first[v + 1]; ++j) {
        const std::int32_t g = bucket[i], h = bucket[j];
        const bool opposed = from(g) == to(h) && to(g) == from(h);
        if (!opposed && !(from(g) == from(h) && to(g) == to(h))) continue;
        const std::string where = edge_name(from(g), to(g));
        if (opposite_[g] != kNone || opposite_[h] != kNone)
          throw InvalidInput(where + " has three or more faces, face " + std::to_string(face(h)) + " among them" +
                             kHint);
        if (!opposed)
          throw InvalidInput("faces " + std::to_string(face(g)) + " and " + std::to_string(face(h)) +
                             " run the same way along " + where + kHint);
        opposite_[g] = h;
        opposite_[h] = g;
      }
}

void Mesh::find_fans(Job& job) {
  vertex_halfedge_.assign(vertices_.size(), kNone);
  std::vector<std::int32_t> leaving(vertices_.size(), 0);
  const auto half_edges = static_cast<std::int32_t>(3 * triangles_.size());
  for (std::int32_t h = 0; h < half_edges; ++h) {
    std::int32_t& at = vertex_halfedge_[from(h)];
    ++leaving[from(h)];
    if (at == kNone || opposite(h) == kNone) at = h;  // a border half-edge starts the walk over the whole fan
  }
  job.poll();
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const std::int32_t start = vertex_halfedge_[v];
    if (start == kNone) {
      ++report_.unused_vertices;
      continue;
    }
    std::int32_t seen = 0, h = start;
    do {
      ++seen;
      h = turn(h);
    } while (h != kNone && h != start);
    if (seen != leaving[v])
      throw InvalidInput("the faces of vertex " + std::to_string(v) + " form two or more fans" + kHint);
  }
}

void Mesh::find_components() {
  component_.assign(triangles_.size(), kNone);
  std::vector<std::int32_t> stack;
  for (std::size_t start = 0; start < triangles_.size(); ++start) {
    if (component_[start] != kNone) continue;
    const std::int32_t id = report_.components++;
    bool closed = true;
    component_[start] = id;
    stack.push_back(static_cast<std::int32_t>(start));
    while (!stack.empty()) {
      const std::int32_t f = stack.back();
      stack.pop_back();
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        const std::int32_t other = opposite(h);
        if (other == kNone) {
          closed = false;
          ++report_.border_edges;
        } else if (component_[face(other)] == kNone) {
          component_[face(other)] = id;
          stack.push_back(face(other));
        }
      }
    }
    if (closed) ++report_.closed_components;
  }
}

void Mesh::summarise() {
  report_.vertices = vertex_count();
  report_.faces = face_count();
  report_.area = graph_.area;
  report_.closed = report_.border_edges == 0;
  const auto half_edges = static_cast<std::int64_t>(opposite_.size());
  const std::int64_t edges = (half_edges + report_.border_edges) / 2;
  report_.euler = report_.vertices - report_.unused_vertices - edges + report_.faces;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    if (vertex_halfedge_[v] == kNone) continue;
    low = low.cwiseMin(vertices_[v]);
    high = high.cwiseMax(vertices_[v]);
  }
  report_.diagonal = (high - low).norm();
  for (const FaceRecord& record : std::span(graph_.faces).first(triangles_.size()))
    report_.zero_area_faces += record.area == 0.0F;

  std::vector<bool> seen(opposite_.size(), false);  // every border half-edge belongs to one loop
  for (std::int32_t h = 0; h < half_edges; ++h) {
    if (opposite(h) != kNone || seen[h]) continue;
    ++report_.border_loops;
    for (std::int32_t g = h; !seen[g];) {
      seen[g] = true;
      g = vertex_halfedge_[to(g)];  // one fan, so the border half-edge that leaves the vertex is unique
    }
  }
}

}  // namespace isimp
