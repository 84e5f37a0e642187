#include "judge/judge.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

MeshingReport judged(const Triangles& triangles, std::size_t vertices) {
  PolygonMesh mesh;
  mesh.vertices.resize(vertices);
  for (const auto& triangle : triangles) {
    mesh.loop_start.push_back(static_cast<std::int32_t>(mesh.loops.size()));
    mesh.loops.insert(mesh.loops.end(), triangle.begin(), triangle.end());
  }
  judge_topology(mesh);
  return mesh.report;
}

const Triangles kTetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(JudgeTopology, OfATetrahedronIsThatOfASphere) {
  const auto report = judged(kTetrahedron, 4);
  EXPECT_TRUE(report.closed);
  EXPECT_TRUE(report.manifold);
  EXPECT_EQ(report.euler, 2);
}

TEST(JudgeTopology, AnOpenMeshIsManifold) {
  const auto report = judged({{0, 1, 2}, {1, 0, 3}}, 4);
  EXPECT_FALSE(report.closed);
  EXPECT_TRUE(report.manifold);
}

TEST(JudgeTopology, FindsEdgesAndVerticesThatAreNotManifold) {
  Triangles pinched = kTetrahedron, turned = kTetrahedron;
  for (const auto& [a, b, c] : kTetrahedron) pinched.push_back({a + 3, b + 3, c + 3});
  turned[0] = {0, 1, 2};
  EXPECT_TRUE(judged(pinched, 7).closed);
  EXPECT_FALSE(judged(pinched, 7).manifold) << "two share a vertex";
  EXPECT_FALSE(judged(turned, 4).manifold) << "an edge is used twice in one direction";
  EXPECT_FALSE(judged({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5).manifold) << "three share an edge";
}

}  // namespace
}  // namespace isimp::meshing
