// Cuts polygons into triangles.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "isimp/mesh/io.h"
#include "surface/edge_groups.h"
#include "surface/index_set.h"
#include "surface/point_boxes.h"

namespace isimp {
namespace {

using detail::turn;
using detail::Vec2;

constexpr std::int32_t kSmall = 64;  // work: corners of a polygon whose corners are all checked again after every ear
constexpr std::int64_t kStepsBetweenPolls = 1 << 15;                   // work
constexpr std::int64_t kStepsACorner = 300, kLeastSteps = 50'000'000;  // limit: limits of steps of the search for ears
constexpr std::int64_t kStepsCrossing = 30;  // limit: likewise once the polygon is known to meet
                                             // itself

/// Cuts ears off one polygon at a time; keeps its memory between them.
///
/// If the polygon does not meet itself, a corner that is no ear becomes one only when an adjacent corner is cut off: so
/// only the two neighbours are checked again. If this finds no ear, all corners are checked again, some times; after
/// that the polygon is one that meets itself, and loses the corner that turns most to the left.
class EarCutter {
 public:
  EarCutter(const std::vector<Vec3>& vertices, Triangulation& result, Job& job)
      : vertices_(vertices), result_(result), job_(job) {}

  void cut(std::span<const std::int32_t> polygon, std::int32_t number) {
    const auto n = static_cast<std::int32_t>(polygon.size());
    const auto emit = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
      result_.triangles.push_back({polygon[a], polygon[b], polygon[c]});
      result_.source_polygon.push_back(number);
    };
    if (n < 3) return;
    if (n == 3) return emit(0, 1, 2);
    flatten(polygon);
    link(n);
    std::int32_t at = 0;
    if (n == 4) at = (flat_[0] - flat_[2]).squaredNorm() <= (flat_[1] - flat_[3]).squaredNorm() ? 1 : 0;  // the shorter
    for (std::int32_t left = n; left > 3;) {
      at = find_ear(at, left);
      emit(previous_[at], at, next_[at]);
      at = remove(at);
      --left;
      if (left == 3) emit(previous_[at], at, next_[at]);
    }
  }

 private:
  void step() {
    if (++steps_ % kStepsBetweenPolls == 0) job_.poll();
  }

  /// Puts the polygon into the plane across its vector area (Newell), where it runs counter-clockwise, lengthwise along
  /// the first axis.
  void flatten(std::span<const std::int32_t> polygon) {
    const Vec3& origin = vertices_[polygon[0]];
    Vec3 area = Vec3::Zero();
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      area += (vertices_[polygon[i]] - origin).cross(vertices_[polygon[i + 1]] - origin);
    const Vec3 normal = area.normalized();
    Vec3 along = Vec3::Zero();
    for (const std::int32_t v : polygon)
      if (const Vec3 p = vertices_[v] - origin; p.squaredNorm() > along.squaredNorm()) along = p;
    const Vec3 x = (along - normal * normal.dot(along)).normalized(), y = normal.cross(x);
    flat_.clear();
    for (const std::int32_t v : polygon) {
      const Vec3 p = vertices_[v] - origin;
      flat_.emplace_back(p.dot(x), p.dot(y));
    }
  }
  void link(std::int32_t n) {
    previous_.resize(n);
    next_.resize(n);
    for (std::int32_t i = 0; i < n; ++i) {
      previous_[i] = i == 0 ? n - 1 : i - 1;
      next_[i] = i == n - 1 ? 0 : i + 1;
    }
    is_reflex_.assign(n, 0);
    reflex_.clear();
    for (std::int32_t i = 0; i < n; ++i) {
      if (corner(i) > 0) continue;
      is_reflex_[i] = 1;
      reflex_.push_back(i);
    }
    boxes_.build(flat_, reflex_, job_);
    untried_.reset(n);
    for (std::int32_t i = 0; i < n; ++i) untried_.insert(i);
    all_are_tried_ = true;  // holds once untried_ is empty
    is_small_ = n <= kSmall;
    searches_left_ = 4 * n;  // of all corners, for an ear that the search at neighbours misses
    steps_ = 0;
    last_step_ = std::max(kLeastSteps, kStepsACorner * n);
    widest_.clear();
  }
  [[nodiscard]] double corner(std::int32_t i) const { return turn(flat_[previous_[i]], flat_[i], flat_[next_[i]]); }

