#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/types.h"

namespace isimp {

/// A plane in which a surface is its own mirror image.
struct Mirror {
  Vec3 normal = Vec3::UnitX();  ///< unit; its coordinate of the largest size is positive
  double offset = 0;            ///< the plane is normal * x = offset, in the caller's coordinates, scene units
  double mismatch_mean = 0;     ///< distance of the surface from its mirror image, mean by area, scene units
  double mismatch = 0;          ///< nine tenths of the surface are at most this far from it, scene units
  std::int32_t regions = 0;     ///< regions that mirror, including regions across the plane; kNone: edited since
  bool operator==(const Mirror&) const = default;

  /// The same plane in coordinates relative to `origin`.
  [[nodiscard]] Mirror relative_to(const Vec3& origin) const {
    Mirror moved = *this;
    moved.offset -= normal.dot(origin);
    return moved;
  }
  [[nodiscard]] double height(const Vec3& p) const { return normal.dot(p) - offset; }
  [[nodiscard]] Vec3 image(const Vec3& p) const { return p - 2 * height(p) * normal; }
  [[nodiscard]] Vec3 turned(const Vec3& direction) const { return direction - 2 * normal.dot(direction) * normal; }
};

/// The features that distinguish a region, or a polygon, from others.
struct Patch {
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();  ///< unit, or zero where there is none
  double area = 0;
};

/// The mirror image of each patch: the two are nearest to each other's image, with about the same area and direction.
/// \param mirror  relative to the same origin as the patches
/// \return (P) itself where a patch lies across the plane, kNone where there is no image
/// Cost: O(P log P), and a sweep of the patches at about the same coordinate.
std::vector<std::int32_t> mirror_images(std::span<const Patch> patches, const Mirror& mirror);

}  // namespace isimp
