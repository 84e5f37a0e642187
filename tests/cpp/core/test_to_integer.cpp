#include "isimp/core/to_integer.h"
#include "tests.h"

namespace isimp {
namespace {

TEST(ToInteger, KeepsTheWholePartInsideTheRange) {
  EXPECT_EQ(to_integer(2.9, 0, 10), 2);
  EXPECT_EQ(to_integer(-2.9, -10, 10), -2);
  EXPECT_EQ(to_integer(10.5F, 0, 10), 10);
  EXPECT_EQ(to_integer(-0.5, 0, 10), 0);
  static_assert(to_integer(254.5F, std::uint8_t{0}, std::uint8_t{255}) == 254);
}

TEST(ToInteger, ReturnsAnEndForNumbersThatTheTypeCannotHold) {
  constexpr auto kLow = std::numeric_limits<std::int32_t>::min(), kHigh = std::numeric_limits<std::int32_t>::max();
  constexpr auto kLong = std::numeric_limits<std::int64_t>::max();
  for (const double most : {1e30, 1e300, std::numeric_limits<double>::infinity(), 2147483647.0, 2147483648.0}) {
    EXPECT_EQ(to_integer(most, kLow, kHigh), kHigh);
    EXPECT_EQ(to_integer(-most * 2, kLow, kHigh), kLow);
    EXPECT_EQ(to_integer(static_cast<float>(most), kLow, kHigh), kHigh);
  }
  EXPECT_EQ(to_integer(std::numeric_limits<double>::quiet_NaN(), 3, 10), 3);
  EXPECT_EQ(to_integer(std::numeric_limits<float>::quiet_NaN(), 3, 10), 3);
  EXPECT_EQ(to_integer(0x1p63, std::int64_t{0}, kLong), kLong);
  EXPECT_EQ(to_integer(0x1p62, std::int64_t{0}, kLong), std::int64_t{1} << 62);
}

}  // namespace
}  // namespace isimp
