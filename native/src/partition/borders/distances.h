#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/prefetch.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/options.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Sums of area * position and area * position * position^T over faces, each as its three corners: enough for the plane
/// of least squares.
struct Moments {
  double area = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(const Moments& m) { accumulate(m, 1); }
  void remove(const Moments& m) { accumulate(m, -1); }

 private:
  void accumulate(const Moments& m, double sign);
};

/// The distances of faces from the planes of their regions, a part of the error as that of the normals.
///
/// The error of a face is area * d^2 / (kLength side)^2, with d the distance of its corners from its region's plane of
/// least squares, root mean square, and `side` the side of a square as large as a mean region. The planes are fitted
/// again after each sweep only: for fixed planes a move costs O(1), and neither moves nor fits raise the error.
///
/// Lengths are shares of the root of the surface's area, so that scaling by a power of two changes no bit.
class Distances {
 public:
  using Corners = std::array<Vec3, 3>;

  /// \param regions  of the whole surface
  Distances(const Surface& surface, Metric metric, std::int64_t regions);

  /// The weight of the error of normals, relative to this one.
  [[nodiscard]] float of_normals() const { return of_normals_; }

  /// Sums up all regions and fits their planes.
  /// \param sums  of normals, by region
  /// Cost: O(F)
  template <class Labels>
  void sum_up(Labels labels, std::span<const RegionSum> sums, Job& job) {
    forget(sums.size());
    const std::int32_t n = graph_->size();
    for (std::int32_t i = 0; i < n; ++i) {
      if ((i & 0xffff) == 0) job.poll();
      if (i + kSoon < n) fetch_triangle(i + kSoon);
      if (i + kSoon / 2 < n) fetch_corners(i + kSoon / 2);
      if (const std::int32_t r = labels.get(i); r >= 0) add(i, r);
    }
    for (std::size_t r = 0; r < sums.size(); ++r) start(static_cast<std::int32_t>(r), sums[r]);
    knows_all_ = true;
  }

  /// Or one region after the other: forgets all of them, adds the faces of one, and fits its first plane.
  void forget(std::size_t regions);
  [[nodiscard]] bool knows(std::int32_t region) const { return known_[region] != 0; }
  [[nodiscard]] bool knows_all() const { return knows_all_; }
  void add(std::int32_t face, std::int32_t region) { moments_[region].add(moments(face)); }
  void start(std::int32_t region, const RegionSum& sum);

  [[nodiscard]] Corners corners(std::int32_t face) const {
    const Triangle& t = triangles_[graph_->mesh_face[face]];
    return {vertices_[t[0]] * unit_, vertices_[t[1]] * unit_, vertices_[t[2]] * unit_};
  }
  /// The error of a face in a region, for each unit of area.
  [[nodiscard]] double square(const Corners& face, std::int32_t region) const {
    const Plane& p = planes_[region];
    double sum = 0;
    for (const Vec3& c : face) {
      const double d = p.x * c.x() + p.y * c.y() + p.z * c.z() - p.offset;
      sum += d * d;
    }
    return sum / 3;
  }
  /// The error of all regions.
  [[nodiscard]] double error() const;

  /// Moves a face to another region, whose planes stay.
  void move(std::int32_t face, std::int32_t from, std::int32_t to);
  /// Fits the plane of a region again.
  void fit(std::int32_t region) { fit(region, kSteps); }

  /// Prefetches the data of `corners`: first the triangle, then its corners.
  void fetch_triangle(std::int32_t face) const { prefetch(&triangles_[graph_->mesh_face[face]]); }
  void fetch_corners(std::int32_t face) const {
    for (const std::int32_t v : triangles_[graph_->mesh_face[face]]) prefetch(&vertices_[v]);
  }

 private:
  struct Plane {
    double x = 0, y = 0, z = 0, offset = 0;  // the error of a corner is the square of (x, y, z) * corner - offset
  };
  // tuned distances
  static constexpr int kFirstSteps = 4, kSteps = 2;  // steps of the iteration that fits a plane
  static constexpr std::int32_t kSoon = 32;          // work: faces to prefetch ahead

  [[nodiscard]] Moments moments(std::int32_t face) const;
  void fit(std::int32_t region, int steps);

  std::span<const Vec3> vertices_;
  std::span<const Triangle> triangles_;
  const FaceGraph* graph_;
  float of_normals_;
  double unit_, scale_;  // shares of lengths for each scene unit; roots of errors for each such share
  std::vector<Moments> moments_;
  std::vector<Plane> planes_;
  std::vector<std::uint8_t> known_;
  bool knows_all_ = false;
};

}  // namespace isimp
