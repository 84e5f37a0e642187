#pragma once

#include <cstdint>
#include <vector>

#include "compass.h"
#include "isimp/partition/partition.h"
#include "region_planes.h"

namespace isimp::regular {

/// The kind of each snapped plane.
enum class Kind : std::uint8_t { free, level, upright, slope, parallel, by_hand };

/// A region with its snapped plane. The axis of a round part takes part as a plane that is square to it.
struct Region : RegionPlane {
  Kind kind = Kind::free;
  std::uint8_t chosen = 0;  ///< kPlaneByHand or kPlaneRound: its plane stays; kPlaneFree: it stays free; else 0

  [[nodiscard]] bool is_by_hand() const { return kind == Kind::by_hand; }
  [[nodiscard]] bool is_free() const { return kind == Kind::free; }
  void snap(const Vec3& to, Kind as) {
    snapped = normal.dot(to) < 0 ? Vec3(-to) : to;
    kind = as;
  }
  void release() {
    snapped = normal;
    kind = Kind::free;
  }
};

using Some = std::vector<std::int32_t>;  ///< numbers of regions, the largest first

/// The limits of snaps.
struct Limits {
  double angle = 0;   ///< radians
  double usual = 0;   ///< radians; a plane that is turned further may be so on purpose
  double length = 0;  ///< largest increase of the root mean square distance of a region, scene units
  double hardly = 0;  ///< increase that is none, by any angle up to kWider times `angle`, scene units
  double unsure = 0;  ///< uncertainty of the plane of a region by noise, times sqrt(faces / 3)

  /// The increase that noise explains: the fewer faces, the larger.
  [[nodiscard]] double by_noise(const RegionPlane& region) const;
  /// The length for one region.
  [[nodiscard]] double reach(const RegionPlane& region) const;
  /// Whether the plane of a region may be turned to a normal.
  [[nodiscard]] bool allow(const RegionPlane& region, const Vec3& normal) const;
};

// tuned regular
constexpr double kWider = 3;  ///< times the angle: allowed to regions that it hardly moves

/// The upward direction, or the own one of a part that stands askew in the scene: its planes are parallel and square to
/// that of a large region, and not to `up`.
/// \param up  of length 1, or zero: there is none
/// Cost: O(R).
Vec3 up_or_own(const std::vector<Region>& regions, const Some& all, const Limits& limits, const Vec3& up);

/// Snaps the normals of regions: level, upright with right angles between them, equal slopes along the upright ones,
/// parallel. Regions whose planes were set by hand lead, then the large ones; the normal of a group is fitted to all of
/// its regions.
/// \param all  regions that take part, the largest first
/// Cost: O(R^2).
void snap_directions(std::vector<Region>& regions, const Some& all, const Limits& limits, const Compass& compass,
                     const Job& job);

}  // namespace isimp::regular
