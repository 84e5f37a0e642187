// Undoing joined junctions restores the labels, and all charts are discs meanwhile.
#include "isimp/meshing/polygonize.h"
#include "labelled.h"
#include "repair/junctions.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

class Joins : public testing::Test {
 protected:
  Joins()
      : mesh_(shapes::mesh(shapes::noisy(shapes::sphere(5), 0.01, 1))),
        part_(labelled::voronoi(mesh_, 120, 5)),
        state_(mesh_, part_, options_, job_) {
    state_.update({});
    before_ = state_.labels.label;
    corners_ = corners();
    joins_ = join_junctions(state_, job_);
    EXPECT_GT(joins_.size(), 20U);
  }

  /// The number of polygons that meet in each vertex of the mesh.
  [[nodiscard]] std::vector<int> corners() const {
    std::vector<int> count(mesh_.vertex_count(), 0);
    for (std::int32_t l = 0; l < state_.labels.chart_count(); ++l)
      for (const std::int32_t h : state_.complex.chords(l)) ++count[mesh_.from(h)];
    return count;
  }
  void expect_discs() {
    for (std::int32_t l = 0; l < state_.labels.chart_count(); ++l) {
      EXPECT_EQ(state_.labels.label[state_.labels.charts[l].face], l);
      const std::vector<std::int32_t> faces = state_.labels.faces_of(l);
      EXPECT_EQ(std::count(state_.labels.label.begin(), state_.labels.label.end(), l), std::ssize(faces));
      EXPECT_TRUE(state_.labels.shape(faces, true).is_disc());
    }
  }

  const Mesh mesh_;
  const Partition part_;
  const MeshingOptions options_{.threads = 1};
  Job job_;
  State state_;
  std::vector<std::int32_t> before_;
  std::vector<int> corners_;
  std::vector<Join> joins_;
};

TEST_F(Joins, AllTakenBackLeaveWhatWas) {
  EXPECT_TRUE(take_back(state_, std::vector<bool>(120, true), joins_));
  EXPECT_TRUE(joins_.empty());
  EXPECT_EQ(state_.labels.label, before_);
  state_.update({});
  expect_discs();
  const std::vector<int> now = corners();
  for (std::size_t v = 0; v < now.size(); ++v) EXPECT_TRUE(corners_[v] < 3 || now[v] == corners_[v]) << v;
}

TEST_F(Joins, NoneIsTakenBackWithoutADefect) {
  const std::vector<std::int32_t> joined = state_.labels.label;
  const std::size_t count = joins_.size();
  EXPECT_FALSE(take_back(state_, std::vector<bool>(120, false), joins_));
  EXPECT_EQ(joins_.size(), count);
  EXPECT_EQ(state_.labels.label, joined);
  EXPECT_TRUE(state_.labels.touched.empty());
}

TEST_F(Joins, TakenBackChartByChartLeaveDiscs) {
  for (std::int32_t l = 0; l < 120; l += 7) {
    std::vector<bool> defective(120, false);
    defective[l] = true;
    take_back(state_, defective, joins_);
    for (const Join& join : joins_)
      EXPECT_EQ(std::count(join.charts.begin(), join.charts.end(), l), 0) << "chart " << l << " has a join still";
    state_.update({});
    expect_discs();
  }
  EXPECT_TRUE(take_back(state_, std::vector<bool>(120, true), joins_)) << "some were left";
  EXPECT_EQ(state_.labels.label, before_);
}

TEST(JoinsOfPolygons, AreTakenBackWhereMovingCornersDoesNotMendTheDefects) {
  // So rough that nearly all polygons meet others, for any corners.
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(5), 0.2, 1));
  const Partition part = labelled::voronoi(mesh, 120, 5);
  const MeshingOptions options{.flatness = 0.05, .threads = 1};  // else planes miss most places
  State state(mesh, part, options, job());
  state.update({});
  const std::size_t possible = join_junctions(state, job()).size();
  EXPECT_GT(possible, 4U);
  EXPECT_LT(polygonize(mesh, part, options, job()).report.joined_junctions, 0.5 * static_cast<double>(possible));
}

}  // namespace
}  // namespace isimp::meshing
