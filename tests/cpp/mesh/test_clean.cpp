#include "isimp/mesh/clean.h"
#include "mesh_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::repair;
using checks::repaired;
using shapes::Arrays;

Mesh cleaned(const Arrays& a, double weld = 0.0) { return clean(a.vertices, a.triangles, {.weld = weld}, job()); }

std::int64_t all_repairs(const Mesh& mesh) {
  std::int64_t sum = 0;
  for (const Repair& r : mesh.report().repairs) sum += r.count;
  return sum;
}

/// Every kept face lies where the caller's face lay (halved edges apart).
void expect_in_place(const Mesh& mesh, const Arrays& a) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.triangles()[f]) {
      const Triangle& t = a.triangles[mesh.source_face()[f]];
      double nearest = 1e300;
      for (const std::int32_t corner : t) nearest = std::min(nearest, (a.vertices[corner] - mesh.vertices()[v]).norm());
      ASSERT_EQ(nearest, 0.0) << "face " << f;
    }
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    ASSERT_EQ(mesh.vertices()[v], a.vertices[mesh.source_vertex()[v]]) << "vertex " << v;
  }
}

/// Every face with three vertices of its own, as in an STL file.
Arrays unwelded(const Arrays& a) {
  Arrays soup;
  for (const Triangle& t : a.triangles) {
    const auto n = static_cast<std::int32_t>(soup.vertices.size());
    for (const std::int32_t v : t) soup.vertices.push_back(a.vertices[v]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  return soup;
}

/// A strip of n squares whose ends meet after half a turn.
Arrays moebius(int n) {
  Arrays a;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * i / n;
    for (const double s : {-0.3, 0.3})
      a.vertices.emplace_back((1 + s * std::cos(u / 2)) * std::cos(u), (1 + s * std::cos(u / 2)) * std::sin(u),
                              s * std::sin(u / 2));
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const bool last = i == n - 1;
    const std::int32_t a0 = 2 * i, a1 = 2 * i + 1, b0 = last ? 1 : 2 * i + 2, b1 = last ? 0 : 2 * i + 3;
    a.triangles.push_back({a0, b0, b1});
    a.triangles.push_back({a0, b1, a1});
  }
  return a;
}

/// The mesh with vertices at the same places merged.
Arrays fused(const Arrays& a) {
  Arrays result;
  std::vector<std::int32_t> place;
  for (const Vec3& p : a.vertices) {
    std::size_t i = 0;
    while (i < result.vertices.size() && (result.vertices[i] - p).norm() > 1e-9) ++i;
    if (i == result.vertices.size()) result.vertices.push_back(p);
    place.push_back(static_cast<std::int32_t>(i));
  }
  for (const auto& [i, j, k] : a.triangles) result.triangles.push_back({place[i], place[j], place[k]});
  return result;
}

TEST(Clean, FacesThatWeldingDropsAreNamed) {
  const Vec3 place(1, 2, 3);
  EXPECT_EQ(
      message_of([&] {
        clean({place, place, place}, {{0, 1, 2}}, {}, job());
      }),
      "no usable face is left: after vertices at the same position were welded, no face has three different ones");
}

TEST(Clean, LeavesASoundMeshAsItIs) {
  for (const Arrays& a : {shapes::cube(3), shapes::shuffled(shapes::torus(9, 7), 5), shapes::plane(4)}) {
    const Mesh mesh = cleaned(a);
    EXPECT_EQ(all_repairs(mesh), 0);
    ASSERT_EQ(mesh.vertex_count(), a.vertices.size());
    ASSERT_EQ(mesh.face_count(), a.triangles.size());
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) EXPECT_EQ(mesh.vertices()[v], a.vertices[v]);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      EXPECT_EQ(mesh.triangles()[f], a.triangles[f]);
      EXPECT_EQ(mesh.source_face()[f], f);
    }
  }
}

