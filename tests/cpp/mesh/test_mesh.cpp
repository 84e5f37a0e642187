#include "isimp/mesh/mesh.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

std::string said(const Arrays& a) {
  return message_of([&] { shapes::mesh(a); });
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
      h = mesh.next_outgoing(h);
      if (h == start) break;
    }
  EXPECT_EQ(visits, 3 * mesh.face_count());
}

TEST(Mesh, BadInputIsNamed) {
  const Arrays cube = shapes::cube();
  Arrays a = cube;
  a.triangles.clear();
  EXPECT_EQ(said(a), "the mesh has no faces");
  a = cube;
  a.triangles[3][1] = 99;
  EXPECT_EQ(said(a), "face 3 uses vertex 99, but there are 8 vertices");
  a = cube;
  a.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(said(a), "vertex 5 has a coordinate that is not finite; clean(...) repairs this");
  a = cube;
  a.triangles[2] = {1, 1, 2};
  EXPECT_EQ(said(a), "face 2 uses vertex 1 twice; clean(...) repairs this");
  a = cube;
  std::swap(a.triangles[4][0], a.triangles[4][1]);
  EXPECT_NE(said(a).find("have opposite orientations at the edge of vertices"), std::string::npos);
  a = cube;
  a.vertices.emplace_back(0.5, 0.5, 3.0);
  a.triangles.push_back({a.triangles[0][1], a.triangles[0][0], 8});
  EXPECT_NE(said(a).find("has three or more faces"), std::string::npos);
}

TEST(Mesh, TwoTrianglesThatTouchInAPointAreTwoFans) {
  const Arrays bow_tie{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(said(bow_tie), "the faces of vertex 0 form two or more fans; clean(...) repairs this");
}

using Edge = std::pair<std::int32_t, std::int32_t>;

/// Part of the verdict on a mesh, by the definition: each edge is run along once at most each way, and the faces of
/// each vertex are one fan.
std::string verdict_on(const std::vector<Triangle>& triangles) {
  std::set<Edge> seen;
  std::map<std::int32_t, std::vector<Edge>> around;  // by vertex, the ends of the side of each face that faces it
  for (const auto& [a, b, c] : triangles) {
    for (const Edge& edge : {Edge{a, b}, Edge{b, c}, Edge{c, a}})
      if (!seen.insert(edge).second) return "the edge of vertices";
    around[a].emplace_back(b, c);
    around[b].emplace_back(c, a);
    around[c].emplace_back(a, b);
  }
  for (auto& [vertex, left] : around) {
    std::set<std::int32_t> fan{left.front().first};
    for (bool grown = true; grown;) {
      const auto out = std::remove_if(left.begin(), left.end(), [&](const Edge& side) {
        if (!fan.contains(side.first) && !fan.contains(side.second)) return false;
        fan.insert({side.first, side.second});
        return true;
      });
      grown = out != left.end();
      left.erase(out, left.end());
    }
    if (!left.empty()) return "two or more fans";
  }
  return "no error";
}

TEST(Mesh, AcceptsExactlySoundArrays) {
  std::mt19937 random(1);
  int sound = 0;
  for (int run = 0; run < 4000; ++run) {
    // The same few vertices, or a hub with more edges than are searched one by one.
    const bool hub = run % 4 == 0;
    const std::uint32_t vertices = hub ? 40 : 4 + random() % 5;
    Arrays a{std::vector<Vec3>(vertices, Vec3(0, 0, 0)), {}};
    const auto some = [&] { return static_cast<std::int32_t>(random() % vertices); };
    if (hub)
      for (std::int32_t v = 1; v + 1 < 32; ++v) a.triangles.push_back({0, v, v + 1});
    for (std::uint32_t k = hub ? random() % 3 : 1 + random() % 6; k > 0; --k) {
      Triangle t{hub ? 0 : some(), some(), some()};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) a.triangles.push_back(t);
    }
    if (a.triangles.empty()) continue;
    std::shuffle(a.triangles.begin(), a.triangles.end(), random);
    std::vector<std::int32_t> name(vertices);  // so that the hub is not always the lowest
    for (std::uint32_t v = 0; v < vertices; ++v) name[v] = static_cast<std::int32_t>(v);
    std::shuffle(name.begin(), name.end(), random);
    for (Triangle& t : a.triangles)
      for (std::int32_t& v : t) v = name[v];
    const std::string verdict = verdict_on(a.triangles), message = said(a);
    ASSERT_NE(message.find(verdict), std::string::npos) << "run " << run << ": " << message << ", not " << verdict;
    sound += verdict == "no error" ? 1 : 0;
  }
  EXPECT_GT(sound, 400);
  EXPECT_LT(sound, 3600);
}

TEST(FaceGraph, FollowsTheCurve) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::plane(150), 7));
  std::vector<std::pair<std::uint64_t, std::int32_t>> order;
  for (const std::int32_t f : mesh.graph().mesh_face) {
    Vec3 middle(0, 0, 0);
    for (const std::int32_t v : mesh.triangles()[f]) middle += mesh.vertices()[v];
    std::uint64_t place = 0;
    for (int bit = 0; bit < 11; ++bit)
      for (int k = 0; k < 3; ++k)
        place |= (static_cast<std::uint64_t>(middle[k] / 3 * 2047) >> bit & 1) << (3 * bit + k);
    order.emplace_back(place, f);
  }
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
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

TEST(FaceGraph, TinyFacesNextToALongOneWithoutAreaHaveTheirShares) {
  Arrays a = shapes::scaled(shapes::plane(1), 1e-25);
  for (const double x : {1.0, 2.0, 3.0}) a.vertices.emplace_back(x, 0, 0);
  a.triangles.push_back({4, 5, 6});
  const Mesh mesh = shapes::mesh(a);
  EXPECT_EQ(mesh.report().zero_area_faces, 1);
  EXPECT_NEAR(mesh.report().area, 1e-50, 1e-60);
  for (const std::int32_t f : {0, 1}) EXPECT_NEAR(mesh.graph().faces[mesh.graph().graph_face[f]].area, 0.5F, 1e-6);
}

}  // namespace
}  // namespace isimp
