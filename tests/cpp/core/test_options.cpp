// The table of options: the contents of a range, its name, and the refusal of other values.

#include <optional>

#include "isimp/core/options.h"
#include "tests.h"

namespace isimp {
namespace {

enum class Kind { plain, fancy };

struct Options {
  double share = 0.5;
  std::optional<double> length = std::nullopt;
  int count = 3;
  bool on = false;
  std::string name = "x";
  Kind kind = Kind::plain;
};

constexpr auto fields(const Options*) {
  using O = Options;
  return std::tuple{field("share", &O::share, from_below(0, 1), Unit::none, "A share."),
                    field("length", &O::length, above(0), Unit::length, "A length."),
                    field("count", &O::count, at_least(1), Unit::none, "A count."),
                    field("on", &O::on, "A switch."),
                    field("name", &O::name, "A name."),
                    choice("kind", &O::kind, {{"plain", Kind::plain}, {"fancy", Kind::fancy}}, "A kind.")};
}

std::string said(const Options& options) {
  return message_of([&] { check_fields(options); });
}

TEST(Options, ARangeHoldsItsEndsOrNot) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(between(0, 1).holds(0) && between(0, 1).holds(1));
  EXPECT_FALSE(above_to(0, 1).holds(0));
  EXPECT_FALSE(from_below(0, 1).holds(1));
  EXPECT_FALSE(at_least(0).holds(infinity));
  EXPECT_TRUE(at_least_or_infinite(0).holds(infinity));
  EXPECT_TRUE(any().holds(-1e300));
  for (const Range& range : {between(0, 1), at_least(0), above(0), at_least_or_infinite(0)})
    EXPECT_FALSE(range.holds(std::numeric_limits<double>::quiet_NaN()));
}

TEST(Options, ValuesOutOfRangeAreNamedWithTheRange) {
  EXPECT_EQ(said({}), "no error");
  EXPECT_EQ(said({.share = 1}), "share must be in [0, 1), got 1");
  EXPECT_EQ(said({.length = 0.0}), "length must be a finite length above 0, got 0");
  EXPECT_EQ(said({.length = 2.0}), "no error");
  EXPECT_EQ(said({.count = 0}), "count must be at least 1, got 0");
  EXPECT_EQ(said({.on = true, .name = "", .kind = Kind::fancy}), "no error");
  EXPECT_EQ(said({.share = 2, .count = 0}), "share must be in [0, 1), got 2") << "the first one";
}

}  // namespace
}  // namespace isimp
