// Joins that are undone in reverse order.
#include <gtest/gtest.h>

#include "isimp/core/undo_forest.h"

namespace isimp {
namespace {

TEST(UndoForest, JoinsAreUndoneInReverse) {
  detail::UndoForest forest(6);
  EXPECT_TRUE(forest.join(0, 1));
  EXPECT_TRUE(forest.join(2, 3));
  const std::size_t two = forest.joins();
  EXPECT_TRUE(forest.join(1, 3));
  EXPECT_FALSE(forest.join(0, 2));
  EXPECT_TRUE(forest.join(4, 0));
  EXPECT_EQ(forest.root(4), forest.root(3));
  forest.undo(two);
  EXPECT_EQ(forest.root(0), forest.root(1));
  EXPECT_EQ(forest.root(2), forest.root(3));
  EXPECT_NE(forest.root(0), forest.root(2));
  EXPECT_EQ(forest.root(4), 4);
  forest.undo(0);
  for (std::int32_t i = 0; i < 6; ++i) EXPECT_EQ(forest.root(i), i);
  EXPECT_EQ(forest.joins(), 0U);
}

}  // namespace
}  // namespace isimp
