#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "shapes.h"

namespace isimp {
namespace {

/// Two regions of a flat sheet with a border that zigzags.
Partition zigzag(const Mesh& mesh) {
  std::vector<std::int32_t> regions;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 middle = (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3;
    const double border = 0.5 + 0.08 * std::asin(std::sin(6 * std::numbers::pi * (middle.y() + 0.0625)));
    regions.push_back(middle.x() < border ? 0 : 1);
  }
  return labelled::by(std::move(regions));
}

Mesh sheet() { return shapes::mesh(shapes::plane(40)); }

PolygonMesh meshed(const Mesh& mesh, double reach, std::int32_t threads = 1) {
  Job job;
  return polygonize(mesh, zigzag(mesh), {.chord_tolerance = 0.05, .reach = reach, .threads = threads}, job);
}

TEST(Slide, KeepsCornersWithinReach) {
  const Mesh mesh = sheet();
  for (const double reach : {0.0, 0.01, 0.05}) {
    const PolygonMesh polygons = meshed(mesh, reach);
    EXPECT_LE(polygons.report.distance_max, reach * mesh.diagonal() + 1e-12);
    EXPECT_EQ(polygons.report.imperfect.size(), 0U);
  }
}

TEST(SlideThreads, DoNotChangeTheResult) {
  const Mesh mesh = sheet();
  EXPECT_EQ(meshed(mesh, 0.1, 1).vertices, meshed(mesh, 0.1, 3).vertices);
}

}  // namespace
}  // namespace isimp
