#include "isimp/tiles/weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/core/to_integer.h"

namespace isimp::tiles {
namespace {

constexpr std::int64_t kFarthest = std::int64_t{1} << 53;  // largest cell index: doubles resolve no cells beyond

/// Points by the cubic cell that contains them.
class Grid {
 public:
  Grid(std::span<const Vec3> points, double size) : points_(points), size_(size) {
    if (!points.empty()) origin_ = points[0];
  }
  void insert(std::int32_t i) { cells_[key(cell(points_[i]))].push_back(i); }
  /// Calls fn(i) for all points within `size` of a place, and for some others.
  template <class Function>
  void near(const Vec3& place, Function fn) const {
    const Cell at = cell(place);
    for (std::int64_t x = -1; x <= 1; ++x)
      for (std::int64_t y = -1; y <= 1; ++y)
        for (std::int64_t z = -1; z <= 1; ++z)
          if (const auto found = cells_.find(key({at[0] + x, at[1] + y, at[2] + z})); found != cells_.end())
            for (const std::int32_t i : found->second) fn(i);
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  [[nodiscard]] Cell cell(const Vec3& p) const {
    Cell c;
    for (int k = 0; k < 3; ++k) c[k] = to_integer(std::floor((p[k] - origin_[k]) / size_), -kFarthest, kFarthest);
    return c;
  }
  /// Cells with the same key share their points. Callers of `near` measure all distances, so this is harmless.
  static std::uint64_t key(const Cell& c) {
    std::uint64_t h = 0;
    for (const std::int64_t x : c) {
      h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15U;
      h ^= h >> 29;
    }
    return h;
  }

  std::span<const Vec3> points_;
  double size_;
  Vec3 origin_ = Vec3::Zero();
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;
};

void check_length(double length) {
  if (!(length > 0) || !std::isfinite(length))
    throw InvalidInput("the length to weld within must be above 0, got " + std::to_string(length));
}

/// A point, and the nearest place of an earlier tile that it could take.
struct Wish {
  std::int32_t place;
  double distance;
  std::int32_t point;
  bool operator<(const Wish& o) const {
    return place != o.place ? place < o.place : distance != o.distance ? distance < o.distance : point < o.point;
  }
};

}  // namespace

std::vector<std::int32_t> weld(std::span<const Vec3> points, std::span<const std::int32_t> tile, double length,
                               Job& job) {
  check_length(length);
  if (tile.size() != points.size()) throw InvalidInput("each point must have a tile");
  if (!std::is_sorted(tile.begin(), tile.end())) throw InvalidInput("points must be in the order of their tiles");
  const auto count = static_cast<std::int32_t>(points.size());
  std::vector<std::int32_t> to(points.size());
  Grid grid(points, length);
  std::vector<Wish> wishes;
  for (std::int32_t begin = 0, end = 0; begin < count; begin = end) {
    wishes.clear();
    for (; end < count && tile[end] == tile[begin]; ++end) {
      if ((end & 0xfff) == 0) job.poll();
      to[end] = end;
      Wish best{kNone, length, end};
      grid.near(points[end], [&](std::int32_t i) {
        const double d = (points[i] - points[end]).norm();
        if (d < best.distance || (d == best.distance && (best.place == kNone || i < best.place))) {
          best.place = i;
          best.distance = d;
        }
      });
      if (best.place != kNone) wishes.push_back(best);
    }
    std::sort(wishes.begin(), wishes.end());
    for (std::size_t k = 0, first = 0; k < wishes.size(); ++k) {
      if (wishes[k].place != wishes[first].place) first = k;
      // Vertices of a tile at exactly the same place move together.
      if (k == first || points[wishes[k].point] == points[wishes[first].point]) to[wishes[k].point] = wishes[k].place;
    }
    for (std::int32_t i = begin; i < end; ++i)
      if (to[i] == i) grid.insert(i);
  }
  return to;
}

std::vector<OnEdge> points_on_edges(std::span<const Vec3> ends, std::span<const Vec3> points, double length, Job& job) {
  check_length(length);
  if (ends.size() % 2 != 0) throw InvalidInput("each edge must have two ends");
  const auto edges = static_cast<std::int32_t>(ends.size() / 2);
  double mean = 0;
  for (std::int32_t e = 0; e < edges; ++e) mean += (ends[2 * e + 1] - ends[2 * e]).norm() / edges;
  const double step = std::max(mean, 2 * length);
  Grid grid(points, step);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(points.size()); ++i) grid.insert(i);
  std::vector<OnEdge> result;
  std::vector<std::int32_t> found;
  for (std::int32_t e = 0; e < edges; ++e) {
    if ((e & 0xfff) == 0) job.poll();
    const Vec3 &a = ends[2 * e], &b = ends[2 * e + 1];
    const Vec3 d = b - a;
    const double size = d.norm();
    if (!(size > 0)) continue;
    found.clear();
    const std::int32_t steps = to_integer(std::ceil(size / step), 0, edges + 1) + 1;
    for (std::int32_t s = 0; s <= steps; ++s)
      grid.near(a + static_cast<double>(s) / steps * d, [&](std::int32_t i) { found.push_back(i); });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    const std::size_t first = result.size();
    for (const std::int32_t i : found) {
      const Vec3 p = points[i] - a;
      const double along = p.dot(d) / (size * size);
      if (along <= 0 || along >= 1 || (p - along * d).norm() > length) continue;
      if (p.norm() <= length || (points[i] - b).norm() <= length) continue;
      result.push_back({e, i, along});
    }
    std::sort(result.begin() + static_cast<std::ptrdiff_t>(first), result.end(), [](const OnEdge& x, const OnEdge& y) {
      return x.along != y.along ? x.along < y.along : x.point < y.point;
    });
  }
  return result;
}

}  // namespace isimp::tiles
