#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"

namespace isimp {

/// The plane that a region is to have: normal * x = offset, x in the caller's coordinates.
struct HeldPlane {
  std::int32_t region = kNone;
  Vec3 normal = Vec3::UnitZ();  ///< unit, facing as the region
  double offset = 0;
};

/// The axis and radius that a round part is to have.
struct HeldRound {
  std::int32_t number = kNone;  ///< in Partition::curved
  Vec3 point = Vec3::Zero();    ///< on the axis, in the caller's coordinates
  Vec3 axis = Vec3::UnitZ();    ///< unit
  double radius = 0;            ///< for full cylinders and spheres; others, and the pipes of bends, keep theirs
};

/// Holds planes and round parts where a caller has computed them, as if `regularise` had snapped them there. Cells follow
/// their round part, and parts of one axis move together.
///
/// \return the partition with region_normal, region_offset and region_held set; the bound is 0, as after an edit
/// \throws InvalidInput  the partition is not one of this mesh; a number out of its range; a plane that is not finite; a
///                       region that was left out or is a cell of a round part; a radius not above 0
/// \throws Cancelled     nothing was made
/// Cost: O(F + R^2).
Partition hold_planes(const Mesh& mesh, const Partition& partition, std::span<const HeldPlane> planes,
                      std::span<const HeldRound> round, Job& job);

}  // namespace isimp
