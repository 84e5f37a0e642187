#include <gtest/gtest.h>

#include <limits>

#include "isimp/core/errors.h"
#include "isimp/mesh/mesh.h"
#include "shapes.h"

namespace isimp {
namespace {

using shapes::Arrays;

std::string message_of(const Arrays& a) {
  try {
    shapes::mesh(a);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "no error";
}

TEST(Mesh, CubeIsClosedWithTwelveFaces) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  EXPECT_EQ(mesh.face_count(), 12);
  EXPECT_EQ(mesh.report().euler, 2);
  EXPECT_EQ(mesh.report().components, 1);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_DOUBLE_EQ(mesh.report().area, 6.0);
  EXPECT_DOUBLE_EQ(mesh.diagonal(), std::sqrt(3.0));
}

TEST(Mesh, OppositesPairUpAndRunAgainstEachOther) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::torus(12, 8), 3));
  EXPECT_EQ(mesh.report().euler, 0);
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    ASSERT_EQ(mesh.opposite(mesh.opposite(h)), h);
    ASSERT_EQ(mesh.from(mesh.opposite(h)), mesh.to(h));
  }
}

TEST(Mesh, TurnVisitsTheWholeFanOfABorderVertex) {
  const Mesh mesh = shapes::mesh(shapes::plane(3));
  EXPECT_EQ(mesh.report().border_edges, 12);
  EXPECT_EQ(mesh.report().border_loops, 1);
  std::int64_t visits = 0;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    for (std::int32_t h = mesh.vertex_halfedge()[v], start = h; h != kNone;) {
      EXPECT_EQ(mesh.from(h), v);
      ++visits;
      h = mesh.turn(h);
      if (h == start) break;
    }
  EXPECT_EQ(visits, 3 * mesh.face_count());
}

TEST(Mesh, BadInputIsNamed) {
  const Arrays cube = shapes::cube();
  Arrays a = cube;
  a.triangles.clear();
  EXPECT_EQ(message_of(a), "the mesh has no faces");
  a = cube;
  a.triangles[3][1] = 99;
  EXPECT_EQ(message_of(a), "face 3 uses vertex 99, but there are 8 vertices");
  a = cube;
  a.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of(a), "vertex 5 has a coordinate that is not finite; clean(...) repairs this");
  a = cube;
  a.triangles[2] = {1, 1, 2};
  EXPECT_EQ(message_of(a), "face 2 names vertex 1 twice; clean(...) repairs this");
  a = cube;
  std::swap(a.triangles[4][0], a.triangles[4][1]);
  EXPECT_NE(message_of(a).find("run the same way along the edge of vertices"), std::string::npos);
  a = cube;
  a.vertices.emplace_back(0.5, 0.5, 3.0);
  a.triangles.push_back({a.triangles[0][1], a.triangles[0][0], 8});
  EXPECT_NE(message_of(a).find("has three or more faces"), std::string::npos);
}

TEST(Mesh, TwoTrianglesThatTouchInAPointAreTwoFans) {
  const Arrays bow_tie{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(message_of(bow_tie), "the faces of vertex 0 form two or more fans; clean(...) repairs this");
}

TEST(FaceGraph, IsInBothOrdersTheSameAndEndsInASentinel) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::cube(4), 7));
  const FaceGraph& graph = mesh.graph();
  ASSERT_EQ(graph.size(), mesh.face_count());
  double area = 0;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    EXPECT_EQ(graph.graph_face[graph.mesh_face[i]], i);
    area += graph.faces[i].area;
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(graph.neighbours[i][k], graph.graph_face[mesh.opposite(3 * graph.mesh_face[i] + k) / 3]);
  }
  EXPECT_NEAR(area, 1.0, 1e-6);
  EXPECT_EQ(graph.neighbours[graph.size()][0], graph.size());
}

TEST(FaceGraph, AFaceWithoutAreaTakesItsNeighboursNormal) {
  // A unit square of two triangles with a flat third one between them: vertices 0, 2 and 4 lie on the diagonal.
  const Arrays a{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
                 {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {4, 2, 3}}};
  const Mesh mesh = shapes::mesh(a);
  EXPECT_EQ(mesh.report().zero_area_faces, 1);
  const FaceRecord& flat = mesh.graph().faces[mesh.graph().graph_face[1]];
  EXPECT_EQ(flat.area, 0.0F);
  EXPECT_EQ(flat.nz, 1.0F);
}

TEST(FaceGraph, TinyFacesBesideALongOneWithoutAreaHaveTheirShares) {
  Arrays a = shapes::plane(1);
  for (Vec3& p : a.vertices) p *= 1e-25;
  for (const double x : {1.0, 2.0, 3.0}) a.vertices.emplace_back(x, 0, 0);
  a.triangles.push_back({4, 5, 6});
  const Mesh mesh = shapes::mesh(a);
  EXPECT_EQ(mesh.report().zero_area_faces, 1);
  EXPECT_NEAR(mesh.report().area, 1e-50, 1e-60);
  for (const std::int32_t f : {0, 1}) EXPECT_NEAR(mesh.graph().faces[mesh.graph().graph_face[f]].area, 0.5F, 1e-6);
}

}  // namespace
}  // namespace isimp
