#include "repair/convex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "discs/vec2.h"
#include "isimp/core/sorted.h"
#include "judge/trials.h"

namespace isimp::meshing {
namespace {

/// rounding: depth of a corner below the line between its neighbours up to which it counts as straight, as a share of the
/// diagonal: corners of planar polygons are on their planes, and so on straight lines, to this much.
constexpr double kStraightDepth = 1e-7;

constexpr std::size_t kTried = 64;        ///< limit: cuts of a polygon that are tried to their end
constexpr std::size_t kMostPlanned = 64;  ///< limit: corners of a polygon for which they are

/// A polygon seen along its normal.
class View {
 public:
  View(const State& state, std::int32_t polygon) : slack_(kStraightDepth * state.mesh.diagonal()) {
    const auto loop = state.polygons.of(polygon);
    const auto& at = state.corners.position;
    const Vec3 area = vector_area(loop, at);
    if (!(area.norm() > 0)) return;  // no corner is reflex then
    const Vec3 normal = area.normalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
    for (const std::int32_t c : loop) {
      const Vec3 p = at[c] - at[loop[0]];
      corner_.push_back(static_cast<std::int32_t>(points_.size()));
      points_.emplace_back(p.dot(u), p.dot(v));
    }
  }

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] std::size_t after(std::size_t i) const { return i + 1 < size() ? i + 1 : 0; }
  [[nodiscard]] std::size_t before(std::size_t i) const { return i > 0 ? i - 1 : size() - 1; }
  /// Whether the way from a by b to c turns right.
  [[nodiscard]] bool turns_right(std::size_t a, std::size_t b, std::size_t c) const {
    return cross(points_[b] - points_[a], points_[c] - points_[b]) < -slack_ * (points_[c] - points_[a]).norm();
  }
  [[nodiscard]] bool is_reflex(std::size_t i) const { return turns_right(before(i), i, after(i)); }

  [[nodiscard]] bool is_concave() const {
    for (std::size_t i = 0; i < size(); ++i)
      if (is_reflex(i)) return true;
    return false;
  }
  /// The number of a corner in the whole polygon.
  [[nodiscard]] std::int32_t corner(std::size_t i) const { return corner_[i]; }

  /// A diagonal between two corners, and its effect.
  struct Cut {
    std::int32_t convex = 0;  ///< reflex corners that are convex in both parts
    double least = 0;         ///< the least of the four angles at its ends, by a measure that rises with the angle
    std::size_t i = 0, j = 0;
    std::int32_t parts = std::numeric_limits<std::int32_t>::max();  ///< as `parts_after` counts them
    [[nodiscard]] bool is_better(const Cut& o) const {
      return convex != o.convex ? convex > o.convex : least > o.least;
    }
  };
  /// The cut between two corners; nullopt if it leaves the polygon near its ends.
  [[nodiscard]] std::optional<Cut> cut(std::size_t i, std::size_t j) const {
    Cut made{0, 4, i, j};
    for (const auto& [end, other] : {std::pair(i, j), std::pair(j, i)}) {
      if (!is_within(end, other)) return std::nullopt;
      if (is_reflex(end) && !turns_right(before(end), end, other) && !turns_right(other, end, after(end)))
        ++made.convex;
      made.least = std::min({made.least, width(before(end), end, other), width(other, end, after(end))});
    }
    return made;
  }
  /// The two parts that a diagonal leaves, seen in the same way.
  [[nodiscard]] std::array<View, 2> divided(const Cut& c) const {
    std::array<View, 2> parts{View(slack_), View(slack_)};
    for (const auto& [part, from, to] : {std::tuple(0, c.i, c.j), std::tuple(1, c.j, c.i)})
      for (std::size_t k = from;; k = after(k)) {
        parts[part].points_.push_back(points_[k]);
        parts[part].corner_.push_back(corner_[k]);
        if (k == to) break;
      }
    return parts;
  }
  /// Whether a diagonal meets no edge and no corner but its ends.
  [[nodiscard]] bool is_free(const Cut& c) const {
    const Vec2 &a = points_[c.i], &b = points_[c.j], way = b - a;
    const double length = way.norm();
    for (std::size_t k = 0; k < size(); ++k) {
      const Vec2& p = points_[k];
      if (k == c.i || k == c.j) continue;
      const double along = way.dot(p - a), off = cross(way, p - a);
      if (along >= 0 && along <= length * length && std::abs(off) <= slack_ * length) return false;
      const std::size_t next = after(k);
      if (next == c.i || next == c.j) continue;
      const Vec2& q = points_[next];
      if ((off > 0) != (cross(way, q - a) > 0) && (cross(q - p, a - p) > 0) != (cross(q - p, b - p) > 0)) return false;
    }
    return true;
  }

 private:
  explicit View(double slack) : slack_(slack) {}
  /// Whether the diagonal from one corner to another begins inside the polygon.
  [[nodiscard]] bool is_within(std::size_t i, std::size_t j) const {
    const Vec2 to = points_[after(i)] - points_[i], from = points_[before(i)] - points_[i],
               way = points_[j] - points_[i];
    const bool left = cross(to, way) > 0, right = cross(way, from) > 0;
    return cross(to, from) > 0 ? left && right : left || right;
  }
  /// 1 - cos of the angle, and beyond 180 degrees more.
  [[nodiscard]] double width(std::size_t from, std::size_t at, std::size_t to) const {
    const Vec2 a = (points_[to] - points_[at]).normalized(), b = (points_[from] - points_[at]).normalized();
    return cross(a, b) < 0 ? 3 + a.dot(b) : 1 - a.dot(b);
  }

