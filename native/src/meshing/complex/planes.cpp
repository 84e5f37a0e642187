#include "complex/planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "isimp/core/prefetch.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kFacesAPoll = 1 << 14;  ///< work: faces from one poll to the next
// tuned places
constexpr double kOutlying = 6;  ///< medians of the distances from a region's plane, beyond which a face is an outlier
constexpr double kOutlier = 1e-3;  ///< limit: weight of one, so that a chart of outliers alone has a plane
constexpr int kTurns = 20;         ///< limit

/// Integrals over a set of faces, about an origin that keeps the numbers small.
struct Moments {
  double area = 0;
  Vec3 normal = Vec3::Zero(), first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< its lower half
  std::int32_t face = kNone;

  void add(const Mesh& mesh, std::int32_t f, const Vec3& origin, std::span<const std::uint8_t> outlying) {
    const Triangle& t = mesh.triangles()[f];
    const Vec3 a = mesh.vertices()[t[0]] - origin, b = mesh.vertices()[t[1]] - origin,
               c = mesh.vertices()[t[2]] - origin;
    const double weight = outlying.empty() || outlying[f] == 0 ? 1 : kOutlier;
    const Vec3 n = weight * (b - a).cross(c - a);
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

/// Half of the area is nearer than this.
/// \param all  distance and area of each face; its order changes
/// Cost: O(n) in the mean.
double median_of(std::span<std::pair<double, double>> all) {
  double half = 0;
  for (const auto& [distance, area] : all) half += area / 2;
  while (all.size() > 1) {
    const auto middle = all.begin() + std::ssize(all) / 2;
    std::nth_element(all.begin(), middle, all.end());
    double nearer = 0;
    for (auto at = all.begin(); at != middle; ++at) nearer += at->second;
    const bool is_nearer = nearer >= half;
    if (!is_nearer) half -= nearer;
    all = is_nearer ? std::span(all.begin(), middle) : std::span(middle, all.end());
  }
  return all[0].first;
}

}  // namespace

Vec3 best_normal(const Plane& plane) {
  const Vec3 n = direct_spectrum_of(plane.spread).vectors.col(0);
  return n.dot(plane.normal) < 0 ? Vec3(-n) : n;
}

void mark_outlying(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<std::uint8_t> outlying) {
  std::vector<std::pair<double, double>> all(faces.size());
  std::vector<double> away(faces.size());
  bool changed = true;
  for (int turn = 0; turn < kTurns && changed; ++turn) {
    const Plane p = plane_of(mesh, faces, outlying);
    const Vec3 n = best_normal(p);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const Triangle& t = mesh.triangles()[faces[i]];
      const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
      const double x = n.dot(a - p.centre), y = n.dot(b - p.centre), z = n.dot(c - p.centre);
      away[i] = std::sqrt((x * x + y * y + z * z + (x + y + z) * (x + y + z)) / 12);
      all[i] = {away[i], (b - a).cross(c - a).norm()};
    }
    const double most = std::max(kOutlying * median_of(all), kThickness * mesh.diagonal());
    changed = false;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const std::uint8_t is_out = away[i] > most ? 1 : 0;
      changed = changed || is_out != outlying[faces[i]];
      outlying[faces[i]] = is_out;
    }
  }
}

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
      if (part == 0 && f % kFacesAPoll == 0) job.poll();
      if (f + kAhead < mesh.face_count() && mine(f + kAhead))
        for (const std::int32_t v : mesh.triangles()[f + kAhead]) prefetch(&mesh.vertices()[v]);
      if (mine(f)) moments[labels.label[f]].add(mesh, f, origin[labels.label[f]], labels.outlying);
    }
    for (std::int32_t l = begin; l < end; ++l) planes[l] = plane(mesh, moments[l], origin[l]);
  };
  threads.run(labels.chart_count(), threads.pieces(mesh.face_count()), measure);
  return planes;
}

std::vector<std::uint8_t> outlying_faces(const Mesh& mesh, std::span<const std::int32_t> face_region,
                                         std::int32_t regions, const Threads& threads, const Job& job) {
  std::vector<std::int32_t> start(static_cast<std::size_t>(regions) + 1, 0);
  for (const std::int32_t r : face_region)
    if (r != kNone) ++start[r + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::int32_t> faces(start.back()), end = start;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (const std::int32_t r = face_region[f]; r != kNone) faces[end[r]++] = f;
  std::vector<std::uint8_t> outlying(mesh.face_count(), 0);
  threads.blocks(regions, 4, [&](std::int32_t, std::int32_t begin, std::int32_t stop) {
    job.poll();
    for (std::int32_t r = begin; r < stop; ++r)
      if (start[r] < start[r + 1])
        mark_outlying(mesh, std::span(faces).subspan(start[r], start[r + 1] - start[r]), outlying);
  });
  return outlying;
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
  const auto [values, vectors] = spectrum_of(a);
  Vec3 d = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 way = vectors.col(i);
    if (!(values[i] > fixed * values[2])) continue;
    d += way.dot(g) / values[i] * way;
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
  scale.deviation = std::sqrt(scale.square / std::max(area, kTiny));
  scale.error /= count;
  scale.square /= count;
  return scale;
}

Plane plane_of(const Mesh& mesh, std::span<const std::int32_t> faces, std::span<const std::uint8_t> outlying) {
  Moments moments;
  const Vec3 origin = mesh.vertices()[mesh.triangles()[faces[0]][0]];
  for (const std::int32_t f : faces) moments.add(mesh, f, origin, outlying);
  return plane(mesh, moments, origin);
}

}  // namespace isimp::meshing
