#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "isimp/core/tiny.h"
#include "isimp/partition/curved.h"

/// Geometry of a curved surface at a point.
namespace isimp::curved {

using Vec2 = Eigen::Vector2d;

inline constexpr double kTurn = 2 * std::numbers::pi;                      ///< unit: a full turn, radians
inline constexpr double kNever = std::numeric_limits<double>::infinity();  ///< mark: the cost of what is not possible

/// A point seen from the axis of a surface. For an extrusion, `out` and `up` are the directions of its profile.
struct Polar {
  double rho = 0, z = 0;
  Vec3 out = Vec3::Zero();  ///< unit, away from the axis
  Vec3 up = Vec3::Zero();   ///< unit, along the axis; rho and z are the coordinates along `out` and `up`
};

struct Residual {
  double distance = 0;         ///< signed; not for a revolution
  Vec3 normal = Vec3::Zero();  ///< normal of the surface, on the side of the scan's
};

/// Two unit vectors square to a unit vector, which they follow in a right-handed frame.
std::array<Vec3, 2> frame(const Vec3& axis);

/// Whether the profile is a straight line.
inline bool is_straight(const CurvedSurface& s) { return s.kind == CurvedKind::cylinder || s.kind == CurvedKind::cone; }

inline Polar polar(const CurvedSurface& surface, const Vec3& p) {
  const Vec3 v = p - surface.point;
  if (surface.kind == CurvedKind::extrusion) {
    const Vec3 up = surface.axis.cross(surface.across);
    return {v.dot(surface.across), v.dot(up), surface.across, up};
  }
  const double z = v.dot(surface.axis);
  const Vec3 out = v - z * surface.axis;
  const double rho = out.norm();
  return {rho, z, out / std::max(rho, kTiny), surface.axis};
}

/// The place on a surface that is nearest to a point.
struct OnSurface {
  Polar polar;
  Residual residual;
  double along = 0;  ///< as `along`
};

/// Finds places on one surface. The edges of its profile are prepared once, for many points.
class Locator {
 public:
  explicit Locator(const CurvedSurface& surface);

  [[nodiscard]] OnSurface at(const Vec3& p) const;
  [[nodiscard]] Residual residual(const Vec3& p) const;
  [[nodiscard]] double distance(const Vec3& p) const;  ///< not signed
  /// The place along the profile: height, angle from the lower pole of a sphere, or length along the profile.
  [[nodiscard]] double along(const Polar& p) const;
  /// The place of a sphere or a profile at a place along it.
  [[nodiscard]] Vec2 place(double along) const;

 private:
  /// The place on the profile that is nearest to a point of its plane.
  struct OnProfile {
    std::size_t edge = 0;
    double share = 0;          ///< share of the edge
    Vec2 away = Vec2::Zero();  ///< from that place to the point
  };
  /// Some edges in a row, and a box around them.
  struct Block {
    Vec2 low, high;
    std::size_t begin, end;
  };
  [[nodiscard]] OnProfile nearest(double x, double y) const;
  [[nodiscard]] Residual residual(const Polar& p) const;  ///< of a cylinder or a cone
  [[nodiscard]] Residual residual(const Polar& p, const OnProfile& on) const;
  [[nodiscard]] double length_to(const OnProfile& on) const;

  const CurvedSurface* surface_;
  // By edge of the profile: its first corner, its vector, 1 / its squared length, and the shares that are on it.
  std::vector<double> x_, y_, dx_, dy_, inverse_, from_, to_;
  std::vector<double> length_;  // by edge: of the profile up to there
  std::vector<Block> block_;
  double size_ = 0;  // the largest squared length of a corner
};

inline bool has_profile(const CurvedSurface& s) {
  return s.kind == CurvedKind::revolution || s.kind == CurvedKind::extrusion;
}

/// The angle of a point about the axis, from `across` on, in [0, 2 pi).
double angle(const CurvedProxy& proxy, const Vec3& p);
/// std::fmod(angle, kTurn), with a subtraction that is exact where the angle is between 0 and three turns.
double rest_of_turns(double angle);
/// An angle made one in [-pi, pi).
double turned(double angle);

inline Vec2 corner(const CurvedSurface& s, std::size_t i) { return {s.profile[2 * i], s.profile[2 * i + 1]}; }
inline std::size_t corners(const CurvedSurface& s) { return s.profile.size() / 2; }

}  // namespace isimp::curved
