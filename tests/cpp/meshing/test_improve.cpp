// Corners keep their places while polygons change, and move one by one afterwards: nothing that was sound is spoilt.
#include "isimp/core/sorted.h"
#include "judge/bounds.h"
#include "judge/defects.h"
#include "labelled.h"
#include "place/improve.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

class Improved : public testing::Test {
 protected:
  Improved()
      : mesh_(shapes::mesh(shapes::noisy(shapes::sphere(4), 0.02, 7))),
        part_(labelled::voronoi(mesh_, 60, 3)),
        state_(mesh_, part_, options_, job_),
        defects_(state_, bounds_of(state_), job_) {
    state_.update({});
    defects_.judge(charts());
    state_.take_stale();
  }

  [[nodiscard]] std::vector<std::int32_t> charts() const { return numbers_below(state_.labels.chart_count()); }

  /// Splits every third chart, with corners where they are.
  void split_some() {
    for (std::int32_t l = 0; l < 60; l += 3) {
      state_.labels.face_marks.clear();
      state_.split(l, job_);
    }
    defects_.judge(state_.update_in_place({}));
  }

  const Mesh mesh_;
  const Partition part_;
  const MeshingOptions options_{.threads = 1};
  Job job_;
  State state_;
  Defects defects_;
};

TEST_F(Improved, SplitsMoveNoCornerThatThereWas) {
  const std::vector<Vec3> before = state_.corners.position;
  split_some();
  ASSERT_GT(state_.corners.count(), static_cast<std::int32_t>(before.size()));
  std::size_t used = 0;
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(before.size()); ++c) {
    used += !state_.polygons.at(c).empty();
    EXPECT_EQ(state_.corners.position[c], before[c]);
  }
  EXPECT_GT(used, 60U);
  const double reach = options_.reach * mesh_.diagonal();
  for (auto c = static_cast<std::int32_t>(before.size()); c < state_.corners.count(); ++c)
    if (!state_.polygons.at(c).empty()) {
      EXPECT_LE((state_.corners.position[c] - mesh_.vertices()[state_.corners.vertex[c]]).norm(), reach * (1 + 1e-9));
    }
}

TEST_F(Improved, MovesLeaveNoNewDefectAndWhatAnotherJudgeFinds) {
  split_some();
  const std::vector<bool> before = defects_.defective();
  std::vector<std::uint8_t> kinds;
  for (const std::int32_t l : charts()) kinds.push_back(defects_.kinds(l));
  const std::vector<Vec3> places = state_.corners.position;
  improve_places(state_, defects_, job_);
  std::size_t moved = 0;
  for (std::size_t c = 0; c < places.size(); ++c) moved += state_.corners.position[c] != places[c];
  EXPECT_GT(moved, 20U);
  const std::vector<bool> after = defects_.defective();
  for (const std::int32_t l : charts()) {
    EXPECT_FALSE(after[l] && !before[l]) << l;
    EXPECT_EQ(defects_.kinds(l) & ~kinds[l], 0) << l;
  }
  Defects again(state_, bounds_of(state_), job_);
  again.judge(charts());
  EXPECT_EQ(again.defective(), after);
  ASSERT_EQ(again.hits().size(), defects_.hits().size());
  for (std::size_t i = 0; i < again.hits().size(); ++i) EXPECT_EQ(again.hits()[i].key(), defects_.hits()[i].key());
}

TEST_F(Improved, CornersThatWerePutBackFindTheirPlacesAgain) {
  const std::vector<bool> defective = defects_.defective();
  std::vector<std::int32_t> corners;
  for (std::int32_t c = 0; c < state_.corners.count(); ++c) {
    const auto round = state_.polygons.at(c);
    if (!round.empty() &&
        std::none_of(round.begin(), round.end(), [&](auto q) { return defective[state_.polygons.chart(q)]; }))
      corners.push_back(c);
  }
  ASSERT_GT(corners.size(), 20U);
  const std::vector<Vec3> targets = state_.better_places(corners, true);
  const auto distance = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) sum += (state_.corners.position[corners[i]] - targets[i]).norm();
    return sum;
  };
  EXPECT_EQ(state_.take_stale(), std::vector<std::int32_t>()) << "to ask for places changes nothing";
  for (const std::int32_t c : corners) {
    state_.move(c, mesh_.vertices()[state_.corners.vertex[c]]);
    state_.mark_stale(c);
  }
  defects_.judge(charts());
  const double home = distance();
  improve_places(state_, defects_, job_);
  EXPECT_LT(distance(), 0.3 * home);
}

TEST_F(Improved, AMoveThatSpoilsAPolygonIsRefusedAndAnotherIsNot) {
  const std::vector<bool> defective = defects_.defective();
  int tried = 0;
  for (std::int32_t c = 0; c < state_.corners.count() && tried < 10; ++c) {
    std::vector<std::int32_t> round;
    for (const std::int32_t q : state_.polygons.at(c)) round.push_back(state_.polygons.chart(q));
    sort_unique(round);
    if (round.empty() || std::any_of(round.begin(), round.end(), [&](auto l) { return defective[l]; })) continue;
    ++tried;
    const Vec3 from = state_.corners.position[c];
    state_.move(c, -from);  // to the other side of the sphere
    EXPECT_FALSE(defects_.accepts(round, c));
    state_.move(c, from);
    EXPECT_TRUE(defects_.accepts(round, c));
  }
  EXPECT_EQ(tried, 10);
  defects_.renew_hits();
  EXPECT_EQ(defects_.defective(), defective);
}

}  // namespace
}  // namespace isimp::meshing
