// Regions of many holes and scans that meet themselves everywhere: the results, and the length of their lists.
#include "isimp/mesh/clean.h"
#include "isimp/mesh/meet.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/partitioner.h"
#include "labelled.h"
#include "polygon_judge.h"
#include "tests.h"

namespace isimp {
namespace {

/// The plane of n by n squares without some of them.
shapes::Arrays with_hole(int n, const std::function<bool(int x, int y)>& is_open) {
  const shapes::Arrays whole = shapes::plane(n);
  shapes::Arrays a{whole.vertices, {}};
  for (const Triangle& t : whole.triangles) {
    const Vec3 middle = n * (whole.vertices[t[0]] + whole.vertices[t[1]] + whole.vertices[t[2]]) / 3;
    if (!is_open(static_cast<int>(middle.x()), static_cast<int>(middle.y()))) a.triangles.push_back(t);
  }
  return a;
}

/// The plane, n by n times three by three squares, without the middle one of each three by three.
shapes::Arrays perforated(int n) {
  return with_hole(3 * n, [](int x, int y) { return x % 3 == 1 && y % 3 == 1; });
}

TEST(ManyHoles, RowsOfHolesArePartedByRows) {
  for (const int n : {4, 12}) {
    const Mesh mesh = shapes::mesh(perforated(n));
    const Partition one = labelled::single(mesh);
    const PolygonMesh p = judge::sound(mesh, one);
    EXPECT_EQ(p.report.polygons, n + 1);
    EXPECT_EQ(p.report.split_for_holes, n);
    EXPECT_TRUE(p.report.imperfect.empty());
  }
}

TEST(ManyHoles, LongRowsArePartedAcross) {
  for (int n = 25; n <= checks::size(50, 25); n += 25) {
    const Mesh mesh = shapes::mesh(perforated(n));
    const Partition one = labelled::single(mesh);
    const PolygonMesh p = judge::sound(mesh, one);
    std::int32_t most = 0;
    for (std::int32_t q = 0; q < p.polygon_count(); ++q) most = std::max(most, p.loop_end(q) - p.loop_start[q]);
    EXPECT_LE(most, 128) << n;  // for any number of holes in a row
    EXPECT_LE(p.report.polygons, (n + 1) * (n / 12 + 1));
  }
}

TEST(ManyHoles, FewHolesTakeTwoPolygons) {
  const Mesh mesh = shapes::mesh(perforated(2));
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_EQ(p.report.polygons, 2);
}

/// The area of the smallest polygon.
double least_area(const PolygonMesh& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const judge::Loop& loop : judge::polygons_of(p)) {
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 0; i < loop.size(); ++i)
      area += p.vertices[loop[i]].cross(p.vertices[loop[(i + 1) % loop.size()]]) / 2;
    least = std::min(least, area.norm());
  }
  return least;
}

/// Noise enlarges the area of a flat region by a fifth: it is a wall all the same. Its hole is cut from two corners to the
/// next side.
TEST(ManyHoles, ARoughWallIsCutAtCornersOfItsHole) {
  shapes::Arrays flat = with_hole(60, [](int x, int y) { return x >= 6 && x < 14 && y >= 26 && y < 34; });
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.006);
  for (Vec3& v : flat.vertices) v.z() += noise(random);
  const Mesh mesh = shapes::mesh(flat);
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_EQ(p.report.polygons, 2);
  EXPECT_NEAR(least_area(p), 6 * 8 / 3600.0, 3 / 3600.0);
}

/// The nearest corners of a hole are at a notch. A strip between cuts from both would be a needle.
TEST(ManyHoles, TheTwoCutsOfAHoleAreApart) {
  const Mesh mesh = shapes::mesh(
      with_hole(30, [](int x, int y) { return (x >= 7 && x < 13 && y >= 12 && y < 18) || (x == 6 && y == 15); }));
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_EQ(p.report.polygons, 2);
  EXPECT_GE(least_area(p), 3 * 6 / 900.0);  // three squares wide, up to the side
}

