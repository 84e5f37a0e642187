// The options of polygonize.
#pragma once

#include <cstdint>
#include <optional>
#include <tuple>

#include "isimp/core/options.h"

namespace isimp {

/// The options of `polygonize`. The table `fields` below describes each of them.
struct MeshingOptions {
  double chord_tolerance = 0.35;
  double chord_area = 0.53;
  double join_junctions = 0.8;
  double reach = 0.02;
  std::optional<double> straight_rims = std::nullopt;
  std::int32_t flatten = 15;
  std::int32_t flatness_from = 100;
  double flatness = 0.005;
  double repair_budget = 4;
  bool planar = false;
  double planar_reach = 0.005;
  double planar_most = 1;
  bool convex = false;
  std::int32_t threads = 0;
};

constexpr auto fields(const MeshingOptions*) {
  using O = MeshingOptions;
  return std::tuple{
      field("chord_tolerance", &O::chord_tolerance, between(0, 100), Unit::none,
            "Distance between a boundary and its chord at which the boundary gets another corner, as a share of "
            "sqrt(area / regions). Larger where the two regions are nearly coplanar.")
          .shown("Corner Tolerance",
                 "Distance of a border from a straight line at which it gets another corner, as a share of a region's "
                 "size. A smaller value follows the scan more closely, with more corners",
                 {.low = 0.01, .high = 2}),
      field("chord_area", &O::chord_area, between(0, 100), Unit::none,
            "Largest share of a region's area that its chords may add or leave out, so that small regions keep "
            "their shape. Larger where the two regions are nearly coplanar."),
      field("join_junctions", &O::join_junctions, between(0, 100), Unit::none,
            "Largest distance of two vertices where three regions meet that become one vertex, as a share of "
            "sqrt(area / regions), if the polygons round them get better by it. 0: none do.")
          .shown("Join Junctions",
                 "Largest distance at which two vertices of three polygons become one vertex of four, as a share of a "
                 "region's size, where that gives better polygons. 0: none",
                 {.high = 2}),
      field("reach", &O::reach, between(0, 1), Unit::none,
            "Largest distance of a corner from its vertex of the scan, as a share of the diagonal. Corners among cells "
            "of round parts may be further off, and with planar all corners by their moves (planar_reach)."),
      field("straight_rims", &O::straight_rims, at_least(0), Unit::length,
            "How far a straight rim may leave the ragged border of an open scan, in scene units. None: twice the "
            "raggedness, where that is more than a mean edge of the border. 0: rims follow the border.")
          .shown("Straight Rims",
                 "How far straight rims may leave the ragged border of an open scan, in the scan's units. 0: rims "
                 "follow the border. Below 0: twice the raggedness, where the border is ragged",
                 {.high = 1}),
      field("flatten", &O::flatten, between(0, 10000), Unit::none,
            "Rounds of fitting planes and moving corners. 0: corners stay at vertices of the scan.")
          .shown("Flatten",
                 "Rounds of moving corners to bring polygons near the scan and make them planar. 0: corners "
                 "stay at vertices of the scan",
                 {.high = 200}),
      field("flatness_from", &O::flatness_from, any(), Unit::none,
            "Number of regions from which the limit is flatness itself. With fewer regions it is flatness * "
            "(flatness_from / regions)^4, since these are not planar themselves."),
      field("flatness", &O::flatness, between(0, 100), Unit::none,
            "Largest distance of a corner from its polygon's plane, as a share of the diagonal; polygons beyond it "
            "are split. Where a tolerance found the number of regions, the tolerance if that is more. 0: no "
            "limit."),
      field("repair_budget", &O::repair_budget, between(0, 1000), Unit::none,
            "Largest number of splits of the repair, as a multiple of the number of polygons; a border or a handle of "
            "the "
            "scan counts as 4. Those that prove unnecessary are undone."),
      field("planar", &O::planar,
            "Make every polygon planar to a millionth of the diagonal: planes and corners are moved together, and a "
            "corner that can't be on its polygon's plane is cut off as a triangle.")
          .shown("Exactly Flat Faces",
                 "Make every polygon exactly planar. Corners that can't be on the plane of their polygon are cut off "
                 "as triangles"),
      field("planar_reach", &O::planar_reach, between(0, 1), Unit::none,
            "With planar: distance that a corner may move to be on its planes, as a share of the diagonal. Up to one "
            "and a half times as far along the scan where its edges are long, less where they are short. Up to six "
            "times as far where planes that are set or snapped are further off."),
      field("planar_most", &O::planar_most, between(0, 1), Unit::none,
            "With planar: largest share of the polygons that may be cut to be planar. If more would be, none is made "
            "planar, and the report says so (left_off).")
          .shown("Cut at Most",
                 "Largest share of the polygons that Exactly Flat Faces may cut. If more would be, polygons stay whole "
                 "and are not exactly planar, and the report says so"),
      field(
          "convex", &O::convex,
          "Cut concave polygons along diagonals into few convex ones. Corners stay where they are, and none is added. "
          "A polygon stays concave where every cut would make a defect or a second edge between two corners: the "
          "report counts them (concave).")
          .shown("Convex Faces",
                 "Cut every concave polygon along diagonals into few convex ones. Corners stay where they are, and "
                 "none is added"),
      threads_field(&O::threads),
  };
}

}  // namespace isimp
