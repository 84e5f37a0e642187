#include "repair/junctions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "complex/angles.h"
#include "isimp/core/sorted.h"
#include "repair/gifts.h"

namespace isimp::meshing {
namespace {

constexpr int kPasses = 2;
constexpr std::size_t kMostLabels = 5;  ///< charts that may meet in a vertex
// How far the planes may miss the vertex: deviations of the scan from them, and of sqrt(area / charts).
constexpr double kPlanes = 3.2, kGap = 0.11;
constexpr double kRounding = 1e-9;                 ///< share of the diagonal: planes that are nearer than this meet
constexpr double kFixed = 0.0625;                  ///< share of the largest eigenvalue: below, planes fix no point
constexpr double kParallel = 1e-6, kMeets = 1e-6;  ///< the same of planes of cells; how far these may miss, of the size
constexpr double kStep = 0.3;                      ///< from the middle to the vertex, in sqrt(area / charts)
// The energy of polygons, in area / charts: the distortion of their faces, a price for an edge of no length that falls to
// 0 for one of kShort, for each full turn by which reflex corners open too far, and for each full turn that sharp corners
// lack. A join must lower it.
constexpr double kOfShort = 0.003, kOfReflex = 0.3, kOfSharp = 6;
constexpr double kShort = 0.4;  ///< sqrt(area / charts); at cells of round parts also the longest chord that is removed
constexpr double kOfGiver = 1.0 / 3;  ///< share of its area that a chart may give
constexpr double kLongest = 4;        ///< longest path between two junctions, in sqrt(area / charts)

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

