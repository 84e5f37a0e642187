#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "layout.h"

namespace isimp::detail {
namespace {

constexpr std::int32_t kCells = 1024;  // columns of the atlas, as profiles have them
constexpr double kGuess = 0.57;        // the fill to begin with: the search then takes few tries
using Cell = std::int16_t;             // narrow, so that the compiler compares eight columns at once

/// A chart in one of four turns, as columns of cells: the lowest and the highest cell that each column uses.
struct Profile {
  std::vector<Cell> low, high;
  std::int32_t height = 0;
  std::int64_t low_sum = 0;

  [[nodiscard]] std::int32_t width() const { return static_cast<std::int32_t>(low.size()); }
};

/// The extent of every edge in every column that it crosses, `grow` cells more on each side.
void add_edge(Vec2 a, Vec2 b, double grow, Profile& profile) {
  if (a.x() > b.x()) std::swap(a, b);
  const auto from = std::max(0, static_cast<std::int32_t>(std::floor(a.x() - grow)));
  const auto to = std::min(profile.width() - 1, static_cast<std::int32_t>(std::floor(b.x() + grow)));
  const double run = b.x() - a.x();
  for (std::int32_t k = from; k <= to; ++k) {
    const double s = run > 0 ? std::clamp((k - grow - a.x()) / run, 0.0, 1.0) : 0;
    const double t = run > 0 ? std::clamp((k + 1 + grow - a.x()) / run, 0.0, 1.0) : 1;
    const double ya = a.y() + s * (b.y() - a.y()), yb = a.y() + t * (b.y() - a.y());
    const auto low = static_cast<std::int32_t>(std::floor(std::min(ya, yb) - grow));
    const auto high = static_cast<std::int32_t>(std::floor(std::max(ya, yb) + grow));
    profile.low[k] = std::min(profile.low[k], static_cast<Cell>(std::clamp(low, 0, profile.height - 1)));
    profile.high[k] = std::max(profile.high[k], static_cast<Cell>(std::clamp(high, 0, profile.height - 1)));
  }
}

/// Columns that no edge crosses, if any, are taken whole.
void close(Profile& profile) {
  profile.low_sum = 0;
  for (std::int32_t k = 0; k < profile.width(); ++k) {
    if (profile.low[k] > profile.high[k]) {
      profile.low[k] = 0;
      profile.high[k] = static_cast<Cell>(profile.height - 1);
    }
    profile.low_sum += profile.low[k];
  }
}

Profile half_turn(const Profile& p) {
  Profile turned = p;
  const std::int32_t m = p.width();
  for (std::int32_t k = 0; k < m; ++k) {
    turned.low[m - 1 - k] = static_cast<Cell>(p.height - 1 - p.high[k]);
    turned.high[m - 1 - k] = static_cast<Cell>(p.height - 1 - p.low[k]);
  }
  close(turned);
  return turned;
}

/// The four turns of a box of w by h, by quarters counter-clockwise.
Rigid quarter(std::int32_t turns, double w, double h) {
  Rigid r;
  switch (turns) {
    case 0:
      break;
    case 1:
      r.turn << 0, -1, 1, 0;
      r.shift = {h, 0};
      break;
    case 2:
      r.turn << -1, 0, 0, -1;
      r.shift = {w, h};
      break;
    default:
      r.turn << 0, 1, -1, 0;
      r.shift = {0, w};
  }
  return r;
}

class Packer {
 public:
  Packer(const Layout& layout, std::int32_t side, double grow)
      : layout_(layout),
        cells_(std::min(side, kCells)),
        cell_(static_cast<double>(side) / cells_),
        grow_(grow / cell_),
        members_(layout.chart_count),
        extent_(layout.chart_count, Vec2::Zero()) {
    for (std::int32_t q = 0; q < layout.polygon_count(); ++q) {
      members_[layout.chart[q]].push_back(q);
      for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i)
        extent_[layout.chart[q]] = extent_[layout.chart[q]].cwiseMax(layout.corner(q, i));
    }
    order_.resize(layout.chart_count);
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [&](std::int32_t a, std::int32_t b) {
      return extent_[a].maxCoeff() > extent_[b].maxCoeff() * (1 + 1e-9);
    });
  }

  /// The places at so many texels per scene unit; false if the charts do not fit.
  bool attempt(double scale, Packing& packing, Job& job) {
    const double s = scale / cell_;  // cells per scene unit
    top_.assign(cells_, 0);
    used_ = 0;
    packing.scale = scale;
    packing.place.resize(layout_.chart_count);
    std::int32_t done = 0;
    for (const std::int32_t c : order_) {
      if (done++ % 16 == 0) job.poll();
      const Vec2 box = (s * extent_[c]).array() + 2 * grow_;
      if (!(box.maxCoeff() <= cells_)) return false;
      const std::array<std::int32_t, 2> size = {std::max(1, static_cast<std::int32_t>(std::ceil(box.x()))),
                                                std::max(1, static_cast<std::int32_t>(std::ceil(box.y())))};
      make_profiles(c, s, size);
      const Spot spot = best_spot();
      if (spot.x < 0) return false;
      settle(spot);
      const Rigid turn = quarter(spot.turn, size[0] * cell_, size[1] * cell_);
      const Vec2 margin(grow_ * cell_, grow_ * cell_);
      packing.place[c] = {turn.turn, turn(margin) + cell_ * Vec2(spot.x, spot.y)};
    }
    return true;
  }

