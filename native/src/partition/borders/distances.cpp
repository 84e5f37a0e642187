#include "borders/distances.h"

#include <cmath>

#include "isimp/core/check.h"
#include "isimp/mesh/mesh.h"

namespace isimp {
namespace {

// tuned distances
constexpr double kLength = 0.06;  // sides of a mean region: a distance that counts as normals that differ by 60 degrees
constexpr double kLine = 1e-9;    // rounding: share of the squared spread, below which corners are on a line

}  // namespace

void Moments::accumulate(const Moments& m, double sign) {
  area += sign * m.area;
  x += sign * m.x;
  y += sign * m.y;
  z += sign * m.z;
  xx += sign * m.xx;
  xy += sign * m.xy;
  xz += sign * m.xz;
  yy += sign * m.yy;
  yz += sign * m.yz;
  zz += sign * m.zz;
}

Distances::Distances(const Surface& surface, Metric metric, std::int64_t regions)
    : vertices_(surface.mesh().vertices()),
      triangles_(surface.mesh().triangles()),
      graph_(&surface.graph()),
      of_normals_(metric == Metric::distance ? 0.0F : 1.0F),
      unit_(surface.mesh().graph().area > 0 ? 1 / std::sqrt(surface.mesh().graph().area) : 0.0),
      scale_(metric == Metric::normals ? 0.0 : std::sqrt(static_cast<double>(regions)) / kLength) {}

Moments Distances::moments(std::int32_t face) const {
  Moments m;
  const double area = graph_->faces[face].area, w = area / 3;
  m.area = area;
  for (const Vec3& p : corners(face)) {
    const double x = w * p.x(), y = w * p.y(), z = w * p.z();
    m.x += x;
    m.y += y;
    m.z += z;
    m.xx += x * p.x();
    m.xy += x * p.y();
    m.xz += x * p.z();
    m.yy += y * p.y();
    m.yz += y * p.z();
    m.zz += z * p.z();
  }
  return m;
}

void Distances::forget(std::size_t regions) {
  moments_.assign(regions, {});
  planes_.assign(regions, {});
  known_.assign(regions, 0);
  knows_all_ = false;
}

void Distances::start(std::int32_t region, const RegionSum& sum) {
  const Vec3 normal = sum.normal() * scale_;
  planes_[region] = {normal.x(), normal.y(), normal.z(), 0};
  known_[region] = 1;
  fit(region, kFirstSteps);
}

void Distances::move(std::int32_t face, std::int32_t from, std::int32_t to) {
  const Moments m = moments(face);
  moments_[from].remove(m);
  moments_[to].add(m);
}

/// By inverse iteration from the present plane: each step lowers the mean square distance. With the adjugate in place of
/// the inverse, which exists for corners in one plane too.
void Distances::fit(std::int32_t region, int steps) {
  const Moments& m = moments_[region];
  Plane& p = planes_[region];
  if (!(m.area > 0)) return;
  const double by = 1 / m.area, x = m.x * by, y = m.y * by, z = m.z * by;
  const double xx = m.xx * by - x * x, xy = m.xy * by - x * y, xz = m.xz * by - x * z, yy = m.yy * by - y * y,
               yz = m.yz * by - y * z, zz = m.zz * by - z * z, spread = xx + yy + zz;
  const double axx = yy * zz - yz * yz, axy = xz * yz - xy * zz, axz = xy * yz - xz * yy, ayy = xx * zz - xz * xz,
               ayz = xy * xz - xx * yz, azz = xx * yy - xy * xy;
  for (int k = 0; k < steps; ++k) {
    const double u = axx * p.x + axy * p.y + axz * p.z, v = axy * p.x + ayy * p.y + ayz * p.z,
                 w = axz * p.x + ayz * p.y + azz * p.z, length = std::sqrt(u * u + v * v + w * w);
    if (!(length > kLine * spread * spread * scale_)) break;
    const double to = scale_ / length;
    p.x = u * to;
    p.y = v * to;
    p.z = w * to;
  }
  p.offset = p.x * x + p.y * y + p.z * z;
}

double Distances::error() const {
  double sum = 0;
  for (std::size_t r = 0; r < moments_.size(); ++r) {
    const Moments& m = moments_[r];
    const Plane& p = planes_[r];
    const double squares =
        p.x * (p.x * m.xx + 2 * (p.y * m.xy + p.z * m.xz)) + p.y * (p.y * m.yy + 2 * p.z * m.yz) + p.z * p.z * m.zz;
    const double along = p.x * m.x + p.y * m.y + p.z * m.z;
    sum += std::max(0.0, squares - p.offset * (2 * along - p.offset * m.area));
  }
  return sum;
}

}  // namespace isimp
