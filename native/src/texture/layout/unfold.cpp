// Unfolds polygons into charts along shared edges.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "isimp/mesh/io.h"
#include "layout/layout.h"

namespace isimp::detail {
namespace {

// tuned texture
constexpr double kLargest = 0.22;  // extent of a chart over that of the whole atlas: larger ones pack badly
constexpr double kSlack = 1e-4;    // rounding: overlap that is rounding, as a share of a polygon's usual extent

struct Flat3 {
  std::array<Vec2, 3> p;  // counter-clockwise
  Vec2 low, high;

  explicit Flat3(std::array<Vec2, 3> corners) : p(std::move(corners)) {
    const Vec2 a = p[1] - p[0], b = p[2] - p[0];
    if (a.x() * b.y() - a.y() * b.x() < 0) std::swap(p[1], p[2]);
    low = p[0].cwiseMin(p[1]).cwiseMin(p[2]);
    high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  }
  [[nodiscard]] Flat3 moved(const Rigid& by) const { return Flat3({by(p[0]), by(p[1]), by(p[2])}); }
};

/// Whether an edge of `a` has all of `b` beyond it, give or take `slack`.
bool keeps_apart(const Flat3& a, const Flat3& b, double slack) {
  for (int i = 0; i < 3; ++i) {
    const Vec2 e = a.p[(i + 1) % 3] - a.p[i];
    const double length = e.norm();
    if (!(length > 0)) continue;
    const auto inside = [&](const Vec2& q) {
      const Vec2 d = q - a.p[i];
      return e.x() * d.y() - e.y() * d.x();
    };
    if (std::max({inside(b.p[0]), inside(b.p[1]), inside(b.p[2])}) <= slack * length) return true;
  }
  return false;
}

bool overlap(const Flat3& a, const Flat3& b, double slack) {
  if ((a.low.array() >= b.high.array() - slack).any() || (b.low.array() >= a.high.array() - slack).any()) return false;
  return !keeps_apart(a, b, slack) && !keeps_apart(b, a, slack);
}

/// An edge of two polygons, with the corner of each where it begins.
struct Join {
  double order;  // the flattest and longest first
  std::int32_t p, i, q, j;
};

class Unfolder {
 public:
  Unfolder(const PolygonMesh& polygons, double angle, Layout& layout, Job& job)
      : polygons_(polygons), layout_(layout), cosine_(std::cos(angle * std::numbers::pi / 180)) {
    cut(job);
    const std::int32_t count = layout.polygon_count();
    members_.resize(count);
    low_.resize(count);
    high_.resize(count);
    for (std::int32_t q = 0; q < count; ++q) {
      members_[q] = {q};
      low_[q] = high_[q] = layout.flat[layout.start[q]];
      for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i) {
        low_[q] = low_[q].cwiseMin(layout.flat[i]);
        high_[q] = high_[q].cwiseMax(layout.flat[i]);
      }
    }
    largest_ = kLargest * std::sqrt(layout.tile_area);
    slack_ = kSlack * std::sqrt(layout.area / std::max(count, 1));
  }

  void run(Job& job) {
    std::vector<Join> all = joins();
    std::sort(all.begin(), all.end(),
              [](const Join& a, const Join& b) { return std::tie(a.order, a.p, a.i) < std::tie(b.order, b.p, b.i); });
    std::int32_t done = 0;
    for (const Join& join : all) {
      if (done++ % 64 == 0) job.poll();
      try_join(join);
    }
    renumber();
  }

 private:
  /// The triangles of each polygon in its chart, for the search for overlaps.
  void cut(Job& job) {
    PolygonSoup soup{polygons_.vertices,
                     {polygons_.loops.begin(), polygons_.loops.end()},
                     {polygons_.loop_start.begin(), polygons_.loop_start.end()}};
    const Triangulation cut = triangulate(soup, job);
    triangles_.resize(layout_.polygon_count());
    for (std::size_t t = 0; t < cut.triangles.size(); ++t) {
      const std::int32_t q = cut.source_polygon[t];
      const auto corner = [&](std::int32_t vertex) {
        const auto begin = polygons_.loops.begin() + layout_.start[q],
                   end = polygons_.loops.begin() + layout_.start[q + 1];
        return layout_.flat[layout_.start[q] + (std::find(begin, end, vertex) - begin)];
      };
      const Triangle& v = cut.triangles[t];
      triangles_[q].push_back(Flat3({corner(v[0]), corner(v[1]), corner(v[2])}));
    }
  }

  [[nodiscard]] std::int32_t next(std::int32_t q, std::int32_t i) const {
    return i + 1 < layout_.start[q + 1] ? i + 1 : layout_.start[q];
  }

