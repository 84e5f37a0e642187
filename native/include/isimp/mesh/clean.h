#pragma once

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/options.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// How to repair a mesh. The table `fields` below describes each field.
struct CleanOptions {
  double weld = 0.0;
  double fill_holes = 0.0;
  double fill_flat_holes = 0.0;
  double cut_handles = 0.0;
  std::optional<double> stitch = std::nullopt;
  std::optional<double> grid = std::nullopt;
  bool outside_only = false;
  std::int32_t threads = 0;
};

constexpr auto fields(const CleanOptions*) {
  using O = CleanOptions;
  return std::tuple{
      field("weld", &O::weld, at_least(0), Unit::length,
            "Largest distance at which two border vertices may become one, in scene units. 0: only equal positions."),
      field("fill_holes", &O::fill_holes, at_least_or_infinite(0), Unit::length,
            "Largest length of a border that is closed, in scene units. 0: none."),
      field("fill_flat_holes", &O::fill_flat_holes, at_least_or_infinite(0), Unit::length,
            "Largest length of a border that is closed where the faces beside the hole are in its plane, as a wall is "
            "around what hides it, in scene units. 0: none."),
      field("cut_handles", &O::cut_handles, at_least_or_infinite(0), Unit::length,
            "Largest length of a loop around a handle or tunnel that is removed, in scene units. 0: none."),
      field("stitch", &O::stitch, at_least(0), Unit::length,
            "Largest distance at which the borders of two chunks of a scan become one although their vertices do not "
            "match, in scene units. None: two mean edges, where a tenth of the border has another border that near. 0: "
            "borders stay apart.")
          .shown("Stitch",
                 "Largest gap between borders of chunks of a scan that become one, in the scan's units. 0: none do. "
                 "Below 0: two mean edges, where a tenth of the border has another border that near",
                 {.high = 1}),
      field(
          "grid", &O::grid, at_least(0), Unit::length,
          "Cell of the grid of occupied and empty cells that the mesh was cut on: its stair steps are smoothed within "
          "half a cell, in scene units. None: found, where the mesh is such a grid's. 0: steps stay.")
          .shown("Grid Cell",
                 "Cell of the grid of occupied cells that the mesh was cut on, whose steps are smoothed, in the scan's "
                 "units. 0: steps stay. Below 0: it is found",
                 {.high = 1}),
      field("outside_only", &O::outside_only,
            "Whether components inside a closed one, which nobody sees from outside, are removed, such as the inner "
            "walls of generated meshes.")
          .shown("Outside Only", "Parts inside a closed part, such as inner walls of generated meshes, are removed"),
      threads_field(&O::threads),
  };
}

/// Repairs any triangles into a manifold, oriented mesh: output of scanners, STL files, texture seams.
///
/// The repairs in their order. `report().repairs` has the count and first places of each under this key, zeros too:
///  - `non_finite_faces`      dropped: a coordinate is not finite, or beyond 1e30, where areas would overflow
///  - `repeated_index_faces`  dropped: a vertex is used twice, in the input or after welding
///  - `duplicate_faces`       dropped: the same three vertices as an earlier face, in either orientation
///  - `welded_vertices`       border vertices at the same position become one. Vertices inside a surface are never
///                            welded, so closed components that touch stay separate
///  - `flipped_faces`         orientation reversed, so that each component is consistent; the smaller area yields
///  - `cut_edges`             cut open: no orientation fits both sides (a Moebius strip)
///  - `split_edges`           non-manifold edges (three or more faces) split: neighbouring faces that bound the same
///                            wedge of a solid stay joined, so that solids that touch separate
///  - `split_vertices`        vertices copied, once for each further fan of faces around them
///  - `subdivided_edges`      halved: after the repairs above two edges had the same ends
///  - `turned_edges`          edge flips: the longest edge of a degenerate face (thinner than rounding), flipped
///                            so that it and its neighbour have an area each
///  - `unused_vertices`       dropped: no kept face uses them
///  - `inner_faces`           dropped: their component is inside a closed one
///  - `stitched_vertices`     border vertices that became one with a vertex of another border, or were put into its edge
///  - `smoothed_vertices`     moved within half a cell of the grid that the mesh was cut on
///  - `filled_holes`          covered by new faces, which intersect nothing where there are such. A hole stays open if
///                            its cover is more than half of its component (then it is the outline, not a hole)
///  - `cut_handles`           handles whose ring of faces was removed and whose two ends were covered
/// `where` holds the caller's vertices for the keys that end in `vertices`, else the caller's faces.
/// Zero-area faces that no edge flip mends (at a border, for example) are kept, since dropping them would open holes;
/// `report().zero_area_faces` counts them. Faces and vertices keep the caller's order; copies of vertices and covers
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
