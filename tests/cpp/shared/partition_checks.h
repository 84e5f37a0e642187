#pragma once

#include "isimp/simplify/edges.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

namespace isimp::checks {

/// A sphere with noise.
inline const Mesh& bumpy() {
  static const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(checks::size(4, 3)), 0.003, 2));
  return mesh;
}

/// A ring with noise.
inline const Mesh& ring() {
  static const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(60, 30), 0.02, 5));
  return mesh;
}

/// A cube, and a separate cube so small that it is left out.
inline Mesh cube_and_speck() {
  return shapes::mesh(shapes::both(shapes::cube(6), shapes::scaled(shapes::cube(2), 0.02), {3, 3, 3}));
}

inline Partition run(const Mesh& mesh, const PartitionOptions& options) { return partition(mesh, options, job()); }
inline Partition run(const Mesh& mesh, std::int32_t proxies) { return run(mesh, {.proxies = proxies}); }

inline std::vector<std::int32_t> faces_of(const Partition& part, std::int32_t region) {
  std::vector<std::int32_t> faces;
  for (std::size_t f = 0; f < part.face_region.size(); ++f)
    if (part.face_region[f] == region) faces.push_back(static_cast<std::int32_t>(f));
  return faces;
}

/// The inner edges both ends of which satisfy a condition.
template <class Condition>
std::vector<VertexPair> edges_where(const Mesh& mesh, Condition holds) {
  std::vector<VertexPair> edges = inner_edges(mesh, job()).edges;
  std::erase_if(edges,
                [&](const VertexPair& e) { return !holds(mesh.vertices()[e[0]]) || !holds(mesh.vertices()[e[1]]); });
  return edges;
}

/// The least area of a face over its longest edge squared with which it counts: see make_face_graph.
inline constexpr double kLeastShape = 0.5e-12;

/// Error of a partition from its labels and normals, in double.
inline double error_of(const Mesh& mesh, const Partition& p) {
  double error = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.triangles()[f];
    const Vec3 u = mesh.vertices()[t[1]] - mesh.vertices()[t[0]], v = mesh.vertices()[t[2]] - mesh.vertices()[t[0]];
    const Vec3 doubled = u.cross(v);
    const double area = doubled.norm() / 2,
                 longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
    if (p.face_region[f] == kNone || area <= kLeastShape * longest) continue;
    error += area * (doubled.normalized() - p.region_normal[p.face_region[f]]).squaredNorm();
  }
  return error;
}

/// All promises of a partition for every mesh, except its history.
/// \param wanted  the number of regions; kNone: any
inline void expect_sound_regions(const Mesh& mesh, const Partition& p, std::int32_t wanted = kNone) {
  const std::int32_t regions = p.region_count();
  EXPECT_TRUE(wanted == kNone || regions == wanted) << regions << " regions, not " << wanted;
  ASSERT_EQ(p.face_region.size(), static_cast<std::size_t>(mesh.face_count()));
  ASSERT_EQ(p.region_normal.size(), p.region_seed.size());
  ASSERT_EQ(p.region_sum.size(), p.region_seed.size());
  std::vector<bool> seen(p.face_region.size(), false), met(p.region_seed.size(), false);
  std::vector<std::int32_t> faces(p.region_seed.size(), 0), stack;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t r = p.face_region[f];
    ASSERT_TRUE(r == kNone || (r >= 0 && r < regions)) << "face " << f << " has label " << r;
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (mesh.opposite(h) != kNone && r == kNone) {
        ASSERT_EQ(p.face_region[mesh.opposite(h) / 3], kNone) << "a component is left out in part only";
      }
    if (r == kNone || seen[f]) continue;
    ASSERT_FALSE(met[r]) << "region " << r << " is not connected";
    met[r] = seen[f] = true;
    stack.push_back(f);
    while (!stack.empty()) {
      const std::int32_t g = stack.back();
      stack.pop_back();
      ++faces[r];
      for (std::int32_t h = 3 * g; h < 3 * g + 3; ++h) {
        const std::int32_t other = mesh.opposite(h);
        if (other == kNone || seen[other / 3] || p.face_region[other / 3] != r) continue;
        seen[other / 3] = true;
        stack.push_back(other / 3);
      }
    }
  }
  for (std::int32_t r = 0; r < regions; ++r) {
    ASSERT_TRUE(met[r]) << "region " << r << " is empty";
    ASSERT_EQ(p.face_region[p.region_seed[r]], r);
    ASSERT_EQ(p.region_sum[r].faces, faces[r]);
    const double length = p.region_normal[r].norm();
    ASSERT_TRUE(std::abs(length - 1) < 1e-9 || length == 0);
  }
  EXPECT_NEAR(p.error, error_of(mesh, p), 1e-6 * mesh.report().area);
  ASSERT_FALSE(p.history.empty());
}

/// All promises of a partition for every mesh, where no round may end above the one before.
inline void expect_sound(const Mesh& mesh, const Partition& p, std::int32_t wanted = kNone) {
  expect_sound_regions(mesh, p, wanted);
  if (testing::Test::HasFatalFailure()) return;
  EXPECT_LE(p.error, *std::min_element(p.history.begin(), p.history.end()) + 1e-12 * mesh.report().area);
}

}  // namespace isimp::checks