/// A closed box of n by n cells with a square hole through the middle of each cell.
shapes::Arrays plate(int n, double height = 0.6) {
  return shapes::perforated(3 * n, 3 * n, height, [](int x, int y) { return x % 3 == 1 && y % 3 == 1; });
}

/// A region of a face of the plate with the walls of all holes: no polygon stands for both.
TEST(ManyHoles, WallsArePartedFromTheirPlate) {
  const int n = 5;
  const Mesh mesh = shapes::mesh(plate(n));
  ASSERT_TRUE(mesh.report().closed);
  std::vector<std::int32_t> region;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
    region.push_back((b - a).cross(c - a).z() < 0 ? 0 : 1);
  }
  const Partition two = labelled::by(region);
  const PolygonMesh p = judge::sound(mesh, two);
  EXPECT_TRUE(p.report.imperfect.empty());
  EXPECT_EQ(p.report.split_for_repair, 0);
  EXPECT_LE(p.report.planarity_max, 1e-12);
  EXPECT_LE(p.report.polygons, 4 * n * n + 4 + 2 * (n + 1));  // the walls, the sides, rows of both faces
}

/// Regions that end anywhere: a wall is in two regions, and some of them hold walls of two sides as discs.
TEST(ManyHoles, WallsAreWholeWhereverRegionsEnd) {
  const int n = 7;
  const Mesh mesh = shapes::mesh(plate(n));
  std::vector<std::int32_t> region;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    const bool is_rim = normal.x() > 0.9 && (a.x() > 3 * n - 1e-9 || a.y() > 3 * n - 4);
    region.push_back(is_rim ? 2 : normal.z() < 0 ? 0 : 1);
  }
  const Partition three = labelled::by(region);
  const PolygonMesh p = judge::sound(mesh, three);
  EXPECT_EQ(p.report.split_for_repair, 0);
  EXPECT_LE(p.report.planarity_max, 1e-12);
}

/// The number of upright polygons of a plate.
std::int32_t upright(const PolygonMesh& p, double height = 0.6) {
  std::int32_t count = 0;
  for (std::int32_t q = 0; q < p.polygon_count(); ++q) {
    const std::int32_t begin = p.loop_start[q];
    double low = p.vertices[p.loops[begin]].z(), high = low;
    for (std::int32_t i = begin; i < p.loop_end(q); ++i) {
      low = std::min(low, p.vertices[p.loops[i]].z());
      high = std::max(high, p.vertices[p.loops[i]].z());
    }
    count += high - low > height / 2 ? 1 : 0;
  }
  return count;
}

/// Six regions of the default method, which end anywhere on the walls and have some faces of other sides: all polygons
/// are as flat as the sides, and each side of a hole is one of them.
TEST(ManyHoles, FewFacesOfAnotherSideTiltNoPolygon) {
  for (const auto& [n, height] : {std::pair(4, 0.2), {5, 0.2}, {6, 0.2}, {8, 0.2}, {10, 0.6}, {20, 0.6}}) {
    const Mesh mesh = shapes::mesh(plate(n, height));
    const Partition six = partition(mesh, {.proxies = 6}, job());
    const PolygonMesh p = judge::sound(mesh, six);
    EXPECT_LE(p.report.planarity_max, 1e-6 * mesh.diagonal()) << n;
    EXPECT_EQ(p.report.split_for_repair, 0) << n;
    EXPECT_GE(upright(p, height), 4 * n * n + 4) << n;
    EXPECT_LE(upright(p, height), 4 * n * n + 4 + 6) << n;  // a region keeps its first chart
  }
}

