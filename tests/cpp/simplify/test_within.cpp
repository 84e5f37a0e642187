// The distance of the scan from its polygons, and polygons that keep a bound.

#include "isimp/mesh/io.h"
#include "isimp/simplify/within.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

struct Made {
  Mesh mesh = shapes::mesh(shapes::torus(40, 20));
  Partition part;
  PolygonMesh polygons;
  Made() {
    part = partition(mesh, {.bound = 0.1}, job());
    polygons = polygonize(mesh, part, {}, job());
  }
};

const Made& ring() {
  static const Made made;
  return made;
}

std::vector<double> distances(const DistanceOptions& options) {
  return scan_distances(ring().mesh, ring().part, ring().polygons, options, job());
}

TEST(Distances, AreToPlanesSidesAndCorners) {
  const std::array<Vec3, 3> triangle{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  EXPECT_EQ(distance_to_triangle({0.2, 0.2, 3}, triangle), 3);
  EXPECT_EQ(distance_to_triangle({0.5, -2, 0}, triangle), 2);
  EXPECT_EQ(distance_to_triangle({4, 0, 4}, triangle), 5);
  EXPECT_EQ(distance_to_triangle({0.2, 0.2, 0}, triangle), 0);
  const std::array<Vec3, 3> point{Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)};
  EXPECT_EQ(distance_to_triangle({1, 1, 3}, point), 2);
}

TEST(Distances, AreTheLeastToAnyTriangle) {
  const PolygonMesh& p = ring().polygons;
  const Triangulation cut =
      triangulate({p.vertices, {p.loops.begin(), p.loops.end()}, {p.loop_start.begin(), p.loop_start.end()}}, job());
  std::vector<double> wanted;
  for (const Vec3& v : ring().mesh.vertices()) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : cut.triangles)
      least = std::min(least, distance_to_triangle(v, {p.vertices[a], p.vertices[b], p.vertices[c]}));
    wanted.push_back(least);
  }
  EXPECT_EQ(distances({}), wanted);
  const double enough = 0.05;
  const std::vector<double> rough = distances({.enough = enough});
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    EXPECT_GE(rough[v], wanted[v]);
    EXPECT_TRUE(rough[v] <= enough || rough[v] == wanted[v]) << rough[v];
  }
  EXPECT_GT(*std::ranges::max_element(rough), enough) << "some are looked for among all";
}

TEST(DistancesThreads, DoNotChangeThemNorDoBlocks) {
  const std::vector<double> one = distances({.threads = 1});
  for (const std::int32_t threads : {2, 3})
    for (const std::int32_t block : {1, 7, 1 << 20}) EXPECT_EQ(distances({.threads = threads, .block = block}), one);
}

// Far from zero coordinates are kept relative to an origin, which the polygons are not.
TEST(Distances, AreTheSameFarFromZero) {
  shapes::Arrays arrays = shapes::torus(40, 20);
  const Vec3 far(1 << 22, 0, 1 << 20);
  for (Vec3& v : arrays.vertices) v = (v + far).eval();
  const Mesh mesh = shapes::mesh(arrays);
  ASSERT_FALSE(mesh.origin().isZero(0));
  const Partition part = partition(mesh, {.bound = 0.1}, job());
  const PolygonMesh polygons = polygonize(mesh, part, {}, job());
  const std::vector<double> away = scan_distances(mesh, part, polygons, {}, job()), near = distances({});
  EXPECT_NEAR(*std::ranges::max_element(away), *std::ranges::max_element(near), 0.01);
}

TEST(Distances, AreNoneWhereThereIsNoRegion) {
  const Mesh mesh = checks::cube_and_speck();
  const Partition part = partition(mesh, {.proxies = 6}, job());
  const std::vector<double> away = scan_distances(mesh, part, polygonize(mesh, part, {}, job()), {}, job());
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool left_out = part.face_region[Mesh::face(mesh.vertex_halfedge()[v])] == kNone;
    EXPECT_EQ(std::isnan(away[v]), left_out);
    EXPECT_TRUE(left_out || away[v] < 1e-9) << away[v];
  }
}

TEST(Distances, OfAnotherMeshOrPartitionAreRefused) {
  const Mesh cube = shapes::mesh(shapes::cube(2));
  const Partition six = partition(cube, {.proxies = 6}, job());
  EXPECT_EQ(message_of([&] { (void)scan_distances(cube, ring().part, ring().polygons, {}, job()); }),
            "the partition has 1600 faces and the mesh has 48: it was made for another mesh");
  const std::string said = message_of([&] { (void)scan_distances(cube, six, ring().polygons, {}, job()); });
  EXPECT_NE(said.find("but there are 6: the polygons were made of another partition"), std::string::npos) << said;
}

TEST(Distances, CanBeCancelledAtEveryPoll) {
  const auto run = [](Job& job) {
    (void)scan_distances(ring().mesh, ring().part, ring().polygons, {.threads = 1}, job);
  };
  Counting all;
  run(all.job);
  EXPECT_GT(all.polls, ring().mesh.vertex_count() / 64);
  for (int stop = 1; stop <= all.polls; ++stop) {
    Counting counting(stop);
    EXPECT_THROW(run(counting.job), Cancelled) << "at poll " << stop;
  }
}

TEST(BoundSearch, LowersWhatPolygonsUseUpAndThenTheBound) {
  BoundSearch search(1.0, true);
  std::vector<double> anew;
  double done = 0.0;
  int polygons = 0;
  while (const auto step = search.next()) {
    EXPECT_EQ(step->begin, done);
    EXPECT_GT(step->end, step->begin);
    EXPECT_LE(step->end, 1.0);
    done = step->end;
    if (step->anew) {
      anew.push_back(step->share);
      EXPECT_EQ(polygons % 3, 0);
      continue;
    }
    EXPECT_EQ(step->share, (std::array{1.0, 0.5, 0.25})[polygons % 3]);
    EXPECT_EQ(search.take(2.0 + (polygons == 1 ? -0.5 : 0.0)), polygons <= 1) << "nearer than all before";
    ++polygons;
  }
  EXPECT_EQ(anew, (std::vector{0.75, 0.5625, 0.421875, 0.31640625, 0.2373046875}));
  EXPECT_EQ(polygons, 18);
  EXPECT_EQ(search.tries(), 18);
}

TEST(BoundSearch, EndsWhereItIsNearEnough) {
  BoundSearch search(1.0, true);
  ASSERT_TRUE(search.next());
  EXPECT_TRUE(search.take(1.0));
  EXPECT_FALSE(search.next());
  BoundSearch once(1.0, false);
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(once.next());
    once.take(3.0);
  }
  EXPECT_FALSE(once.next()) << "the partition can not be made again";
}

}  // namespace
}  // namespace isimp
