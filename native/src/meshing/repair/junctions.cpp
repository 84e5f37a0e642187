#include "repair/junctions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "complex/angles.h"
#include "complex/flat_fit.h"
#include "discs/no_length.h"
#include "isimp/core/sorted.h"
#include "judge/bounds.h"
#include "repair/gifts.h"

namespace isimp::meshing {
namespace {

// tuned joins
constexpr int kChordPasses = 2;     ///< over all chords
constexpr double kToPoint = 0.01;   ///< weight of a corner's distance from the point, relative to that from a plane
constexpr double kCellMiss = 1e-6;  ///< rounding: how far cells' planes may miss a place, of the size
// The energy of polygons, in edges: an edge is worth a mean square distance of kEdgePrice square deviations of the scan along
// the side of a chart. Noise of the scan counts less, as it moves planes by a small part of itself. A full turn by which
// reflex corners open too far is worth kOfReflex edges, and a full turn that sharp corners lack is worth kOfSharp edges.
constexpr double kEdgePrice = 15;  ///< price of an edge, in square deviations of the scan beyond its noise
constexpr double kEdgeNoise = 2;   ///< price of an edge, in square deviations that are noise; at cells kEdgePrice
constexpr double kOfReflex = 15;   ///< price of a full turn of reflex corners, in edges
constexpr double kOfSharp = 300;   ///< price of a full turn that sharp corners lack, in edges
constexpr double kMisses = 1.5;    ///< bounds of bent polygons: planes that a place misses by more do not meet there
/// The price of an edge where cells of several round parts meet, in edges, so that these cells are quads. At any cell the
/// side is sqrt(area / charts).
// tuned round
constexpr double kOfCell = 2;
/// A chord is short up to this times sqrt(area / charts). At cells of round parts longer ones stay. Elsewhere borders that
/// move by the removal of a longer one count where both planes are one too, by this square sine.
// tuned joins
constexpr double kShortChord = 0.4;        ///< of sqrt(area / charts): longer chords stay at cells
constexpr double kLeastSquareSine = 0.02;  ///< least square sine at the moved borders of long chords

using Charts = std::vector<std::int32_t>;  ///< in rising order

/// A loop with a for b.
std::vector<std::int32_t> without(const std::vector<std::int32_t>& loop, std::int32_t a, std::int32_t b) {
  std::vector<std::int32_t> result;
  for (const std::int32_t c : loop) {
    const std::int32_t d = c == b ? a : c;
    if (result.empty() || result.back() != d) result.push_back(d);
  }
  if (result.size() > 1 && result.front() == result.back()) result.pop_back();
  return result;
}

/// The polygons of a state as loops of corners. They follow the joins of junctions, which the state does only at its next
/// update.
class JunctionNet {
 public:
  explicit JunctionNet(const State& state)
      : s_(state),
        loops_(state.labels.charts.size()),
        at_(state.corners.count()),
        vertex_(state.corners.vertex),
        position_(state.corners.position) {
    for (std::int32_t l = 0; l < s_.labels.chart_count(); ++l)
      if (s_.labels.charts[l].face != kNone)
        for (const std::int32_t h : s_.complex.chords(l)) {
          const std::int32_t c = s_.corners.of_vertex[s_.mesh.from(h)];
          if (!at_[c].empty() && at_[c].back() == l) continue;  // vertices that share it
          loops_[l].push_back(c);
          at_[c].push_back(l);
        }
    for (std::size_t c = 0; c < at_.size(); ++c)
      if (at_[c].size() > 2 && charts_around(s_.labels, vertex_[c]).size() != at_[c].size()) at_[c].clear();
  }

  /// Two adjacent junctions.
  struct Pair {
    double length;
    std::int32_t a, b;
    auto operator<=>(const Pair&) const = default;
  };
  /// The pairs of adjacent junctions that are nearer than a limit, the nearest first. Junctions at a border and at faces
  /// that were left out do not count.
  /// \param longest  scene units
  [[nodiscard]] std::vector<Pair> pairs(double longest) const {
    std::vector<Pair> some;
    for (const auto& loop : loops_)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t a = loop[i], b = loop[i + 1 < loop.size() ? i + 1 : 0];
        if (a > b || at_[a].size() < 3 || at_[b].size() < 3) continue;
        const double length = (position_[a] - position_[b]).norm();
        if (length < longest) some.push_back({length, a, b});
      }
    std::sort(some.begin(), some.end());
    return some;
  }

  /// The charts at one of two corners, in rising order.
  [[nodiscard]] std::vector<std::int32_t> charts_at(std::int32_t a, std::int32_t b) const {
    std::vector<std::int32_t> all = at_[a];
    all.insert(all.end(), at_[b].begin(), at_[b].end());
    sort_unique(all);
    return all;
  }