TEST(Clean, DropsBrokenAndDuplicateFacesAndUnusedVerticesAndListsThem) {
  Arrays a = shapes::cube();  // faces 0 to 11
  const Triangle third = a.triangles[3];
  a.vertices.emplace_back(std::nan(""), 0, 0);            // vertex 8
  a.vertices.emplace_back(0, 1e31, 0);                    // vertex 9
  a.vertices.emplace_back(5, 5, 5);                       // vertex 10, unused
  a.triangles.push_back({0, 1, 8});                       // 12
  a.triangles.push_back({4, 4, 5});                       // 13
  a.triangles.push_back(third);                           // 14
  a.triangles.push_back({third[1], third[0], third[2]});  // 15, turned over
  a.triangles.push_back({9, 1, 2});                       // 16
  a.triangles.insert(a.triangles.begin(), {7, 0, 7});     // the indices of the others increase by one
  const Mesh mesh = cleaned(a);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.face_count(), 12);
  EXPECT_EQ(mesh.source_face()[0], 1);
  EXPECT_EQ(repair(mesh, "non_finite_faces").where, (std::vector<std::int32_t>{13, 17}));
  EXPECT_EQ(repair(mesh, "repeated_index_faces").where, (std::vector<std::int32_t>{0, 14}));
  EXPECT_EQ(repair(mesh, "duplicate_faces").where, (std::vector<std::int32_t>{15, 16}));
  EXPECT_EQ(repair(mesh, "unused_vertices").where, (std::vector<std::int32_t>{8, 9, 10}));
  EXPECT_EQ(all_repairs(mesh), 2 + 2 + 2 + 3);
}

TEST(Clean, TurnsTheLongestEdgeOfAFaceWithoutArea) {
  // The square of test_mesh: vertex 4 is on the diagonal, face 1 is flat. It takes half of face 0.
  const Arrays a{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
                 {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {4, 2, 3}}};
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.face_count(), 4);
  EXPECT_EQ(mesh.report().zero_area_faces, 0);
  EXPECT_EQ(mesh.report().border_edges, 4);
  EXPECT_NEAR(mesh.report().area, 1, 1e-12);
  EXPECT_EQ(repair(mesh, "turned_edges").where, (std::vector<std::int32_t>{1}));
  // The neighbours are kept up to date: a new search finds the same.
  const Mesh again({mesh.vertices().begin(), mesh.vertices().end()}, {mesh.triangles().begin(), mesh.triangles().end()},
                   job());
  EXPECT_TRUE(std::ranges::equal(again.opposite(), mesh.opposite()));
}

TEST(Clean, TurnsFacesWithoutAreaThatLieInARow) {
  // Triangles on both sides of the line y = 0, six vertices on it, and between them four flat faces folded to and fro.
  const Arrays a{{{4, -2, 0}, {6, 0, 0}, {4, 0, 0}, {2, 0, 0}, {1, 0, 0}, {3, 0, 0}, {5, 0, 0}, {3, 2, 0}},
                 {{0, 1, 2}, {0, 2, 3}, {3, 2, 4}, {2, 1, 6}, {2, 6, 4}, {4, 6, 5}, {5, 6, 7}, {4, 5, 7}}};
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.face_count(), 8);
  EXPECT_EQ(mesh.report().zero_area_faces, 0);
  EXPECT_EQ(mesh.report().border_edges, 6);
  EXPECT_NEAR(mesh.report().area, 8, 1e-12);
  for (const Triangle& t : mesh.triangles())  // none faces away
    EXPECT_GT((mesh.vertices()[t[1]] - mesh.vertices()[t[0]]).cross(mesh.vertices()[t[2]] - mesh.vertices()[t[0]]).z(),
              0);
}

TEST(Clean, KeepsFacesWithoutAreaThatCanNotBeTurned) {
  // A flat face along the border, and one whose other diagonal is an edge already.
  const Arrays border{{{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{1, 0, 2}, {1, 2, 3}, {2, 0, 3}}};
  EXPECT_EQ(cleaned(border).report().zero_area_faces, 1);
  const Arrays folded{{{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 0, 3}, {3, 2, 1}, {3, 0, 2}}};
  const Mesh mesh = cleaned(folded);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.report().zero_area_faces, 1);
  EXPECT_EQ(all_repairs(mesh), 0);
}

TEST(Clean, ClosesAnStlSoup) {
  const Arrays torus = shapes::torus(12, 8);
  const Mesh mesh = cleaned(unwelded(torus));
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.report().euler, 0);
  EXPECT_EQ(mesh.vertex_count(), torus.vertices.size());
  EXPECT_EQ(repaired(mesh, "welded_vertices"), 3 * 192 - 96);
  EXPECT_EQ(repaired(mesh, "unused_vertices"), 0);
  expect_in_place(mesh, unwelded(torus));
}

