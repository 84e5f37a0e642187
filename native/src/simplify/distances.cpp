// Distances of the scan's vertices from the polygons.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "exact_sums.h"
#include "isimp/core/errors.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/io.h"
#include "isimp/simplify/within.h"
#include "judge/boxes.h"

namespace isimp {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();  // mark
constexpr double kMargin =
    1e-7;  // rounding: margin of boxes, as a share of the diagonal, for the rounding of distances
constexpr std::int32_t kPollEvery = 64;  // work

/// The box of floats that contains one of doubles: rounded away from the middle.
meshing::Box box_between(const Vec3& low, const Vec3& high) {
  meshing::Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::nextafter(static_cast<float>(low[k]), -std::numeric_limits<float>::infinity());
    box.high[k] = std::nextafter(static_cast<float>(high[k]), std::numeric_limits<float>::infinity());
  }
  return box;
}

/// A triangle, with the values that do not depend on the point.
class Target {
 public:
  explicit Target(const std::array<Vec3, 3>& corners) : corner_(corners) {
    for (int k = 0; k < 3; ++k) {
      side_[k] = corner_[(k + 1) % 3] - corner_[k];
      square_[k] = detail::dot(side_[k], side_[k]);
    }
    normal_ = side_[0].cross(corner_[2] - corner_[0]);
    length_ = detail::norm(normal_);
  }
  [[nodiscard]] const std::array<Vec3, 3>& corners() const { return corner_; }
  [[nodiscard]] double distance(const Vec3& p) const {
    bool inside = length_ > 0;
    double nearest = kInfinite;
    for (int k = 0; k < 3; ++k) {
      const Vec3 away = p - corner_[k];
      const double along = detail::dot(away, side_[k]) / (square_[k] > 0 ? square_[k] : 1.0);
      const Vec3 foot = corner_[k] + std::clamp(along, 0.0, 1.0) * side_[k];
      nearest = std::min(nearest, detail::norm(p - foot));
      inside &= detail::dot(side_[k].cross(away), normal_) >= 0;
    }
    return inside ? std::abs(detail::dot(p - corner_[0], normal_)) / length_ : nearest;
  }

 private:
  std::array<Vec3, 3> corner_, side_;
  std::array<double, 3> square_{};
  Vec3 normal_;
  double length_;
};

/// The triangles of polygons, sorted by region.
struct Targets {
  std::vector<Target> all;
  std::vector<std::int32_t> first;  ///< (R + 1)

  Targets(const PolygonMesh& polygons, std::int32_t regions, Job& job)
      : first(static_cast<std::size_t>(regions) + 1, 0) {
    for (const std::int32_t region : polygons.polygon_region)
      if (region < 0 || region >= regions)
        throw InvalidInput("a polygon is of region " + std::to_string(region) + ", but there are " +
                           std::to_string(regions) + ": the polygons were made of another partition");
    const auto& [loops, start] = std::tie(polygons.loops, polygons.loop_start);
    const Triangulation cut =
        triangulate({polygons.vertices, {loops.begin(), loops.end()}, {start.begin(), start.end()}}, job);
    const auto region_of = [&](std::size_t t) { return polygons.polygon_region[cut.source_polygon[t]]; };
    for (std::size_t t = 0; t < cut.triangles.size(); ++t) ++first[region_of(t) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::int32_t> fill(first.begin(), first.end() - 1), order(cut.triangles.size());
    for (std::size_t t = 0; t < order.size(); ++t) order[fill[region_of(t)]++] = static_cast<std::int32_t>(t);
    all.reserve(order.size());
    for (const std::int32_t t : order) {
      const auto& [a, b, c] = cut.triangles[t];
      all.emplace_back(std::array<Vec3, 3>{polygons.vertices[a], polygons.vertices[b], polygons.vertices[c]});
    }
  }
};

/// Boxes of the triangles, relative to the mesh's origin.
meshing::BoxTree tree_of(const Targets& targets, const Vec3& origin) {
  std::vector<meshing::NumberedBox> entries;
  entries.reserve(targets.all.size());
  for (const Target& target : targets.all) {
    const auto& [a, b, c] = target.corners();
    entries.push_back({box_between(a.cwiseMin(b).cwiseMin(c) - origin, a.cwiseMax(b).cwiseMax(c) - origin),
                       static_cast<std::int32_t>(entries.size())});
  }
  return meshing::BoxTree(std::move(entries));
}

/// Distances of vertices from triangles.
class Measure {
 public:
  Measure(const Mesh& mesh, const Partition& partition, const Targets& targets)
      : mesh_(mesh), partition_(partition), targets_(targets) {}