  /// The changes of corner angles by one corner instead of two, in full turns.
  struct Turns {
    double reflex;  ///< by how much more reflex corners open too far
    double sharp;   ///< how much more sharp corners lack
  };
  /// \return no value if a polygon vanishes or faces away
  std::optional<Turns> turns(std::int32_t a, std::int32_t b, const Vec3& place) {
    const std::vector<std::int32_t> charts = charts_at(a, b);
    Angles before, after;
    for (const std::int32_t l : charts) before.add(angles_of(loops_[l], position_, s_.planes[l].normal));
    const Vec3 was = std::exchange(position_[a], place);
    bool good = true;
    for (const std::int32_t l : charts) {
      const std::vector<std::int32_t> loop = without(loops_[l], a, b);
      good = good && loop.size() >= 3;
      if (good) after.add(angles_of(loop, position_, s_.planes[l].normal));
    }
    position_[a] = was;
    if (!good || after.faces_away) return {};
    return Turns{(after.excess - before.excess) / 360, (after.lack - before.lack) / 360};
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

/// The sum of the vector areas of some faces.
Vec3 vector_area(const Mesh& mesh, std::span<const std::int32_t> faces, double& area) {
  Vec3 sum = Vec3::Zero();
  for (const std::int32_t f : faces) {
    const FaceRecord& r = mesh.graph().faces[mesh.graph().graph_face[f]];
    const double weight = mesh.graph().area * r.area;
    area += weight;
    sum += weight * Vec3(r.nx, r.ny, r.nz);
  }
  return sum;
}

/// One of the ways to join two junctions.
struct Way {
  Gift gift;
  Vec3 area;         ///< vector area of its faces
  double error = 0;  ///< increase of the distortion
};

/// The data of a join of two junctions.
struct Plan {
  std::int32_t a, b;  ///< corners
  Vec3 place;
  Way way;
  Charts all;
};

class Joiner {
 public:
  /// \param joins  new joins are appended
  Joiner(State& state, std::vector<Join>& joins, Job& job)
      : s_(state), joins_(joins), job_(job), net_(state), planes_(planes_with_cells(state)) {
    const Scale scale = s_.scale();
    size_ = scale.size;
    gap_ = std::min(kPlanes * scale.deviation, kGap * size_) + kRounding * s_.mesh.diagonal();
    for (const Plane& p : s_.planes) areas_.push_back(p.projected * p.normal);
  }

  bool run() {
    const std::size_t before = joins_.size();
    for (const JunctionNet::Pair& pair : net_.pairs(s_.options.join_junctions * size_)) {
      job_.poll();
      if (std::optional<Plan> plan = plan_of(pair.a, pair.b)) carry_out(*plan);
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

  /// Where the planes of some charts meet, near a point; nothing where they do not.
  [[nodiscard]] std::optional<Vec3> meeting_point(const Charts& charts, const Vec3& near, double radius,
                                                  double gap) const {
    const bool holds = holds_cells(charts);
    std::vector<const Plane*> cells, others;
    for (const std::int32_t l : charts) (holds && planes_[l].round ? cells : others).push_back(&planes_[l]);
    Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
    Vec3 d = Vec3::Zero();
    if (holds) d = step_onto(cells, kParallel, near, free);
    d += step_onto(others, kFixed, near + d, free);
    if (!(d.norm() <= radius)) return {};
    const auto misses = [&](const Plane* p, double most) {
      return std::abs(p->normal.dot(near + d - p->centre)) > most;
    };
    const bool is_met = std::none_of(cells.begin(), cells.end(), [&](auto p) { return misses(p, kMeets * size_); }) &&
                        std::none_of(others.begin(), others.end(), [&](auto p) { return misses(p, gap); });
    return is_met ? std::optional(Vec3(near + d)) : std::nullopt;
  }

  [[nodiscard]] std::optional<Plan> plan_of(std::int32_t a, std::int32_t b) {
    const Charts &at_a = net_.at(a), &at_b = net_.at(b);
    if (at_a.size() < 3 || at_b.size() < 3) return {};
    Charts all = net_.charts_at(a, b);
    if (all.size() > kMostLabels || all.size() + 2 != at_a.size() + at_b.size()) return {};
    const double length = (net_.position(a) - net_.position(b)).norm();
    const bool any_cell = std::any_of(all.begin(), all.end(), [&](std::int32_t l) { return planes_[l].round; });
    if (any_cell && length > kShort * size_) return {};  // a long way would turn the edges of a ring
    const std::optional<Vec3> place =
        meeting_point(all, (net_.position(a) + net_.position(b)) / 2, std::max(length, kStep * size_), gap_);
    if (!place) return {};
    const std::optional<JunctionNet::Turns> turns = net_.turns(a, b, *place);
    if (!turns) return {};
    const double gain =
        kOfReflex * turns->reflex + kOfSharp * turns->sharp - kOfShort * std::max(0.0, 1 - length / (kShort * size_));
    if (gain >= 0) return {};
    std::optional<Way> way = best_way(a, b, -gain * size_ * size_);
    if (!way) return {};
    return Plan{a, b, *place, std::move(*way), std::move(all)};
  }

  /// The way to join with the least increase of the error.
  /// \param most  the largest increase of the error
  [[nodiscard]] std::optional<Way> best_way(std::int32_t a, std::int32_t b, double most) const {
    const std::int32_t u = net_.vertex(a), v = net_.vertex(b);
    Charts both;
    std::set_intersection(net_.at(a).begin(), net_.at(a).end(), net_.at(b).begin(), net_.at(b).end(),
                          std::back_inserter(both));
    const std::vector<std::int32_t> path = path_between(s_.labels, u, v, both, kLongest * size_);
    std::optional<Way> best;
    if (path.empty()) return best;
    const auto consider = [&](const Charts& at_end, std::int32_t keeps, std::int32_t moves) {
      if (at_end.size() != 3) return;
      const std::int32_t taker =
          *std::find_if(at_end.begin(), at_end.end(), [&](std::int32_t l) { return l != both[0] && l != both[1]; });
      const std::int32_t left = s_.labels.label[path[0] / 3];
      for (const std::int32_t giver : {left, both[0] == left ? both[1] : both[0]}) {
        Way way{{giver, taker, keeps, moves, {}}, Vec3::Zero()};
        fill(way.gift, s_.labels, path);
        if (may_be(way) && way.error <= most && !(best && best->error <= way.error)) best = std::move(way);
      }
    };
    consider(net_.at(a), v, u);
    consider(net_.at(b), u, v);
    return best;
  }

  /// Finds the increase of the error by a gift.
  /// \return whether its faces may be given
  bool may_be(Way& way) const {
    const Gift& gift = way.gift;
    double area = 0;
    way.area = vector_area(s_.mesh, gift.faces, area);
    const Vec3 &giver = areas_[gift.giver], &taker = areas_[gift.taker];
    way.error = 2 * (giver.norm() + taker.norm() - (giver - way.area).norm() - (taker + way.area).norm());
    return !gift.faces.empty() && area < kOfGiver * s_.planes[gift.giver].area &&
           keeps_own(s_.labels, gift.giver, gift.faces) && may_give(s_, gift.giver, gift.taker, gift.faces);
  }

  /// Makes a join if all charts stay discs by it and no other junction changes.
  void carry_out(Plan& p) {
    Gift& gift = p.way.gift;
    if (!keeps_discs(s_.labels, gift, p.all)) return;
    areas_[gift.giver] -= p.way.area;
    areas_[gift.taker] += p.way.area;
    s_.hand_over(gift.giver, gift.taker, gift.faces, p.all);
    s_.drop_corner(gift.moves);
    s_.add_corner(gift.keeps);
    net_.join(p.a, p.b, p.place, gift.keeps);
    joins_.push_back({gift.giver, gift.taker, gift.moves, std::move(gift.faces), std::move(p.all)});
  }

  State& s_;
  std::vector<Join>& joins_;
  Job& job_;
  JunctionNet net_;
  double size_ = 0;                  // size of a region, scene units
  double gap_ = 0;                   // distance by which planes may miss the vertex
  const std::vector<Plane> planes_;  // by chart: see planes_with_cells
  std::vector<Vec3> areas_;          // by chart: vector area of its faces
};

}  // namespace

std::vector<Join> join_junctions(State& state, Job& job) {
  std::vector<Join> joins;
  if (!(state.options.join_junctions > 0)) return joins;
  for (int pass = 0; pass < kPasses && Joiner(state, joins, job).run(); ++pass) state.update({});
  return joins;
}

}  // namespace isimp::meshing
