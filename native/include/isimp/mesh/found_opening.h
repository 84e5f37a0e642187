#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/mesh/clean.h"

namespace isimp {

/// A hole or a handle that was short enough to close. Coordinates are the caller's, lengths in scene units.
struct FoundOpening {
  bool handle = false;  ///< else a hole
  bool kept = false;    ///< it stayed open at the caller's wish; else it was closed
  Vec3 center = Vec3::Zero();
  double length = 0;                     ///< length of the border of a hole, or of the loop around a handle or tunnel
  std::vector<std::vector<Vec3>> loops;  ///< closed polylines: the border of a hole, or both ends of the cut
};

/// A repaired mesh and the openings that were short enough to close.
struct Cleaned {
  Mesh mesh;
  std::vector<FoundOpening> openings;  ///< holes, then handles; openings that could not be closed are not listed
};

/// As `clean`, but openings at some places stay open. Places, unlike indices, are the same after another repair.
///
/// \param keep  places, such as FoundOpening::center. An opening stays if one of them lies within a quarter of its
///              length of its center; for a handle, of the line between the centers of its two ends
/// \throws InvalidInput  as `clean`; a place is not finite
Cleaned clean_keeping(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options,
                      const std::vector<Vec3>& keep, Job& job);

/// Closes openings of a sound mesh. The result is the one of `clean_keeping` on the arrays that the mesh was made from,
/// and its report covers both, but the other repairs are not repeated.
///
/// \param options  `fill_holes`, `fill_flat_holes`, `cut_handles` and `threads` count
/// \param aside    (F) 1 for faces of whole components that stay as they are, and that the result for the others does
///                 not depend on; their faces and vertices come last. Empty: none
/// \throws InvalidInput  a length is negative or not a number; a place is not finite
/// Cost: O((V + F) log F).
Cleaned close_openings(const Mesh& mesh, const CleanOptions& options, const std::vector<Vec3>& keep, Job& job,
                       std::span<const std::uint8_t> aside = {});

}  // namespace isimp
