#include "complex/planes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "isimp/core/prefetch.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kAhead = 12;  ///< work: faces between the current one and the one whose corners are prefetched
constexpr std::int32_t kStride = 1 << 14;  ///< work: faces from one poll to the next

/// Integrals over a set of faces, about an origin that keeps the numbers small.
struct Moments {
  double area = 0;
  Vec3 normal = Vec3::Zero(), first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< its lower half
  std::int32_t face = kNone;

  void add(const Mesh& mesh, std::int32_t f, const Vec3& origin) {
    const Triangle& t = mesh.triangles()[f];
    const Vec3 a = mesh.vertices()[t[0]] - origin, b = mesh.vertices()[t[1]] - origin,
               c = mesh.vertices()[t[2]] - origin;
    const Vec3 n = (b - a).cross(c - a);
    const double s = n.norm() / 2;
    const Vec3 sum = a + b + c;
    if (face == kNone) face = f;
    normal += n;
    area += s;
    first += s / 3 * sum;
    // The integral of x x^T over a triangle is its area / 12 times this.
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) second(i, j) += s / 12 * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
  }
};

Plane plane(const Mesh& mesh, const Moments& m, const Vec3& origin) {
  Plane p;
  p.area = m.area;
  const double length = m.normal.norm();
  if (m.area <= 0 || length <= 1e-12 * m.area) {
    const FaceRecord& r = mesh.graph().faces[mesh.graph().graph_face[m.face]];
    p.normal = Vec3(r.nx, r.ny, r.nz);
    if (p.normal.norm() == 0) p.normal = Vec3::UnitZ();
    p.normal.normalize();
    p.centre = mesh.vertices()[mesh.triangles()[m.face][0]];
    return p;
  }
  p.normal = m.normal / length;
  p.projected = length / 2;
  const Vec3 c = m.first / m.area;
  p.centre = c + origin;
  p.spread = Eigen::Matrix3d(m.second.selfadjointView<Eigen::Lower>()) / m.area - c * c.transpose();
  return p;
}

}  // namespace

std::vector<Plane> planes_of(const Labels& labels, const Threads& threads, const Job& job) {
  const Mesh& mesh = labels.mesh;
  std::vector<Moments> moments(labels.charts.size());
  std::vector<Vec3> origin(labels.charts.size());
  for (std::size_t l = 0; l < origin.size(); ++l)
    origin[l] = mesh.vertices()[mesh.triangles()[labels.charts[l].face][0]];
  std::vector<Plane> planes(moments.size());
  // Each thread has some of the charts, and adds up their faces in the order of all.
  const auto measure = [&](std::int32_t part, std::int32_t begin, std::int32_t end) {
    const auto mine = [&](std::int32_t f) { return labels.label[f] >= begin && labels.label[f] < end; };
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      if (part == 0 && f % kStride == 0) job.poll();
      if (f + kAhead < mesh.face_count() && mine(f + kAhead))
        for (const std::int32_t v : mesh.triangles()[f + kAhead]) prefetch(&mesh.vertices()[v]);
      if (mine(f)) moments[labels.label[f]].add(mesh, f, origin[labels.label[f]]);
    }
    for (std::int32_t l = begin; l < end; ++l) planes[l] = plane(mesh, moments[l], origin[l]);
  };
  threads.run(labels.chart_count(), threads.pieces(mesh.face_count()), measure);
  return planes;
}

Plane united(const Plane& a, const Plane& b) {
  Plane p;
  p.area = a.area + b.area;
  const Vec3 normal = a.projected * a.normal + b.projected * b.normal;
  p.projected = normal.norm();
  p.normal = normal / p.projected;
  const double share = b.area / p.area;
  const Vec3 between = b.centre - a.centre;
  p.centre = a.centre + share * between;
  p.spread = (1 - share) * a.spread + share * b.spread + share * (1 - share) * between * between.transpose();
  return p;
}

Plane without(const Plane& chart, const Plane& part) {
  Plane p;
  p.area = chart.area - part.area;
  const Vec3 normal = chart.projected * chart.normal - part.projected * part.normal;
  p.projected = normal.norm();
  p.normal = normal / p.projected;
  const double share = part.area / chart.area, rest = p.area / chart.area;
  p.centre = chart.centre + share / rest * (chart.centre - part.centre);
  const Vec3 between = part.centre - p.centre;
  p.spread = (chart.spread - share * part.spread - share * rest * between * between.transpose()) / rest;
  return p;
}

void hold_by_hand(Plane& plane, const Partition& partition, std::int32_t region, const Vec3& origin) {
  if (partition.is_held(region) && !partition.is_snapped(region)) hold(plane, partition, region, origin);
}

void hold(Plane& plane, const Partition& partition, std::int32_t region, const Vec3& origin) {
  plane.held = partition.is_held(region);
  plane.snapped = partition.is_snapped(region);
  plane.round = plane.held && partition.region_held[region] == kPlaneRound;
  if (!plane.held) return;
  plane.normal = partition.region_normal[region];
  plane.centre += (partition.offset_from(origin, region) - plane.normal.dot(plane.centre)) * plane.normal;
}

Vec3 step_onto(std::span<const Plane* const> planes, double fixed, const Vec3& from, Eigen::Matrix3d& free) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 g = Vec3::Zero();
  for (const Plane* p : planes) {
    const Vec3 n = free * p->normal;
    a += n * n.transpose();
    g += p->normal.dot(p->centre - from) * n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
  Vec3 d = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 way = solver.eigenvectors().col(i);
    if (!(solver.eigenvalues()[i] > fixed * solver.eigenvalues()[2])) continue;
    d += way.dot(g) / solver.eigenvalues()[i] * way;
    free -= way * way.transpose();
  }
  return d;
}

Scale scale_of(const Labels& labels, std::span<const Plane> planes) {
  Scale scale;
  double area = 0, count = 0;
  for (std::size_t l = 0; l < planes.size(); ++l) {
    if (labels.charts[l].face == kNone) continue;
    area += planes[l].area;
    scale.error += error_of(planes[l]);
    scale.square += std::max(0.0, square_of(planes[l]));
    ++count;
  }
  if (count == 0) return scale;
  scale.size = std::sqrt(area / count);
  scale.deviation = std::sqrt(scale.square / std::max(area, 1e-300));
  scale.error /= count;
  scale.square /= count;
  return scale;
}

Plane plane_of(const Mesh& mesh, std::span<const std::int32_t> faces) {
  Moments moments;
  const Vec3 origin = mesh.vertices()[mesh.triangles()[faces[0]][0]];
  for (const std::int32_t f : faces) moments.add(mesh, f, origin);
  return plane(mesh, moments, origin);
}

}  // namespace isimp::meshing
