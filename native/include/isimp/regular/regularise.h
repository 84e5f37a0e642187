#pragma once

#include <cstdint>
#include <optional>
#include <tuple>

#include "isimp/core/job.h"
#include "isimp/core/options.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// The upward axis of the scene.
enum class Up : std::uint8_t { x, y, z, none };

/// How the planes of regions are snapped. The table `fields` below describes each field.
struct RegulariseOptions {
  double angle = 8;
  std::optional<double> length;
  Up up = Up::z;
  bool even_spacing = false;
  double merge_islands = 0;
};

constexpr auto fields(const RegulariseOptions*) {
  using O = RegulariseOptions;
  return std::tuple{
      field("angle", &O::angle, between(0, 45), Unit::none,
            "Largest angle by which a plane is turned, degrees; three times as much where a region is so small that it "
            "hardly moves.")
          .shown("Angle", "Largest angle by which a plane is turned, in degrees"),
      field(
          "length", &O::length, above(0), Unit::length,
          "What turning or moving a plane may add to the distance of its region, root mean square. None: 1.2 times "
          "the median of that distance, and more for regions of few faces, so it follows the scan's noise; the planes "
          "that add most are released until all together add at most 10 % to that distance of the scan.")
          .shown("Allowed",
                 "What snapping may add to the distance of a region from its plane. 0: it follows from the noise of "
                 "the scan, and all planes together add a tenth at most",
                 {.high = 1}),
      choice("up", &O::up, {{"x", Up::x}, {"y", Up::y}, {"z", Up::z}, {"none", Up::none}},
             "The axis that is up, for level and upright planes; none: planes are made parallel only."),
      field("even_spacing", &O::even_spacing,
            "Also make distances of parallel planes equal, as of storeys, stairs and rows of windows, and equal the "
            "sizes that three or more pairs of them have in common, as windows have their widths. No plane moves "
            "further than the length allows.")
          .shown("Even Spacing",
                 "Make distances of parallel planes equal: of storeys, steps and rows of windows, and the widths that "
                 "three or more windows have in common"),
      field("merge_islands", &O::merge_islands, at_least(0), Unit::length,
            "Largest depth of a rim behind which islands become part of their wall: window panes that are coplanar "
            "with the wall around them, which then is one polygon. No part of an island or its rim may be further from "
            "the wall's plane. 0: none do.")
          .shown("Merge Islands",
                 "Window panes that are coplanar with the wall round them become part of it, with rims up to this "
                 "depth. 0: none do",
                 {.high = 1}),
  };
}

/// Snaps the planes of regions: level, upright with right angles between them, equal slopes, parallel, coplanar. Large
/// regions lead; then the planes of a group are fitted to all of its regions by least squares. Each snap is made only
/// if the scan stays within `length` of the plane. On request distances of parallel planes are made equal, and islands
/// that are coplanar with the wall around them become part of it; only then labels change. A bound of the partition
/// holds for the new planes too: planes that would leave it are released. Axes of round parts are snapped like planes,
/// within the same limits: parallel ones that are nearly one line become one, and nearly equal radii equal; the cells
/// follow. `polygonize` uses the planes. Planes that `align_planes` has set do not change, and others are snapped to
/// them first.
///
/// \param up_direction  the upward direction, in place of options.up
/// \return the partition with region_normal, region_offset, region_held and regularity set
/// \throws InvalidInput  the partition is not one of this mesh; an option out of its range; up_direction has no direction
/// \throws Cancelled     nothing was made
/// Source: the order of snaps as in Verdie, Lafarge, Alliez 2015; the gate by length is our own.
/// Cost: O(F + R^2).
Partition regularise(const Mesh& mesh, const Partition& partition, const RegulariseOptions& options, Job& job,
                     const std::optional<Vec3>& up_direction = {});

}  // namespace isimp
