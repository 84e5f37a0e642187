// Pieces while polygons are made: those that are gone, and what is known of those that are united.
#include <gtest/gtest.h>

#include <vector>

#include "labelled.h"
#include "shapes.h"
#include "state.h"

namespace isimp::meshing {
namespace {

class Pieces : public testing::Test {
 protected:
  Pieces()
      : mesh_(shapes::mesh(shapes::noisy(shapes::plane(6), 0.01, 1))),
        part_(labelled::single(mesh_)),
        state_(mesh_, part_, options_, job_) {
    state_.update({});
    EXPECT_TRUE(state_.split(0, state_.find_cut(0, nullptr), job_));
    state_.update({});
  }

  const Mesh mesh_;
  const Partition part_;
  const MeshingOptions options_;
  Job job_;
  State state_;
};

TEST_F(Pieces, OneThatWasUnitedAfterItWasTouchedIsNotLookedAt) {
  state_.labels.touched.push_back(1);
  state_.unite(0, 1, state_.loop_together(0, 1));
  state_.update({});
  EXPECT_EQ(state_.polygons.count_of(1), 0);
  EXPECT_EQ(state_.polygons.count_of(0), 1);
  EXPECT_EQ(state_.polygons.count(), 1);
}

TEST_F(Pieces, AFaceThatStandsAloneIsNotTouchedByShatteringIt) {
  EXPECT_TRUE(state_.shatter(1));
  state_.update({});
  const std::int32_t last = state_.labels.piece_count() - 1;
  state_.shatter(last);
  state_.update({});
  EXPECT_FALSE(state_.shatter(last));
  EXPECT_TRUE(state_.labels.touched.empty());
}

TEST_F(Pieces, WhatIsKnownOfAUnionIsWhatItsFacesTell) {
  const Plane before = state_.planes[0];
  const Union u = state_.unite(0, 1, state_.loop_together(0, 1));
  state_.update({});
  const Plane found = plane_of(mesh_, state_.labels.faces_of(0)), known = state_.planes[0];
  EXPECT_NEAR(known.area, found.area, 1e-12);
  EXPECT_NEAR(known.projected, found.projected, 1e-12);
  EXPECT_LE((known.normal - found.normal).norm(), 1e-12);
  EXPECT_LE((known.centre - found.centre).norm(), 1e-12);
  EXPECT_LE((known.spread - found.spread).norm(), 1e-12);
  state_.part_again(u);
  state_.update({0, 1});
  EXPECT_EQ(state_.planes[0].normal, before.normal);
  EXPECT_EQ(state_.polygons.count(), 2);
}

}  // namespace
}  // namespace isimp::meshing
