// Corners on the boundary between two halves of a sphere, where no third chart needs any.
#include "complex/complex.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

class Halves : public testing::Test {
 protected:
  Halves() : mesh_(shapes::mesh(shapes::sphere(3))), half_(above(mesh_)), labels_(mesh_), complex_(labels_, planes_) {
    label_charts(labels_, half_, Threads(1), job_);
    planes_.assign(planes_of(labels_, Threads(1), job_));
    complex_.tolerance = {10, 10, 10, 1};  // no chord has to be close
    complex_.refresh(std::vector<std::int32_t>{0, 1}, {loop(0), loop(1)}, job_);
  }

  static std::vector<std::int32_t> above(const Mesh& mesh) {
    std::vector<std::int32_t> half(static_cast<std::size_t>(mesh.face_count()));
    for (std::size_t f = 0; f < half.size(); ++f) {
      double z = 0;
      for (const std::int32_t v : mesh.triangles()[f]) z += mesh.vertices()[v].z();
      half[f] = z > 0 ? 1 : 0;
    }
    return half;
  }

  std::vector<std::int32_t> loop(std::int32_t chart) {
    for (const std::int32_t f : labels_.faces_of(chart))
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
        if (!labels_.inner(h)) return labels_.loop_from(h);
    return {};
  }

  const Job job_;
  const Mesh mesh_;
  const std::vector<std::int32_t> half_;
  Labels labels_;
  Logged<Plane> planes_;
  Complex complex_;
};

TEST_F(Halves, HaveTheSameCornersAndNotFewerThanThree) {
  ASSERT_EQ(labels_.chart_count(), 2);
  complex_.make_regular();
  std::vector<std::int32_t> corners[2];
  for (const std::int32_t l : {0, 1})
    for (const std::int32_t h : complex_.chords(l)) corners[l].push_back(mesh_.from(h));
  EXPECT_GE(corners[0].size(), 3U);
  std::reverse(corners[1].begin(), corners[1].end());
  std::rotate(corners[1].begin(), std::find(corners[1].begin(), corners[1].end(), corners[0][0]), corners[1].end());
  EXPECT_EQ(corners[0], corners[1]);
}

TEST_F(Halves, BendTheirChordWhereTheBoundaryIsFarthest) {
  const std::int32_t chord = complex_.chords(0)[0];
  const double depth = complex_.depth(chord);
  EXPECT_GT(depth, 0.1);  // a third of a great circle or so
  ASSERT_TRUE(complex_.bend(chord));
  EXPECT_LT(complex_.depth(chord), depth);
}

TEST_F(Halves, GetNoEndOfCornersWhereThePlaneIsNotANumber) {
  Plane none = planes_[0];
  none.normal = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  planes_.assign({none, none});
  complex_.tolerance.of_area = 0.01;
  complex_.refresh(std::vector<std::int32_t>{0, 1}, {loop(0), loop(1)}, job_);
  EXPECT_LE(complex_.chords(0).size(), complex_.loop(0).size());
}

/// A change of charts removes corners before it adds others: meanwhile a query of a chord returns, and the walk along
/// it ends.
TEST_F(Halves, CanBeAskedOfAChordWhoseCornersAreGone) {
  const std::int32_t chord = complex_.chords(0)[0];
  std::vector<std::int32_t> vertices;
  for (const std::int32_t h : complex_.loop(0)) vertices.push_back(mesh_.from(h));
  for (const std::int32_t v : vertices) EXPECT_TRUE(complex_.drop_corner(v));
  EXPECT_NEAR(complex_.depth(chord), 2, 0.2);  // a closed chord: the diameter
  EXPECT_TRUE(complex_.bend(chord));
}

}  // namespace
}  // namespace isimp::meshing