  /// The first ear from a corner on, or the corner that is cut off where there is none.
  std::int32_t find_ear(std::int32_t start, std::int32_t left) {
    while (true) {
      for (std::int32_t at = untried_.next(start); at != kNone; at = untried_.next(at)) {
        step();
        if (is_ear(at)) return at;
        untried_.erase(at);
      }
      if (all_are_tried_ || searches_left_ < left) return widest(start);
      searches_left_ -= left;
      try_all(start);
    }
  }
  void try_all(std::int32_t start) {
    untried_.insert(start);
    for (std::int32_t i = next_[start]; i != start; i = next_[i]) untried_.insert(i);
    all_are_tried_ = true;
  }
  /// Whether the triangle at a convex corner holds no other corner; only reflex ones can lie in it.
  [[nodiscard]] bool is_ear(std::int32_t i) {
    if (!(corner(i) > 0)) return false;
    if (steps_ > last_step_) return true;  // it would take too long to find out
    const std::int32_t p = previous_[i], n = next_[i];
    const Vec2 &a = flat_[p], &b = flat_[i], &c = flat_[n];
    const auto [left, right] = std::minmax({a.x(), b.x(), c.x()});
    const auto lies_inside = [&, left = left, right = right](std::int32_t r) {
      const Vec2& q = flat_[r];
      if (r == p || r == i || r == n || q.x() < left || q.x() > right) return false;
      if (q == a || q == b || q == c) return false;  // a bridge to a hole names its ends twice
      return turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0;
    };
    return !boxes_.any_near({a, b, c}, lies_inside, [&] { step(); });
  }
  /// The corner that turns most to the left.
  std::int32_t widest(std::int32_t start) {
    if (is_small_) {
      std::int32_t best = start;
      for (std::int32_t i = next_[start]; i != start; i = next_[i])
        if (corner(i) > corner(best)) best = i;
      return best;
    }
    if (widest_.empty()) {
      last_step_ = std::min(last_step_,
                            steps_ + std::max(kLeastSteps, kStepsCrossing * static_cast<std::int64_t>(next_.size())));
      offer(start);
      for (std::int32_t i = next_[start]; i != start; i = next_[i]) offer(i);
    }
    while (true) {  // the last state of each corner counts
      const auto [width, i] = widest_.front();
      std::pop_heap(widest_.begin(), widest_.end());
      widest_.pop_back();
      step();
      if (next_[i] != kNone && width == width_of(i)) return i;
    }
  }
  [[nodiscard]] double width_of(std::int32_t i) const {
    const double width = corner(i);
    return std::isnan(width) ? -std::numeric_limits<double>::infinity() : width;
  }
  void offer(std::int32_t i) {
    widest_.emplace_back(width_of(i), i);
    std::push_heap(widest_.begin(), widest_.end());
  }
  /// Removes a corner; returns the one from which to continue, two further, so that fans do not arise.
  std::int32_t remove(std::int32_t i) {
    const std::int32_t p = previous_[i], n = next_[i];
    next_[p] = n;
    previous_[n] = p;
    next_[i] = kNone;
    untried_.erase(i);
    if (is_reflex_[i]) straighten(i);
    for (const std::int32_t r : {p, n}) {
      if (is_reflex_[r] && corner(r) > 0) straighten(r);
      untried_.insert(r);
      if (!widest_.empty()) offer(r);
    }
    all_are_tried_ = false;
    if (is_small_) try_all(p);
    return next_[n];
  }
  void straighten(std::int32_t i) {
    is_reflex_[i] = 0;
    boxes_.remove(i);
  }

  const std::vector<Vec3>& vertices_;
  Triangulation& result_;
  Job& job_;
  std::vector<Vec2> flat_;
  std::vector<std::int32_t> previous_, next_;
  std::vector<char> is_reflex_;
  std::vector<std::int32_t> reflex_;
  detail::PointBoxes boxes_;  // points of the corners that still are reflex
  detail::IndexSet untried_;  // corners of which it is not known that they are no ears
  bool all_are_tried_ = false, is_small_ = false;
  std::int64_t searches_left_ = 0, steps_ = 0, last_step_ = 0;
  std::vector<std::pair<double, std::int32_t>> widest_;  // a heap; empty while it is not needed
};

}  // namespace

bool are_triangles(const PolygonSoup& soup, Job& job) {
  if (soup.loops.size() != 3 * soup.loop_start.size()) return false;
  bool equal = true;
  detail::for_each_index(soup.loop_start.size(), job,
                         [&](std::size_t q) { equal &= static_cast<std::size_t>(soup.loop_start[q]) == 3 * q; });
  return equal;
}

Triangulation triangulate(const PolygonSoup& soup, Job& job) {
  Triangulation result;
  if (are_triangles(soup, job)) {
    result.triangles.resize(soup.loop_start.size());
    result.source_polygon.resize(soup.loop_start.size());
    detail::for_each_index(soup.loop_start.size(), job, [&](std::size_t q) {
      for (std::size_t k = 0; k < 3; ++k) result.triangles[q][k] = soup.loops[3 * q + k];
      result.source_polygon[q] = static_cast<std::int32_t>(q);
    });
    return result;
  }
  result.triangles.reserve(soup.loops.size() / 3);
  result.source_polygon.reserve(soup.loops.size() / 3);
  EarCutter cutter(soup.vertices, result, job);
  for (std::int32_t q = 0; q < soup.polygon_count(); ++q) {
    if (q % detail::kPollEvery == 0) job.poll();
    cutter.cut(soup.polygon(q), q);
  }
  return result;
}

}  // namespace isimp
