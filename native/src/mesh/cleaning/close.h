// Closes holes and handles of a mesh.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/found_opening.h"
#include "surface/soup.h"
#include "surface/topology.h"

namespace isimp::detail {

/// Triangles that cover a loop. Their vertices are the loop's, by position in it, then `inner`.
struct Patch {
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<Vec3> inner;  ///< its own vertices
  [[nodiscard]] bool empty() const { return triangles.empty(); }
};

/// A hole or handle to close: faces to remove, and the loops to cover then.
struct Opening {
  RepairKind kind = RepairKind::filled_holes;
  std::vector<std::int32_t> removed;             ///< faces, rising
  std::vector<std::vector<std::int32_t>> loops;  ///< vertices in the order in which a patch runs along them
  std::vector<Patch> patches;                    ///< one for each loop; empty until patches are searched
  double length = 0;                             ///< length of a hole's border, or of a handle's loop
  std::vector<std::int32_t> round;               ///< vertices of a handle's loop
};

// close.cpp
/// Some numbers in rising order, each once.
std::vector<std::int32_t> rising(std::vector<std::int32_t> numbers);

// patch.cpp
constexpr int kPlans = 2;  ///< unit: ways to cover a loop
/// Covers a loop, inside its box, without new vertices where `plan` is 0, with one in the middle where it is 1; empty if that can't be.
/// \param beyond  a point of the face on the other side of each edge of the loop, from place i to i + 1
/// Source: Liepa 2003 (the triangulation of least dihedral angles, then least area), by CGAL.
Patch cover(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond, int plan);

// crossings.cpp
/// The faces whose boxes touch one of some boxes, rising.
/// \param among  faces to search; null: all
/// Cost: O(these).
std::vector<std::int32_t> find_near(const MeshArrays& arrays, const std::vector<std::int32_t>* among,
                                    const std::vector<Eigen::AlignedBox3d>& boxes, const Threads& threads, Job& job);
/// For each of the last `fresh` triangles whether it intersects one of some others, outside common vertices and edges.
/// \param others  triangles, may be some of the last ones too
/// \param removed  (F) marks of triangles to ignore
std::vector<char> find_crossed(const MeshArrays& arrays, const std::vector<std::int32_t>& others,
                               const std::vector<char>& removed, std::size_t fresh, Job& job);

// close.cpp
/// The length of a closed loop of vertices.
double length(const MeshArrays& arrays, const std::vector<std::int32_t>& loop);

// kept_openings.cpp
/// The description of an opening that `clean_keeping` returns.
FoundOpening found_opening(const MeshArrays& arrays, const Opening& opening, bool kept);
/// Whether one of the places means the opening; see clean_keeping.
bool is_kept(const MeshArrays& arrays, const Opening& opening, const std::vector<Vec3>& keep);

// handles.cpp
/// Handles that were closed and handles that were to stay.
struct Handles {
  std::vector<Opening> closed, kept;
  std::vector<std::vector<std::int32_t>> loops;   ///< vertices of all loops that were found, those left alone too
  std::vector<std::vector<std::int32_t>> failed;  ///< vertices of loops that can't be closed
};
/// Where to search, once it is known.
struct HandleSearch {
  std::vector<std::int32_t> near;              ///< vertices near which handles may be
  std::set<std::vector<std::int32_t>> failed;  ///< loops to leave alone, each as rising vertices
};
/// Closes handles that have a loop of at most `longest`; no two of these handles are near each other. If one loop of a
/// handle can't be closed, the next one is tried; in the last try patches may meet other faces.
/// \param search  null: everywhere
/// \param keep  places whose handles are not closed
/// \param close  closes openings, with patches that meet other faces if its second argument is true, and returns the
///               closed ones
/// Cost: that of `find_loops`, and of the patches.
Handles close_handles(const MeshArrays& arrays, const Topology& topology, double longest, const HandleSearch* search,
                      const std::vector<Vec3>& keep,
                      const std::function<std::vector<Opening>(std::vector<Opening>, bool)>& close,
                      const Threads& threads, Job& job);

// close.cpp
/// Fills holes and cuts handles by the options. `arrays` are sound, and `topology` is theirs, before and after.
/// \return the openings that were closed or kept
std::vector<FoundOpening> close_small(MeshArrays& arrays, Topology& topology, const CleanOptions& options,
                                      const std::vector<Vec3>& keep, RepairLog& log, const Threads& threads, Job& job);

}  // namespace isimp::detail