  /// An edge from a junction, and the charts on its sides.
  struct Spoke {
    std::int32_t from, to, left, right;
  };
  /// The edges at a junction.
  [[nodiscard]] std::vector<Spoke> spokes(std::int32_t corner) const {
    std::vector<Spoke> some;
    const auto beside = [&](std::int32_t chart, std::size_t step) {
      const auto& loop = loops_[chart];
      const std::size_t i = std::find(loop.begin(), loop.end(), corner) - loop.begin();
      return loop[(i + step) % loop.size()];
    };
    for (const std::int32_t l : at_[corner]) {
      const std::int32_t to = beside(l, 1);
      for (const std::int32_t r : at_[corner])
        if (r != l && beside(r, loops_[r].size() - 1) == to) some.push_back({corner, to, l, r});
    }
    return some;
  }

  /// The angles of the polygons of some charts.
  [[nodiscard]] Angles angles(const std::vector<std::int32_t>& charts) const {
    Angles sum;
    for (const std::int32_t l : charts) sum.add(angles_of(loops_[l], position_, s_.planes[l].normal));
    return sum;
  }

  /// The same if two corners of theirs were one.
  /// \return no value if a polygon vanishes or faces away
  std::optional<Angles> angles_joined(const std::vector<std::int32_t>& charts, std::int32_t a, std::int32_t b,
                                      const Vec3& place) {
    Angles sum;
    const Vec3 was = std::exchange(position_[a], place);
    bool good = true;
    for (const std::int32_t l : charts) {
      const std::vector<std::int32_t> loop = without(loops_[l], a, b);
      good = good && loop.size() >= 3;
      if (good) sum.add(angles_of(loop, position_, s_.planes[l].normal));
    }
    position_[a] = was;
    if (!good || sum.faces_away) return {};
    return sum;
  }

  /// Makes two corners one: `a`, at a junction that is a vertex of either.
  void join(std::int32_t a, std::int32_t b, const Vec3& place, std::int32_t vertex) {
    position_[a] = place;
    vertex_[a] = vertex;
    for (const std::int32_t l : at_[b]) loops_[l] = without(loops_[l], a, b);
    at_[a] = charts_at(a, b);
    at_[b].clear();
  }

  /// By corner: the charts at it, in rising order; none at a border, at faces that were left out, and for corners that
  /// have become part of another.
  [[nodiscard]] const std::vector<std::int32_t>& at(std::int32_t corner) const { return at_[corner]; }
  [[nodiscard]] std::int32_t vertex(std::int32_t corner) const { return vertex_[corner]; }
  [[nodiscard]] const Vec3& position(std::int32_t corner) const { return position_[corner]; }

 private:
  const State& s_;
  std::vector<std::vector<std::int32_t>> loops_, at_;  // corners by chart, charts by corner
  std::vector<std::int32_t> vertex_;                   // by corner
  std::vector<Vec3> position_;                         // by corner
};

/// By chart: its plane; for a cell of a round part, the plane of the cell.
std::vector<Plane> planes_with_cells(const State& state) {
  std::vector<Plane> planes = state.planes;
  if (state.partition.region_cell.empty()) return planes;
  for (std::size_t l = 0; l < planes.size(); ++l)
    if (const Chart& chart = state.labels.charts[l];
        chart.face != kNone && state.partition.region_held[chart.region] == kPlaneRound)
      hold(planes[l], state.partition, chart.region, state.mesh.origin());
  return planes;
}

/// Length times the mean square distance from both planes beside an edge.
double from_planes(const Vec3& p, const Vec3& q, const Plane& left, const Plane& right) {
  double sum = 0;
  for (const Plane* plane : {&left, &right}) {
    const double a = plane->normal.dot(p - plane->centre), b = plane->normal.dot(q - plane->centre);
    sum += a * a + a * b + b * b;
  }
  return (q - p).norm() * sum / 3;
}

/// Length times the mean square distance of an edge p q from where it was with its end p at `old`.
double from_border(const Vec3& p, const Vec3& q, const Vec3& old) {
  const Vec3 way = q - p;
  const double square = way.squaredNorm();
  const double share = square > 0 ? std::clamp(way.dot(old - p) / square, 0.0, 1.0) : 0.0;
  return std::sqrt(square) * (old - p - share * way).squaredNorm() / 3;
}

class Joiner {
 public:
  /// \param joins  new joins are appended
  Joiner(State& state, std::vector<Join>& joins, Job& job)
      : s_(state), joins_(joins), job_(job), net_(state), planes_(planes_with_cells(state)) {
    const Scale scale = s_.scale();
    size_ = scale.size;
    const double deviation = scale.deviation + kNoLength * s_.mesh.diagonal();
    // The mean square of a triangle's distances is half of that of its vertices.
    const double noise = std::min(deviation * deviation, 0.5 * s_.partition.noise * s_.partition.noise);
    const double bend = bounds_of(s_).bend;
    gap_ = bend > 0 ? kMisses * bend : std::numeric_limits<double>::infinity();
    edge_of_cells_ = kEdgePrice * deviation * deviation;
    edge_ = edge_of_cells_ - (kEdgePrice - kEdgeNoise) * noise;
  }