  std::vector<Join> joins() const {
    std::vector<std::array<std::int32_t, 5>> edges;  // lower vertex, upper vertex, polygon, corner, whether it rises
    for (std::int32_t q = 0; q < layout_.polygon_count(); ++q)
      for (std::int32_t i = layout_.start[q]; i < layout_.start[q + 1]; ++i) {
        const std::int32_t a = polygons_.loops[i], b = polygons_.loops[next(q, i)];
        if (a != b) edges.push_back({std::min(a, b), std::max(a, b), q, i, a < b});
      }
    std::sort(edges.begin(), edges.end());
    std::vector<Join> all;
    for (std::size_t k = 0, end = 0; k < edges.size(); k = end) {
      for (end = k; end < edges.size() && edges[end][0] == edges[k][0] && edges[end][1] == edges[k][1];) ++end;
      if (end - k != 2 || edges[k][2] == edges[k + 1][2] || edges[k][4] == edges[k + 1][4]) continue;
      if (layout_.group[edges[k][2]] != layout_.group[edges[k + 1][2]]) continue;
      const auto [a, b, p, i, rises] = edges[k];
      const std::int32_t q = edges[k + 1][2], j = edges[k + 1][3];
      const double cosine = layout_.plane[p].n.dot(layout_.plane[q].n);
      const double length = (polygons_.vertices[a] - polygons_.vertices[b]).norm();
      if (cosine > cosine_ && length > 0) all.push_back({-length * (1 + cosine), p, i, q, j});
    }
    return all;
  }

  /// The motion that moves the chart of q next to that of p, edge to edge.
  [[nodiscard]] Rigid beside(const Join& join) const {
    const Vec2 a = layout_.corner(join.p, join.i), b = layout_.corner(join.p, next(join.p, join.i));
    const Vec2 d = layout_.corner(join.q, join.j), c = layout_.corner(join.q, next(join.q, join.j));
    const Vec2 e = b - a, f = d - c;
    const double angle = std::atan2(e.y(), e.x()) - std::atan2(f.y(), f.x());
    Rigid rigid;
    rigid.turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    rigid.shift = (a + b) / 2 - rigid.turn * ((c + d) / 2);
    return rigid;
  }

  void try_join(Join join) {
    std::int32_t to = layout_.chart[join.p], from = layout_.chart[join.q];
    if (to == from) return;
    if (members_[to].size() < members_[from].size()) {
      std::swap(to, from);
      join = {join.order, join.q, join.j, join.p, join.i};
    }
    const Rigid rigid = beside(join);
    std::vector<std::vector<Flat3>> moved;
    Vec2 low = low_[to], high = high_[to];
    for (const std::int32_t q : members_[from]) {
      std::vector<Flat3>& triangles = moved.emplace_back();
      for (const Flat3& t : triangles_[q]) {
        triangles.push_back(t.moved(rigid));
        low = low.cwiseMin(triangles.back().low);
        high = high.cwiseMax(triangles.back().high);
      }
    }
    if ((high - low).maxCoeff() > largest_ || meets(to, moved)) return;
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const std::int32_t q = members_[from][k];
      triangles_[q] = std::move(moved[k]);
      layout_.place[q] = rigid * layout_.place[q];
      layout_.chart[q] = to;
    }
    members_[to].insert(members_[to].end(), members_[from].begin(), members_[from].end());
    members_[from].clear();
    low_[to] = low;
    high_[to] = high;
  }

  [[nodiscard]] bool meets(std::int32_t chart, const std::vector<std::vector<Flat3>>& moved) const {
    for (const std::vector<Flat3>& triangles : moved)
      for (const Flat3& t : triangles) {
        if ((t.low.array() >= high_[chart].array()).any() || (t.high.array() <= low_[chart].array()).any()) continue;
        for (const std::int32_t q : members_[chart])
          for (const Flat3& other : triangles_[q])
            if (overlap(t, other, slack_)) return true;
      }
    return false;
  }

  /// Numbers the charts 0, 1, ... by their first polygons.
  void renumber() {
    std::vector<std::int32_t> number(layout_.chart.size(), kNone);
    layout_.chart_count = 0;
    for (std::int32_t& chart : layout_.chart) {
      if (number[chart] == kNone) number[chart] = layout_.chart_count++;
      chart = number[chart];
    }
  }

  const PolygonMesh& polygons_;
  Layout& layout_;
  double cosine_, largest_ = 0, slack_ = 0;
  std::vector<std::vector<Flat3>> triangles_;       // (Q) in the chart
  std::vector<std::vector<std::int32_t>> members_;  // (charts)
  std::vector<Vec2> low_, high_;                    // (charts)
};

}  // namespace

void unfold(const PolygonMesh& polygons, double angle, Layout& layout, Job& job) {
  Unfolder(polygons, angle, layout, job).run(job);
}

}  // namespace isimp::detail
