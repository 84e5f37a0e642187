#include "draw/ownership.h"
#include "tests.h"

namespace isimp::detail {
namespace {

using Corners = std::vector<std::array<double, 2>>;

double distance(const Corners& outline, double x, double y) {
  constexpr int kSteps = 1000;
  double least = 1e9;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto &a = outline[i], &b = outline[(i + 1) % outline.size()];
    for (int k = 0; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      least = std::min(least, std::hypot(a[0] + t * (b[0] - a[0]) - x, a[1] + t * (b[1] - a[1]) - y));
    }
  }
  return least;
}

TEST(Ownership, TexelsNearAnOutlineHaveTheirDistanceFromIt) {
  const TexelBox box{2, 3, 30, 28};
  constexpr float kReach = 4, kFar = 99;
  for (const Corners& outline : {Corners{{8, 8}, {20, 8}, {20, 20}, {8, 20}}, Corners{{7, 9}, {24, 13}, {11, 22}}}) {
    std::vector<float> found(static_cast<std::size_t>(box.width()) * box.height(), kFar);
    measure_edges(outline, box, kReach, found);
    for (std::int32_t y = box.y0; y < box.y1; ++y)
      for (std::int32_t x = box.x0; x < box.x1; ++x) {
        const double wanted = distance(outline, x + 0.5, y + 0.5);
        const float got = found[static_cast<std::size_t>(y - box.y0) * box.width() + (x - box.x0)];
        if (std::abs(wanted - kReach) < 0.01) continue;
        EXPECT_NEAR(got, wanted < kReach ? wanted : kFar, 0.01) << x << " " << y;
      }
  }
}

}  // namespace
}  // namespace isimp::detail
