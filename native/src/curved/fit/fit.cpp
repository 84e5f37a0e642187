#include "fit/fit.h"

#include <cmath>

#include "fit/least.h"
#include "fit/numbers.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

using Eigen::Matrix3d;

// tuned round
constexpr double kMostTilt = 0.2;  ///< radians, of one step

double sign(double x) { return x < 0 ? -1.0 : 1.0; }

CurvedSurface plane(const Samples& s) {
  CurvedSurface out;
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) {
    out.point += s.weight[i] * s.place[i];
    normal += s.weight[i] * s.normal[i];
  }
  Matrix3d spread = Matrix3d::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Vec3 v = s.place[i] - out.point;
    spread += s.weight[i] * v * v.transpose();
  }
  const auto [values, vectors] = spectrum_of(spread);
  const Vec3 least = vectors.col(0);
  const bool is_clear = values[0] < 0.02 * values[1];
  out.axis = is_clear ? Vec3(sign(least.dot(normal)) * least) : Vec3(normal / std::max(normal.norm(), kTiny));
  return out;
}

/// The point nearest to all lines along the normals, with those along `axis` projected out where there is one.
Vec3 meeting(const Samples& s, const Vec3* axis) {
  Matrix3d a = Matrix3d::Zero();
  Vec3 b = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) {
    Vec3 n = s.normal[i], x = s.place[i];
    if (axis != nullptr) {
      n -= n.dot(*axis) * *axis;
      n /= std::max(n.norm(), kTiny);
      x -= x.dot(*axis) * *axis;
    }
    const Matrix3d p = Matrix3d::Identity() - n * n.transpose();
    a += s.weight[i] * p;
    b += s.weight[i] * p * x;
  }
  return solve_definite(a, b);
}

CurvedSurface refined_sphere(CurvedSurface c, const Samples& s, int steps) {
  for (int k = 0; k < steps; ++k) {
    Eigen::Matrix4d m = 1e-12 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    double r = 0;
    for (std::size_t i = 0; i < s.size(); ++i) r += s.weight[i] * (s.place[i] - c.point).norm();
    for (std::size_t i = 0; i < s.size(); ++i) {
      const Vec3 v = s.place[i] - c.point;
      const double l = std::max(v.norm(), kTiny);
      Eigen::Vector4d j;
      j << -v / l, -1;
      m += s.weight[i] * j * j.transpose();
      b -= s.weight[i] * (l - r) * j;
    }
    c.point += solve_definite(m, b).head<3>();
  }
  c.radius = 0;
  for (std::size_t i = 0; i < s.size(); ++i) c.radius += s.weight[i] * (s.place[i] - c.point).norm();
  return c;
}

/// Gauss-Newton on tilt, place across the axis, radius and, of a cone, slope.
CurvedSurface refined_axial(CurvedSurface c, const Samples& s, int steps) {
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) middle += s.weight[i] * s.place[i];
  const bool is_cone = c.kind == CurvedKind::cone;
  for (int k = 0; k < steps; ++k) {
    const double to = (middle - c.point).dot(c.axis);
    c.point += to * c.axis;
    c.radius += c.slope * to;
    const auto [u, w] = frame(c.axis);
    Matrix6 m = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (std::size_t i = 0; i < s.size(); ++i) {
      const Polar p = polar(c, s.place[i]);
      const double eu = p.out.dot(u), ew = p.out.dot(w), arm = p.z + c.slope * p.rho;
      Vector6 j;
      j << -eu * arm, -ew * arm, -eu, -ew, -1, is_cone ? -p.z : 0;
      m += s.weight[i] * j * j.transpose();
      b -= s.weight[i] * (p.rho - c.radius - c.slope * p.z) * j;
    }
    for (int d = 0; d < 6; ++d) m(d, d) = m(d, d) > 0 ? (1 + kDamping) * m(d, d) : 1.0;
    const Vector6 step = solve_balanced(m, b);
    if (!step.allFinite() || std::hypot(step[0], step[1]) > kMostTilt) break;
    c.axis = (c.axis + step[0] * u + step[1] * w).normalized();
    c.point += step[2] * u + step[3] * w;
    c.radius += step[4];
    c.slope += step[5];
  }
  return c;
}

void set_side(CurvedSurface& c, const Samples& s) {
  double sum = 0;
  for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i].dot(polar(c, s.place[i]).out);
  c.side = sign(sum);
}

