#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cell.h"
#include "isimp/core/job.h"
#include "isimp/mesh/io.h"

namespace isimp::convex {

/// A triangle of a polygon, and the plane that the polygon is taken to lie in.
struct Facet {
  std::array<Vec3, 3> corners;
  Vec3 normal = Vec3::Zero();
  std::int32_t plane = 0;
};

// tuned colliders
constexpr double kTolerance = 0.005;  ///< share of the diagonal: the default ConvexOptions::tolerance
constexpr double kLikeNormal = 0.5;   ///< cosine of 60 degrees, between which normals are alike or opposite

/// Lengths that count as nothing.
struct Lengths {
  double snap = 0;    ///< for rounding: a billionth of the diagonal
  double same = 0;    ///< for noise: polygons this near to a plane lie in it
  double slight = 0;  ///< of parts: corners this near to a hull are left out, and deeper ones of a face are reflex
  double deep = 0;    ///< ConvexOptions::tolerance
};

/// A solid that is bounded by few planes.
struct Solid {
  std::vector<Facet> facets;
  std::vector<Plane> planes;
  std::vector<char> both_ways;  ///< whether a plane has polygons that face along its normal, and others
  Eigen::AlignedBox3d box;
  Lengths lengths;

  /// Whether a point is farther than a distance from all facets.
  [[nodiscard]] bool is_far(const Vec3& p, double distance) const;
  /// How often the surface winds around a point; not a whole number near an opening.
  [[nodiscard]] double winding(const Vec3& p) const;
};

/// Finds the planes of polygons: one for each region, and regions in one plane share it.
/// \param origin  is subtracted from all vertices
/// \throws InvalidInput  an index or a number out of its range
Solid solid_of(const PolygonSoup& polygons, std::span<const std::int32_t> region, const Vec3& origin, double tolerance,
               Job& job);

/// The cells of a solid, and the cells of the free space in a box around it.
struct Cells {
  std::vector<Cell> inside, outside;
};

/// Cuts space along the polygons of a solid until none passes through a cell. Adds the planes of the box to the solid's.
/// \throws InvalidInput  the surface encloses nothing, or is open where cells would be inside
/// Source: Thibault, Naylor 1987.
Cells cells_of(Solid& solid, const Vec3& origin, Job& job);

}  // namespace isimp::convex
