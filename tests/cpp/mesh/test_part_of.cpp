#include "isimp/mesh/part_of.h"
#include "tests.h"

namespace isimp {
namespace {

/// Sheets in one place are not one surface as a whole, and no part of them may become one.
TEST(Parts, KeepAllFacesAndJoinNoOthers) {
  const shapes::Arrays sheet = shapes::plane(1);
  const Mesh mesh = shapes::mesh(shapes::both(shapes::both(sheet, sheet, Vec3::Zero()), shapes::cube(2), {2, 0, 0}));
  std::vector<std::int32_t> all(static_cast<std::size_t>(mesh.face_count()));
  std::iota(all.begin(), all.end(), 0);
  const Mesh same = part_of(mesh, all, job());
  EXPECT_EQ(same.face_count(), mesh.face_count());
  EXPECT_EQ(same.component_count(), 3);
  // Two faces of the cube that share a vertex alone, one of them named twice.
  const std::int32_t first = 4, at = mesh.triangles()[first][0];
  std::int32_t other = first;
  const auto shared = [&](std::int32_t f) {
    const Triangle &a = mesh.triangles()[first], &b = mesh.triangles()[f];
    return std::ranges::count_if(a, [&](std::int32_t v) { return std::ranges::count(b, v) > 0; });
  };
  for (std::int32_t f = first + 1; f < mesh.face_count(); ++f)
    if (std::ranges::count(mesh.triangles()[f], at) > 0 && shared(f) == 1) other = f;
  ASSERT_NE(other, first);
  const Mesh two = part_of(mesh, std::vector{other, first, other}, job());
  EXPECT_EQ(two.face_count(), 2);
  EXPECT_EQ(two.vertex_count(), 6);
  EXPECT_EQ(two.source_face()[1], 1);
  EXPECT_EQ(std::ranges::count(two.source_vertex(), at), 2);
}

TEST(Parts, HaveTheSourcesThatAreGiven) {
  const Mesh mesh = shapes::mesh(shapes::cube(1));
  const Mesh part = part_of(mesh, std::vector<std::int32_t>{7, 2}, job(), std::vector<std::int32_t>{kNone, 40});
  EXPECT_EQ(part.source_face()[0], kNone);
  EXPECT_EQ(part.source_face()[1], 40);
}

}  // namespace
}  // namespace isimp
