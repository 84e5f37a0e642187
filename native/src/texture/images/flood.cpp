#include "images/flood.h"

#include <algorithm>
#include <array>
#include <vector>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

/// A reduced copy of an image: each pixel is the mean of the known ones of two by two.
struct Level {
  std::int32_t side = 0;
  std::vector<std::array<std::uint8_t, 4>> pixel;
  std::vector<std::uint8_t> known;
};

/// \param read  read(x, y, rgba) sets the colour of a pixel of the finer copy and returns whether it is known
template <class Read>
Level halve(std::int32_t side, Read read) {
  Level level;
  level.side = (side + 1) / 2;
  const auto size = static_cast<std::size_t>(level.side) * level.side;
  level.pixel.resize(size);
  level.known.assign(size, 0);
  for (std::int32_t y = 0; y < level.side; ++y)
    for (std::int32_t x = 0; x < level.side; ++x) {
      std::array<std::int32_t, 4> sum{};
      std::int32_t count = 0;
      for (std::int32_t j = 2 * y; j < std::min(2 * y + 2, side); ++j)
        for (std::int32_t i = 2 * x; i < std::min(2 * x + 2, side); ++i) {
          std::array<std::uint8_t, 4> rgba;
          if (!read(i, j, rgba)) continue;
          ++count;
          for (int k = 0; k < 4; ++k) sum[k] += rgba[k];
        }
      if (count == 0) continue;
      const std::size_t at = static_cast<std::size_t>(y) * level.side + x;
      level.known[at] = 1;
      for (int k = 0; k < 4; ++k) level.pixel[at][k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
    }
  return level;
}

std::vector<Level> reduced(std::span<const std::int32_t> owner, std::int32_t side, std::span<const std::uint8_t> color,
                           Job& job) {
  std::vector<Level> levels;
  levels.push_back(halve(side, [&](std::int32_t x, std::int32_t y, std::array<std::uint8_t, 4>& rgba) {
    if (owner[static_cast<std::size_t>(side - 1 - y) * side + x] == kNone) return false;
    std::copy_n(color.data() + 4 * (static_cast<std::size_t>(y) * side + x), 4, rgba.begin());
    return true;
  }));
  while (levels.back().side > 1) {
    job.poll();
    const Level& fine = levels.back();
    Level coarse = halve(fine.side, [&](std::int32_t x, std::int32_t y, std::array<std::uint8_t, 4>& rgba) {
      const std::size_t at = static_cast<std::size_t>(y) * fine.side + x;
      rgba = fine.pixel[at];
      return fine.known[at] != 0;
    });
    levels.push_back(std::move(coarse));
  }
  return levels;
}

}  // namespace

void flood(std::span<const std::int32_t> owner, std::int32_t side, std::int32_t tile, const Rgba& mean,
           std::span<std::uint8_t> color, Job& job) {
  const std::size_t pixels = static_cast<std::size_t>(side) * side;
  color = color.last(4 * pixels * (tile + 1)).first(4 * pixels);
  owner = owner.subspan(pixels * tile, pixels);
  std::vector<Level> levels = reduced(owner, side, color, job);
  Level& top = levels.back();
  if (top.known[0] == 0)
    for (int k = 0; k < 4; ++k) top.pixel[0][k] = to_integer(mean[k] + 0.5F, std::uint8_t{0}, std::uint8_t{255});
  for (std::size_t l = levels.size() - 1; l-- > 0;) {
    Level& fine = levels[l];
    const Level& coarse = levels[l + 1];
    for (std::int32_t y = 0; y < fine.side; ++y)
      for (std::int32_t x = 0; x < fine.side; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * fine.side + x;
        if (fine.known[at] == 0) fine.pixel[at] = coarse.pixel[static_cast<std::size_t>(y / 2) * coarse.side + x / 2];
      }
  }
  const Level& half = levels.front();
  for (std::int32_t y = 0; y < side; ++y) {
    if (y % 64 == 0) job.poll();
    for (std::int32_t x = 0; x < side; ++x) {
      if (owner[static_cast<std::size_t>(side - 1 - y) * side + x] != kNone) continue;
      const std::size_t at = static_cast<std::size_t>(y) * side + x;
      const auto& rgba = half.pixel[static_cast<std::size_t>(y / 2) * half.side + x / 2];
      std::copy_n(rgba.begin(), 4, color.data() + 4 * at);
    }
  }
}

void flood_normals(std::span<const std::int32_t> owner, std::int32_t side, std::span<std::uint8_t> normal) {
  const auto rows = static_cast<std::int32_t>(owner.size() / side);
  for (std::int32_t y = 0; y < rows; ++y)
    for (std::int32_t x = 0; x < side; ++x) {
      if (owner[static_cast<std::size_t>(rows - 1 - y) * side + x] != kNone) continue;
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * side + x);
      normal[at] = normal[at + 1] = 128;
      normal[at + 2] = 255;
    }
}

}  // namespace isimp::detail
