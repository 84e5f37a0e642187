#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh_report.h"
#include "surface/edge_groups.h"
#include "surface/topology.h"

namespace isimp::detail {

/// rounding: with coordinates up to here areas, their squares and sums of them stay finite.
inline constexpr double kFarthest = 1e30;

/// The kinds of repairs, in the order of the report. Its keys are older names: "flipped_faces" for reversed_faces and
/// "turned_edges" for flipped_edges; else they are these names.
enum class RepairKind {
  non_finite_faces,
  repeated_index_faces,
  duplicate_faces,
  welded_vertices,
  reversed_faces,
  cut_edges,
  split_edges,
  split_vertices,
  subdivided_edges,
  flipped_edges,
  unused_vertices,
  inner_faces,
  stitched_vertices,
  smoothed_vertices,
  filled_holes,
  cut_handles,
};

/// Counts repairs and stores the first few places of each kind.
class RepairLog {
 public:
  RepairLog();
  /// \param before  earlier repairs; empty: none
  explicit RepairLog(const RepairReport& before);
  void add(RepairKind what, std::int32_t where);
  /// Adds another log's reversed faces, and edges that were cut and split.
  /// \param face  the caller's face of each of its faces
  void add_orientation(const RepairLog& other, const std::vector<std::int32_t>& face);
  [[nodiscard]] std::int64_t count(RepairKind what) const { return repairs_[static_cast<std::size_t>(what)].count; }
  [[nodiscard]] RepairReport take() { return std::move(repairs_); }

 private:
  RepairReport repairs_;
};

/// Triangles under repair, and their adjacency as far as it is known.
struct Soup {
  std::vector<Vec3> vertices;           ///< the vertices of the caller
  std::vector<Triangle> named;          ///< the kept faces with the caller's vertices
  std::vector<Triangle> welded;         ///< the triangles after welding; empty as long as it is equal to `named`
  Array<std::int32_t> source_face;      ///< the caller's face of each
  std::vector<std::int32_t> opposite;   ///< the half-edge that each is joined to; kNone: none
  std::vector<std::int32_t> contested;  ///< half-edges along edges that were split
  RepairLog log;

  /// The faces with their vertices after welding.
  [[nodiscard]] const std::vector<Triangle>& faces() const { return welded.empty() ? named : welded; }
  [[nodiscard]] std::int32_t from(std::int32_t h) const { return faces()[h / 3][h % 3]; }
  [[nodiscard]] std::int32_t to(std::int32_t h) const { return faces()[h / 3][(h + 1) % 3]; }
  [[nodiscard]] std::int32_t apex(std::int32_t h) const { return faces()[h / 3][(h + 2) % 3]; }
  void join(std::int32_t g, std::int32_t h) {
    opposite[g] = h;
    opposite[h] = g;
  }
  void count_face(RepairKind what, std::int32_t face) { log.add(what, source_face[face]); }
  /// Drops the faces that are marked.
  void drop(const std::vector<char>& marked);
};

// faces.cpp
/// Drops faces with a coordinate that is not finite, and faces that use a vertex twice.
/// \throws InvalidInput  if none is left
void drop_broken(Soup& soup, const Threads& threads, Job& job);
/// Drops each face with the same vertices as an earlier one. Returns whether there were any.
bool drop_duplicates(Soup& soup, const EdgeGroups& edges, Job& job);

// weld.cpp
/// Welds the given vertices that lie within the tolerance of each other; drops faces that then use a vertex twice.
/// Returns whether any vertex was welded.
/// \param border  rising
bool weld(Soup& soup, const std::vector<std::int32_t>& border, double tolerance, Job& job);
/// The vertices on borders (ends of edges with one face), rising.
std::vector<std::int32_t> border_vertices(const Soup& soup, const EdgeGroups& edges, Job& job);
/// The indices of the marks that are set.
std::vector<std::int32_t> marked_indices(const std::vector<char>& marks);

// join.cpp
/// Half-edges whose orientation or neighbour is still to be decided.
struct Undecided {
  std::vector<std::int32_t> same_way;                   ///< one of each joined pair with opposite face orientations
  std::vector<std::vector<std::int32_t>> non_manifold;  ///< half-edges along edges of three or more faces
};
/// Joins the half-edges of edges with two faces, independent of the orientation of the faces.
Undecided join_simple_edges(Soup& soup, const EdgeGroups& edges, Job& job);
/// At each non-manifold edge, joins the half-edges of the two faces that bound the same wedge of a solid. The others
/// become borders.
/// \param reversed  (F) the faces whose orientation will be reversed, or empty
void join_non_manifold_edges(Soup& soup, const std::vector<std::vector<std::int32_t>>& non_manifold,
                             const std::vector<char>& reversed);

// orient.cpp
/// Chooses the faces to reverse so that all components are consistently oriented, and cuts the edges where that is
/// impossible. Returns (F) marks, empty if no face is to be reversed.
std::vector<char> orient(Soup& soup, const std::vector<std::int32_t>& same_way, Job& job);
/// Reverses the orientation of the marked faces.
void reverse_faces(Soup& soup, const std::vector<char>& marked);

/// The arrays that a mesh is made of.
struct MeshArrays {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  Array<std::int32_t> source_face, source_vertex;
  double cell = 0.0;  ///< see MeshReport
};

// separate.cpp
/// Makes a vertex of its own for every fan of faces, and halves edges with the same ends as another. Leaves
/// the soup empty.
MeshArrays separate(Soup& soup, Job& job);

// manifold_fast_path.cpp
/// Whether two faces have the same three vertices: in a manifold mesh they then share all their edges.
bool has_twins(const Topology& topology, const Threads& threads);
/// The vertices on borders (ends of edges with one face), rising.
std::vector<std::int32_t> border_vertices(const Soup& soup, const Topology& topology);
/// Drops the vertices that no face uses, from the topology too. Moves out of the soup.
MeshArrays compact(Soup& soup, Topology& topology, const Threads& threads, Job& job);

// flip_degenerate_edges.cpp
/// Flips the longest edge of each zero-area face where that gives it and its neighbour an area. The mesh is manifold
/// before and after.
void flip_degenerate_edges(MeshArrays& arrays, Topology& topology, RepairLog& log, const Threads& threads, Job& job);

}  // namespace isimp::detail
