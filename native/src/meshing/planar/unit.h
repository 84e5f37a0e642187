#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "complex/planes.h"
#include "complex/state.h"

namespace isimp::meshing::planar {

inline constexpr std::int32_t kBlock = 64;  ///< work: corners that a thread takes at a time

/// The reason why a polygon is not one face any more.
enum class Cause : std::uint8_t {
  none,
  apart,     ///< the planes at a corner do not meet within reach
  crossing,  ///< it would intersect itself or have no area
  flipped,   ///< it would face away from the scan
  meeting,   ///< it would intersect another polygon
};

/// A polygon that is to be planar: the part of the scan that it stands for, the plane that it is to have, and the steps
/// taken for it.
struct Unit {
  Vec3 normal = Vec3::UnitZ();  ///< unit; the plane is where normal * x = offset
  double offset = 0;
  double trust = 1;           ///< factor on the cost of moves off its scan, relative to other units of the same area
  bool held = false;          ///< its plane is given and does not change
  bool pinned = false;        ///< its plane does not change for now
  bool missed = false;        ///< some corner was not on its plane when planes were fitted last
  bool free = false;          ///< given up: it is triangulated, and its plane counts for nothing
  Cause cause = Cause::none;  ///< why it was given up or a corner held back
  std::int32_t chart = kNone;
  std::vector<std::int32_t> loop;  ///< corners
  std::vector<Vec3> home;          ///< the vertices of the scan for these corners
  std::vector<Vec3> beyond;        ///< by edge: the vector area between it and the boundary that it stands for
  Plane scan;                      ///< the plane of the faces that it stands for
  double noise = 0;                ///< root mean square distance of the scan from the plane that fits it best
  bool left = false;               ///< it keeps its old shape, planar or not

  /// Whether its plane restricts its corners. A triangle has a plane wherever its corners are.
  [[nodiscard]] bool binds() const { return !free && (is_fixed() || loop.size() > 3); }
  [[nodiscard]] bool is_fixed() const { return held || pinned; }
};

/// The corners, with the largest move of each.
struct Places {
  std::vector<Vec3> start;  ///< (C) their places in the polygons of the mesher
  Logged<double> reach;     ///< (C) largest distance from `start`
  double base = 0;          ///< the reach of the options, scene units
  double diagonal = 0;

  /// Whether a corner may be at x.
  [[nodiscard]] bool allows(std::int32_t corner, const Vec3& x) const;
  /// Lowers the largest moves of corners to the need of their held planes.
  void limit(std::span<const Unit> units);
};

/// Whether a polygon is planar: no corner is further from its plane than 1e-6 of the diagonal, in double and rounded to
/// float32.
bool is_flat(std::span<const std::int32_t> polygon, std::span<const Vec3> at, double diagonal);

/// The polygons of a state as units, in the order of their charts. A chart has at most one.
std::vector<Unit> units_of(const State& state);

/// The largest move of each corner: `base`; more if its edges are long, as it slides along its planes, or if given
/// planes are further off; less if its edges are short.
Places places_of(const State& state, const std::vector<Unit>& units, double base);

}  // namespace isimp::meshing::planar
