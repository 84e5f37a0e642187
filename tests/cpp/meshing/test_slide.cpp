#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "tests.h"

namespace isimp {
namespace {

/// Two regions of a flat sheet with a border that zigzags.
Partition zigzag(const Mesh& mesh) {
  return labelled::by(shapes::labels(mesh, [](const Vec3& middle) {
    const double border = 0.5 + 0.08 * std::asin(std::sin(6 * std::numbers::pi * (middle.y() + 0.0625)));
    return middle.x() < border ? 0 : 1;
  }));
}

Mesh sheet() { return shapes::mesh(shapes::plane(40)); }

PolygonMesh meshed(const Mesh& mesh, double reach, std::int32_t threads = 1) {
  return polygonize(mesh, zigzag(mesh), {.chord_tolerance = 0.05, .reach = reach, .threads = threads}, job());
}

TEST(Slide, KeepsCornersWithinReach) {
  const Mesh mesh = sheet();
  for (const double reach : {0.0, 0.01, 0.05}) {
    const PolygonMesh polygons = meshed(mesh, reach);
    EXPECT_LE(polygons.report.distance_max, reach * mesh.diagonal() + 1e-12);
    EXPECT_EQ(polygons.report.imperfect.size(), 0U);
  }
}

/// The corners of polygons that are sharper than 15 degrees.
int needles(const PolygonMesh& p) {
  int count = 0;
  for (std::int32_t q = 0; q < p.polygon_count(); ++q) {
    const std::int32_t begin = p.loop_start[q], n = p.loop_end(q) - begin;
    const auto at = [&](std::int32_t i) -> const Vec3& { return p.vertices[p.loops[begin + i % n]]; };
    for (std::int32_t i = 0; i < n; ++i) {
      const Vec3 back = at(i) - at(i + 1), on = at(i + 2) - at(i + 1);
      count += back.dot(on) > std::cos(std::numbers::pi / 12) * back.norm() * on.norm() ? 1 : 0;
    }
  }
  return count;
}

TEST(Slide, LeavesFewNeedles) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(120, 60), 0.004, 5));
  int found = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U})
    found += needles(polygonize(mesh, labelled::voronoi(mesh, 300, seed), {}, job()));
  EXPECT_LE(found, 8);
}

TEST(SlideThreads, DoNotChangeTheResult) {
  const Mesh mesh = sheet();
  EXPECT_EQ(meshed(mesh, 0.1, 1).vertices, meshed(mesh, 0.1, 3).vertices);
}

}  // namespace
}  // namespace isimp