  bool run() {
    const std::size_t before = joins_.size();
    for (const JunctionNet::Pair& pair : net_.pairs(s_.options.join_junctions * size_)) {
      job_.poll();
      try_join(pair.a, pair.b);
    }
    return joins_.size() > before;
  }

 private:
  /// Whether corners of some charts stay on the planes of cells exactly: two cells of one round part meet in a line, from
  /// which a join would move their corner far if they are nearly parallel. Four cells of two parts nearly meet in a point,
  /// which is good enough.
  [[nodiscard]] bool holds_cells(const Charts& charts) const {
    int cells = 0;
    std::int32_t part = kNone;
    for (const std::int32_t l : charts) {
      if (!planes_[l].round) continue;
      const std::int32_t mine = s_.partition.region_cell[s_.labels.charts[l].region].proxy;
      if (cells > 0 && mine != part) return false;
      part = mine;
      ++cells;
    }
    return cells > 1;
  }

  /// The place of a corner of some charts that is nearest to their planes and to a point; nothing where cells that hold
  /// their corners do not meet, or a plane is missed by too much.
  [[nodiscard]] std::optional<Vec3> place_of_least(const Charts& charts, const Vec3& near) const {
    Vec3 at = near;
    Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
    if (holds_cells(charts)) {
      std::vector<const Plane*> cells;
      for (const std::int32_t l : charts)
        if (planes_[l].round) cells.push_back(&planes_[l]);
      at += step_onto(cells, kParallel, near, free);
      const auto misses = [&](const Plane* p) { return std::abs(p->normal.dot(at - p->centre)) > kCellMiss * size_; };
      if (std::any_of(cells.begin(), cells.end(), misses)) return {};
    }
    Eigen::Matrix3d a = kToPoint * Eigen::Matrix3d::Identity();
    Vec3 r = Vec3::Zero();
    for (const std::int32_t l : charts) {
      const Vec3 n = free * planes_[l].normal;
      a += n * n.transpose();
      r += planes_[l].normal.dot(planes_[l].centre - at) * n;
    }
    at += a.inverse() * r;
    const auto is_missed = [&](std::int32_t l) {
      return std::abs(planes_[l].normal.dot(at - planes_[l].centre)) > gap_;
    };
    return std::any_of(charts.begin(), charts.end(), is_missed) ? std::nullopt : std::optional(at);
  }

  [[nodiscard]] static double price(const Angles& angles) {
    return (kOfReflex * angles.excess + kOfSharp * angles.lack) / 360;
  }

  /// The distances in the energy of edges from two junctions, scene units^3.
  /// \param place  of both; without it they are where they are
  /// \param least  the least square sine between the planes of a border that moves
  [[nodiscard]] double distances(std::span<const JunctionNet::Spoke> spokes, const std::optional<Vec3>& place = {},
                                 double least = 0) const {
    double sum = 0;
    for (const auto& [from, to, left, right] : spokes) {
      const Vec3 &old = net_.position(from), &end = net_.position(to);
      const Plane &l = planes_[left], &r = planes_[right];
      sum += from_planes(place.value_or(old), end, l, r);
      if (place) sum += from_border(*place, end, old) * std::max(l.normal.cross(r.normal).squaredNorm(), least);
    }
    return sum;
  }

