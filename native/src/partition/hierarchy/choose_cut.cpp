#include "hierarchy/choose_cut.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace isimp {
namespace {

constexpr double kWindow = 4.0;    // gaps are looked for from t to this times t
constexpr double kSlack = 4.0;     // a gap counts no further than this factor of cost beyond the window
constexpr double kRatio = 2.0;     // least ratio of costs
constexpr double kSurprise = 4.0;  // above what the largest of W + 1 exponential draws is about

}  // namespace

double merge_limit(double tolerance, double noise, double deviations) {
  const double t = std::max(tolerance, deviations * noise);
  return 16 * t * t;
}

Cut choose_cut(std::span<const double> falling, std::int32_t parts, double rounding, double tolerance, double noise,
               bool snap) {
  const double low = merge_limit(tolerance, noise, kLeastNoise), high = merge_limit(kWindow * tolerance, noise);
  Cut cut{.cost = merge_limit(tolerance, noise)};
  if (snap) {
    const auto inside = static_cast<double>(
        std::count_if(falling.begin(), falling.end(), [&](double c) { return c >= low && c <= high; }));
    double widest = std::log(kRatio);
    for (std::size_t j = 0; j < falling.size() && falling[j] >= low; ++j) {
      const double above = falling[j], below = std::max(j + 1 < falling.size() ? falling[j + 1] : 0.0, rounding);
      if (below > high) continue;
      const double top = std::min(above, kSlack * high), bottom = std::max(below, low / kSlack);
      const double gap = std::log(top / bottom), regions = parts + static_cast<double>(j) + 1;
      if (gap <= widest || regions / 2 * gap <= std::log(inside + 1) + kSurprise) continue;
      widest = gap;
      cut.cost = std::sqrt(top * bottom);
      cut.snapped = true;
    }
  }
  return cut;
}

}  // namespace isimp
