#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "layout/layout.h"

namespace isimp::detail {

using Cell = std::int16_t;  // narrow, so that the compiler compares eight columns at once

/// A chart in one of four turns, as columns of cells: the lowest and the highest cell that each column uses.
struct Profile {
  std::vector<Cell> low, high;
  std::int32_t height = 0;
  std::int64_t low_sum = 0;

  [[nodiscard]] std::int32_t width() const { return static_cast<std::int32_t>(low.size()); }
};

/// A tile as cells, and the charts of a layout in them, the largest first.
class Cells {
 public:
  Cells(const Layout& layout, const Room& room);

  [[nodiscard]] std::int32_t count() const { return count_; }  ///< cells along a side of the image
  [[nodiscard]] const std::vector<std::int32_t>& order() const { return order_; }
  [[nodiscard]] std::int32_t group(std::int32_t chart) const { return layout_.group[members_[chart].front()]; }

  /// The profiles of a chart in its four turns, by quarters counter-clockwise; false if it is larger than a tile.
  bool shape(std::int32_t chart, double scale, std::array<Profile, 4>& profile) const;
  /// The place of a chart whose profile has its lower left cell at (x, y) of a tile.
  [[nodiscard]] Rigid place(const std::array<Profile, 4>& profile, std::int32_t turn, std::int32_t x, std::int32_t y,
                            std::int32_t tile) const;

 private:
  const Layout& layout_;
  std::int32_t count_;
  double size_, grow_;
  std::vector<std::vector<std::int32_t>> members_;  // (charts) polygons
  std::vector<Vec2> extent_;                        // (charts) scene units
  std::vector<std::int32_t> order_;
};

}  // namespace isimp::detail
