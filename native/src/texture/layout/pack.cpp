// Packs charts into tiles.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "isimp/core/check.h"
#include "layout/layout.h"
#include "layout/profile.h"

namespace isimp::detail {
namespace {

constexpr double kGuess = 0.57;  // work: the fill to begin with: the search then takes few tries

/// The skyline of a tile: the filled height of each column, and the largest.
struct Pile {
  std::vector<Cell> top;
  std::int32_t used = 0;
};

class Packer {
 public:
  Packer(const Layout& layout, const Room& room) : cells_(layout, room), tiles_(room.tiles), groups_(layout.groups) {}

  /// The places at `scale` texels per scene unit; false if the charts do not fit.
  bool attempt(double scale, Packing& packing, Job& job) {
    piles_.assign(static_cast<std::size_t>(tiles_) * groups_, {std::vector<Cell>(cells_.count(), 0), 0});
    packing.scale = scale;
    packing.place.resize(cells_.order().size());
    packing.tile.resize(cells_.order().size());
    std::int32_t done = 0;
    for (const std::int32_t c : cells_.order()) {
      if (done++ % 16 == 0) job.poll();
      if (!cells_.shape(c, scale, profile_)) return false;
      const std::int32_t first = cells_.group(c) * tiles_;
      Spot spot;
      std::int32_t tile = first;
      for (; tile < first + tiles_ && spot.x < 0; ++tile) spot = best_spot(piles_[tile]);
      if (spot.x < 0) return false;
      settle(spot, piles_[--tile]);
      packing.place[c] = cells_.place(profile_, spot.turn, spot.x, spot.y, tile);
      packing.tile[c] = tile;
    }
    return true;
  }

 private:
  struct Spot {
    std::int32_t x = -1, y = 0, turn = 0;
  };

  /// The spot that raises the pile least and wastes the least room below the chart. A higher pile costs one row; room
  /// below counts twice, as tried on polygons of scans.
  [[nodiscard]] Spot best_spot(const Pile& pile) const {
    const std::int32_t cells = cells_.count();
    std::vector<std::int64_t> below(cells + 1, 0);
    for (std::int32_t k = 0; k < cells; ++k) below[k + 1] = below[k] + pile.top[k];
    Spot best;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (std::int32_t turn = 0; turn < 4; ++turn) {
      const Profile& p = profile_[turn];
      const std::int32_t m = p.width();
      for (std::int32_t x = 0; x + m <= cells; ++x) {
        const std::int32_t y = rest(pile.top.data() + x, p);
        if (y + p.height > cells) continue;
        const std::int64_t waste = std::int64_t{m} * y + p.low_sum - (below[x + m] - below[x]);
        const std::int64_t cost = std::int64_t{std::max(y + p.height - pile.used, 0)} * cells + waste * 2 + y;
        if (cost < least) {
          least = cost;
          best = {x, y, turn};
        }
      }
    }
    return best;
  }

  /// The lowest free row for a chart whose left column has this top.
  [[nodiscard]] static std::int32_t rest(const Cell* top, const Profile& p) {
    const Cell* low = p.low.data();
    Cell y = 0;
    for (std::int32_t k = 0; k < p.width(); ++k) y = std::max(y, static_cast<Cell>(top[k] - low[k]));
    return y;
  }

  void settle(const Spot& spot, Pile& pile) const {
    const Profile& p = profile_[spot.turn];
    ISIMP_ASSERT(spot.x + p.width() <= cells_.count() && spot.y + p.height <= cells_.count(), "a chart is in its tile");
    for (std::int32_t k = 0; k < p.width(); ++k) {
      Cell& top = pile.top[spot.x + k];
      ISIMP_ASSERT(spot.y + p.low[k] >= top, "a chart lies on those below it");
      top = std::max(top, static_cast<Cell>(spot.y + p.high[k] + 1));
      pile.used = std::max<std::int32_t>(pile.used, top);
    }
  }

  Cells cells_;
  std::int32_t tiles_, groups_;  // tiles of each group
  std::array<Profile, 4> profile_;
  std::vector<Pile> piles_;
};

}  // namespace

std::optional<Packing> pack(const Layout& layout, const Room& room, Job& job) {
  if (layout.chart_count == 0) return Packing{1, {}, {}};
  Packer packer(layout, room);
  Packing best, tried;
  double low = 0, high = 0;  // scales that fit and that do not, 0 as long as unknown
  double scale = room.side * std::sqrt(kGuess / std::max(layout.tile_area, std::numeric_limits<double>::min()));
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