TEST(Clean, WeldsWithinTheToleranceOnly) {
  const Arrays soup = shapes::noisy(unwelded(shapes::cube(2)), 1e-6, 2);
  EXPECT_EQ(cleaned(soup).report().components, 48);
  const Mesh mesh = cleaned(soup, 1e-4);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.vertex_count(), 26);
  EXPECT_EQ(mesh.report().components, 1);
}

TEST(Clean, WeldsNegativeZeroToZero) {
  const Arrays a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {0, 1, -0.0}, {-1, 0, 0}}, {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_EQ(cleaned(a).report().components, 1);
}

TEST(Clean, DoesNotWeldClosedPartsThatTouch) {
  const Arrays a = shapes::both(shapes::cube(2), shapes::cube(2), {1, 0, 0});  // share a whole side
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(all_repairs(mesh), 0);
  EXPECT_EQ(mesh.report().components, 2);
}

TEST(Clean, WeldsThatCloseNothingAreNotMade) {
  const Arrays a = shapes::both(shapes::plane(), shapes::plane(), {1, 1, 0});  // corner to corner
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.vertex_count(), 8);
  EXPECT_EQ(all_repairs(mesh), 0);
}

TEST(Clean, ATriangleThatWeldingFoldsIsDropped) {
  // A square of two triangles and a third one as a sliver in the slit between them: 2 and 4 are at the same place.
  const Arrays a{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}}};
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.face_count(), 2);
  EXPECT_EQ(mesh.report().border_edges, 4);
  EXPECT_EQ(repair(mesh, "repeated_index_faces").where, (std::vector<std::int32_t>{1}));
  EXPECT_EQ(repaired(mesh, "welded_vertices"), 1);
}

TEST(Clean, TurnsTheFewerFacesByArea) {
  Arrays a = shapes::sphere(2);
  std::vector<std::int32_t> turned;
  for (std::int32_t f = 0; f < 320; f += 3) {
    std::swap(a.triangles[f][0], a.triangles[f][1]);
    turned.push_back(f);
  }
  const Mesh mesh = cleaned(a);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(repaired(mesh, "flipped_faces"), 107);
  turned.resize(16);
  EXPECT_EQ(repair(mesh, "flipped_faces").where, turned);
  const auto& [i, j, k] = mesh.triangles()[0];
  const auto p = mesh.vertices();
  EXPECT_GT((p[j] - p[i]).cross(p[k] - p[i]).dot(p[i]), 0.0);
}

TEST(Clean, CutsAMoebiusStripAlongALine) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const Mesh mesh = cleaned(shapes::shuffled(moebius(20), seed));
    EXPECT_EQ(repaired(mesh, "cut_edges"), 1);  // one edge is the whole width
    EXPECT_EQ(repaired(mesh, "split_vertices"), 2);
    EXPECT_EQ(mesh.report().components, 1);
    EXPECT_EQ(mesh.report().euler, 1);  // a disc
    EXPECT_EQ(mesh.face_count(), 40);
  }
}

TEST(Clean, TakesAFinOffACube) {
  Arrays a = shapes::cube();
  const auto n = static_cast<std::int32_t>(a.vertices.size());
  a.vertices.emplace_back(2, -1, 0.5);
  std::int32_t low = 0, high = 0;  // the edge from (1, 0, 0) to (1, 0, 1)
  for (std::int32_t v = 0; v < n; ++v) {
    if (a.vertices[v] == Vec3(1, 0, 0)) low = v;
    if (a.vertices[v] == Vec3(1, 0, 1)) high = v;
  }
  for (const Triangle& fin : {Triangle{low, high, n}, Triangle{high, low, n}}) {
    Arrays b = a;
    b.triangles.push_back(fin);
    const Mesh mesh = cleaned(b);
    EXPECT_EQ(mesh.report().components, 2);
    EXPECT_EQ(mesh.report().closed_components, 1);
    EXPECT_EQ(repaired(mesh, "split_edges"), 1);
    EXPECT_EQ(repaired(mesh, "split_vertices"), 2);
    EXPECT_EQ(all_repairs(mesh), 3);
    expect_in_place(mesh, b);
  }
}