/// The left and the right half of a plate, which share walls; not where a lock keeps the faces of one.
TEST(ManyHoles, AWallOfTwoRegionsIsOnePolygonUnlessOneIsLocked) {
  const int n = 4;
  const Mesh mesh = shapes::mesh(plate(n));
  Partition two = labelled::by(shapes::labels(mesh, [](const Vec3& p) { return p.x() + p.z() < 4.5 ? 0 : 1; }));
  const PolygonMesh shared = judge::sound(mesh, two);
  EXPECT_EQ(upright(shared), 4 * n * n + 4);
  two.region_locked = {1, 0};
  EXPECT_GT(upright(polygonize(mesh, two, {}, job())), 4 * n * n + 4);
}

/// The work a hole does not grow with the holes, for polygons and for regions.
TEST(ManyHoles, WorkAHoleStaysTheSame) {
  const auto work_a_hole = [](int n) {
    const Mesh mesh = shapes::mesh(plate(n, 0.2));
    Counting counting;
    const Partition six = partition(mesh, {.proxies = 6, .threads = 1}, counting.job);
    const std::int64_t partitioning = counting.polls;
    const MeshingWork work = polygonize(mesh, six, {}, job()).report.work;
    const double all = static_cast<double>(work.faces + work.corners + work.polygons);
    return std::array{static_cast<double>(partitioning) / (n * n), all / (n * n)};
  };
  const auto few = work_a_hole(checks::size(15, 8)), many = work_a_hole(checks::size(30, 16));
  EXPECT_LE(many[0], 1.5 * few[0]);
  EXPECT_LE(many[1], 1.5 * few[1]);
}

TEST(ManyHoles, HolesWithoutOrderAreCutToDiscs) {
  std::mt19937 random(4);
  const shapes::Arrays whole = shapes::noisy(shapes::plane(40), 0.002, 9);
  shapes::Arrays a{whole.vertices, {}};
  for (std::size_t f = 0; f < whole.triangles.size(); f += 2) {
    if (random() % 12 == 0) continue;
    a.triangles.push_back(whole.triangles[f]);
    a.triangles.push_back(whole.triangles[f + 1]);
  }
  const Mesh mesh = clean(a.vertices, a.triangles, {}, job());
  ASSERT_GT(mesh.report().border_loops, 60);
  const Partition one = labelled::single(mesh);
  const PolygonMesh p = judge::sound(mesh, one);
  EXPECT_LE(p.report.split_for_holes, mesh.report().border_loops / 2);
}

TEST(Soups, AllPairsAreCountedAndTheFirstListed) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(0, 1);
  shapes::Arrays a;
  for (std::int32_t f = 0; f < 300; ++f) {
    for (int k = 0; k < 3; ++k) a.vertices.emplace_back(any(random), any(random), any(random));
    a.triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  const Mesh mesh = shapes::mesh(a);
  std::vector<std::int32_t> each(300);
  for (std::int32_t f = 0; f < 300; ++f) each[f] = f;
  const PolygonMesh p = polygonize(mesh, labelled::by(each), {}, job());
  std::int64_t pairs = 0;
  const auto corners = [&](std::int32_t f) {
    Corners c;
    for (int k = 0; k < 3; ++k) c[k] = rounded_to_float(a.vertices[3 * f + k]);
    return c;
  };
  for (std::int32_t f = 0; f < 300; ++f)
    for (std::int32_t g = f + 1; g < 300; ++g)
      pairs += meet_elsewhere(a.triangles[f], corners(f), a.triangles[g], corners(g)) ? 1 : 0;
  ASSERT_GT(pairs, 2000);
  EXPECT_EQ(p.report.excused, pairs);
  EXPECT_FALSE(p.report.excused_at_least);
  EXPECT_EQ(p.report.intersecting, 0);
  ASSERT_EQ(p.report.imperfect.size(), 2000U);
  std::map<ListedDefect, int> listed;
  for (const ListedDefect& i : p.report.imperfect) ++listed[i];
  for (const auto& [i, times] : listed) {
    EXPECT_EQ(times, 1);
    EXPECT_TRUE(listed.contains({i.other, i.kind, i.polygon}));
  }
}

}  // namespace
}  // namespace isimp
