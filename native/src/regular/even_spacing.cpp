#include "even_spacing.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace isimp::regular {
namespace {

constexpr double kFalseAlarms = 0.1;   ///< expected number by chance among as many planes; above it, a series does not
                                       ///< count
constexpr double kLeastStep = 6;       ///< tolerances: between nearer planes everything is evenly spaced
constexpr std::size_t kLeast = 3;      ///< planes of a series, pairs of a size
constexpr std::size_t kMost = 100;     ///< the largest planes that are compared
constexpr std::size_t kFarthest = 12;  ///< steps between the two planes that begin the search for a series
constexpr double kStays = 1e9;         ///< times the area: weight of a plane that can't be moved

using Indices = std::vector<std::size_t>;

/// The probability that at least k of n trials succeed, each with probability p.
double tail(std::size_t n, std::size_t k, double p) {
  if (k == 0) return 1;
  if (k > n || p <= 0) return 0;
  double sum = 0;
  for (std::size_t i = k; i <= n; ++i) {
    const double ways = std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(static_cast<double>(n - i) + 1.0);
    sum += std::exp(ways + static_cast<double>(i) * std::log(p) +
                    static_cast<double>(n - i) * std::log1p(-std::min(p, 1 - 1e-12)));
  }
  return sum;
}

/// Planes at first + rank * step.
struct Series {
  Indices planes;
  std::vector<double> rank;
  double first = 0, step = 0;
  double false_alarms = 0;
};

class Spacing {
 public:
  Spacing(std::span<const ParallelPlane> planes, double tolerance, const Job* job)
      : planes_(planes), tolerance_(tolerance), job_(job), is_placed_(planes.size(), false) {
    for (const ParallelPlane& plane : planes) result_.offset.push_back(plane.offset);
  }

  EvenSpacing run() {
    std::vector<Series> all = series_of(true), against = series_of(false);
    all.insert(all.end(), against.begin(), against.end());
    share_steps(all);
    for (const Series& series : all) {
      for (std::size_t k = 0; k < series.planes.size(); ++k)
        place(series.planes[k], series.first + series.rank[k] * series.step);
      ++result_.series;
    }
    even_sizes();
    result_.planes = static_cast<int>(std::count(is_placed_.begin(), is_placed_.end(), true));
    return std::move(result_);
  }

 private:
  [[nodiscard]] double weight(std::size_t i) const { return planes_[i].area * (planes_[i].is_fixed ? kStays : 1); }
  [[nodiscard]] bool may_be_at(std::size_t i, double offset) const {
    const double slack = 1e-6 * tolerance_;
    return offset >= planes_[i].low - slack && offset <= planes_[i].high + slack;
  }
  void place(std::size_t i, double offset) {
    if (!planes_[i].is_fixed) result_.offset[i] = offset;
    is_placed_[i] = true;
  }