  /// Makes two junctions one if the energy falls by that.
  void try_join(std::int32_t a, std::int32_t b) {
    const Charts &at_a = net_.at(a), &at_b = net_.at(b);
    if (at_a.size() < 3 || at_b.size() < 3) return;
    Charts all = net_.charts_at(a, b);
    if (all.size() + 2 != at_a.size() + at_b.size()) return;
    const Vec3 &from = net_.position(a), &to = net_.position(b);
    const double length = (from - to).norm();
    const bool any_cell = std::any_of(all.begin(), all.end(), [&](std::int32_t l) { return planes_[l].round; });
    if (any_cell && length > kShortChord * size_) return;  // a long way would turn the edges of a ring
    std::vector<JunctionNet::Spoke> spokes = net_.spokes(a);
    for (const JunctionNet::Spoke& s : net_.spokes(b))
      if (s.to != a) spokes.push_back(s);
    const double distances_before = distances(spokes);
    std::erase_if(spokes, [&](const JunctionNet::Spoke& s) { return s.to == b; });
    const double angles_before = price(net_.angles(all));
    double side = size_;
    for (const std::int32_t l : all) side = std::min(side, std::sqrt(planes_[l].area));
    const double edge =
        any_cell ? edge_of_cells_ * (holds_cells(all) ? 1 : kOfCell) * size_ : edge_ * side;  // scene units^3
    Vec3 best = from;
    double least = 0;  // change of the energy, in edges
    for (const Vec3& near : {from, to, Vec3((from + to) / 2)}) {
      const std::optional<Vec3> place = place_of_least(all, near);
      if (!place) continue;
      const double change =
          (distances(spokes, place, length > kShortChord * size_ ? kLeastSquareSine : 0) - distances_before) / edge -
          1 - angles_before;
      if (change >= least) continue;
      const std::optional<Angles> angles = net_.angles_joined(all, a, b, *place);
      if (!angles || change + price(*angles) >= least) continue;
      least = change + price(*angles);
      best = *place;
    }
    if (least >= 0) return;
    std::optional<Gift> gift = gift_for(a, b, best, all, -least * edge);
    if (!gift) return;
    s_.hand_over(gift->giver, gift->taker, gift->faces, all);
    s_.drop_corner(gift->moves);
    s_.add_corner(gift->keeps);
    net_.join(a, b, best, gift->keeps);
    joins_.push_back({gift->giver, gift->taker, gift->moves, std::move(gift->faces), std::move(all)});
  }

  /// A gift by which two junctions become one, at the vertex that is nearer to a place where both can be. Of two charts that
  /// may give, that with fewer faces to give does.
  /// \param most  the most by which the energy may rise, scene units^3
  [[nodiscard]] std::optional<Gift> gift_for(std::int32_t a, std::int32_t b, const Vec3& place, const Charts& all,
                                             double most) const {
    Charts both;
    std::set_intersection(net_.at(a).begin(), net_.at(a).end(), net_.at(b).begin(), net_.at(b).end(),
                          std::back_inserter(both));
    const std::vector<std::int32_t> path = path_between(s_.labels, net_.vertex(a), net_.vertex(b), both);
    if (path.empty()) return {};
    const auto away = [&](std::int32_t c) { return (s_.mesh.vertices()[net_.vertex(c)] - place).squaredNorm(); };
    const std::int32_t nearer = away(b) < away(a) ? b : a;
    for (const std::int32_t keeps : {nearer, nearer == a ? b : a}) {
      const std::int32_t moves = keeps == a ? b : a;
      const Charts& at_end = net_.at(moves);
      if (at_end.size() != 3) continue;
      const std::int32_t taker =
          *std::find_if(at_end.begin(), at_end.end(), [&](std::int32_t l) { return l != both[0] && l != both[1]; });
      const std::int32_t left = s_.labels.label[path[0] / 3];
      std::array<Gift, 2> gifts;
      for (std::size_t i = 0; i < 2; ++i) {
        gifts[i] = {i == 0            ? left
                    : both[0] == left ? both[1]
                                      : both[0],
                    taker,
                    net_.vertex(keeps),
                    net_.vertex(moves),
                    {}};
        fill(gifts[i], s_.labels, path);
      }
      if (gifts[1].faces.size() < gifts[0].faces.size()) std::swap(gifts[0], gifts[1]);
      for (Gift& gift : gifts)
        if (!gift.faces.empty() && rise_by(gift) <= most && keeps_own(s_.labels, gift.giver, gift.faces) &&
            may_give(s_, gift.giver, gift.taker, gift.faces) && keeps_discs(s_.labels, gift, all))
          return std::move(gift);
    }
    return {};
  }

  /// The increase of the energy by faces that are given: their area / size times the mean square distance from the plane.
  [[nodiscard]] double rise_by(const Gift& gift) const {
    const Plane part = plane_of(s_.mesh, gift.faces, s_.labels.outlying);
    const auto square = [&](std::int32_t chart) {
      const Plane& p = planes_[chart];
      const double off = p.normal.dot(part.centre - p.centre);
      return p.normal.dot(part.spread * p.normal) + off * off;
    };
    return part.area / size_ * (square(gift.taker) - square(gift.giver));
  }

  State& s_;
  std::vector<Join>& joins_;
  Job& job_;
  JunctionNet net_;
  double size_ = 0;                  // size of a region, scene units
  double gap_ = 0;                   // distance by which a plane may miss the place of a corner
  double edge_ = 0;                  // the price of an edge, as a square distance
  double edge_of_cells_ = 0;         // the same at cells
  const std::vector<Plane> planes_;  // by chart: see planes_with_cells
};

}  // namespace

std::vector<Join> join_junctions(State& state, Job& job) {
  std::vector<Join> joins;
  if (!(state.options.join_junctions > 0)) return joins;
  for (int pass = 0; pass < kChordPasses && Joiner(state, joins, job).run(); ++pass) state.update({});
  return joins;
}

}  // namespace isimp::meshing
