#include "planar/cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "isimp/core/sorted.h"
#include "judge/judge.h"

namespace isimp::meshing::planar {
namespace {

// tuned planar
/// Weight of a triangle's share of the polygon's surface, if a triangle that becomes a face of its own costs 1.
constexpr double kOfSurface = 0.02;
constexpr double kBad =
    100;  ///< mark: cost of a triangle that faces away or has no area: used only if there is no other way
constexpr double kNever = 1e30;  // mark

/// The conditions on triangles under which the judge finds no defect in them.
struct Rules {
  Vec3 facing = Vec3::UnitZ();  ///< normal of the chart, for triangles without a direction of the scan
  double thickness = 0;         ///< scene units: a thinner one has no area
};

/// The triangulation of a polygon that leaves the fewest faces, once triangles on the plane are one again.
/// Source: Gilbert 1979, with another cost.
class Triangulation {
 public:
  Triangulation(const Unit& unit, const std::vector<std::uint8_t>& kept, const std::vector<Vec3>& at,
                const Rules& rules, const Edges& edges)
      : unit_(unit),
        kept_(kept),
        at_(at),
        rules_(rules),
        edges_(edges),
        n_(unit.loop.size()),
        cost_(n_ * n_, 0),
        via_(n_ * n_, 0) {
    outline_ = vector_area(unit.loop, at);
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
    return !unit_.free && kept_[i] && kept_[k] && kept_[j];
  }

  void best(std::size_t i, std::size_t j) {
    double& least = cost_[i * n_ + j];
    least = kNever;
    if (j - i < n_ - 1 && edges_.has(edge(i, j))) return;
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
    const double share = kOfSurface * size / std::max(area_, 1e-300);
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

  const Unit& unit_;
  const std::vector<std::uint8_t>& kept_;
  const std::vector<Vec3>& at_;
  const Rules& rules_;
  const Edges& edges_;
  const std::size_t n_;
  Vec3 outline_, up_;
  double area_ = 0;
  std::vector<double> cost_;
  std::vector<std::size_t> via_;
};

}  // namespace

bool Edges::has(const Edge& e) const {
  const auto& some = beyond_[e[0]];
  return std::find(some.begin(), some.end(), e[1]) != some.end();
}

void Edges::remove(const Edge& e) {
  auto& some = beyond_[e[0]];
  some.erase(std::find(some.begin(), some.end(), e[1]));
}

Cuts::Cuts(State& state, const Defects& defects, Draft& draft)
    : s_(state),
      draft_(draft),
      thickness_(defects.bounds().thickness),
      edges_(state.corners.count()),
      cuts_(draft.units.size()),
      uncut_(draft.units.size(), false) {
  for (const Unit& u : draft.units)
    for (std::size_t i = 0; i < u.loop.size(); ++i) {
      const auto [a, b] = std::minmax(u.loop[i], u.loop[(i + 1) % u.loop.size()]);
      edges_.add({a, b});
    }
}

bool Cuts::cut(std::int32_t u) {
  const Unit& unit = draft_.units[u];
  const auto& kept = draft_.kept[u];
  const bool whole = !unit.free && std::all_of(kept.begin(), kept.end(), [](std::uint8_t k) { return k != 0; });
  if (whole || unit.loop.size() == 3) return true;
  const Rules rules{s_.planes[unit.chart].normal, thickness_};
  Triangulation triangles(unit, kept, draft_.at, rules, edges_);
  if (!triangles.find()) return false;
  std::vector<Edge> cuts;
  triangles.collect(cuts);
  set(u, std::move(cuts));
  return true;
}

void Cuts::set(std::int32_t u, std::vector<Edge> cuts) {
  for (const Edge& e : cuts_[u]) edges_.remove(e);
  cuts_[u] = std::move(cuts);
  for (const Edge& e : cuts_[u]) edges_.add(e);
}

std::vector<std::int32_t> Cuts::renew() {
  const std::vector<std::int32_t> dirty = draft_.dirty.take();
  for (const std::int32_t u : dirty) set(u, {});
  std::vector<std::int32_t> charts;
  for (const std::int32_t u : dirty) {
    const Unit& unit = draft_.units[u];
    uncut_[u] = !unit.left && !is_flat(unit.loop, draft_.at, draft_.places.diagonal) && !cut(u);
    charts.push_back(unit.chart);
  }
  sort_unique(charts);
  rebuild(charts);
  return charts;
}

void Cuts::rebuild(std::span<const std::int32_t> charts) {
  std::vector<std::int32_t> changed;
  for (const std::int32_t l : charts) {
    std::vector<std::array<std::int32_t, 2>> diagonals;
    for (std::int32_t u = draft_.first[l]; u < draft_.first[l + 1]; ++u)
      for (const auto& [a, b] : cuts_[u]) diagonals.push_back({s_.corners.vertex[a], s_.corners.vertex[b]});
    if (diagonals == s_.diagonals[l]) continue;
    s_.set_diagonals(l, std::move(diagonals));
    changed.push_back(l);
  }
  s_.collect(changed);
}

Cuts::Past Cuts::past() const {
  Past past;
  for (const std::int32_t u : draft_.dirty.all()) past.push_back({u, cuts_[u], uncut_[u]});
  return past;
}

void Cuts::restore(Past past) {
  draft_.dirty.take();
  std::vector<std::int32_t> charts;
  for (Was& was : past) {
    charts.push_back(draft_.units[was.unit].chart);
    uncut_[was.unit] = was.uncut;
    set(was.unit, std::move(was.cuts));
  }
  sort_unique(charts);
  rebuild(charts);
}

}  // namespace isimp::meshing::planar