  /// The least likely series of the planes of one facing, then the next one among the other planes.
  [[nodiscard]] std::vector<Series> series_of(bool faces_along) const {
    Indices left;
    for (std::size_t i = 0; i < planes_.size(); ++i)
      if (planes_[i].faces_along == faces_along) left.push_back(i);
    if (left.size() > kMost) {
      std::nth_element(left.begin(), left.begin() + kMost, left.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(-planes_[a].area, a) < std::pair(-planes_[b].area, b);
      });
      left.resize(kMost);
    }
    std::sort(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(planes_[a].offset, a) < std::pair(planes_[b].offset, b);
    });
    std::vector<Series> found;
    while (std::optional<Series> best = best_series(left)) {
      std::erase_if(left, [&](std::size_t i) { return std::count(best->planes.begin(), best->planes.end(), i) > 0; });
      found.push_back(std::move(*best));
    }
    return found;
  }

  [[nodiscard]] std::optional<Series> best_series(const Indices& sorted) const {
    std::optional<Series> best;
    if (sorted.size() < kLeast) return best;
    const double range = planes_[sorted.back()].offset - planes_[sorted.front()].offset;
    const auto count = static_cast<double>(sorted.size());
    const double chance = -std::expm1(-2 * tolerance_ * (count - 2) / std::max(range, tolerance_));
    const double pairs = count * (count - 1) / 2;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (job_ != nullptr) job_->poll();
      for (std::size_t j = i + 1; j < sorted.size(); ++j) {
        const double apart = planes_[sorted[j]].offset - planes_[sorted[i]].offset;
        // Far planes determine the step best; one of the planes between may be missing.
        const std::size_t most = std::min(j - i + 1, kFarthest);
        for (std::size_t steps = 1; steps <= most; ++steps) {
          if (apart < kLeastStep * tolerance_ * static_cast<double>(steps)) break;
          Series series = along(sorted, planes_[sorted[i]].offset, apart / static_cast<double>(steps));
          if (series.planes.size() < kLeast || !fit({&series, 1})) continue;
          const auto slots = static_cast<std::size_t>(series.rank.back() - series.rank.front()) + 1;
          series.false_alarms = pairs * tail(slots - 2, series.planes.size() - 2, chance);
          if (series.false_alarms > kFalseAlarms) continue;
          if (!best || series.false_alarms < best->false_alarms) best = std::move(series);
        }
      }
    }
    return best;
  }

  /// Planes at multiples of a step from a first offset, one at most at each; where two in a row are missing, it ends.
  [[nodiscard]] Series along(const Indices& sorted, double first, double step) const {
    Series series{{}, {}, first, step};
    const auto miss = [&](std::size_t i, double rank) { return std::abs(planes_[i].offset - first - rank * step); };
    for (const std::size_t i : sorted) {
      const double rank = std::round((planes_[i].offset - first) / step);
      if (miss(i, rank) > tolerance_) continue;
      if (!series.rank.empty() && series.rank.back() == rank) {
        if (miss(i, rank) < miss(series.planes.back(), rank)) series.planes.back() = i;
        continue;
      }
      if (!series.rank.empty() && rank > series.rank.back() + 2) {
        if (series.rank.back() >= 0) break;  // the next ones are beyond the end
        series.planes.clear();               // the earlier ones are beyond the begin: rank 0 is that of `first` itself
        series.rank.clear();
      }
      series.planes.push_back(i);
      series.rank.push_back(rank);
    }
    return series;
  }

  /// Fits one step to some series, and to each its first offset, by least squares.
  /// \return whether every plane may be moved to its place; else nothing has changed
  [[nodiscard]] bool fit(std::span<Series> some) const {
    double along = 0, across = 0;
    std::vector<std::pair<double, double>> means;  // means of rank and offset
    for (const Series& series : some) {
      double sum = 0, rank = 0, offset = 0;
      for (std::size_t k = 0; k < series.planes.size(); ++k) {
        const double w = weight(series.planes[k]);
        sum += w;
        rank += w * series.rank[k];
        offset += w * planes_[series.planes[k]].offset;
      }
      means.emplace_back(rank / sum, offset / sum);
      for (std::size_t k = 0; k < series.planes.size(); ++k) {
        const double off = series.rank[k] - means.back().first, w = weight(series.planes[k]);
        along += w * off * off;
        across += w * off * (planes_[series.planes[k]].offset - means.back().second);
      }
    }
    if (!(along > 0)) return false;
    const double step = across / along;
    for (std::size_t s = 0; s < some.size(); ++s)
      for (std::size_t k = 0; k < some[s].planes.size(); ++k)
        if (!may_be_at(some[s].planes[k], means[s].second + step * (some[s].rank[k] - means[s].first))) return false;
    for (std::size_t s = 0; s < some.size(); ++s) {
      some[s].first = means[s].second - step * means[s].first;
      some[s].step = step;
    }
    return true;
  }

  /// Sets the same step for series whose steps are so nearly the same that their planes allow it.
  void share_steps(std::vector<Series>& all) const {
    std::sort(all.begin(), all.end(),
              [](const Series& a, const Series& b) { return std::pair(a.step, a.first) < std::pair(b.step, b.first); });
    for (std::size_t begin = 0; begin < all.size();) {
      std::size_t end = begin + 1;
      while (end < all.size() && fit({&all[begin], end + 1 - begin})) ++end;
      begin = end;
    }
  }

  /// The widths of openings and of the walls between them: between adjacent planes that face opposite ways.
  void even_sizes() {
    Indices sorted(planes_.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = i;
    std::sort(sorted.begin(), sorted.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(result_.offset[a], a) < std::pair(result_.offset[b], b);
    });
    for (const bool opening : {true, false}) {
      std::vector<std::pair<double, std::size_t>> sizes;  // and the place of the lower plane in `sorted`
      for (std::size_t k = 0; k + 1 < sorted.size(); ++k) {
        const ParallelPlane &low = planes_[sorted[k]], &high = planes_[sorted[k + 1]];
        if (low.faces_along != opening || high.faces_along == opening) continue;
        const double size = result_.offset[sorted[k + 1]] - result_.offset[sorted[k]];
        if (size >= kLeastStep * tolerance_) sizes.emplace_back(size, k);
      }
      std::sort(sizes.begin(), sizes.end());
      for (std::size_t begin = 0; begin < sizes.size();) {
        std::size_t end = begin + 1;
        while (end < sizes.size() && sizes[end].first - sizes[begin].first <= 2 * tolerance_) ++end;
        const auto count = static_cast<double>(sizes.size());
        const double chance = std::min(1.0, 2 * tolerance_ / sizes.back().first);
        const double false_alarms = count * tail(sizes.size() - 1, end - begin - 1, chance);
        const bool counts = end - begin >= kLeast && false_alarms <= kFalseAlarms;
        if (counts) make_equal(sorted, {sizes.data() + begin, end - begin});
        begin = counts ? end : begin + 1;
      }
    }
  }

  void make_equal(const Indices& sorted, std::span<const std::pair<double, std::size_t>> sizes) {
    double sum = 0, area = 0;
    for (const auto& [size, k] : sizes) {
      const bool stays = stays_at(sorted[k]) && stays_at(sorted[k + 1]);
      const double w = (planes_[sorted[k]].area + planes_[sorted[k + 1]].area) * (stays ? kStays : 1);
      sum += w * size;
      area += w;
    }
    const double wanted = sum / area;
    bool any = false;
    for (const auto& [size, k] : sizes) {
      const std::size_t low = sorted[k], high = sorted[k + 1];
      if (stays_at(low) && stays_at(high)) continue;
      const double less = wanted - size;
      const double share = stays_at(low) ? 0 : stays_at(high) ? 1 : 0.5;
      const double below = result_.offset[low] - share * less, above = result_.offset[high] + (1 - share) * less;
      if (!may_be_at(low, below) || !may_be_at(high, above)) continue;
      place(low, below);
      place(high, above);
      any = true;
    }
    if (any) ++result_.sizes;
  }
  [[nodiscard]] bool stays_at(std::size_t i) const { return is_placed_[i] || planes_[i].is_fixed; }

  std::span<const ParallelPlane> planes_;
  double tolerance_;
  const Job* job_;
  std::vector<bool> is_placed_;
  EvenSpacing result_;
};

}  // namespace

EvenSpacing even_spacing(std::span<const ParallelPlane> planes, double tolerance, const Job* job) {
  return Spacing(planes, tolerance, job).run();
}

}  // namespace isimp::regular
