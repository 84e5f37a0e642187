#include "planar/cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "isimp/core/tiny.h"
#include "judge/judge.h"

namespace isimp::meshing::planar {
namespace {

// tuned planar
/// Weight of a triangle's share of the polygon's surface, if a triangle that becomes a face of its own costs 1.
constexpr double kOfSurface = 0.02;
constexpr double kBad =
    100;  ///< mark: cost of a triangle that faces away or has no area: used only if there is no other way
constexpr double kNever = 1e30;  // mark

using Edge = std::array<std::int32_t, 2>;  // corners, the lower first

/// The conditions on triangles under which the judge finds no defect in them.
struct Rules {
  Vec3 facing = Vec3::UnitZ();  ///< normal of the chart, for triangles without a direction of the scan
  double thickness = 0;         ///< scene units: a thinner one has no area
};

/// The triangulation of a polygon that leaves the fewest faces, once triangles on the plane are one again.
/// Source: Gilbert 1979, with another cost.
class Triangulation {
 public:
  /// \param on  by place in the loop: whether the corner is on the plane
  Triangulation(const Draft& draft, const Unit& unit, const std::vector<bool>& on, const Rules& rules)
      : draft_(draft),
        unit_(unit),
        on_(on),
        at_(draft.state.corners.position),
        rules_(rules),
        n_(unit.loop.size()),
        cost_(n_ * n_, 0),
        via_(n_ * n_, 0) {
    outline_ = vector_area(unit.loop, at_);
    area_ = outline_.norm();
    up_ = area_ > 0 ? Vec3(outline_ / area_) : rules.facing;
  }

  /// \return whether there is one
  bool find() {
    for (std::size_t gap = 2; gap < n_; ++gap)
      for (std::size_t i = 0; i + gap < n_; ++i) best(i, i + gap);
    return cost_[n_ - 1] < kNever;
  }

  /// The edges across that part two triangles of which not both lie on the plane.
  void collect(std::vector<Edge>& cuts) const { collect(0, n_ - 1, false, cuts); }

 private:
  [[nodiscard]] const Vec3& point(std::size_t i) const { return at_[unit_.loop[i]]; }
  [[nodiscard]] Edge edge(std::size_t i, std::size_t j) const {
    return {std::min(unit_.loop[i], unit_.loop[j]), std::max(unit_.loop[i], unit_.loop[j])};
  }
  [[nodiscard]] bool is_core(std::size_t i, std::size_t k, std::size_t j) const {
    return !unit_.free && on_[i] && on_[k] && on_[j];
  }

  [[nodiscard]] bool is_joined(const Edge& e) const {
    const auto& some = draft_.beyond[e[0]];
    return std::find(some.begin(), some.end(), e[1]) != some.end();
  }

  void best(std::size_t i, std::size_t j) {
    double& least = cost_[i * n_ + j];
    least = kNever;
    if (j - i < n_ - 1 && is_joined(edge(i, j))) return;
    for (std::size_t k = i + 1; k < j; ++k) {
      const double rest = cost_[i * n_ + k] + cost_[k * n_ + j];
      if (rest >= least) continue;
      const double sum = rest + price(i, k, j);
      if (sum >= least) continue;
      least = sum;
      via_[i * n_ + j] = k;
    }
  }

  [[nodiscard]] double price(std::size_t i, std::size_t k, std::size_t j) const {
    const Vec3 &a = point(i), &b = point(k), &c = point(j);
    const Vec3 area = (b - a).cross(c - a) / 2;
    const double size = area.norm();
    const double extent = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double share = kOfSurface * size / std::max(area_, kTiny);
    const bool faces = area.dot(up_) > 0;
    if (is_core(i, k, j)) return faces || size <= rules_.thickness * extent ? share : kBad;
    const double turn = std::max(area.dot(direction(i, k, j)), area.dot(rules_.facing));
    const bool thin = size <= rules_.thickness * extent;
    if (!faces || thin || turn <= 2 * kFacingApart * size) return kBad + share;  // twice the bound of the judge
    return 1 + share;
  }

  /// The direction of the part of the scan that a triangle stands for.
  [[nodiscard]] Vec3 direction(std::size_t i, std::size_t k, std::size_t j) const {
    const Vec3 u = unit_.home[k] - unit_.home[i], v = unit_.home[j] - unit_.home[i];
    Vec3 area = u.cross(v) / 2;
    if (k == i + 1) area += unit_.beyond[i];
    if (j == k + 1) area += unit_.beyond[k];
    if (i == 0 && j == n_ - 1) area += unit_.beyond[j];
    const double size = area.norm();
    return size > rules_.thickness * std::max(u.norm(), v.norm()) ? Vec3(area / size) : rules_.facing;
  }

  void collect(std::size_t i, std::size_t j, bool core, std::vector<Edge>& cuts) const {
    if (j - i < 2) return;
    const std::size_t k = via_[i * n_ + j];
    const bool here = is_core(i, k, j);
    if (j - i < n_ - 1 && !(here && core)) cuts.push_back(edge(i, j));
    collect(i, k, here, cuts);
    collect(k, j, here, cuts);
  }

  const Draft& draft_;
  const Unit& unit_;
  const std::vector<bool>& on_;
  const std::vector<Vec3>& at_;
  const Rules& rules_;
  const std::size_t n_;
  Vec3 outline_, up_;
  double area_ = 0;
  std::vector<double> cost_;
  std::vector<std::size_t> via_;
};

/// The cuts of a unit; none if it is whole, or if there is no way to cut it.
std::vector<Edge> cuts_of(const Draft& draft, const Unit& unit, double thickness) {
  std::vector<Edge> cuts;
  if (unit.left || draft.is_flat(unit.loop)) return cuts;
  std::vector<bool> on;
  for (const std::int32_t c : unit.loop) on.push_back(draft.is_on(unit, c));
  if (!unit.free && std::find(on.begin(), on.end(), false) == on.end()) return cuts;
  const Rules rules{draft.state.planes[unit.chart].normal, thickness};
  Triangulation triangles(draft, unit, on, rules);
  if (triangles.find()) triangles.collect(cuts);
  return cuts;
}

}  // namespace

std::vector<std::int32_t> renew_cuts(Draft& draft, double thickness) {
  State& state = draft.state;
  const std::vector<std::int32_t> dirty = draft.dirty.take();
  for (const std::int32_t u : dirty)
    for (const auto& [v, w] : state.diagonals[draft.units[u].chart]) {
      auto& some = draft.beyond.edit(state.corners.of_vertex[v]);
      some.erase(std::find(some.begin(), some.end(), state.corners.of_vertex[w]));
    }
  std::vector<std::int32_t> charts, changed;
  for (const std::int32_t u : dirty) {
    const std::int32_t l = charts.emplace_back(draft.units[u].chart);
    std::vector<std::array<std::int32_t, 2>> diagonals;
    for (const auto& [a, b] : cuts_of(draft, draft.units[u], thickness)) {
      draft.beyond.edit(a).push_back(b);
      diagonals.push_back({state.corners.vertex[a], state.corners.vertex[b]});
    }
    if (diagonals == state.diagonals[l]) continue;
    state.set_diagonals(l, std::move(diagonals));
    changed.push_back(l);
  }
  state.collect(changed);
  return charts;
}

}  // namespace isimp::meshing::planar
