#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/types.h"

namespace isimp {

enum class CurvedKind : std::uint8_t { plane, cylinder, cone, sphere, revolution, extrusion };

/// A surface with an axis, or a plane. An extrusion is a profile moved along its axis. Lengths in scene units. In a partition, `point` is in the caller's coordinates;
/// while patches are searched and cut, it is relative to the mesh's origin.
struct CurvedSurface {
  CurvedKind kind = CurvedKind::plane;
  /// On the axis; the centre of a sphere; of a cone, a cylinder and an extrusion in the middle of their faces.
  Vec3 point = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  ///< unit; the normal of a plane
  /// Cylinder, sphere; of a cone at `point`; of a revolution the largest; of an extrusion the largest from `point`.
  double radius = 0;
  double slope = 0;  ///< cone: growth of the radius along the axis
  double side = 1;   ///< 1: the normals lead away from the axis, or to the right of the profile; -1: the other way
  /// Revolution: rho, z, rho, z, ... of its corners, z along the axis from `point`. Extrusion: the places of its corners
  /// along `across` and along the axis x `across`, from `point`.
  std::vector<double> profile;
  bool closed = false;          ///< revolution, extrusion: the profile is a ring
  Vec3 across = Vec3::UnitX();  ///< unit, square to the axis: where angles begin
  bool operator==(const CurvedSurface&) const = default;
};

/// A curved patch of a partition: one surface, cut into segments about its axis and rings along its profile. Segments
/// of an extrusion are strips along its axis; it has one ring.
struct CurvedProxy : CurvedSurface {
  /// The begin of the first segment and the angle of all segments, radians; of an extrusion the turn of its normals.
  double phase = 0, span = 0;
  bool full = false;  ///< the segments close around the axis
  std::int32_t segments = 0, rings = 0;
  /// (rings + 1) along the profile: height, angle from the lower pole, or length. Extrusion: (segments + 1) lengths.
  std::vector<double> knots;
  bool low_cap = false, high_cap = false;  ///< the first and last ring are one cell across the axis
  bool operator==(const CurvedProxy&) const = default;
};

/// The cell of a patch that a region is.
struct CurvedCell {
  std::int32_t proxy = kNone, ring = 0, segment = 0;
  bool operator==(const CurvedCell&) const = default;
};

}  // namespace isimp
