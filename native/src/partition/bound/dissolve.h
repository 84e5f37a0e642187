#pragma once

#include <array>
#include <span>
#include <vector>

#include "bound/bound.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/surface.h"

namespace isimp::detail {

// tuned bound
/// Cosine: a face whose normal is further from its region's is behind the plane, not next to it.
inline constexpr double kLeastCosine = 0.2;

/// The corners of a surface's faces, by graph index; vertices numbered in the order of the faces, so that neighbours on
/// the surface are near in memory.
class Corners {
 public:
  Corners(const Surface& surface, Job& job);

  void add_to(Slab& slab, std::int32_t face) const {
    for (const std::int32_t v : corner_[face]) slab.add(vertex_[v]);
  }
  [[nodiscard]] const Vec3& vertex(std::int32_t v) const { return vertex_[v]; }
  /// The vertices of each region, by number here; hardly any of them twice.
  [[nodiscard]] std::vector<std::vector<std::int32_t>> points_of(const BoundedRegions& bounded, Job& job) const;
  /// The width of a slab with one more face in it; infinite for a face that is turned away from it.
  [[nodiscard]] double width_with(const Slab& slab, std::int32_t face) const {
    const FaceRecord& f = graph_.faces[face];
    if (f.nx * slab.normal.x() + f.ny * slab.normal.y() + f.nz * slab.normal.z() < kLeastCosine)
      return std::numeric_limits<double>::infinity();
    Slab grown = slab;
    add_to(grown, face);
    return grown.width();
  }

 private:
  const FaceGraph& graph_;
  std::vector<Vec3> vertex_;
  std::vector<std::array<std::int32_t, 3>> corner_;
};

/// Removes regions whose faces, one by one, fit between the planes of their neighbours; smallest first.
/// \param need       (C) the least number of regions of each component.
/// \param component  (R) component of each region
/// \return whether any was removed; labels and sums are renumbered then
bool dissolve(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
              BoundedRegions& bounded, Job& job);

/// Moves faces of the smaller half of the regions to neighbours, as above, as far as possible: the rest of a region
/// merges more easily. Slabs then are wider than necessary.
void squeeze(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
             BoundedRegions& bounded, Job& job);

/// The component of each region; empty if there is one.
std::vector<std::int32_t> components_of_regions(const Surface& surface, const BoundedRegions& bounded);

}  // namespace isimp::detail
