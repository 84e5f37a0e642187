#include <span>

#include "density/normal_filter.h"
#include "isimp/partition/noise.h"
#include "tests.h"

namespace isimp {
namespace {

TEST(SurfaceSize, EqualsTheIntegralForAnyTriangles) {
  // A side of the unit cube is .5 from the centre; the mean of its squared distances is .25 + 2 / 12.
  const double expected = 3 * std::sqrt(0.25 + 2.0 / 12.0);
  EXPECT_NEAR(surface_size(shapes::mesh(shapes::cube(1))), expected, 1e-12);
  EXPECT_NEAR(surface_size(shapes::mesh(shapes::cube(7))), expected, 1e-12);
}

TEST(SurfaceSize, NeitherTurnsNorMoves) {
  shapes::Arrays torus = shapes::torus(24, 12);
  const double before = surface_size(shapes::mesh(torus));
  const Eigen::AngleAxisd turn(1.1, Vec3(1, 2, 3).normalized());
  for (Vec3& v : torus.vertices) v = turn * v + Vec3(1e5, -3e5, 2e5);
  EXPECT_NEAR(surface_size(shapes::mesh(torus)), before, 1e-9);
}

TEST(Noise, IsFoundOnPlanesAndCurvedSurfaces) {
  const auto ratio = [&](const shapes::Arrays& shape, double sigma) {
    return estimate_noise(shapes::mesh(shapes::noisy(shape, sigma, 5)), Threads(2), job()) / sigma;
  };
  for (const double sigma : {0.001, 0.004}) {
    EXPECT_NEAR(ratio(shapes::plane(60), sigma), 1.0, 0.1);
    EXPECT_NEAR(ratio(shapes::cube(40), sigma), 1.0, 0.2);  // its edges look like noise to some vertices
  }
  EXPECT_NEAR(ratio(shapes::sphere(5), 0.004), 1.0, 0.1);
}

TEST(Noise, OfOneThreadIsThatOfTheVertices) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(60), 0.002, 1));
  EXPECT_NEAR(estimate_noise(mesh, Threads(1), job()), 0.002, 0.0004);
}

TEST(Noise, ASampleShowsWhetherThereIsEnough) {
  const std::array sigmas{0.05, 0.0005, 0.004, 0.0};
  for (const double sigma : std::span(sigmas).first(checks::size(4, 2))) {
    const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(240), sigma, 5));  // 57,600 vertices
    const double noise = estimate_noise(mesh, Threads(2), job());
    for (const double share : {0.1, 0.9, 0.999, 1.001, 1.1, 10.0})
      EXPECT_EQ(is_noisier(mesh, share * std::max(noise, 1e-6), job()), noise > share * std::max(noise, 1e-6)) << sigma;
  }
}

TEST(Noise, IsZeroOnASmoothSurface) {
  EXPECT_LT(estimate_noise(shapes::mesh(shapes::sphere(5)), Threads(2), job()), 1e-4);
  EXPECT_EQ(estimate_noise(shapes::mesh(shapes::plane(9)), Threads(2), job()), 0.0);
}

/// A lump of few triangles of all shapes, as modellers draw and decimation leaves.
shapes::Arrays coarse(int levels, std::uint32_t seed) {
  shapes::Arrays a = shapes::sphere(levels);
  const shapes::Arrays moved = shapes::noisy(a, 0.45 / (1 << levels), seed);
  for (std::size_t v = 0; v < a.vertices.size(); ++v) {
    const Vec3 p = moved.vertices[v].normalized();
    a.vertices[v] = (1 + 0.4 * std::sin(4 * p.x() + 1) * std::sin(5 * p.y()) * std::cos(4 * p.z())) * p;
  }
  return a;
}

TEST(Noise, IsMostlyTakenForShapeOnACoarseCurvedMesh) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const Mesh mesh = shapes::mesh(coarse(3, seed));
    EXPECT_LT(estimate_noise(mesh, Threads(2), job()), 0.03 * mean_edge(mesh)) << seed;
  }
}

/// Cubes of n by n squares a side, forty of four sizes, as a drawn model has large parts and small ones.
shapes::Arrays cubes(int n) {
  shapes::Arrays all;
  for (int k = 0; k < 40; ++k) {
    shapes::Arrays one = shapes::cube(n);
    const auto first = static_cast<std::int32_t>(all.vertices.size());
    for (const Vec3& v : one.vertices) all.vertices.emplace_back((1 << k % 4) * v + Vec3(20.0 * k, 0, 0));
    for (Triangle t : one.triangles) {
      for (std::int32_t& v : t) v += first;
      all.triangles.push_back(t);
    }
  }
  return all;
}

TEST(Noise, IsTakenForShapeWhereItGrowsWithTheEdges) {
  EXPECT_EQ(estimate_noise(shapes::mesh(cubes(2)), Threads(2), job()), 0.0);
  EXPECT_EQ(estimate_noise(shapes::mesh(cubes(3)), Threads(2), job()), 0.0);
  const double sigma = 0.02;  // as much at edges of .06 as at edges of .5
  EXPECT_NEAR(estimate_noise(shapes::mesh(shapes::noisy(cubes(16), sigma, 5)), Threads(2), job()) / sigma, 1.0, 0.3);
}

TEST(Noise, IsFoundOnACoarseNoisyScan) {
  for (const double sigma : {0.01, 0.02})
    EXPECT_NEAR(estimate_noise(shapes::mesh(shapes::noisy(shapes::cube(12), sigma, 5)), Threads(2), job()) / sigma, 1.0,
                0.35);
}

TEST(Noise, IsTakenForShapeOnTwelveTriangles) {
  EXPECT_EQ(estimate_noise(shapes::mesh(shapes::cube(1)), Threads(2), job()), 0.0);
}

TEST(NormalFilter, RemovesNoiseAndKeepsCreases) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::cube(20), 0.005, 3));
  FaceGraph graph = mesh.graph();
  const double bend = median_bend(graph);
  graph.faces = filtered_faces(graph, 8, filter_range(bend), Threads(2), job());
  EXPECT_LT(median_bend(graph), bend / 5);
  // Every face of the cube faces along an axis again, also next to its edges.
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    const FaceRecord& f = graph.faces[i];
    EXPECT_GT(std::max({std::abs(f.nx), std::abs(f.ny), std::abs(f.nz)}), 0.97F);
  }
}

}  // namespace
}  // namespace isimp
