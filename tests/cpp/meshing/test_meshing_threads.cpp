// The polygons, and their report, are the same bit for bit on any number of threads.
#include <chrono>
#include <thread>

#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "tests.h"

namespace isimp {
namespace {

/// A mesh, its regions, and the entry of the report that shows that they are not easy.
struct Case {
  std::string name;
  std::function<Mesh()> mesh;
  std::function<Partition(const Mesh&)> regions;
  std::function<std::int32_t(const MeshingReport&)> hard;
};

void PrintTo(const Case& given, std::ostream* out) { *out << given.name; }

/// Leaves out faces that lie apart from each other.
shapes::Arrays pierced(shapes::Arrays a, std::size_t step) {
  std::vector<Triangle> left;
  for (std::size_t f = 0; f < a.triangles.size(); ++f)
    if (f % step != step / 2) left.push_back(a.triangles[f]);
  a.triangles = left;
  return a;
}

/// Waves that leave few polygons flat.
shapes::Arrays bumpy(shapes::Arrays a, double height) {
  for (Vec3& v : a.vertices) v *= 1 + height * std::sin(9 * v.x()) * std::sin(8 * v.y()) * std::sin(7 * v.z());
  return a;
}

std::function<Partition(const Mesh&)> voronoi(int count) {
  return [count](const Mesh& mesh) { return labelled::voronoi(mesh, count, 3); };
}

std::vector<Case> cases() {
  return {
      {"bent", [] { return shapes::mesh(bumpy(shapes::sphere(5), 0.2)); }, voronoi(300),
       [](const MeshingReport& r) { return r.split_for_repair; }},
      {"rough", [] { return shapes::mesh(shapes::noisy(shapes::torus(120, 60), 0.02, 5)); }, voronoi(250),
       [](const MeshingReport& r) { return r.repair_rounds - 3; }},
      {"holes", [] { return shapes::mesh(pierced(bumpy(shapes::torus(120, 60), 0.05), 231)); }, voronoi(40),
       [](const MeshingReport& r) { return r.split_for_holes; }},
      {"handles",
       [] {
         return shapes::mesh(shapes::both(shapes::torus(90, 40), shapes::torus(60, 30), {3, 0, 0}));
       },
       voronoi(3), [](const MeshingReport& r) { return r.split_for_handles; }},
      {"meeting",
       [] {
         return shapes::mesh(shapes::both(shapes::sphere(4), shapes::sphere(4), {1.1, 0.1, 0.2}));
       },
       voronoi(160), [](const MeshingReport& r) { return r.excused; }},
      {"many",  // so that threads have parts of the mesh, across which regions hang together
       [] { return shapes::mesh(shapes::shuffled(shapes::torus(checks::size(300, 200), checks::size(150, 100)), 2)); },
       voronoi(4), [](const MeshingReport& r) { return r.split_for_handles + r.split_for_holes; }},
      {"components", [] { return shapes::mesh(shapes::sphere(3)); },
       [](const Mesh& mesh) { return labelled::noise(mesh, 9, 7); },
       [](const MeshingReport& r) { return r.split_for_unconnected; }},
  };
}

class MeshingOnThreads : public testing::TestWithParam<Case> {};

TEST_P(MeshingOnThreads, GivesTheSameBits) {
  const Mesh mesh = GetParam().mesh();
  const Partition regions = GetParam().regions(mesh);
  std::int64_t polls_of_one = 0;
  PolygonMesh one;
  for (const std::int32_t threads : {1, 3, 8}) {
    Counting counting;
    PolygonMesh p = polygonize(mesh, regions, {.threads = threads}, counting.job);
    if (threads == 1) {
      one = std::move(p);
      polls_of_one = counting.polls;
      EXPECT_GT(GetParam().hard(one.report), 0);
      continue;
    }
    EXPECT_EQ(p.vertices, one.vertices) << threads << " threads";
    EXPECT_EQ(p.loops, one.loops) << threads << " threads";
    EXPECT_EQ(p.loop_start, one.loop_start) << threads << " threads";
    EXPECT_EQ(p.polygon_region, one.polygon_region) << threads << " threads";
    EXPECT_EQ(p.planarity, one.planarity) << threads << " threads";
    EXPECT_EQ(p.source_vertex, one.source_vertex) << threads << " threads";
    EXPECT_EQ(p.report, one.report) << threads << " threads";
    EXPECT_EQ(counting.polls, polls_of_one) << threads << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(Of, MeshingOnThreads, testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

TEST(MeshingOnThreads, ACancelOnAnyOfThemIsHeard) {
  const Case given = cases().front();
  const Mesh mesh = given.mesh();
  const Partition regions = given.regions(mesh);
  const auto caller = std::this_thread::get_id();
  std::atomic<bool> elsewhere{false};
  Job job;
  job.at_poll = [&] {
    if (std::this_thread::get_id() != caller) {
      elsewhere = true;
      job.cancel();
    } else if (!elsewhere) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // leaves something to do for the others
    }
  };
  EXPECT_THROW(polygonize(mesh, regions, {.threads = 4}, job), Cancelled);
  EXPECT_TRUE(elsewhere);
}

TEST(MeshingOnThreads, WantANumberOfThem) {
  const Mesh mesh = shapes::mesh(shapes::cube(2));
  const auto message = [&](std::int32_t threads) {
    return message_of([&] { polygonize(mesh, labelled::planes(mesh), {.threads = threads}, job()); });
  };
  EXPECT_EQ(message(-1), "threads must be at least 0, got -1");
  EXPECT_EQ(message(0), "no error");
}

}  // namespace
}  // namespace isimp