CurvedSurface sphere(const Samples& s) {
  CurvedSurface c;
  c.kind = CurvedKind::sphere;
  c.point = meeting(s, nullptr);
  c = refined_sphere(c, s, 4);
  double sum = 0;
  for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i].dot(s.place[i] - c.point);
  c.side = sign(sum);
  return c;
}

std::optional<CurvedSurface> cylinder(const Samples& s) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i] * s.normal[i].transpose();
  const auto [values, vectors] = spectrum_of(sum);
  if (values[1] < kFlat) return std::nullopt;
  CurvedSurface c;
  c.kind = CurvedKind::cylinder;
  c.axis = vectors.col(0);
  c.point = meeting(s, &c.axis);
  c.radius = 0;
  for (std::size_t i = 0; i < s.size(); ++i) c.radius += s.weight[i] * polar(c, s.place[i]).rho;
  c = refined_axial(c, s, 4);
  set_side(c, s);
  if (!(c.radius > 0)) return std::nullopt;
  return c;
}

std::optional<CurvedSurface> cone(const Samples& s) {
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) mean += s.weight[i] * s.normal[i];
  Matrix3d spread = Matrix3d::Zero(), a = Matrix3d::Zero();
  Vec3 b = Vec3::Zero();
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Vec3 &n = s.normal[i], v = n - mean;
    spread += s.weight[i] * v * v.transpose();
    a += s.weight[i] * n * n.transpose();
    b += s.weight[i] * n.dot(s.place[i]) * n;
  }
  const auto [values, vectors] = spectrum_of(spread);
  if (values[1] < kFlat) return std::nullopt;
  CurvedSurface c;
  c.kind = CurvedKind::cone;
  c.axis = vectors.col(0);
  c.point = solve_definite(a, b);
  double up = 0, across = 0, height = 0;
  for (std::size_t i = 0; i < s.size(); ++i) up += s.weight[i] * (s.place[i] - c.point).dot(c.axis);
  c.axis *= sign(up);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Polar p = polar(c, s.place[i]);
    across += s.weight[i] * p.rho * p.z;
    height += s.weight[i] * p.z * p.z;
  }
  c.slope = across / std::max(height, kTiny);
  c = refined_axial(c, s, 4);
  set_side(c, s);
  if (!(c.radius > 0) || !std::isfinite(c.slope)) return std::nullopt;
  return c;
}

}  // namespace

Samples::Samples(std::size_t count) {
  weight.reserve(count);
  place.reserve(count);
  normal.reserve(count);
}

void Samples::add(double w, const Vec3& x, const Vec3& n) {
  weight.push_back(w);
  place.push_back(x);
  normal.push_back(n);
}

void Samples::normalise() {
  double sum = 0;
  for (const double w : weight) sum += w;
  for (double& w : weight) w /= std::max(sum, kTiny);
}

Samples samples_of(const Points& points, std::span<const std::int32_t> some) {
  Samples s(some.size());
  for (const std::int32_t i : some) s.add(points.area[i], points.centre[i], points.normal[i]);
  s.normalise();
  return s;
}

Samples samples_of(const Faces& faces, std::span<const std::int32_t> some) {
  Samples s(some.size());
  for (const std::int32_t i : some) s.add(faces.area(i), faces.centre(i), faces.normal(i));
  s.normalise();
  return s;
}

std::optional<CurvedSurface> fit(CurvedKind kind, const Samples& samples) {
  switch (kind) {
    case CurvedKind::plane:
      return plane(samples);
    case CurvedKind::cylinder:
      return cylinder(samples);
    case CurvedKind::cone:
      return cone(samples);
    case CurvedKind::sphere:
      return sphere(samples);
    case CurvedKind::revolution:
      return fit_revolution(samples);
    case CurvedKind::extrusion:
      return fit_extrusion(samples);
  }
  return std::nullopt;
}

CurvedSurface refined(CurvedSurface surface, const Samples& samples, int steps) {
  if (surface.kind == CurvedKind::sphere) return refined_sphere(std::move(surface), samples, steps);
  return refined_axial(std::move(surface), samples, steps);
}

double rms(const CurvedSurface& surface, const Samples& samples) {
  const Locator on(surface);
  double sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double d = on.distance(samples.place[i]);
    sum += samples.weight[i] * d * d;
  }
  return std::sqrt(sum);
}

}  // namespace isimp::curved
