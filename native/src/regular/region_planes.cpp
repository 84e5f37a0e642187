#include "region_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/core/symmetric.h"

namespace isimp::regular {
namespace {

// tuned regular
constexpr double kThin = 0.25;  ///< a spread whose smallest eigenvalue is above this share of the next fixes no plane
constexpr double kAgree = 0.8;  ///< cosine between that plane and the faces' mean normal below which the mean counts

void fit(RegionPlane& r) {
  const Vec3& mean = r.scan.normal;
  const auto [values, vectors] = spectrum_of(r.scan.spread);
  const Vec3 n = vectors.col(0);
  const bool is_thin = !(values[0] <= kThin * values[1]);
  r.normal = is_thin || std::abs(n.dot(mean)) < kAgree ? mean : Vec3(n.dot(mean) < 0 ? -n : n);
  r.snapped = r.normal;
  r.offset = r.best_offset();
}

bool is_along(const Vec3& a, const Vec3& b) { return a.cross(b).norm() <= kSame; }

bool is_one_plane(const RegionPlane& a, const RegionPlane& b, double diagonal) {
  return (a.snapped - b.snapped).norm() <= kSame && std::abs(a.offset - b.offset) <= kSame * diagonal;
}

}  // namespace

std::vector<RegionPlane> region_planes(const Mesh& mesh, const Partition& partition) {
  std::vector<std::vector<std::int32_t>> faces(partition.region_count());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (const std::int32_t r = partition.face_region[f]; r != kNone) faces[r].push_back(f);
  std::vector<RegionPlane> regions(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    RegionPlane& r = regions[i];
    if (!faces[i].empty()) r.scan = meshing::plane_of(mesh, faces[i]);
    r.faces = static_cast<double>(std::max<std::size_t>(faces[i].size(), 1));
    fit(r);
  }
  return regions;
}

Vec3 unit_up(const Vec3& up) {
  const double length = up.norm();
  if (!(length > 0 && length < std::numeric_limits<double>::infinity()))
    throw InvalidInput("up_direction must be a direction: three finite numbers, not all 0");
  return up / length;
}

double squared_distance(const RegionPlane& region, const Vec3& normal, double offset) {
  const double d = normal.dot(region.scan.centre) - offset;
  return std::max(0.0, normal.dot(region.scan.spread * normal)) + d * d;
}

double median_distance(const std::vector<RegionPlane>& regions) {
  std::vector<std::pair<double, double>> all;  // distance, area
  double area = 0;
  for (const RegionPlane& r : regions) {
    all.emplace_back(std::sqrt(squared_distance(r, r.normal, r.best_offset())), r.scan.area);
    area += r.scan.area;
  }
  std::sort(all.begin(), all.end());
  double sum = 0;
  for (const auto& [distance, share] : all)
    if ((sum += share) >= area / 2) return distance;
  return 0;
}

Regularity summary_of(const std::vector<RegionPlane>& regions, double diagonal, const Job& job) {
  Regularity found;
  double area = 0, before = 0, after = 0;
  std::vector<const RegionPlane*> planes;
  std::vector<Vec3> directions;
  for (const RegionPlane& r : regions) {
    job.poll();
    if (r.scan.area <= 0) continue;
    area += r.scan.area;
    before += r.scan.area * squared_distance(r, r.normal, r.best_offset());
    after += r.scan.area * squared_distance(r, r.snapped, r.offset);
    if (std::none_of(directions.begin(), directions.end(), [&](const Vec3& d) { return is_along(d, r.snapped); }))
      directions.push_back(r.snapped);
    if (std::none_of(planes.begin(), planes.end(), [&](const RegionPlane* p) { return is_one_plane(*p, r, diagonal); }))
      planes.push_back(&r);
  }
  found.directions = static_cast<std::int32_t>(directions.size());
  found.planes = static_cast<std::int32_t>(planes.size());
  found.rms_before = area > 0 ? std::sqrt(before / area) : 0;
  found.rms = area > 0 ? std::sqrt(after / area) : 0;
  return found;
}

}  // namespace isimp::regular
