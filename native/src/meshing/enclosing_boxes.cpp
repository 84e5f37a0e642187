#include "enclosing_boxes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "isimp/core/forest.h"
#include "isimp/core/least_box.h"
#include "isimp/core/sorted.h"
#include "judge/judge.h"

namespace isimp::meshing {
namespace {

// tuned unrecorded
constexpr double kThinnest = 1e-3;  ///< the least side of a box, as a share of its largest
/// unit: corners of each side of a box
constexpr std::array<std::array<int, 4>, 6> kSides{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

/// Regions that one box replaces.
struct BoxGroup {
  std::vector<std::int32_t> vertices;        ///< in rising order
  std::map<std::int32_t, double> neighbour;  ///< by region of which polygons are made: length of the common border
  std::int32_t largest = kNone;              ///< its region of the largest area
};

/// By lowest region.
std::map<std::int32_t, BoxGroup> groups_of(const Mesh& mesh, const Partition& partition) {
  const auto boxed = [&](std::int32_t f) {
    const std::int32_t r = partition.face_region[f];
    return r != kNone && partition.region_locked[r] == kBoxed ? r : kNone;
  };
  detail::Forest forest(static_cast<std::size_t>(partition.region_count()));
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (const std::int32_t o = mesh.opposite(h); o > h) {
      const std::int32_t a = boxed(h / 3), b = boxed(o / 3);
      if (a != kNone && b != kNone && a != b) forest.join(a, b);
    }
  std::map<std::int32_t, BoxGroup> groups;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (boxed(f) == kNone) continue;
    BoxGroup& group = groups[forest.root(boxed(f))];
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      group.vertices.push_back(mesh.from(h));
      const std::int32_t o = mesh.opposite(h);
      if (const std::int32_t r = o == kNone ? kNone : partition.kept_region(o / 3); r != kNone)
        group.neighbour[r] += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
    }
  }
  for (std::int32_t r = 0; r < partition.region_count(); ++r)
    if (partition.region_locked[r] == kBoxed) {
      std::int32_t& largest = groups[forest.root(r)].largest;
      if (largest == kNone || partition.region_sum[r].weight > partition.region_sum[largest].weight) largest = r;
    }
  for (auto& [region, group] : groups) sort_unique(group.vertices);
  return groups;
}

/// The normal of the region that a box stands on; without one, of its own largest region.
Vec3 up_of(const BoxGroup& group, const Partition& partition) {
  const auto longest = std::ranges::max_element(group.neighbour, {}, [](const auto& n) { return n.second; });
  const Vec3& up = partition.region_normal[longest == group.neighbour.end() ? group.largest : longest->first];
  return up.norm() > 0 ? up.normalized() : Vec3(Vec3::UnitZ());
}

/// The corners; bit k of a number is set if the corner is at the far end along axis k.
std::array<Vec3, 8> corners_of(const BoxGroup& group, const Vec3& up, const Mesh& mesh) {
  Eigen::Matrix3d axes;  // in rows
  axes.row(0) = up.unitOrthogonal().transpose();
  axes.row(2) = up.transpose();
  axes.row(1) = up.cross(Vec3(axes.row(0).transpose())).transpose();
  std::vector<Eigen::Vector2d> flat;
  for (const std::int32_t v : group.vertices) flat.push_back((axes * mesh.vertices()[v]).head<2>());
  axes.topRows<2>() = (detail::least_box_turn(flat) * axes.topRows<2>()).eval();
  Vec3 low = axes * mesh.vertices()[group.vertices[0]], high = low;
  for (const std::int32_t v : group.vertices) {
    low = low.cwiseMin(axes * mesh.vertices()[v]);
    high = high.cwiseMax(axes * mesh.vertices()[v]);
  }
  high = high.cwiseMax(low + Vec3::Constant(kThinnest * (high - low).maxCoeff()));
  std::array<Vec3, 8> corners;
  for (int k = 0; k < 8; ++k)
    corners[k] =
        axes.transpose() * Vec3(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(), k & 4 ? high.z() : low.z());
  return corners;
}

}  // namespace

void add_enclosing_boxes(const Mesh& mesh, const Partition& partition, PolygonMesh& polygons) {
  if (std::ranges::count(partition.region_locked, kBoxed) == 0) return;
  for (const auto& [region, group] : groups_of(mesh, partition)) {
    const auto first = static_cast<std::int32_t>(polygons.vertices.size());
    for (const Vec3& corner : corners_of(group, up_of(group, partition), mesh)) {
      const auto away = [&](std::int32_t v) { return (mesh.vertices()[v] - corner).squaredNorm(); };
      polygons.source_vertex.push_back(*std::ranges::min_element(group.vertices, {}, away));
      polygons.vertices.push_back(corner + mesh.origin());
    }
    for (const auto& side : kSides) {
      polygons.loop_start.push_back(static_cast<std::int32_t>(polygons.loops.size()));
      polygons.polygon_region.push_back(region);
      polygons.planarity.push_back(0);
      for (const int corner : side) polygons.loops.push_back(first + corner);
    }
    ++polygons.report.boxes;
  }
  polygons.report.polygons = polygons.polygon_count();
  polygons.report.corners = static_cast<std::int32_t>(polygons.loops.size());
  polygons.report.vertices = static_cast<std::int32_t>(polygons.vertices.size());
  judge_topology(polygons);
}

}  // namespace isimp::meshing
