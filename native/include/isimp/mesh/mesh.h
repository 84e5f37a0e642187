#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/mesh/mesh_report.h"

namespace isimp {

namespace detail {
struct Cleaning;
struct MeshArrays;
struct Topology;
}  // namespace detail

/// An oriented triangle surface, checked once and never changed: the input of all other modules.
///
/// Holds by construction: every edge has one or two faces, two faces of an edge run along it in opposite directions,
/// the faces at a vertex form one fan, no face names a vertex twice, all coordinates are finite. Borders, several
/// components, handles, zero-area faces and unused vertices are ordinary. `clean` makes such a mesh from any arrays.
///
/// Coordinates are relative to `origin`: a mesh that lies far from zero, as in map coordinates, is shifted to zero on
/// the way in, without rounding. Coordinates that leave the engine are shifted back.
///
/// Half-edge h = 3 * f + k runs along face f from its corner k to its corner k + 1 (mod 3).
/// Memory: about 80 bytes a face.
class Mesh {
 public:
  /// Checks the arrays and computes adjacency, components and the face graph.
  ///
  /// \throws InvalidInput  no faces; an index out of range; a coordinate that is not finite; a face that names a vertex
  ///                       twice; an edge with three or more faces or with two that run the same way; a vertex whose
  ///                       faces form two fans. The message names the first offender and points to `clean`.
  /// \throws Cancelled     nothing was made
  /// \param threads        0: as many as there are cores; the result does not depend on it
  /// Cost: O(V + F) time and memory.
  Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, Job& job, std::int32_t threads = 0);

  /// As above, for a mesh made from another one: the sources of its faces and vertices, the repairs, and
  /// MeshReport::cell.
  Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, Array<std::int32_t> source_face,
       Array<std::int32_t> source_vertex, RepairReport repairs, double cell, const Threads& threads, Job& job);

  [[nodiscard]] std::int32_t vertex_count() const { return static_cast<std::int32_t>(vertices_.size()); }
  [[nodiscard]] std::int32_t face_count() const { return static_cast<std::int32_t>(triangles_.size()); }
  /// (V) relative to `origin`.
  [[nodiscard]] std::span<const Vec3> vertices() const { return vertices_; }
  /// The offset that was subtracted from the caller's coordinates. Along an axis it is 0 where the box's middle is less
  /// than two diagonals from 0; elsewhere the middle, rounded to a power of two of about a quarter of the diagonal.
  [[nodiscard]] const Vec3& origin() const { return origin_; }
  [[nodiscard]] std::span<const Triangle> triangles() const { return triangles_; }
  /// (F) the caller's face of each face; the identity if the mesh was not cleaned.
  [[nodiscard]] std::span<const std::int32_t> source_face() const { return source_face_; }
  /// (V) the caller's vertex of each vertex; kNone for one that a repair made.
  [[nodiscard]] std::span<const std::int32_t> source_vertex() const { return source_vertex_; }

  /// (3 F) the half-edge on the other side of each; kNone on a border.
  [[nodiscard]] std::span<const std::int32_t> opposite() const { return opposite_; }
  /// (V) a half-edge that leaves each vertex; the one on the border if there is one; kNone if the vertex is unused.
  /// `next_outgoing`, repeated from there, visits all faces of the vertex.
  [[nodiscard]] std::span<const std::int32_t> vertex_halfedge() const { return vertex_halfedge_; }
  /// (F) the component of each face, numbered by first face.
  [[nodiscard]] std::span<const std::int32_t> component() const { return component_; }
  [[nodiscard]] std::int32_t component_count() const { return report_.components; }

  /// The faces in the form for partitioning: Morton order, normals, areas, neighbours.
  [[nodiscard]] const FaceGraph& graph() const { return graph_; }
  [[nodiscard]] const MeshReport& report() const { return report_; }
  /// Length of the bounding box's diagonal.
  [[nodiscard]] double diagonal() const { return report_.diagonal; }

  static std::int32_t next(std::int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static std::int32_t prev(std::int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
  static std::int32_t face(std::int32_t h) { return h / 3; }
  [[nodiscard]] std::int32_t from(std::int32_t h) const {
    return triangles_[static_cast<std::size_t>(h / 3)][static_cast<std::size_t>(h % 3)];
  }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return from(next(h)); }
  [[nodiscard]] std::int32_t opposite(std::int32_t h) const { return opposite_[static_cast<std::size_t>(h)]; }
  /// The next half-edge that leaves the same vertex, counter-clockwise; kNone past the last one before a border.
  [[nodiscard]] std::int32_t next_outgoing(std::int32_t h) const { return opposite(prev(h)); }

 private:
  friend struct detail::Cleaning;
  /// From arrays that were found sound.
  Mesh(detail::MeshArrays arrays, detail::Topology topology, RepairReport repairs, const Threads& threads, Job& job);

  void complete(detail::Topology topology, RepairReport repairs, const Threads& threads, Job& job);
  void find_components(std::span<const std::int32_t> border, const Threads& threads, Job& job);
  void count_border_loops(std::span<const std::int32_t> border);

  std::vector<Vec3> vertices_;
  Vec3 origin_ = Vec3::Zero();
  std::vector<Triangle> triangles_;
  Array<std::int32_t> source_face_, source_vertex_;
  Array<std::int32_t> opposite_, vertex_halfedge_, component_;
  FaceGraph graph_;
  MeshReport report_;
};

/// Calls fn(h) for each half-edge that leaves v, counter-clockwise, a border one first.
template <class Function>
void for_each_leaving(const Mesh& mesh, std::int32_t v, Function fn) {
  const std::int32_t start = mesh.vertex_halfedge()[v];
  for (std::int32_t h = start; h != kNone;) {
    fn(h);
    h = mesh.next_outgoing(h);
    if (h == start) break;
  }
}

}  // namespace isimp
