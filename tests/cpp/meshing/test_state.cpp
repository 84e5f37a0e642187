// Charts while polygons are made: removed ones, and the defects on united ones.
#include "complex/joins.h"
#include "complex/state.h"
#include "complex/transaction.h"
#include "labelled.h"
#include "repair/junctions.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

class Charts : public testing::Test {
 protected:
  Charts()
      : mesh_(shapes::mesh(shapes::noisy(shapes::plane(6), 0.01, 1))),
        part_(labelled::single(mesh_)),
        state_(mesh_, part_, options_, job_) {
    state_.update({});
    EXPECT_TRUE(state_.split(0, job_));
    state_.update({});
  }

  const Mesh mesh_;
  const Partition part_;
  const MeshingOptions options_;
  Job job_;
  State state_;
};

TEST_F(Charts, OneThatWasUnitedAfterItWasTouchedIsNotLookedAt) {
  state_.touch(std::vector<std::int32_t>{1});
  state_.unite(0, 1, state_.loop_together(0, 1));
  state_.update({});
  EXPECT_EQ(state_.polygons.count_of(1), 0);
  EXPECT_EQ(state_.polygons.count_of(0), 1);
  EXPECT_EQ(state_.polygons.count(), 1);
}

TEST_F(Charts, AFaceThatStandsAloneIsNotTouchedByShatteringIt) {
  EXPECT_TRUE(state_.shatter(1));
  state_.update({});
  const std::int32_t last = state_.labels.chart_count() - 1;
  state_.shatter(last);
  state_.update({});
  EXPECT_FALSE(state_.shatter(last));
  EXPECT_TRUE(state_.labels.touched.empty());
}

TEST_F(Charts, WhatIsKnownOfAUnionIsWhatItsFacesTell) {
  const Plane before = state_.planes[0];
  Transaction transaction(state_);
  state_.unite(0, 1, state_.loop_together(0, 1));
  state_.update({});
  const Plane found = plane_of(mesh_, state_.labels.faces_of(0), state_.labels.outlying), known = state_.planes[0];
  EXPECT_NEAR(known.area, found.area, 1e-12);
  EXPECT_NEAR(known.projected, found.projected, 1e-12);
  EXPECT_LE((known.normal - found.normal).norm(), 1e-12);
  EXPECT_LE((known.centre - found.centre).norm(), 1e-12);
  EXPECT_LE((known.spread - found.spread).norm(), 1e-12);
  transaction.rollback();
  EXPECT_EQ(state_.planes[0].normal, before.normal);
  EXPECT_EQ(state_.polygons.count(), 2);
}

TEST(Handovers, LeaveChartsWhatTheirFacesTell) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(6), 0.0005, 3));  // 81,920 faces
  const Partition part = labelled::voronoi(mesh, 40, 1);
  const MeshingOptions options;
  State state(mesh, part, options, job());
  state.update({});
  const std::vector<Plane> before = state.planes;
  const std::int64_t walked = state.labels.walked;
  std::vector<Join> joins = join_junctions(state, job());
  EXPECT_LT(state.labels.walked - walked, mesh.face_count() / 4) << "few faces are looked at again";
  ASSERT_GE(joins.size(), 5U);
  const auto check = [&] {
    const std::vector<Plane> found = planes_of(state.labels, Threads(1), job());
    for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
      const Plane &a = state.planes[l], &b = found[l];
      EXPECT_NEAR(a.area, b.area, 1e-12);
      EXPECT_LE((a.normal - b.normal).norm(), 1e-11);
      EXPECT_LE((a.centre - b.centre).norm(), 1e-11);
      EXPECT_LE((a.spread - b.spread).norm(), 1e-12);
      std::vector<std::int32_t> loop(state.complex.loop(l).begin(), state.complex.loop(l).end());
      std::vector<std::int32_t> traced = state.labels.loop_from(loop[0]);
      EXPECT_EQ(loop, traced);
      for (const std::int32_t h : loop) EXPECT_EQ(state.labels.label[h / 3], l);
    }
  };
  check();
  std::vector<bool> defective(state.labels.chart_count(), false);
  for (const Join& join : joins) defective[join.taker] = true;
  ASSERT_TRUE(take_back(state, defective, joins));
  EXPECT_TRUE(joins.empty());
  state.update({});
  check();
  for (std::size_t l = 0; l < before.size(); ++l) EXPECT_LE((state.planes[l].centre - before[l].centre).norm(), 1e-11);
}

/// A side that faces along x, one that faces along y at its far end, and a strip at its near end that is turned by 50
/// degrees, with a cap. The strip, whose first face is the mesh's, is no side of its own: it joins the first side.
TEST(Walls, AStripGoesWithTheSideBesideIt) {
  const Vec3 a(-0.23, 0.193, 0), up(0, 0, 1);
  const std::vector<Vec3> vertices{
      a, a + up, Vec3::Zero(), up, Vec3(0, -4, 0), {0, -4, 1}, Vec3(4, -4, 0), Vec3(4, -4, 1), Vec3(-3, -3, 1)};
  const std::vector<Triangle> triangles{{1, 3, 2}, {2, 0, 1}, {4, 2, 3}, {4, 3, 5}, {6, 4, 5}, {6, 5, 7}, {3, 1, 8}};
  const Mesh mesh = shapes::mesh({vertices, triangles});
  const Partition one = labelled::single(mesh);
  Labels labels(mesh);
  label_charts(labels, one.face_region, Threads(1), job());
  Cutter cutter(labels);
  EXPECT_EQ(cut_by_direction(cutter, 0), 2);
  EXPECT_EQ(labels.label[0], labels.label[2]);
  std::size_t faces = 0;
  for (std::int32_t l = 0; l < labels.chart_count(); ++l) {
    EXPECT_EQ(labels.label[labels.charts[l].face], l) << "a chart is named by a face of its own";
    faces += labels.faces_of(l).size();
  }
  EXPECT_EQ(faces, triangles.size());
}

}  // namespace
}  // namespace isimp::meshing
