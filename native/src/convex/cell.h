#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::convex {

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;

  [[nodiscard]] double height(const Vec3& p) const { return normal.dot(p) - offset; }
};

using Loop = std::vector<Vec3>;  ///< a convex polygon

Vec3 area_vector(std::span<const Vec3> loop);
Vec3 mean_of(std::span<const Vec3> loop);
Eigen::AlignedBox3d box_of(std::span<const Vec3> points);

/// The parts of a convex polygon above and below a plane; one without area has no corners. Corners within `snap` of the
/// plane are on it.
std::array<Loop, 2> divide(const Loop& loop, const Plane& plane, double snap);

/// The part of a convex polygon inside another one of the same plane.
/// \param normal  of the plane; `within` is counter-clockwise around it
Loop overlap(const Loop& loop, const Loop& within, const Vec3& normal, double snap);

/// A face of a cell. Its outward normal is that of the plane if `up`, else the opposite one.
struct CellFace {
  std::int32_t plane = 0;
  bool up = false;
  Loop loop;  ///< counter-clockwise around the normal of the plane
};

/// A convex polyhedron. Faces do not share vertices, so a cut of one face is as simple as that of a polygon.
struct Cell {
  std::vector<CellFace> faces;
  std::vector<Vec3> corners;  ///< each at least once
  double volume = 0;
  Vec3 center = Vec3::Zero();  ///< mean of its corners
  Eigen::AlignedBox3d box;

  /// The lowest and highest of its corners over a plane.
  [[nodiscard]] std::array<double, 2> heights(const Plane& plane) const;
  void measure();  ///< sets all but the faces
};

/// A box with the planes first, first + 1, ... first + 5, which are added to `planes`.
Cell box_cell(const Vec3& low, const Vec3& high, std::vector<Plane>& planes);

/// The parts of a cell above and below a plane, some of whose corners are on both sides by more than `snap`, and the
/// polygon between them.
struct DividedCell {
  std::array<Cell, 2> side;
  Loop between;
};
DividedCell divide(const Cell& cell, const std::vector<Plane>& planes, std::int32_t plane, double snap);

}  // namespace isimp::convex
