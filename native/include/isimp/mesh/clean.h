#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/options.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// How to repair a mesh. What each field means stands in `fields` below.
struct CleanOptions {
  double weld = 0.0;
  double fill_holes = 0.0;
  double cut_handles = 0.0;
  std::int32_t threads = 0;
};

constexpr auto fields(const CleanOptions*) {
  using O = CleanOptions;
  return std::tuple{
      field("weld", &O::weld, at_least(0), Unit::length,
            "Largest distance at which two border vertices may become one, in scene units. 0: only equal positions."),
      field("fill_holes", &O::fill_holes, at_least_or_infinite(0), Unit::length,
            "Largest length of a border that is closed, in scene units. 0: none."),
      field("cut_handles", &O::cut_handles, at_least_or_infinite(0), Unit::length,
            "Largest length of a loop round a handle or tunnel that is removed, in scene units. 0: none."),
      threads_field(&O::threads),
  };
}

/// Makes a sound mesh of any triangles: what scanners, STL files and texture seams leave behind.
///
/// In this order, each counted and located in `report().repairs` under the key named here, zero counts included:
///  - `non_finite_faces`      dropped: a corner is not finite (or beyond 1e30, where areas would overflow)
///  - `repeated_index_faces`  dropped: a vertex named twice, by the caller or after welding
///  - `duplicate_faces`       dropped: the same three vertices as an earlier face, in either orientation
///  - `welded_vertices`       border vertices at one place become one where that closes an edge; vertices inside a
///                            surface are never welded, so that closed parts that touch stay apart
///  - `flipped_faces`         turned over, so that each component is oriented one way; the fewer by area
///  - `cut_edges`             opened, since no orientation fits both sides (a Moebius strip)
///  - `split_edges`           edges of three or more faces, taken apart: neighbouring faces that bound the same
///                            solid wedge stay together, so that solids that touch fall apart
///  - `split_vertices`        copies of vertices that were made for each further fan of faces
///  - `subdivided_edges`      halved, since two edges with the same ends remained after the above
///  - `turned_edges`          the longest edge of a face thinner than rounding, turned so that it and the
///                            face beside it have an area each
///  - `unused_vertices`       dropped: no kept face uses them
///  - `filled_holes`          covered by new faces; one stays open where every cover tried would meet the surface, or
///                            would be more than half of its part (it is the outline then, not a hole)
///  - `cut_handles`           handles whose ring of faces was taken out, both ends being covered
/// `where` holds the caller's vertices for the keys that end in `vertices`, else the caller's faces.
/// Faces without area that no turn helps (along a border, say) are kept, since dropping them would tear holes; they are
/// counted in `report().zero_area_faces`. Faces and vertices keep the caller's order; copies of vertices and covers
/// come last, the latter with kNone for their source.
///
/// \param vertices   (V) anything
/// \param triangles  (F) indices in [0, V)
/// \throws InvalidInput  no faces, an index out of range (named), a length negative or not a number, or no face is left
/// \throws Cancelled     nothing was made
/// Cost: O(V + F) time and memory for edges of few faces; about half of `Mesh(...)` more on a sound mesh.
///       Closing holes or handles adds O((V + F) log F).
Mesh clean(std::vector<Vec3> vertices, std::vector<Triangle> triangles, const CleanOptions& options, Job& job);

}  // namespace isimp
