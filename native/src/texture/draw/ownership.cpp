#include "draw/ownership.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

using Outline = std::span<const std::array<double, 2>>;

/// Calls found(x, y) for the texels of the box whose centres lie in the outline: even-odd, row by row.
template <class Found>
void fill(Outline outline, const TexelBox& box, std::vector<double>& cuts, Found found) {
  for (std::int32_t row = box.y0; row < box.y1; ++row) {
    const double y = row + 0.5;
    cuts.clear();
    for (std::size_t i = 0, h = outline.size() - 1; i < outline.size(); h = i++) {
      const auto& [xa, ya] = outline[h];
      const auto& [xb, yb] = outline[i];
      if ((ya <= y) != (yb <= y)) cuts.push_back(xa + (y - ya) / (yb - ya) * (xb - xa));
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t k = 0; k + 1 < cuts.size(); k += 2) {
      const std::int32_t from = to_integer(std::ceil(cuts[k] - 0.5), box.x0, box.x1);
      const std::int32_t to = to_integer(std::floor(cuts[k + 1] - 0.5), box.x0 - 1, box.x1 - 1);
      for (std::int32_t x = from; x <= to; ++x) found(x, row);
    }
  }
}

/// The texels of one row near an edge: [from, to], wider than necessary.
struct Stretch {
  double from, to;
};

Stretch near_in_row(const std::array<double, 2>& a, const std::array<double, 2>& b, double y, double reach) {
  const double dy = b[1] - a[1];
  const auto at = [&](double level) {
    const double t = dy != 0 ? std::clamp((level - a[1]) / dy, 0.0, 1.0) : 0;
    return a[0] + t * (b[0] - a[0]);
  };
  if (dy == 0) return {std::min(a[0], b[0]) - reach, std::max(a[0], b[0]) + reach};
  const double p = at(y - reach), q = at(y + reach);
  return {std::min(p, q) - reach, std::max(p, q) + reach};
}

double squared_distance(const std::array<double, 2>& a, const std::array<double, 2>& b, double x, double y) {
  const double ex = b[0] - a[0], ey = b[1] - a[1], length = ex * ex + ey * ey;
  const double t = length > 0 ? std::clamp(((x - a[0]) * ex + (y - a[1]) * ey) / length, 0.0, 1.0) : 0;
  const double dx = a[0] + t * ex - x, dy = a[1] + t * ey - y;
  return dx * dx + dy * dy;
}

/// Calls found(x, y, squared distance) for the texels of the box within reach of an edge; a texel may occur twice.
template <class Found>
void along_edges(Outline outline, const TexelBox& box, double reach, Found found) {
  for (std::size_t i = 0, h = outline.size() - 1; i < outline.size(); h = i++) {
    const auto &a = outline[h], &b = outline[i];
    const std::int32_t low = to_integer(std::floor(std::min(a[1], b[1]) - reach), box.y0, box.y1);
    const std::int32_t high = to_integer(std::ceil(std::max(a[1], b[1]) + reach), box.y0 - 1, box.y1 - 1);
    for (std::int32_t row = low; row <= high; ++row) {
      const Stretch stretch = near_in_row(a, b, row + 0.5, reach);
      const std::int32_t from = to_integer(std::floor(stretch.from - 0.5), box.x0, box.x1);
      const std::int32_t to = to_integer(std::ceil(stretch.to - 0.5), box.x0 - 1, box.x1 - 1);
      for (std::int32_t x = from; x <= to; ++x) {
        const double squared = squared_distance(a, b, x + 0.5, row + 0.5);
        if (squared <= reach * reach) found(x, row, squared);
      }
    }
  }
}

}  // namespace

Outline outline_of(const PolygonMesh& polygons, const Atlas& atlas, std::int32_t q) {
  const std::int32_t begin = polygons.loop_start[q];
  return Outline(atlas.corner).subspan(begin, polygons.loop_end(q) - begin);
}

TexelBox box_of_outline(Outline outline, double gutter, std::int32_t side, std::int32_t height) {
  if (outline.empty()) return {};
  std::array<double, 2> low = outline[0], high = outline[0];
  for (const auto& p : outline)
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  const auto texel = [](double at, std::int32_t most) { return to_integer(at, 0, most); };
  const double more = gutter / 2;
  return {texel(std::floor(low[0] - more), side), texel(std::floor(low[1] - more), height),
          texel(std::ceil(high[0] + more), side), texel(std::ceil(high[1] + more), height)};
}

void measure_edges(Outline outline, const TexelBox& box, float reach, std::span<float> distance) {
  along_edges(outline, box, reach, [&](std::int32_t x, std::int32_t y, double squared) {
    float& d = distance[static_cast<std::size_t>(y - box.y0) * box.width() + (x - box.x0)];
    d = std::min(d, static_cast<float>(std::sqrt(squared)));
  });
}

/// The parts of charts do not meet, so threads that take whole charts write to different texels.
Array<std::int32_t> find_owners(const PolygonMesh& polygons, const Atlas& atlas, const Threads& threads, Job& job) {
  Array<std::int32_t> owner(static_cast<std::size_t>(atlas.side) * atlas.height());
  std::fill(owner.begin(), owner.end(), kNone);
  std::vector<std::vector<std::int32_t>> members(atlas.chart_count);
  for (std::int32_t q = 0; q < polygons.polygon_count(); ++q) members[atlas.chart[q]].push_back(q);
  const auto at = [&](std::int32_t x, std::int32_t y) -> std::int32_t& {
    return owner[static_cast<std::size_t>(y) * atlas.side + x];
  };
  threads.share(atlas.chart_count, [&](const auto& next) {
    std::vector<double> cuts;
    for (std::int32_t c = next(); c < atlas.chart_count; c = next()) {
      job.poll();
      for (const std::int32_t q : members[c]) {
        const Outline outline = outline_of(polygons, atlas, q);
        fill(outline, box_of_outline(polygons, atlas, q), cuts, [&](std::int32_t x, std::int32_t y) {
          if (at(x, y) == kNone) at(x, y) = q;
        });
      }
      for (const std::int32_t q : members[c]) {
        const Outline outline = outline_of(polygons, atlas, q);
        along_edges(outline, box_of_outline(polygons, atlas, q), atlas.gutter / 2 - 0.5,
                    [&](std::int32_t x, std::int32_t y, double) {
                      if (at(x, y) == kNone) at(x, y) = -2 - q;
                    });
      }
    }
  });
  return owner;
}

}  // namespace isimp::detail
