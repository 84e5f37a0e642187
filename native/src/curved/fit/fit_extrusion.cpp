#include <cmath>

#include "fit/fit.h"
#include "fit/least.h"
#include "fit/numbers.h"
#include "isimp/core/symmetric.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr int kTilts = 3;  ///< steps of the axis

/// The surface with its axis tilted so that the samples have the least distances, by a step of Gauss-Newton.
CurvedSurface tilted(CurvedSurface c, const Samples& s) {
  const Vec3 up = c.axis.cross(c.across);
  Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
  Vec2 b = Vec2::Zero();
  const Locator on(c);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Residual r = on.residual(s.place[i]);
    const double z = (s.place[i] - c.point).dot(c.axis);
    const Vec2 j = z * Vec2(r.normal.dot(c.across), r.normal.dot(up));
    m += s.weight[i] * j * j.transpose();
    b += s.weight[i] * r.distance * j;
  }
  m.diagonal().array() += kDamping * m.trace();
  const Vec2 step = solve_definite(m, b);
  if (!step.allFinite()) return c;
  c.axis = (c.axis + step.x() * c.across + step.y() * up).normalized();
  c.across = (c.across - c.across.dot(c.axis) * c.axis).normalized();
  return c;
}

}  // namespace

std::optional<CurvedSurface> fit_extrusion(const Samples& s) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  CurvedSurface c;
  c.kind = CurvedKind::extrusion;
  for (std::size_t i = 0; i < s.size(); ++i) {
    normals += s.weight[i] * s.normal[i] * s.normal[i].transpose();
    c.point += s.weight[i] * s.place[i];
  }
  const auto [values, vectors] = spectrum_of(normals);
  if (values[1] < kFlat) return std::nullopt;
  c.axis = vectors.col(0);
  c.across = frame(c.axis)[0];
  for (int k = 0; k < kTilts; ++k) {
    auto now = with_profile(c, s);
    if (!now) return std::nullopt;
    c = tilted(std::move(*now), s);
  }
  return with_profile(std::move(c), s);
}

}  // namespace isimp::curved
