// Assertions about the engine's own state: on in builds for tests, without effect in others.
#include "isimp/core/check.h"
#include "tests.h"

namespace isimp {
namespace {

TEST(Check, HoldsWithoutEffect) { EXPECT_NO_THROW(ISIMP_ASSERT(1 + 1 == 2, "sums are right")); }

#ifdef ISIMP_ASSERTIONS

TEST(Check, NamesTheStatementAndThePlace) {
  const std::vector<int> empty;
  try {
    ISIMP_ASSERT(!empty.empty(), "a region has faces");
    FAIL() << "the assertion let a false statement pass";
  } catch (const BrokenInvariant& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("a region has faces (!empty.empty()) at "), std::string::npos) << message;
    EXPECT_NE(message.find("test_check.cpp:"), std::string::npos) << message;
  }
}

TEST(CheckDeathTest, StandardLibraryChecksIndices) {
  const std::vector<int> two(2);
  volatile std::size_t past = 2;
  EXPECT_DEATH(static_cast<void>(two[past]), "Assertion");
}

#else

TEST(Check, IsNotEvaluatedWithoutTheOption) {
  int evaluated = 0;
  ISIMP_ASSERT(++evaluated < 0, "never looked at");
  EXPECT_EQ(evaluated, 0);
}

#endif

}  // namespace
}  // namespace isimp