TEST(Clean, SplitsTheVertexOfABowTie) {
  const Arrays a{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.vertex_count(), 6);
  EXPECT_EQ(mesh.source_vertex()[5], 0);
  EXPECT_EQ(repair(mesh, "split_vertices").where, (std::vector<std::int32_t>{0}));
  EXPECT_EQ(mesh.report().components, 2);
}

TEST(Clean, SolidsThatShareAnEdgeOrAVertexAreSeparated) {
  for (const Vec3& offset : {Vec3(1, 1, 0), Vec3(1, -1, 0), Vec3(0, 1, 1), Vec3(1, 1, 1), Vec3(-1, 1, 1)})
    for (const std::uint32_t seed : {1U, 2U}) {
      const Arrays a = shapes::shuffled(fused(shapes::both(shapes::cube(2), shapes::cube(2), offset)), seed);
      const Mesh mesh = cleaned(a);
      EXPECT_EQ(mesh.report().closed_components, 2);
      EXPECT_EQ(mesh.vertex_count(), 52);
      EXPECT_EQ(all_repairs(mesh), offset.cwiseAbs().sum() == 2 ? 2 + 3 : 1);
      expect_in_place(mesh, a);
    }
}

TEST(Clean, CubesGluedAtASideStaySolidOnOneSideOfTheWall) {
  // Both walls become one, since the second is a duplicate of the first: three faces an edge all around it.
  const Arrays a = fused(shapes::both(shapes::cube(), shapes::cube(), {1, 0, 0}));
  const Mesh mesh = cleaned(a);
  EXPECT_EQ(mesh.report().components, 2);
  EXPECT_EQ(mesh.report().closed_components, 1);
  EXPECT_EQ(mesh.report().border_edges, 4);
  EXPECT_EQ(repaired(mesh, "split_edges"), 4);
}

TEST(Clean, HalvesAnEdgeWhereASolidTouchesItselfAndStaysOne) {
  // Two slabs joined by two columns that share the edge from (1, 1, 1) to (1, 1, 2). All faces around either end of the
  // edge are connected once the columns are separated along it, so that vertices alone can't separate them.
  Arrays a;
  for (const int z : {0, 2})
    for (const int x : {0, 1})
      for (const int y : {0, 1}) a = shapes::both(a, shapes::cube(), Vec3(x, y, z));
  a = shapes::both(a, shapes::cube(), {0, 0, 1});
  a = fused(shapes::both(a, shapes::cube(), {1, 1, 1}));
  const std::vector<Triangle> all = a.triangles;
  const auto is_wall = [&](const Triangle& t) {  // between two cubes, so that it is there twice
    const auto sorted = [](Triangle u) { return std::sort(u.begin(), u.end()), u; };
    return std::count_if(all.begin(), all.end(), [&](const Triangle& u) { return sorted(u) == sorted(t); }) > 1;
  };
  std::erase_if(a.triangles, is_wall);
  const Mesh mesh = cleaned(a);
  EXPECT_TRUE(mesh.report().closed);
  EXPECT_EQ(mesh.report().components, 1);
  EXPECT_EQ(mesh.report().euler, 0);  // one handle: the way through between slabs and columns
  EXPECT_EQ(repaired(mesh, "split_edges"), 1);
  EXPECT_EQ(repaired(mesh, "subdivided_edges"), 1);
  EXPECT_EQ(all_repairs(mesh), 2);
  EXPECT_EQ(mesh.face_count(), a.triangles.size() + 2);
  EXPECT_EQ(mesh.source_vertex().back(), kNone);
  EXPECT_EQ(mesh.vertices().back(), Vec3(1, 1, 1.5));
}

/// A square with a long edge, and a strip of short edges beside it.
Arrays sheet_and_strip(double gap) {
  constexpr std::int32_t kEdges = 100;
  Arrays a{{{0, 0, 0}, {1000, 0, 0}, {1000, -1000, 0}, {0, -1000, 0}}, {{0, 2, 1}, {0, 3, 2}}};
  for (std::int32_t i = 0; i <= kEdges; ++i) {
    const std::int32_t k = 4 + 2 * i;
    a.vertices.emplace_back(10 * i, gap, 0);
    a.vertices.emplace_back(10 * i, 100, 0);
    if (i == kEdges) break;
    a.triangles.push_back({k, k + 2, k + 1});
    a.triangles.push_back({k + 1, k + 2, k + 3});
  }
  return a;
}