  /// The distance from the triangles of the regions at a vertex; infinite without triangles, NaN without a region.
  [[nodiscard]] double from_own(std::int32_t vertex, std::vector<std::int32_t>& regions) const {
    regions.clear();
    const std::int32_t start = mesh_.vertex_halfedge()[vertex];
    for (std::int32_t h = start; h != kNone;) {
      const std::int32_t region = partition_.kept_region(Mesh::face(h));
      if (region != kNone && std::ranges::find(regions, region) == regions.end()) regions.push_back(region);
      h = mesh_.next_outgoing(h);
      if (h == start) break;
    }
    if (regions.empty()) return std::numeric_limits<double>::quiet_NaN();
    const Vec3 place = place_of(vertex);
    double least = kInfinite;
    for (const std::int32_t region : regions)
      for (std::int32_t t = targets_.first[region]; t < targets_.first[region + 1]; ++t)
        least = std::min(least, targets_.all[t].distance(place));
    return least;
  }

  /// The distance from all triangles, where the distance of one is known.
  [[nodiscard]] double from_all(std::int32_t vertex, double known, const meshing::BoxTree& tree) const {
    const Vec3 reach = Vec3::Constant(known + kMargin * mesh_.diagonal()), place = place_of(vertex);
    const Vec3& at = mesh_.vertices()[vertex];
    double least = known;
    (void)tree.any(box_between(at - reach, at + reach), [&](const meshing::NumberedBox& entry) {
      least = std::min(least, targets_.all[entry.index].distance(place));
      return false;
    });
    return std::isinf(least) ? std::numeric_limits<double>::quiet_NaN() : least;
  }

 private:
  /// The place of a vertex in the caller's coordinates, as in the polygons.
  [[nodiscard]] Vec3 place_of(std::int32_t vertex) const { return mesh_.vertices()[vertex] + mesh_.origin(); }

  const Mesh& mesh_;
  const Partition& partition_;
  const Targets& targets_;
};

}  // namespace

double distance_to_triangle(const Vec3& point, const std::array<Vec3, 3>& triangle) {
  return Target(triangle).distance(point);
}

std::vector<double> scan_distances(const Mesh& mesh, const Partition& partition, const PolygonMesh& polygons,
                                   const DistanceOptions& options, Job& job) {
  check_is_of(mesh, partition);
  job.poll();
  const Targets targets(polygons, partition.region_count(), job);
  const Measure measure(mesh, partition, targets);
  const Threads threads(options.threads);
  std::vector<double> distance(static_cast<std::size_t>(mesh.vertex_count()));
  threads.blocks(mesh.vertex_count(), options.block, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    std::vector<std::int32_t> regions;
    for (std::int32_t v = begin; v < end; ++v) {
      if (v % kPollEvery == 0) job.poll();
      distance[v] = measure.from_own(v, regions);
    }
  });
  std::vector<std::int32_t> far;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    if (distance[v] > options.enough || std::isinf(distance[v])) far.push_back(v);
  if (far.empty()) return distance;
  const meshing::BoxTree tree = tree_of(targets, mesh.origin());
  const auto count = static_cast<std::int32_t>(far.size());
  threads.blocks(count, options.block, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t k = begin; k < end; ++k) {
      if (k % kPollEvery == 0) job.poll();
      distance[far[k]] = measure.from_all(far[k], distance[far[k]], tree);
    }
  });
  return distance;
}

}  // namespace isimp
