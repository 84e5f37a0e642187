#include "complex/polygons.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "isimp/core/check.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

using Cycle = std::vector<std::int32_t>;  // mesh vertices
using Edge = std::array<std::int32_t, 2>;

Edge edge(std::int32_t a, std::int32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Splits the one of `cycles` that has both ends and not as neighbours.
/// \return whether there is one
bool split_at(std::vector<Cycle>& cycles, const Edge& diagonal) {
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    const Cycle& c = cycles[k];
    auto i = std::find(c.begin(), c.end(), diagonal[0]), j = std::find(c.begin(), c.end(), diagonal[1]);
    if (i == c.end() || j == c.end()) continue;
    if (i > j) std::swap(i, j);
    if (j - i < 2 || (i == c.begin() && j == c.end() - 1)) return false;
    Cycle a(i, j + 1), b(j, c.end());
    b.insert(b.end(), c.begin(), i + 1);
    cycles[k] = std::move(a);
    cycles.push_back(std::move(b));
    return true;
  }
  return false;
}

/// The ends of all chords of some charts, in order.
std::vector<Edge> chord_ends(const Complex& complex, const Mesh& mesh, std::span<const std::int32_t> charts) {
  std::vector<Edge> ends;
  for (const std::int32_t l : charts) {
    const auto chords = complex.chords(l);
    for (std::size_t i = 0; i < chords.size(); ++i)
      ends.push_back(edge(mesh.from(chords[i]), mesh.from(chords[i + 1 < chords.size() ? i + 1 : 0])));
  }
  std::sort(ends.begin(), ends.end());
  return ends;
}

/// Whether the polygons of a chart are listed at each of their corners.
[[maybe_unused]] bool is_listed(const Polygons& polygons, std::int32_t chart) {
  bool all = true;
  polygons.for_each_of(chart, [&](std::int32_t q) {
    all = all && polygons.chart(q) == chart && !polygons.of(q).empty();
    for (const std::int32_t c : polygons.of(q))
      all = all && std::find(polygons.at(c).begin(), polygons.at(c).end(), q) != polygons.at(c).end();
  });
  return all;
}

}  // namespace

std::int32_t Corners::at(std::int32_t v) {
  if (of_vertex[v] == kNone) {
    of_vertex.set(v, count());
    vertex.push_back(v);
    radius.push_back(0);
    position.push_back(Vec3::Zero());
  }
  ISIMP_ASSERT(of_vertex[vertex[of_vertex[v]]] == of_vertex[v], "a corner stands for its vertex");
  ISIMP_ASSERT(radius.size() == vertex.size() && position.size() == vertex.size(),
               "every corner has a radius and a place");
  return of_vertex[v];
}

void Corners::share(std::int32_t v, std::span<const std::int32_t> vertices) {
  const std::int32_t c = at(v);
  for (const std::int32_t other : vertices) of_vertex.set(other, c);
}

void Corners::part(std::int32_t v, std::span<const std::int32_t> vertices) {
  for (const std::int32_t other : vertices)
    if (other != v) of_vertex.set(other, kNone);
}

void Polygons::remove(std::int32_t chart) {
  for_each_of(chart, [&](std::int32_t q) {
    for (const std::int32_t c : of(q)) std::erase(around_.edit(c), q);
    --in_use_.edit(0);
    in_use_.edit(1) -= loops_[q].size;
    loops_.set(q, {0, 0, kNone});
  });
  charts_.edit(chart).count = 0;
}

void Polygons::add(std::int32_t chart, std::span<const Cycle> cycles, Corners& corners) {
  charts_.set(chart, {numbers(), static_cast<std::int32_t>(cycles.size())});
  for (const Cycle& cycle : cycles) {
    const std::int32_t q = numbers();
    loops_.push_back({static_cast<std::int32_t>(corners_.size()), static_cast<std::int32_t>(cycle.size()), chart});
    ++in_use_.edit(0);
    in_use_.edit(1) += loops_.back().size;
    for (const std::int32_t v : cycle) {
      const std::int32_t c = corners.at(v);
      corners_.push_back(c);
      if (static_cast<std::int32_t>(around_.size()) <= c) around_.resize(c + 1);
      auto& round = around_.edit(c);
      round.insert(
          std::upper_bound(round.begin(), round.end(), chart, [&](auto l, auto r) { return l < loops_[r].chart; }), q);
    }
  }
}

void Polygons::close_gaps() {
  ISIMP_ASSERT(!loops_.in_transaction(), "numbers last as long as a transaction");
  constexpr std::size_t kFew = 1024;  // work
  const std::size_t polygons = in_use_[0], used = in_use_[1];
  if (loops_.size() <= 2 * polygons + kFew && corners_.size() <= 2 * used + kFew) return;
  std::vector<Loop> loops;
  std::vector<std::int32_t> left;
  for (std::size_t c = 0; c < around_.size(); ++c) around_.edit(c).clear();
  for (std::size_t l = 0; l < charts_.size(); ++l) {
    const std::int32_t first = charts_[l].first;
    charts_.edit(l).first = static_cast<std::int32_t>(loops.size());
    for (std::int32_t q = first; q < first + charts_[l].count; ++q) {
      for (const std::int32_t c : of(q)) around_.edit(c).push_back(static_cast<std::int32_t>(loops.size()));
      const auto begin = static_cast<std::int32_t>(left.size());
      left.insert(left.end(), of(q).begin(), of(q).end());
      loops.push_back({begin, loops_[q].size, loops_[q].chart});
    }
  }
  loops_.assign(std::move(loops));
  corners_.assign(std::move(left));
}

