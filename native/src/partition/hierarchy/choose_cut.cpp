#include "hierarchy/choose_cut.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace isimp {
namespace {

// tuned found
constexpr double kWindow = 4.0;  // the search for gaps covers t to this times t
// tuned cartons
constexpr double kSlack = 16.0;  // a gap counts no further than this factor of cost beyond the window
// tuned found
constexpr double kRatio = 2.0;     // least ratio of costs
constexpr double kSurprise = 4.0;  // excess over ln(W + 1), about the largest of W + 1 exponential draws
// tuned counts
constexpr double kAround = 1.2;  // the number of regions is a mean over tolerances from t / kAround to t kAround
constexpr int kSamples = 8;      // tolerances on either side of t
constexpr double kFew = 20;      // fewer regions may be the shape's own number, and no mean is computed

/// A cost half-way between the cuts to N and N - 1 regions; N is the geometric mean of the counts near t.
double mean_cut(std::span<const double> falling, std::int32_t components, double rounding, double tolerance,
                double finest, double noise) {
  const double limit = merge_limit(tolerance, noise);
  const auto regions = [&](double cost) {
    const auto end = std::lower_bound(falling.begin(), falling.end(), cost, std::greater<>());
    return components + static_cast<double>(end - falling.begin());
  };
  const double spread = std::min(std::log(kAround), std::log(tolerance / std::max(finest, kNoiseDeviations * noise)));
  if (!(spread > 0) || regions(limit) < kFew) return limit;
  double sum = 0;
  for (int i = -kSamples; i <= kSamples; ++i)
    sum += std::log(regions(merge_limit(tolerance * std::exp(spread * i / kSamples), noise)));
  const auto unmade = static_cast<std::size_t>(std::lround(std::exp(sum / (2 * kSamples + 1)))) - components;
  if (unmade == 0 || unmade >= falling.size()) return limit;
  return std::sqrt(std::max(falling[unmade], rounding) * std::max(falling[unmade - 1], rounding));
}

/// A significant gap of the costs.
struct Gap {
  double width = 0.0, cost = 0.0;  ///< logarithm of its ratio, and its geometric middle
};

/// The significant gaps, widest first; see choose_cut.
std::vector<Gap> gaps(std::span<const double> falling, std::int32_t components, double rounding, double tolerance,
                      double noise) {
  const double low = merge_limit(tolerance, noise, kLeastNoise), high = merge_limit(kWindow * tolerance, noise);
  const auto inside = static_cast<double>(
      std::count_if(falling.begin(), falling.end(), [&](double c) { return c >= low && c <= high; }));
  std::vector<Gap> found;
  for (std::size_t j = 0; j < falling.size() && falling[j] >= low; ++j) {
    const double above = falling[j], below = std::max(j + 1 < falling.size() ? falling[j + 1] : 0.0, rounding);
    if (below > high) continue;
    const double top = std::min(above, kSlack * high), bottom = std::max(below, low / kSlack);
    const double width = std::log(top / bottom), regions = components + static_cast<double>(j) + 1;
    if (width > std::log(kRatio) && regions / 2 * width > std::log(inside + 1) + kSurprise)
      found.push_back({width, std::sqrt(top * bottom)});
  }
  std::stable_sort(found.begin(), found.end(), [](const Gap& a, const Gap& b) { return a.width > b.width; });
  return found;
}

}  // namespace

double merge_limit(double tolerance, double noise, double deviations) {
  const double t = std::max(tolerance, deviations * noise);
  return 16 * t * t;
}

Cut choose_cut(std::span<const double> falling, std::int32_t components, double rounding, double tolerance,
               double finest, double noise, bool snap, const std::function<bool(double)>& fits) {
  if (snap)
    for (const Gap& gap : gaps(falling, components, rounding, tolerance, noise))
      if (!fits || fits(gap.cost)) return {gap.cost, true};
  return {mean_cut(falling, components, rounding, tolerance, finest, noise), false};
}

}  // namespace isimp