TEST(Clean, StitchesALongEdgeToVerticesThatAreVeryNear) {
  const Arrays a = sheet_and_strip(0.005);
  const Mesh mesh = clean(a.vertices, a.triangles, {.stitch = 0.01}, job());
  EXPECT_EQ(mesh.report().components, 1);
  EXPECT_EQ(mesh.report().border_loops, 1);
  EXPECT_GE(repaired(mesh, "stitched_vertices"), 101);
}

/// Two strips of equal edges, the upper one moved along the border between them.
Arrays two_strips(double shift) {
  constexpr std::int32_t kEdges = 50;
  Arrays a;
  for (const double side : {-1.0, 1.0})
    for (std::int32_t i = 0; i <= kEdges; ++i) {
      const double x = 10.0 * i + (side > 0 ? shift : 0.0);
      const auto k = static_cast<std::int32_t>(a.vertices.size());
      a.vertices.emplace_back(x, side * 0.0025, 0);
      a.vertices.emplace_back(x, side * 10, 0);
      if (i == kEdges) continue;
      const std::int32_t first = side > 0 ? k + 2 : k + 1, second = side > 0 ? k + 1 : k + 2;
      a.triangles.push_back({k, first, second});
      a.triangles.push_back({k + 3, second, first});
    }
  return a;
}

TEST(Clean, StitchesVerticesToTheEndsThatTheyAreNear) {
  for (const double shift : {2.0, 8.0}) {
    const Arrays a = two_strips(shift);
    const Mesh mesh = clean(a.vertices, a.triangles, {.stitch = 0.01}, job());
    EXPECT_EQ(mesh.report().components, 1) << shift;
    EXPECT_LE(mesh.face_count(), static_cast<std::int32_t>(a.triangles.size())) << shift << ": no edge is divided";
  }
}

TEST(Clean, StitchesNothingWithinAVerySmallLength) {
  const Arrays a = sheet_and_strip(0.005);
  for (const double length : {1e-9, 1e-300, 5e-324}) {
    const Mesh mesh = clean(a.vertices, a.triangles, {.weld = length, .stitch = length}, job());
    EXPECT_EQ(mesh.report().components, 2) << length;
  }
}

TEST(Clean, PollsWhileItSearchesForBordersNearEachOther) {
  constexpr std::int32_t kTriangles = checks::size(700, 350);
  const Arrays one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  Arrays soup;
  for (std::int32_t i = 0; i < kTriangles; ++i) {
    for (const Vec3& v : one.vertices) soup.vertices.push_back(v + Vec3(0, 0, 2 * i));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto polls = [&](double length) {
    Counting counting;
    (void)clean(soup.vertices, soup.triangles, {.stitch = length, .threads = 1}, counting.job);
    return counting.polls.load();
  };
  // Each border edge is compared to each other one: 50 ms are some 2 million pairs.
  const double pairs = std::pow(3.0 * kTriangles, 2);
  EXPECT_GE(static_cast<double>(polls(1e6) - polls(0)), pairs / 2e6 + 3 * kTriangles / 1024.0 * 4);
}

TEST(Clean, NamesTheInvalidInput) {
  const auto said = [](const Arrays& a, double weld = 0.0) { return message_of([&] { cleaned(a, weld); }); };
  Arrays a = shapes::cube();
  a.triangles[3][1] = 99;
  EXPECT_EQ(said(a), "face 3 uses vertex 99, but there are 8 vertices");
  a.triangles.clear();
  EXPECT_EQ(said(a), "the mesh has no faces");
  a = {{{0, 0, 0}, {1, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0}}, {{0, 1, 2}, {0, 0, 1}}};
  EXPECT_EQ(said(a), "no usable face is left: of 2 faces 1 have a corner that is not finite and 1 use a vertex twice");
  EXPECT_EQ(said(shapes::cube(), -1), "weld must be a finite length, at least 0, got -1");
}

TEST(Clean, StopsWhenCancelledButReportsBadInputFirst) {
  Job job;
  job.cancel();
  const Arrays a = shapes::cube();
  EXPECT_THROW(clean(a.vertices, a.triangles, {}, job), Cancelled);
  EXPECT_THROW(clean(a.vertices, {{0, 1, 99}}, {}, job), InvalidInput);
}

}  // namespace
}  // namespace isimp
