// The search for the closest face.
#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

#include "closest_faces.h"
#include "shapes.h"

namespace isimp {
namespace {

ClosestFaces all_of(const Mesh& mesh) {
  std::vector<std::int32_t> faces(mesh.face_count());
  std::iota(faces.begin(), faces.end(), 0);
  return {mesh, faces};
}

TEST(ClosestFaces, AreFoundFromAnyGuess) {
  const Mesh cube = shapes::mesh(shapes::cube(2));  // from 0 to 1
  const ClosestFaces faces = all_of(cube);
  const Vec3 above = Vec3(0.5, 0.5, 2.5) - cube.origin();
  for (const double guess : {0.0, 1.5, 100.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_NEAR(faces.find(above, Vec3::Zero(), guess).distance, 1.5, 1e-12);
  EXPECT_EQ(faces.find(above, Vec3::Zero(), 0.0, 1.0).face, kNone);
  EXPECT_EQ(faces.find(above, -Vec3::UnitZ(), 0.0).distance, 2.5) << "the face that faces down";
}

TEST(ClosestFaces, OfASurfaceInOnePointAreFound) {
  shapes::Arrays point = shapes::cube(1);
  for (Vec3& v : point.vertices) v.setZero();
  const Mesh mesh = shapes::mesh(point);
  EXPECT_EQ(all_of(mesh).find(Vec3(3, 0, 0), Vec3::Zero(), 0.0).distance, 3.0);
}

}  // namespace
}  // namespace isimp
