#include "complex/tips.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "isimp/core/forest.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

using Ring = std::pair<std::int32_t, std::int32_t>;  // round part, ring

/// The search for the tips of all rings.
class Finder {
 public:
  Finder(const Labels& labels, const Complex& complex, const Partition& partition)
      : l_(labels), x_(complex), p_(partition) {}

  std::vector<Tip> run() {
    std::map<Ring, std::vector<std::int32_t>> rings;
    for (std::int32_t l = 0; l < l_.chart_count(); ++l)
      if (l_.charts[l].face != kNone && ring(l).first != kNone) rings[ring(l)].push_back(l);
    std::vector<Tip> tips;
    for (const auto& [ring, charts] : rings)
      if (charts.size() > 3)
        if (Tip tip = tip_of(ring, charts); tip.nearest != kNone) tips.push_back(std::move(tip));
    return tips;
  }

 private:
  /// The ring that a chart is a cell of, kNone where it is in none.
  [[nodiscard]] Ring ring(std::int32_t chart) const {
    const std::int32_t r = l_.charts[chart].region;
    const CurvedCell& cell = p_.region_cell[r];
    if (cell.proxy == kNone || p_.region_held[r] != kPlaneRound) return {kNone, 0};
    const CurvedProxy& proxy = p_.curved[cell.proxy];
    const bool is_ring = proxy.full && proxy.kind != CurvedKind::extrusion;
    return {is_ring ? cell.proxy : kNone, cell.ring};
  }

  /// Whether three charts or more meet at a vertex, all of one ring.
  [[nodiscard]] bool is_junction(std::int32_t vertex, const Ring& of) const {
    const std::vector<std::int32_t> charts = charts_of(l_, std::span(&vertex, 1));
    return charts.size() > 2 && x_.boundary_edges(vertex) == static_cast<int>(charts.size()) &&
           std::all_of(charts.begin(), charts.end(), [&](std::int32_t l) { return ring(l) == of; });
  }

  [[nodiscard]] Tip tip_of(const Ring& of, const std::vector<std::int32_t>& charts) const {
    std::map<std::int32_t, std::int32_t> number;  // by vertex
    std::vector<std::int32_t> vertices;
    for (const std::int32_t l : charts)
      for (const std::int32_t h : x_.chords(l))
        if (const std::int32_t v = l_.mesh.from(h); !number.contains(v) && is_junction(v, of)) {
          number[v] = static_cast<std::int32_t>(vertices.size());
          vertices.push_back(v);
        }
    detail::Forest forest(vertices.size());
    std::vector<std::vector<std::int32_t>> between(vertices.size());  // corners of two charts, by a junction
    for (const std::int32_t l : charts) join(l, number, forest, between);
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      if (forest.root(static_cast<std::int32_t>(k)) != static_cast<std::int32_t>(k)) continue;
      Tip tip;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        if (forest.root(static_cast<std::int32_t>(i)) == static_cast<std::int32_t>(k)) {
          tip.vertices.push_back(vertices[i]);
          tip.vertices.insert(tip.vertices.end(), between[i].begin(), between[i].end());
        }
      sort_unique(tip.vertices);
      if (tip.vertices.size() < 2 || charts_of(l_, tip.vertices) != charts || !is_whole(l_, x_, tip)) continue;
      double least = std::numeric_limits<double>::infinity();
      for (const std::int32_t v : tip.vertices) {
        const double square = misses(charts, l_.mesh.vertices()[v]);
        if (square >= least) continue;
        least = square;
        tip.nearest = v;
      }
      return tip;
    }
    return {};
  }

  /// The sum of the squared distances of a place from the planes of some cells.
  [[nodiscard]] double misses(const std::vector<std::int32_t>& charts, const Vec3& place) const {
    double sum = 0;
    for (const std::int32_t l : charts) {
      const std::int32_t r = l_.charts[l].region;
      sum += std::pow(p_.region_normal[r].dot(place) - p_.offset_from(l_.mesh.origin(), r), 2);
    }
    return sum;
  }

  /// Joins the junctions that are neighbours on the boundary of a chart. Corners between them are of the same two charts.
  void join(std::int32_t chart, const std::map<std::int32_t, std::int32_t>& number, detail::Forest& forest,
            std::vector<std::vector<std::int32_t>>& between) const {
    const auto chords = x_.chords(chart);
    for (std::size_t i = 0; i < chords.size(); ++i) {
      const auto first = number.find(l_.mesh.from(chords[i]));
      if (first == number.end()) continue;
      std::vector<std::int32_t> passed;
      for (std::size_t k = i + 1; k < i + chords.size(); ++k) {
        const std::int32_t h = chords[k % chords.size()], v = l_.mesh.from(h);
        if (const auto next = number.find(v); next != number.end()) {
          forest.join(first->second, next->second);
          auto& some = between[first->second];
          some.insert(some.end(), passed.begin(), passed.end());
          break;
        }
        if (l_.across(h) != l_.across(chords[i])) break;
        passed.push_back(v);
      }
    }
  }

  const Labels& l_;
  const Complex& x_;
  const Partition& p_;
};

}  // namespace

std::vector<Tip> tips_of(const Labels& labels, const Complex& complex, const Partition& partition) {
  if (partition.region_cell.empty()) return {};
  return Finder(labels, complex, partition).run();
}

std::vector<std::int32_t> charts_of(const Labels& labels, std::span<const std::int32_t> vertices) {
  std::vector<std::int32_t> charts;
  for (const std::int32_t v : vertices)
    for_each_leaving(labels.mesh, v, [&](std::int32_t h) { charts.push_back(labels.label[h / 3]); });
  sort_unique(charts);
  return charts;
}

std::vector<std::int32_t> bends_at(const Labels& labels, const Complex& complex, const Tip& tip) {
  const std::vector<std::int32_t> charts = charts_of(labels, tip.vertices);
  std::vector<std::int32_t> bends;
  for (const std::int32_t l : charts)
    for (const std::int32_t h : complex.chords(l)) {
      const std::int32_t v = labels.mesh.from(h);
      if (complex.boundary_edges(v) != 2 || std::binary_search(tip.vertices.begin(), tip.vertices.end(), v)) continue;
      if (std::binary_search(charts.begin(), charts.end(), labels.across(h))) bends.push_back(v);
    }
  sort_unique(bends);
  return bends;
}

bool is_whole(const Labels& labels, const Complex& complex, const Tip& tip) {
  const std::vector<std::int32_t> charts = charts_of(labels, tip.vertices);
  return std::all_of(charts.begin(), charts.end(), [&](std::int32_t l) {
    const auto chords = complex.chords(l);
    std::size_t others = 0, runs = 0;
    const auto is_at = [&](std::int32_t h) {
      return std::binary_search(tip.vertices.begin(), tip.vertices.end(), labels.mesh.from(h));
    };
    bool was = !chords.empty() && is_at(chords.back());
    for (const std::int32_t h : chords) {
      const bool is = is_at(h);
      others += !is;
      runs += is && !was;
      was = is;
    }
    return runs == 1 && others > 1;
  });
}

}  // namespace isimp::meshing
