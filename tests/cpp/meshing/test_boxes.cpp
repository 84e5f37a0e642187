// Boxes that are added and moved: the results of a search against all boxes.
#include "judge/boxes.h"
#include "tests.h"

namespace isimp::meshing {
namespace {

class Moving {
 public:
  explicit Moving(unsigned seed) : random_(seed) {}

  void set_some(int count, int below) {
    for (int i = 0; i < count; ++i) {
      const auto index = static_cast<std::int32_t>(random_() % static_cast<unsigned>(below));
      if (index >= static_cast<std::int32_t>(boxes_.size())) boxes_.resize(index + 1, Box::nowhere());
      boxes_[index] = random_() % 10 == 0 ? Box::nowhere() : any_box();
      tree_.set(index, boxes_[index]);
    }
    tree_.settle();
  }

  [[nodiscard]] Box any_box() {
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = place_(random_);
      box.high[k] = box.low[k] + 0.1F * place_(random_);
    }
    return box;
  }

  void check() {
    for (int i = 0; i < 20; ++i) {
      const Box box = any_box();
      std::vector<std::int32_t> found, expected;
      tree_.for_each_near(box, [&](std::int32_t k) { found.push_back(k); });
      for (std::size_t k = 0; k < boxes_.size(); ++k)
        if (!boxes_[k].apart(box)) expected.push_back(static_cast<std::int32_t>(k));
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected);
    }
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<float> place_{0, 1};
  std::vector<Box> boxes_;
  MovingBoxes tree_;
};

TEST(MovingBoxes, FindsWhatAllPairsFind) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    Moving boxes(seed);
    boxes.set_some(200, 100);
    boxes.check();
    for (int round = 0; round < 30; ++round) {
      boxes.set_some(5, 100 + 10 * round);
      boxes.check();
    }
    boxes.set_some(300, 400);
    boxes.check();
  }
}

TEST(BoxTree, FindsPairsOfTwoTrees) {
  Moving some(1);
  for (const int count : {0, 1, 7, 9, 100, 333}) {
    std::vector<NumberedBox> a, b;
    for (int i = 0; i < count; ++i) {
      a.push_back({some.any_box(), i});
      b.push_back({some.any_box(), i});
    }
    std::vector<std::pair<int, int>> found, expected;
    for (const NumberedBox& x : a)
      for (const NumberedBox& y : b)
        if (!x.box.apart(y.box)) expected.emplace_back(x.index, y.index);
    const bool stopped = BoxTree(a).any_pair(BoxTree(b), [&](const NumberedBox& x, const NumberedBox& y) {
      found.emplace_back(x.index, y.index);
      return false;
    });
    EXPECT_FALSE(stopped);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace isimp::meshing
