#include "draw/lean.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "draw/ownership.h"

namespace isimp::detail {
namespace {

// tuned texture
// Polygons at sharper edges do not bend each other's directions: the walls of a house are drawn straight. Cosine.
constexpr double kSmooth = 0.2;
constexpr float kOnEdge = 1e-3F;  // squared texels

// Share of the way to the mean normal. 1 is nearest to the scan in close-ups, 0 in views of the whole.
constexpr double kShare = 0.9;

using Corner = std::array<double, 4>;  // a polygon's angle at a vertex, and its normal

}  // namespace

std::vector<Slope> corner_slopes(const PolygonMesh& polygons, const Atlas& atlas) {
  const std::int32_t count = polygons.polygon_count();
  std::vector<std::int32_t> start(polygons.vertices.size() + 1, 0);
  for (const std::int32_t v : polygons.loops) ++start[v + 1];
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<Corner> corners(polygons.loops.size());
  std::vector<std::int32_t> at(start.begin(), start.end() - 1);
  for (std::int32_t q = 0; q < count; ++q) {
    const Vec3& n = atlas.frame[q].n;
    const std::int32_t begin = polygons.loop_start[q];
    const auto outline = outline_of(polygons, atlas, q);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto &here = outline[i], &after = outline[(i + 1) % outline.size()];
      const auto& before = outline[(i + outline.size() - 1) % outline.size()];
      const double ax = after[0] - here[0], ay = after[1] - here[1], bx = before[0] - here[0], by = before[1] - here[1];
      const double angle = std::atan2(ax * by - ay * bx, ax * bx + ay * by);
      corners[at[polygons.loops[begin + i]]++] = {angle < 0 ? angle + 2 * std::numbers::pi : angle, n.x(), n.y(),
                                                  n.z()};
    }
  }
  // The same sums for any numbering of the polygons.
  for (std::size_t v = 0; v + 1 < start.size(); ++v)
    std::sort(corners.data() + start[v], corners.data() + start[v + 1]);
  std::vector<Slope> slopes(polygons.loops.size());
  for (std::int32_t q = 0; q < count; ++q) {
    const ChartFrame& frame = atlas.frame[q];
    const Vec3 u = frame.u.normalized(), v = frame.v.normalized();
    for (std::int32_t i = polygons.loop_start[q]; i < polygons.loop_end(q); ++i) {
      Vec3 mean = Vec3::Zero();
      for (std::int32_t c = start[polygons.loops[i]]; c < start[polygons.loops[i] + 1]; ++c) {
        const auto& [angle, x, y, z] = corners[c];
        if (const Vec3 n(x, y, z); n.dot(frame.n) >= kSmooth) mean += angle * n;
      }
      const double right = mean.dot(u), up = mean.dot(v), out = mean.dot(frame.n);
      const double scale = out > 0 ? kShare / out : 0;
      slopes[i] = {static_cast<float>(scale * right), static_cast<float>(scale * up)};
    }
  }
  return slopes;
}

Lean::Lean(std::span<const std::array<double, 2>> outline, std::span<const Slope> slopes) {
  if (std::all_of(slopes.begin(), slopes.end(), [](const Slope& slope) { return slope == Slope{}; })) return;
  for (std::size_t i = 0, h = outline.size() - 1; i < outline.size(); h = i++) {
    Edge e;
    e.x = static_cast<float>(outline[h][0]);
    e.y = static_cast<float>(outline[h][1]);
    e.ex = static_cast<float>(outline[i][0]) - e.x;
    e.ey = static_cast<float>(outline[i][1]) - e.y;
    const float squared = e.ex * e.ex + e.ey * e.ey;
    if (!(squared > 0)) continue;
    e.over = 1 / squared;
    e.length = std::sqrt(squared);
    e.from = slopes[h];
    e.change = {slopes[i][0] - slopes[h][0], slopes[i][1] - slopes[h][1]};
    edges_.push_back(e);
  }
}

Slope Lean::at(float x, float y) const {
  float right = 0, up = 0, sum = 0;
  for (const Edge& e : edges_) {
    const float px = x - e.x, py = y - e.y;
    const float t = std::clamp((px * e.ex + py * e.ey) * e.over, 0.0F, 1.0F);
    const float dx = px - t * e.ex, dy = py - t * e.ey;
    const float weight = e.length / (dx * dx + dy * dy + kOnEdge);
    sum += weight;
    right += weight * (e.from[0] + t * e.change[0]);
    up += weight * (e.from[1] + t * e.change[1]);
  }
  return sum > 0 ? Slope{right / sum, up / sum} : Slope{};
}

}  // namespace isimp::detail
