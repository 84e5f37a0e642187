#pragma once

#include <functional>
#include <optional>
#include <span>

#include "fit/points.h"
#include "fit/surfaces.h"

namespace isimp::curved {

/// Samples of a surface to which one is fitted.
struct Samples {
  std::vector<double> weight;  ///< they add up to 1
  std::vector<Vec3> place, normal;

  Samples() = default;
  /// \param count  about how many there will be
  explicit Samples(std::size_t count);
  [[nodiscard]] std::size_t size() const { return weight.size(); }
  void add(double w, const Vec3& x, const Vec3& n);
  void normalise();
};

Samples samples_of(const Points& points, std::span<const std::int32_t> some);
Samples samples_of(const Faces& faces, std::span<const std::int32_t> some);

/// The surface of a kind that fits some samples best; none where they do not determine one.
///
/// Sphere, cylinder and cone: the point nearest to all normal lines, then Gauss-Newton on distances. Revolution: the
/// normals meet the axis, n.m + (x cross n).d = 0 for its Pluecker coordinates (d, m), a linear line complex.
/// Source: Pottmann, Wallner 2001; Gelfand, Guibas 2004.
std::optional<CurvedSurface> fit(CurvedKind kind, const Samples& samples);

/// A cylinder, cone or sphere moved by Gauss-Newton on distances alone.
CurvedSurface refined(CurvedSurface surface, const Samples& samples, int steps);

/// (fit_revolution.cpp)
std::optional<CurvedSurface> fit_revolution(const Samples& samples);
/// A free profile moved along the direction that is most nearly square to all normals. (fit_extrusion.cpp)
std::optional<CurvedSurface> fit_extrusion(const Samples& samples);
/// The profile of samples about the axis of a revolution or an extrusion; none if they form no curve.
std::optional<CurvedSurface> with_profile(CurvedSurface surface, const Samples& samples);

/// The length along an open profile at which two lines, or a line and a circle about a point of the axis, meet that fit
/// it best; none if it is closed or too short. (profile_break.cpp)
std::optional<double> profile_break(const CurvedSurface& surface);

/// Root mean square of the distances.
double rms(const CurvedSurface& surface, const Samples& samples);

}  // namespace isimp::curved
