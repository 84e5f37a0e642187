#pragma once

#include <array>
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
};

constexpr auto fields(const RegulariseOptions*) {
  using O = RegulariseOptions;
  return std::tuple{
      field("angle", &O::angle, between(0, 45), Unit::none,
            "Largest angle by which a plane is turned, degrees; three times as much where a region is so small that it "
            "hardly moves. Without a length, planes whose noise does not explain it are turned by at most ten times as "
            "much as half of the area, and a degree.")
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
             "The axis that is up; machine parts that lie askew have their own. none: planes are made parallel only."),
  };
}

/// The fields of earlier versions.
constexpr auto gone_fields(const RegulariseOptions*) {
  return std::array{Gone{"even_spacing", false}, Gone{"merge_islands", 0.0}};
}

/// Snaps the planes of regions: level, upright with right angles between them, equal slopes, parallel, coplanar. Large
/// regions lead; then the planes of a group are fitted to all of its regions by least squares. Each snap is made only
/// if the scan stays within `length` of the plane. A bound of the partition holds for the new planes too: planes that
/// would leave it are released. Labels do not change. Axes of round parts are snapped like planes,
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