std::vector<std::int32_t> Polygons::with_diagonals(std::span<const Edge> edges, const Diagonals& diagonals,
                                                   const Corners& corners) const {
  std::vector<std::int32_t> charts;
  for (const Edge& e : edges) {
    const std::int32_t c = corners.of_vertex[e[0]];
    if (c == kNone || c >= static_cast<std::int32_t>(around_.size())) continue;
    for (const std::int32_t q : at(c)) {
      const auto& own = diagonals[chart(q)];
      if (std::any_of(own.begin(), own.end(), [&](const Edge& d) { return edge(d[0], d[1]) == e; }))
        charts.push_back(chart(q));
    }
  }
  return charts;
}

void Polygons::collect(const Complex& complex, const Labels& labels, Diagonals& diagonals, Corners& corners,
                       std::vector<std::int32_t>& changed) {
  if (!loops_.in_transaction()) close_gaps();
  charts_.resize(labels.charts.size());
  diagonals.resize(labels.charts.size());
  std::vector<std::int32_t> fresh = changed;
  sort_unique(fresh);
  const bool any = std::any_of(diagonals.begin(), diagonals.end(), [](const auto& d) { return !d.empty(); });
  // No diagonal is the same as a chord or another diagonal. A chart that has not changed can only lose one to a chart
  // that has.
  const std::vector<Edge> ends = any ? chord_ends(complex, labels.mesh, fresh) : std::vector<Edge>{};
  std::vector<Edge> edges = ends;
  for (const std::int32_t l : fresh)
    for (const auto& d : diagonals[l]) edges.push_back(edge(d[0], d[1]));
  std::vector<std::int32_t> charts = with_diagonals(edges, diagonals, corners);
  charts.insert(charts.end(), fresh.begin(), fresh.end());
  sort_unique(charts);
  std::set<Edge> added;
  std::vector<Cycle> cycles;
  for (const std::int32_t l : charts) {
    if (!std::binary_search(fresh.begin(), fresh.end(), l)) {
      const auto is_taken = [&](const auto& d) {
        const Edge e = edge(d[0], d[1]);
        return std::binary_search(ends.begin(), ends.end(), e) || added.contains(e);
      };
      if (std::none_of(diagonals[l].begin(), diagonals[l].end(), is_taken)) {
        for (const auto& d : diagonals[l]) added.insert(edge(d[0], d[1]));
        continue;
      }
    }
    remove(l);
    if (complex.chords(l).empty()) continue;  // no more
    cycles.assign(1, {});
    for (const std::int32_t h : complex.chords(l)) {
      const std::int32_t from = labels.mesh.from(h), c = corners.of_vertex[from];
      const std::int32_t v = c == kNone ? from : corners.vertex[c];
      if (cycles[0].empty() || cycles[0].back() != v) cycles[0].push_back(v);
    }
    if (cycles[0].size() > 1 && cycles[0].front() == cycles[0].back()) cycles[0].pop_back();
    const std::size_t had = diagonals[l].size();
    std::erase_if(diagonals.edit(l), [&](const Edge& d) {
      return complex.has_chord(d[0], d[1]) || added.contains(edge(d[0], d[1])) || !split_at(cycles, d) ||
             !added.insert(edge(d[0], d[1])).second;
    });
    if (diagonals[l].size() < had) changed.push_back(l);
    add(l, cycles, corners);
  }
  around_.resize(corners.count());
  ISIMP_ASSERT(std::all_of(changed.begin(), changed.end(), [&](std::int32_t l) { return is_listed(*this, l); }),
               "a polygon is among those round each of its corners");
}

std::vector<std::int32_t> Polygons::corners_of(std::span<const std::int32_t> charts) const {
  std::vector<std::int32_t> all;
  for (const std::int32_t l : charts)
    for_each_of(l, [&](std::int32_t q) { all.insert(all.end(), of(q).begin(), of(q).end()); });
  sort_unique(all);
  return all;
}

std::vector<std::int32_t> Polygons::charts_at(std::span<const std::int32_t> corners) const {
  std::vector<std::int32_t> all;
  for (const std::int32_t c : corners)
    for (const std::int32_t q : at(c)) all.push_back(chart(q));
  sort_unique(all);
  return all;
}

Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = position[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (position[polygon[i]] - origin).cross(position[polygon[i + 1]] - origin);
  return sum / 2;
}

double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  const Vec3 area = vector_area(polygon, position);
  const double length = area.norm();
  if (length == 0) return 0;
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t c : polygon) centre += position[c];
  centre /= static_cast<double>(polygon.size());
  double most = 0;
  for (const std::int32_t c : polygon) most = std::max(most, std::abs((position[c] - centre).dot(area)) / length);
  return most;
}

}  // namespace isimp::meshing
