// Planes of charts whose outermost faces belong to a rounded edge.
#include "complex/planes.h"
#include "isimp/core/sorted.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

constexpr int kRows = 20;

/// A level square of 20 x 20 pairs of faces, whose first `raised` rows rise to the side.
Mesh with_raised_rows(int raised) {
  shapes::Arrays a = shapes::plane(kRows);
  for (Vec3& v : a.vertices) v.z() = 0.5 * std::max(0.0, raised / static_cast<double>(kRows) - v.x());
  return shapes::mesh(a);
}

std::vector<std::uint8_t> outlying_of(const Mesh& mesh) {
  const std::vector<std::int32_t> one(static_cast<std::size_t>(mesh.face_count()), 0);
  return outlying_faces(mesh, one, 1, Threads(1), Job{});
}

TEST(Planes, DoNotTurnWithTheFacesOfARoundedEdge) {
  const Mesh mesh = with_raised_rows(2);
  const std::vector<std::int32_t> faces = numbers_below(mesh.face_count());
  const std::vector<std::uint8_t> outlying = outlying_of(mesh);
  const Vec3 with = best_normal(plane_of(mesh, faces)), without = best_normal(plane_of(mesh, faces, outlying));
  EXPECT_GT(std::acos(with.z()), 0.012);
  EXPECT_LT(std::acos(std::min(1.0, without.z())), 2e-4);
  EXPECT_EQ(std::count(outlying.begin(), outlying.end(), 1), 2 * 2 * kRows);
}

TEST(Planes, HaveNoOutliersInNoiseAndOnCurvedSurfaces) {
  const auto outliers = [](const shapes::Arrays& a) {
    const std::vector<std::uint8_t> found = outlying_of(shapes::mesh(a));
    return static_cast<double>(std::count(found.begin(), found.end(), 1)) / static_cast<double>(found.size());
  };
  EXPECT_LT(outliers(shapes::noisy(shapes::plane(kRows), 0.01, 1)), 0.02);
  shapes::Arrays bowl = shapes::plane(kRows);
  for (Vec3& v : bowl.vertices) v.z() = (v.x() - 0.5) * (v.x() - 0.5) + (v.y() - 0.5) * (v.y() - 0.5);
  EXPECT_EQ(outliers(bowl), 0);
  shapes::Arrays gutter = shapes::plane(kRows);
  for (Vec3& v : gutter.vertices) v.z() = (v.x() - 0.5) * (v.x() - 0.5);
  EXPECT_EQ(outliers(gutter), 0);
}

TEST(Planes, OfOutliersAloneArePlanes) {
  const Mesh mesh = with_raised_rows(2);
  const std::vector<std::uint8_t> outlying = outlying_of(mesh);
  std::vector<std::int32_t> faces;
  for (std::size_t f = 0; f < outlying.size(); ++f)
    if (outlying[f] != 0) faces.push_back(static_cast<std::int32_t>(f));
  ASSERT_FALSE(faces.empty());
  EXPECT_NEAR(best_normal(plane_of(mesh, faces, outlying)).dot(Vec3(1, 0, 2).normalized()), 1, 1e-9);
}

}  // namespace
}  // namespace isimp::meshing
