// Raggedness of borders.
#include "complex/raggedness.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

double raggedness_of(const shapes::Arrays& arrays, double window) {
  const Mesh mesh = shapes::mesh(arrays);
  const std::vector<std::int32_t> regions(mesh.face_count(), 0);
  return raggedness(mesh, regions, window);
}

TEST(Raggedness, ACleanCutHasNone) { EXPECT_NEAR(raggedness_of(shapes::plane(16), 4.0 / 16), 0, 1e-9); }

TEST(Raggedness, AnUnevenBorderHasSome) {
  EXPECT_GT(raggedness_of(shapes::noisy(shapes::plane(16), 0.02, 1), 4.0 / 16), 1e-3);
}

TEST(Raggedness, SmallCleanHolesDoNotOutvoteALongBorder) {
  shapes::Arrays arrays = shapes::noisy(shapes::plane(16), 0.02, 1), small = shapes::scaled(shapes::plane(8), 0.15);
  for (int k = 0; k < 6; ++k) arrays = shapes::both(arrays, small, {3, 1.0 * k, 0});
  EXPECT_GT(raggedness_of(arrays, 4.0 / 16), 1e-3);
}

TEST(Raggedness, WindowsAreNoShorterThanAnEdge) {
  const shapes::Arrays uneven = shapes::noisy(shapes::plane(16), 0.02, 1);
  const double of_edges = raggedness_of(uneven, 0);  // as of regions without area
  EXPECT_GE(of_edges, 0);
  EXPECT_EQ(raggedness_of(uneven, 1e-12), of_edges);
}

}  // namespace
}  // namespace isimp::meshing