  double slack_;
  std::vector<Vec2> points_;
  std::vector<std::int32_t> corner_;
};

/// Which two corners of a polygon an edge joins already.
using Joined = std::vector<std::array<std::int32_t, 2>>;

/// Cuts that help and can be made, the best first.
/// \param most  such cuts
std::vector<View::Cut> cuts_of(const View& view, const Joined& joined, std::size_t most) {
  std::vector<View::Cut> cuts, allowed;
  const std::size_t n = view.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (!view.is_reflex(i)) continue;
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i || j == view.after(i) || j == view.before(i) || (j < i && view.is_reflex(j))) continue;
      if (const auto cut = view.cut(i, j)) cuts.push_back(*cut);
    }
  }
  std::ranges::stable_sort(cuts, [](const View::Cut& a, const View::Cut& b) { return a.is_better(b); });
  for (const View::Cut& c : cuts) {
    if (allowed.size() == most) break;
    const std::int32_t a = view.corner(c.i), b = view.corner(c.j);
    if (!std::ranges::binary_search(joined, std::array{std::min(a, b), std::max(a, b)}) && view.is_free(c))
      allowed.push_back(c);
  }
  return allowed;
}

/// The number of parts if a polygon is cut, and its parts always by the cut that is best at once. A part that stays
/// concave counts as many.
std::int32_t parts_after(const View& view, const View::Cut& first, const Joined& joined) {
  constexpr std::int32_t kConcave = 1000;  // mark
  const auto [left, right] = view.divided(first);
  std::vector<View> open{left, right};
  std::int32_t parts = 0;
  while (!open.empty()) {
    const View next = std::move(open.back());
    open.pop_back();
    const auto cuts = cuts_of(next, joined, 1);
    if (cuts.empty()) {
      parts += next.is_concave() ? kConcave : 1;
    } else {
      auto [a, b] = next.divided(cuts[0]);
      open.push_back(std::move(a));
      open.push_back(std::move(b));
    }
  }
  return parts;
}

/// The pairs of a polygon's corners that follow each other in some polygon, in rising order.
Joined joined_in(const State& state, std::span<const std::int32_t> loop) {
  std::vector<std::array<std::int32_t, 2>> place;  // corners with their places in the loop
  for (std::size_t i = 0; i < loop.size(); ++i) place.push_back({loop[i], static_cast<std::int32_t>(i)});
  std::ranges::sort(place);
  Joined joined;
  for (const auto& [corner, i] : place)
    for (const std::int32_t q : state.polygons.at(corner)) {
      const auto other = state.polygons.of(q);
      for (std::size_t k = 0; k < other.size(); ++k) {
        if (other[k] != corner) continue;
        const std::int32_t next = other[k + 1 < other.size() ? k + 1 : 0];
        for (auto at = std::ranges::lower_bound(place, std::array{next, std::int32_t{0}});
             at != place.end() && (*at)[0] == next; ++at)
          joined.push_back({std::min(i, (*at)[1]), std::max(i, (*at)[1])});
      }
    }
  sort_unique(joined);
  return joined;
}

/// \return whether the polygon was cut
bool cut(State& state, Defects& defects, std::int32_t polygon) {
  const View view(state, polygon);
  if (!view.is_concave()) return false;
  const auto span = state.polygons.of(polygon);
  const std::vector<std::int32_t> loop(span.begin(), span.end());  // a trial may move the numbers
  const std::int32_t chart = state.polygons.chart(polygon);
  const Joined joined = joined_in(state, loop);
  std::vector<View::Cut> cuts = cuts_of(view, joined, loop.size() * loop.size());
  if (loop.size() <= kMostPlanned) {
    for (std::size_t i = 0; i < std::min(cuts.size(), kTried); ++i) cuts[i].parts = parts_after(view, cuts[i], joined);
    std::ranges::stable_sort(cuts, {}, &View::Cut::parts);
  }
  for (const View::Cut& c : cuts) {
    std::vector<std::array<std::int32_t, 2>> all = state.diagonals[chart];
    all.push_back({state.corners.vertex[loop[c.i]], state.corners.vertex[loop[c.j]]});
    const auto add = [&] {
      state.set_diagonals(chart, all);
      return true;
    };
    if (attempt(state, defects, {chart}, kNone, add)) return true;
  }
  return false;
}

}  // namespace

std::int32_t make_convex(State& state, Defects& defects, const Job& job) {
  std::int32_t made = 0;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    job.poll();
    for (std::int32_t part = 0; part < state.polygons.count_of(l);) {
      if (cut(state, defects, state.polygons.first_of(l) + part)) {
        ++made;
        part = 0;  // the polygons of the chart have new numbers
      } else {
        ++part;
      }
    }
  }
  defects.renew_hits();
  return made;
}

std::int32_t count_concave(const State& state) {
  std::int32_t count = 0;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l)
    state.polygons.for_each_of(l, [&](std::int32_t q) { count += View(state, q).is_concave() ? 1 : 0; });
  return count;
}

}  // namespace isimp::meshing
