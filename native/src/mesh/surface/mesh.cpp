#include "isimp/mesh/mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "isimp/core/errors.h"
#include "surface/parallel_loops.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp {
namespace {

using detail::for_each_index;

const char* const kHint = "; clean(...) repairs this";

/// Bad input is reported even if the job was cancelled before the call, so that nothing is polled here.
void check_arrays(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const Threads& threads) {
  if (triangles.empty()) throw InvalidInput("the mesh has no faces");
  const auto most = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
  if (triangles.size() > most / 3 || vertices.size() > most)
    throw InvalidInput("the mesh has " + std::to_string(triangles.size()) + " faces and " +
                       std::to_string(vertices.size()) +
                       " vertices; at most 715,827,882 and 2,147,483,647 are supported");
  const auto usable = [](const Vec3& p) { return p.cwiseAbs().maxCoeff() <= detail::kFarthest && !p.hasNaN(); };
  const auto v = detail::find_first(threads, vertices.size(), [&](std::size_t i) { return !usable(vertices[i]); });
  if (v < vertices.size())
    throw InvalidInput("vertex " + std::to_string(v) + " has a coordinate that is " +
                       (vertices[v].allFinite() ? "larger than 1e30, the largest supported" : "not finite") + kHint);
  const auto n = static_cast<std::int32_t>(vertices.size());
  const auto out_of_range = [n](std::int32_t i) { return i < 0 || i >= n; };
  const auto f = detail::find_first(threads, triangles.size(), [&](std::size_t i) {
    const auto& [a, b, c] = triangles[i];
    return out_of_range(a) || out_of_range(b) || out_of_range(c) || a == b || b == c || c == a;
  });
  if (f == triangles.size()) return;
  const Triangle& t = triangles[f];
  for (const std::int32_t corner : t)
    if (out_of_range(corner))
      throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(corner) + ", but there are " +
                         std::to_string(n) + " vertices");
  throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(t[0] == t[1] ? t[0] : t[2]) +
                     " twice" + kHint);
}

/// The offset to subtract from coordinates in a box, so that they are of about its size. Differences are exact: where
/// there is a shift, it and each coordinate are within a factor of two (Sterbenz's lemma), and so are the sums that
/// lead back.
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

/// Sets of vertices that grow together along edges, on all threads. The order of joins does not matter: the lowest
/// vertex of a set is its name in the end.
///
/// First every vertex takes the lowest name among its face's vertices, face after face, without a branch. Few names and
/// few faces with different names remain, and only there sets are joined.
class VertexSets {
 public:
  VertexSets(std::size_t vertices, std::span<const Triangle> triangles, const Threads& threads, Job& job) {
    Array<std::int32_t> name;  // a vertex of the same set, never a higher one
    detail::number_all(threads, name, vertices, job);
    for_each_index(threads, triangles.size(), job, [&](std::size_t f) {
      const auto& [a, b, c] = triangles[f];
      const std::int32_t at_a = get(name[a]), at_b = get(name[b]), at_c = get(name[c]);
      const std::int32_t lowest = std::min(at_a, std::min(at_b, at_c));  // some thread may undo this: no harm
      set(name[a], lowest);
      set(name[b], lowest);
      set(name[c], lowest);
    });
    for_each_index(threads, vertices, job, [&](std::size_t v) { set(name[v], get(name[get(name[v])])); });
    up_.resize(vertices);
    for_each_index(threads, vertices, job, [&](std::size_t v) { up_[v] = name[v]; });
    for_each_index(threads, triangles.size(), job, [&](std::size_t f) {
      const auto& [a, b, c] = triangles[f];
      if (name[a] != name[b]) join(name[a], name[b]);
      if (name[b] != name[c]) join(name[b], name[c]);
    });
    for_each_index(threads, vertices, job, [&](std::size_t v) { set(up_[v], find(static_cast<std::int32_t>(v))); });
  }

  /// The lowest vertex of v's set.
  [[nodiscard]] std::int32_t find(std::int32_t v) const {
    for (std::int32_t next = get(up_[v]); next != v; next = get(up_[v])) v = next;
    return v;
  }

