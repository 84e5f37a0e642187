#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/clean.h"
#include "soup.h"
#include "topology.h"

namespace isimp::detail {

/// Triangles that cover a loop. Their vertices are those of the loop, by position in it, then `inner`.
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
  std::vector<Patch> patches;                    ///< one a loop, once found
};

// patch.cpp
constexpr int kPlans = 2;  ///< ways to cover a loop
/// Covers a loop without new vertices where `plan` is 0, with one in the middle where it is 1; empty if that can't be.
/// \param beyond  a point of the face on the other side of each edge of the loop, from place i to i + 1
/// Source: Liepa 2003 (the triangulation of least dihedral angles, then least area), by CGAL.
Patch cover(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond, int plan);

// crossings.cpp
/// For each of the last `fresh` triangles whether it intersects a kept one outside what they share.
/// \param removed  (F) marks of triangles to ignore
std::vector<char> find_crossed(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               const std::vector<char>& removed, std::size_t fresh, Job& job);

// close.cpp
/// The length of a closed loop of vertices.
double length(const MeshArrays& arrays, const std::vector<std::int32_t>& loop);

// handles.cpp
/// Handles with a loop round them or through them of at most `longest`, no two of them near each other.
std::vector<Opening> find_handles(const MeshArrays& arrays, const Topology& topology, double longest, Job& job);

// close.cpp
/// Fills holes and cuts handles as the options say. `parts` is sound before and after.
void close_small(MeshArrays& arrays, const CleanOptions& options, RepairLog& log, const Threads& threads, Job& job);

}  // namespace isimp::detail
