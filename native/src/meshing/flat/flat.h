#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

/// The steps of `merge_flat`.
namespace isimp::meshing::flat {

/// rounding: distances below this share of the mesh's diagonal count as none.
inline constexpr double kSame = 1e-6;

using Loop = std::vector<std::int32_t>;  ///< vertices in order

struct Plane {
  Vec3 normal = Vec3::Zero();  ///< unit; zero where the faces have no area
  Vec3 centre = Vec3::Zero();
};

struct Regions {
  std::vector<std::int32_t> label;      ///< (F) numbered by first face
  std::vector<Plane> plane;             ///< (R)
  std::vector<std::int32_t> start, of;  ///< the faces of region r are of[start[r]] ... of[start[r + 1] - 1], rising
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(plane.size()); }
  [[nodiscard]] std::span<const std::int32_t> faces(std::int32_t r) const {
    return std::span(of).subspan(start[r], start[r + 1] - start[r]);
  }
};

/// Connected faces of one plane, grown from the largest faces. See `merge_flat`.
Regions find_regions(const Mesh& mesh, double angle, std::span<const std::int32_t> group, const Job& job);

/// (R) the boundary loops of each region, with the region on the left: its outline, and its holes.
std::vector<std::vector<Loop>> find_loops(const Mesh& mesh, const Regions& regions);

/// Marks the vertices that are corners: where three regions meet, where one ends at the mesh's border, where a border
/// bends, and all vertices of regions that are kept unchanged. The result is the same from both sides of a border.
void mark_corners(const Mesh& mesh, const Regions& regions, const std::vector<std::vector<Loop>>& loops,
                  std::span<const char> as_it_is, std::vector<char>& is_corner);

/// The region as few simple polygons without holes, from its loops without all vertices that are no corners.
/// Empty where that is not possible: a loop has fewer than three corners, or loops cross.
std::vector<Loop> cut(const Mesh& mesh, const Plane& plane, std::vector<Loop> loops);

/// Merges polygons along edges that they share, the longest first, as long as they stay discs.
std::vector<Loop> joined(const Mesh& mesh, std::vector<Loop> polygons);

}  // namespace isimp::meshing::flat