 private:
  static std::int32_t get(const std::int32_t& at) {
    return std::atomic_ref(const_cast<std::int32_t&>(at)).load(std::memory_order_relaxed);
  }
  static void set(std::int32_t& at, std::int32_t value) { std::atomic_ref(at).store(value, std::memory_order_relaxed); }

  std::int32_t find_and_shorten(std::int32_t v) {
    for (std::int32_t next = get(up_[v]); next != v; next = get(up_[v])) {
      set(up_[v], get(up_[next]));
      v = next;
    }
    return v;
  }
  void join(std::int32_t u, std::int32_t v) {
    while (true) {
      const auto [low, high] = std::minmax({find_and_shorten(u), find_and_shorten(v)});
      std::int32_t root = high;
      if (low == high || std::atomic_ref(up_[high]).compare_exchange_strong(root, low, std::memory_order_relaxed))
        return;
    }
  }

  Array<std::int32_t> up_;  // each vertex's next in its set, never a higher one; the lowest is its own
};

}  // namespace

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, Job& job, std::int32_t threads)
    : Mesh(std::move(vertices), std::move(triangles), {}, {}, {}, 0.0, Threads(threads), job) {}

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, Array<std::int32_t> source_face,
           Array<std::int32_t> source_vertex, RepairReport repairs, double cell, const Threads& threads, Job& job)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      source_face_(std::move(source_face)),
      source_vertex_(std::move(source_vertex)) {
  check_arrays(vertices_, triangles_, threads);
  const Job::Stage stage(job, "reading the mesh", 0.0, 1.0);
  detail::Topology topology = [&] {
    const Job::Stage edges(job, "reading the mesh", 0.0, 0.5);
    return detail::find_topology(vertices_.size(), triangles_, threads, job);
  }();
  if (!topology.defect.empty()) throw InvalidInput(topology.defect + kHint);
  report_.cell = cell;
  complete(std::move(topology), std::move(repairs), threads, job);
}

Mesh::Mesh(detail::MeshArrays arrays, detail::Topology topology, RepairReport repairs, const Threads& threads, Job& job)
    : vertices_(std::move(arrays.vertices)),
      triangles_(std::move(arrays.triangles)),
      source_face_(std::move(arrays.source_face)),
      source_vertex_(std::move(arrays.source_vertex)) {
  report_.cell = arrays.cell;
  complete(std::move(topology), std::move(repairs), threads, job);
}

void Mesh::complete(detail::Topology topology, RepairReport repairs, const Threads& threads, Job& job) {
  if (source_face_.empty()) detail::number_all(threads, source_face_, triangles_.size(), job);
  if (source_vertex_.empty()) detail::number_all(threads, source_vertex_, vertices_.size(), job);
  opposite_ = std::move(topology.opposite);
  vertex_halfedge_ = std::move(topology.vertex_halfedge);
  find_components(topology.border, threads, job);
  count_border_loops(topology.border);
  job.report(0.6);
  Box box = detail::box_of(vertices_, threads, job, [&](std::size_t v) { return vertex_halfedge_[v] != kNone; });
  report_.diagonal = box.diagonal().norm();
  origin_ = shift_to_zero(box);
  if (!origin_.isZero(0)) {
    for (Vec3& v : vertices_) v -= origin_;
    box.translate(-origin_);
  }
  {
    const Job::Stage faces(job, job.stage(), 0.6, 1.0);
    graph_ = make_face_graph(vertices_, triangles_, opposite_, box, threads, job);
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
  report_.zero_area_faces = detail::count_of(threads, triangles_.size(), job,
                                             [&](std::size_t f) { return graph_.faces[f].area == 0.0F ? 1 : 0; });
}

/// Uses vertices: connected faces share vertices, and there are only half as many vertices as faces.
void Mesh::find_components(std::span<const std::int32_t> border, const Threads& threads, Job& job) {
  const VertexSets sets(vertices_.size(), triangles_, threads, job);
  component_.resize(triangles_.size());
  for_each_index(threads, triangles_.size(), job, [&](std::size_t f) { component_[f] = sets.find(triangles_[f][0]); });
  std::vector<std::int32_t> number(vertices_.size(), kNone);  // number of the component, at its lowest vertex
  for_each_index(triangles_.size(), job, [&](std::size_t f) {
    std::int32_t& id = number[component_[f]];
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