 private:
  struct Spot {
    std::int32_t x = -1, y = 0, turn = 0;
  };

  void make_profiles(std::int32_t chart, double s, const std::array<std::int32_t, 2>& size) {
    for (std::int32_t r = 0; r < 2; ++r) {
      profile_[r].height = size[1 - r];
      profile_[r].low.assign(size[r], std::numeric_limits<Cell>::max());
      profile_[r].high.assign(size[r], -1);
    }
    const Rigid turned = quarter(1, size[0], size[1]);
    for (const std::int32_t q : members_[chart])
      for (std::int32_t i = layout_.start[q], h = layout_.start[q + 1] - 1; i < layout_.start[q + 1]; h = i++) {
        const Vec2 a = (s * layout_.corner(q, h)).array() + grow_, b = (s * layout_.corner(q, i)).array() + grow_;
        add_edge(a, b, grow_, profile_[0]);
        add_edge(turned(a), turned(b), grow_, profile_[1]);
      }
    close(profile_[0]);
    close(profile_[1]);
    profile_[2] = half_turn(profile_[0]);
    profile_[3] = half_turn(profile_[1]);
  }

  /// The spot that raises the pile least and wastes the least room below the chart. What is lost by a row more is a row;
  /// room below counts twice, as tried on polygons of scans.
  [[nodiscard]] Spot best_spot() const {
    std::vector<std::int64_t> below(cells_ + 1, 0);
    for (std::int32_t k = 0; k < cells_; ++k) below[k + 1] = below[k] + top_[k];
    Spot best;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (std::int32_t turn = 0; turn < 4; ++turn) {
      const Profile& p = profile_[turn];
      const std::int32_t m = p.width();
      for (std::int32_t x = 0; x + m <= cells_; ++x) {
        const std::int32_t y = rest(x, p);
        if (y + p.height > cells_) continue;
        const std::int64_t waste = std::int64_t{m} * y + p.low_sum - (below[x + m] - below[x]);
        const std::int64_t cost = std::int64_t{std::max(y + p.height - used_, 0)} * cells_ + waste * 2 + y;
        if (cost < least) {
          least = cost;
          best = {x, y, turn};
        }
      }
    }
    return best;
  }

  /// The row on which a chart comes to rest whose left column is x.
  [[nodiscard]] std::int32_t rest(std::int32_t x, const Profile& p) const {
    const Cell* top = top_.data() + x;
    const Cell* low = p.low.data();
    Cell y = 0;
    for (std::int32_t k = 0; k < p.width(); ++k) y = std::max(y, static_cast<Cell>(top[k] - low[k]));
    return y;
  }

  void settle(const Spot& spot) {
    const Profile& p = profile_[spot.turn];
    for (std::int32_t k = 0; k < p.width(); ++k) {
      Cell& top = top_[spot.x + k];
      top = std::max(top, static_cast<Cell>(spot.y + p.high[k] + 1));
      used_ = std::max<std::int32_t>(used_, top);
    }
  }

  const Layout& layout_;
  std::int32_t cells_;
  double cell_, grow_;  // texels a cell; cells
  std::vector<std::vector<std::int32_t>> members_;
  std::vector<Vec2> extent_;  // (charts) scene units
  std::vector<std::int32_t> order_;
  std::array<Profile, 4> profile_;
  std::vector<Cell> top_;
  std::int32_t used_ = 0;
};

}  // namespace

std::optional<Packing> pack(const Layout& layout, std::int32_t side, double grow, Job& job) {
  if (layout.chart_count == 0) return Packing{1, {}};
  Packer packer(layout, side, grow);
  Packing best, tried;
  double low = 0, high = 0;  // scales that fit and that do not, 0 as long as unknown
  double scale = side * std::sqrt(kGuess / std::max(layout.area, std::numeric_limits<double>::min()));
  for (int tries = 0; tries < 40 && !(low > 0 && high > 0 && high < 1.012 * low); ++tries) {
    if (packer.attempt(scale, tried, job)) {
      low = scale;
      std::swap(best, tried);
    } else {
      high = scale;
    }
    if (low > 0 && high > 0) {
      scale = std::sqrt(low * high);
    } else {
      scale *= low > 0 ? 1.03 : tries < 4 ? 0.96 : 0.5;
    }
  }
  if (low == 0) return std::nullopt;
  return best;
}

}  // namespace isimp::detail
