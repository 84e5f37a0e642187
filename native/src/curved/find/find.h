#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "fit/fit.h"
#include "fit/points.h"

namespace isimp::curved {

/// A surface and the points of data that are on it.
struct Found {
  CurvedSurface surface;
  Some points;
  double area = 0, rms = 0;

  [[nodiscard]] bool is_plane() const { return surface.kind == CurvedKind::plane; }
};

/// How near data is to a surface that it is on.
struct Nearness {
  double distance = 0;  ///< scene units
  double turn = 0;      ///< radians, of the normal
  double size = 0;      ///< diagonal of the mesh
  double noise = 0;     ///< standard deviation of the scan's noise, scene units

  /// Whether a point with a normal is that near, at multiples of the distance and of the turn.
  [[nodiscard]] bool has(const Residual& r, const Vec3& normal, double further, double turns) const {
    return std::abs(r.distance) < further * distance && r.normal.dot(normal) > std::cos(turns * turn);
  }
};

/// (points) The surface that each point is on, kNone where on none.
Some owners(const Points& points, const std::vector<Found>& found);

/// The share of a full turn about an axis that some samples cover.
double turn_share(const CurvedSurface& surface, const Samples& samples);

/// Whether a surface of revolution is seen over enough of a turn: a tube, whose profile is a ring, over less.
bool is_seen(const CurvedSurface& surface, const Samples& samples);

/// Planes and curved surfaces that explain the data: grown from many seeds, and chosen one after another, each the one
/// with the most area and the least distance. Planes compete as well, so that no wall becomes part of a huge cylinder.
/// The seeds are at equal steps among the points that are free: no random numbers.
std::vector<Found> find_surfaces(const Points& points, const Nearness& near, Job& job);

/// Joins neighbours that are one surface of revolution, adds nearby free points to each, and prefers a cylinder, a
/// sphere or a cone, or two of these, to a revolution that they fit nearly as well. (join.cpp)
std::vector<Found> joined(std::vector<Found> found, const Points& points, const Nearness& near, Job& job);

/// Joins adjacent cylinders and planes of one direction to extrusions. Kept ones stay if they are nearer to their faces.
/// \param kept   of each surface whether the gates keep it
/// \param label  the surface of each face
/// \return the surfaces with the extrusions last, in the place of their parts; none if there is no extrusion
/// (extrusions.cpp)
std::optional<std::vector<Found>> with_extrusions(const Faces& faces, const Points& points,
                                                  const std::vector<Found>& found, const std::vector<bool>& kept,
                                                  const Some& label, const Nearness& near);

/// Adds the bends between pipes of one radius whose axes meet; surfaces there lose their points. (bends.cpp)
std::vector<Found> with_bends(std::vector<Found> found, const Points& points, const Nearness& near);

}  // namespace isimp::curved
