#include "planar/planar.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "isimp/core/sorted.h"
#include "planar/cut.h"
#include "planar/fit.h"
#include "planar/meet.h"
#include "planar/near.h"
#include "planar/solve.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {
namespace {

constexpr int kRings = 5;               ///< rings around stuck charts that are solved again
constexpr int kGentle = 12;             ///< rounds in which corners that are held back keep half their way
constexpr std::int32_t kTogether = 64;  ///< corners on one thread
constexpr std::size_t kFew = 12;  ///< most corners of a unit that is triangulated before its corners are held back
constexpr double kStill = 1e-9;   ///< share of the diagonal: smaller moves count as none
constexpr double kLeast = 1e-3;   ///< share of the diagonal: corners held back to less than this return to their start
constexpr std::array kShares{0.95, 0.5, 0.25, 0.0};  ///< shares of its way kept by a corner that mends a defect
constexpr double kStay = 0.01;   ///< cost of a corner held back to its start, if a polygon that loses a corner costs 1
constexpr double kWhole = 1.5;   ///< cost of the first corner that a polygon loses
constexpr double kOfFace = 0.7;  ///< cost of each face of a polygon that is triangulated. Source: own trials

bool is_flat(std::span<const std::int32_t> polygon, std::span<const Vec3> at, double most) {
  if (polygon.size() == 3) return true;
  if (bend_of(polygon, at) > most) return false;
  std::vector<Vec3> rounded;
  std::vector<std::int32_t> order;
  for (const std::int32_t c : polygon) {
    order.push_back(static_cast<std::int32_t>(rounded.size()));
    rounded.push_back(rounded_to_float(at[c]));
  }
  return bend_of(order, rounded) <= most;
}

class Planarizer {
 public:
  Planarizer(State& state, Defects& defects, Memory& memory, bool is_last, const Job& job)
      : s_(state),
        f_(defects),
        memory_(memory),
        is_last_(is_last),
        job_(job),
        units_(units_of(state)),
        places_(places_of(state, units_, state.options.planar_reach * state.mesh.diagonal())),
        around_(units_, state.corners.count()),
        near_(state, defects, units_, around_, places_),
        diagonals_(state.diagonals),
        edges_(state.corners.count()),
        first_(state.labels.charts.size() + 1, 0),
        cuts_(units_.size()),
        uncut_(units_.size(), false),
        is_dirty_(units_.size(), false),
        is_moving_(state.corners.count(), false) {
    for (const Unit& u : units_) ++first_[u.chart + 1];
    for (std::size_t l = 1; l < first_.size(); ++l) first_[l] += first_[l - 1];
    for (std::size_t l = 0; l + 1 < first_.size(); ++l)
      kinds_.push_back(f_.kinds(static_cast<std::int32_t>(l)) & ~kBent);
    for (const Hit& h : f_.hits()) met_.insert({h.a, h.b});
    for (const Unit& u : units_) {
      kept_.emplace_back(u.loop.size(), 0);
      for (std::size_t i = 0; i < u.loop.size(); ++i) edges_.add(edge(u.loop[i], u.loop[(i + 1) % u.loop.size()]));
    }
    find_own();
    weigh(units_, places_.base);
  }

  PlanarOutcome run() {
    const bool is_again = !memory_.reach.empty();
    recall();
    std::vector<bool> is_new(units_.size(), true);
    for (std::size_t u = 0; is_again && u < units_.size(); ++u) is_new[u] = !memory_.units.contains(units_[u].loop);
    solve(units_, around_, places_, is_new, s_.threads, job_);
    at_ = places_.start;
    for (std::int32_t c = 0; c < s_.corners.count(); ++c) ask(c);
    for (int round = 0;; ++round) {
      job_.poll();
      place();
      apply();
      if (!hold_back(round >= kGentle)) break;
    }
    return sum_up();
  }

 private:
  static Edge edge(std::int32_t a, std::int32_t b) { return {std::min(a, b), std::max(a, b)}; }

  /// The edges across each unit of the triangles that the judge sees now.
  void find_own() {
    own_.resize(units_.size());
    for (std::size_t l = 0; l + 1 < first_.size(); ++l)
      for (const Facet& f : f_.of(static_cast<std::int32_t>(l)).facets.facets) {
        const std::int32_t u = first_[l] + f.part;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int32_t a = f.corner[k], b = f.corner[(k + 1) % 3];
          if (a < b && !edges_.has({a, b})) own_[u].push_back({a, b});
        }
      }
  }

  /// Copies the results of the last try for the same polygons.
  void recall() {
    for (Unit& u : units_) {
      const auto known = memory_.units.find(u.loop);
      if (known == memory_.units.end()) continue;
      const Unit& was = known->second;
      u.normal = was.normal;
      u.offset = was.offset;
      u.trust = was.trust;
      u.missed = was.missed;
      u.held = was.held;
      u.free = was.free;
      u.plain = was.plain;
      u.own = was.own;
      u.cause = was.cause;
    }
    for (std::size_t c = 0; c < std::min(memory_.reach.size(), places_.reach.size()); ++c)
      places_.reach[c] = std::min(places_.reach[c], memory_.reach[c]);
  }

  /// Lists a corner, and so the units at it, for the next round.
  void ask(std::int32_t c) {
    if (is_moving_[c]) return;
    is_moving_[c] = true;
    moving_.push_back(c);
  }
  void ask_unit(std::int32_t u) {
    if (is_dirty_[u]) return;
    is_dirty_[u] = true;
    dirty_.push_back(u);
  }

  /// Puts corners on their planes, nearer to their start if they leave the scan there.
  void place() {
    std::sort(moving_.begin(), moving_.end());
    const auto n = static_cast<std::int32_t>(moving_.size());
    std::vector<Vec3> to(moving_.size());
    s_.threads.blocks(n, kTogether, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      job_.poll();
      for (std::int32_t i = begin; i < end; ++i) to[i] = meet_at(moving_[i], units_, around_, places_, kept_);
    });
    constexpr int kTries = 4;
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t c = moving_[i];
      for (int go = 1; go < kTries && !near_.is_on_scan(c, to[i]); ++go) {
        places_.reach[c] = go + 1 < kTries ? 0.6 * (to[i] - places_.start[c]).norm() : 0;
        to[i] = meet_at(c, units_, around_, places_, kept_);
      }
      at_[c] = to[i];
      s_.move(c, to[i]);
      is_moving_[c] = false;
      for (const auto& [u, place] : around_.of(c)) ask_unit(u);
    }
    moving_.clear();
  }

  /// Cuts the units that have changed, and judges them.
  void apply() {
    std::sort(dirty_.begin(), dirty_.end());
    for (const std::int32_t u : dirty_)
      for (const Edge& e : cuts_[u]) edges_.remove(e);
    judged_.clear();
    for (const std::int32_t u : dirty_) {
      const Rules rules{s_.planes[units_[u].chart].normal, f_.bounds().thickness};
      cuts_[u].clear();
      uncut_[u] = !units_[u].left && !is_flat(units_[u].loop, at_, kPlanar * places_.diagonal) &&
                  !cut(units_[u], kept_[u], own_[u], at_, rules, edges_, cuts_[u]);
      is_dirty_[u] = false;
      judged_.push_back(units_[u].chart);
    }
    dirty_.clear();
    sort_unique(judged_);
    std::vector<std::int32_t> changed;
    for (const std::int32_t l : judged_) {
      std::vector<std::array<std::int32_t, 2>> diagonals = diagonals_[l];
      for (std::int32_t u = first_[l]; u < first_[l + 1]; ++u)
        for (const auto& [a, b] : cuts_[u]) diagonals.push_back({s_.corners.vertex[a], s_.corners.vertex[b]});
      if (diagonals == s_.diagonals[l]) continue;
      s_.set_diagonals(l, std::move(diagonals));
      changed.push_back(l);
    }
    s_.collect(changed);
    f_.judge(judged_);
  }

  /// Moves the corners of polygons that are defective or not planar less far, or triangulates these polygons.
  /// \return whether anything was done; false if nothing is defective
  bool hold_back(bool firmly) {
    acted_.assign(units_.size(), false);
    bool any = false;
    judged_.insert(judged_.end(), stuck_.begin(), stuck_.end());
    sort_unique(judged_);
    stuck_.clear();
    for (const std::int32_t l : judged_) any = hold_back_chart(l, firmly) || any;
    for (const Hit& h : f_.hits()) {
      if (h.excused || met_.contains({h.a, h.b})) continue;
      if (!firmly && settle(h)) {
        any = true;
        continue;
      }
      const std::span<const std::int32_t> corners(h.corners);
      const bool a = give_up(h.a, h.part_a, corners.first(3), Cause::meeting, firmly);
      const bool b = give_up(h.b, h.part_b, corners.last(3), Cause::meeting, firmly);
      if (!a && !b) stuck_.insert(stuck_.end(), {h.a, h.b});
      any = any || a || b;
    }
    sort_unique(stuck_);
    return hold_back_gaps() || any;
  }

  /// Halves the moves of corners that slid away from a part of the scan.
  bool hold_back_gaps() {
    bool any = false;
    std::vector<std::int32_t> corners;
    for (const std::int32_t l : judged_)
      for (std::int32_t u = first_[l]; u < first_[l + 1]; ++u)
        corners.insert(corners.end(), units_[u].loop.begin(), units_[u].loop.end());
    sort_unique(corners);
    for (const std::int32_t c : corners) {
      if (near_.is_covered(c)) continue;
      lower(c, (at_[c] - places_.start[c]).norm() / 2);
      any = true;
    }
    return any;
  }

  bool hold_back_chart(std::int32_t l, bool firmly) {
    bool any = false;
    const double most = kPlanar * s_.mesh.diagonal();
    const auto& polygons = f_.of(l).polygons;
    for (std::int32_t part = 0; part < s_.polygons.count_of(l); ++part) {
      const auto loop = s_.polygons.of(s_.polygons.first_of(l) + part);
      const std::uint8_t kinds = polygons[part].kinds & ~(kBent | kGiven | kinds_[l]);
      const bool flat = is_flat(loop, at_, most);
      if (kinds == 0 && (flat || units_[unit_of(l, part)].left)) continue;
      const Cause cause = kinds & (kCrossing | kNoArea) ? Cause::crossing : kinds ? Cause::flipped : Cause::apart;
      if ((kinds != 0 && !firmly && settle(l, part, loop, cause)) || give_up(l, part, loop, cause, firmly)) {
        any = true;
      } else {
        stuck_.push_back(l);
      }
    }
    return any;
  }

  /// A corner whose shorter move mends a defect, with the cost.
  struct Way {
    double cost = std::numeric_limits<double>::infinity();
    std::int32_t corner = kNone;
    double reach = 0;
  };

  /// Shortens the move of one corner, if that is enough to mend the defect, or triangulates one of the blamed units,
  /// if that costs less.
  /// \param is_mended  tests the defect with corners at their present places
  /// \return whether there is such a way, or something changes there in this round already
  template <class Function>
  bool settle(std::span<const std::int32_t> corners, std::initializer_list<std::int32_t> blamed, Cause cause,
              Function is_mended) {
    if (std::any_of(blamed.begin(), blamed.end(), [&](std::int32_t u) { return acted_[u]; }) ||
        std::any_of(corners.begin(), corners.end(), [&](std::int32_t c) { return is_moving_[c]; }))
      return true;
    Way best;
    for (const std::int32_t c : corners) find_way(c, is_mended, best);
    std::int32_t freed = kNone;
    for (const std::int32_t u : blamed) {
      const Unit& unit = units_[u];
      const std::size_t n = unit.loop.size();
      if (n == 3 || n > kFew || unit.free || unit.held || kOfFace * static_cast<double>(n - 2) >= best.cost) continue;
      best.cost = kOfFace * static_cast<double>(n - 2);
      freed = u;
    }
    if (freed != kNone) {
      units_[freed].free = true;
      return note(freed, cause);
    }
    if (best.corner == kNone) return false;
    lower(best.corner, best.reach);
    for (const std::int32_t u : blamed)
      if (units_[u].cause == Cause::none) units_[u].cause = cause;
    return true;
  }
  bool settle(std::int32_t l, std::int32_t part, std::span<const std::int32_t> loop, Cause cause) {
    return settle(loop, {unit_of(l, part)}, cause,
                  [&] { return (f_.defects_now(l, part).kinds & ~(kBent | kGiven | kinds_[l])) == 0; });
  }
  bool settle(const Hit& h) {
    std::vector<std::int32_t> corners(h.corners.begin(), h.corners.end());
    sort_unique(corners);
    return settle(corners, {unit_of(h.a, h.part_a), unit_of(h.b, h.part_b)}, Cause::meeting,
                  [&] { return !f_.meet_now(h.a, h.b); });
  }

  /// Replaces `best` if a shorter move of a corner mends a defect at a lower cost.
  template <class Function>
  void find_way(std::int32_t c, Function is_mended, Way& best) {
    const Vec3 was = at_[c];
    const double moved = (was - places_.start[c]).norm(), reach = places_.reach[c], before = worth(c);
    if (moved <= kStill * places_.diagonal) return;
    for (const double share : kShares) {
      places_.reach[c] = share * moved;
      const Vec3 to = meet_at(c, units_, around_, places_, kept_);
      const double cost = before - worth(c) + kStay * (1 - share);
      if (cost >= best.cost || to == was) continue;
      s_.move(c, to);
      if (is_mended()) best = {cost, c, share * moved};
    }
    s_.move(c, was);
    places_.reach[c] = reach;
    meet_at(c, units_, around_, places_, kept_);
  }

  /// The loss of the polygons at a corner if it were on none of their planes.
  [[nodiscard]] double worth(std::int32_t c) const {
    double sum = 0;
    for (const auto& [u, place] : around_.of(c)) {
      if (units_[u].free || units_[u].loop.size() == 3 || !kept_[u][place]) continue;
      sum += std::find(kept_[u].begin(), kept_[u].end(), 0) == kept_[u].end() ? kWhole : 1;
    }
    return sum;
  }

  /// The unit that a polygon of a chart is cut from.
  [[nodiscard]] std::int32_t unit_of(std::int32_t l, std::int32_t part) const {
    const auto loop = s_.polygons.of(s_.polygons.first_of(l) + part);
    for (std::int32_t u = first_[l]; u + 1 < first_[l + 1]; ++u) {
      const auto& all = units_[u].loop;
      const auto has = [&](std::int32_t c) { return std::find(all.begin(), all.end(), c) != all.end(); };
      if (std::all_of(loop.begin(), loop.end(), has)) return u;
    }
    return first_[l + 1] - 1;
  }

  /// Applies the next step against a defect of a polygon: triangulates its unit, moves its corners less, or changes its
  /// triangles.
  /// \param corners  the corners of the defect
  /// \return whether there was a step left
  bool give_up(std::int32_t l, std::int32_t part, std::span<const std::int32_t> corners, Cause cause, bool firmly) {
    const std::int32_t u = unit_of(l, part);
    Unit& unit = units_[u];
    if (acted_[u]) return true;
    double most = 0;
    for (const std::int32_t c : corners) most = std::max(most, (at_[c] - places_.start[c]).norm());
    const bool moved = most > kStill * places_.diagonal;
    if (!unit.free && (unit.loop.size() <= kFew || !moved) && !unit.held) {
      unit.free = unit.loop.size() > 3;
      if (unit.free) return note(u, cause);
    }
    if (moved) {
      const double left = firmly || most / 2 < kLeast * places_.diagonal ? 0 : most / 2;
      for (const std::int32_t c : corners)
        if ((at_[c] - places_.start[c]).norm() > most / 2) lower(c, left);
      return note(u, cause);
    }
    if (!unit.free && unit.loop.size() > 3) {
      unit.free = true;
      return note(u, cause);
    }
    const bool may_turn = unit.loop.size() > 3 && cause == Cause::meeting;
    if (may_turn && !unit.plain) {
      unit.plain = true;
      return note(u, cause);
    }
    bool any = false;  // the polygons around it may have moved
    for (const std::int32_t c : unit.loop)
      if (at_[c] != places_.start[c]) {
        lower(c, 0);
        any = true;
      }
    if (any) return note(u, cause);
    if (may_turn && !unit.own) {
      unit.own = true;
      return note(u, cause);
    }
    if (!is_last_ || unit.left) return false;
    unit.left = true;
    return note(u, cause);
  }

  void lower(std::int32_t c, double reach) {
    places_.reach[c] = std::min(places_.reach[c], reach);
    ask(c);
  }

  bool note(std::int32_t u, Cause cause) {
    acted_[u] = true;
    for (const std::int32_t c : units_[u].loop) ask(c);
    ask_unit(u);
    if (units_[u].cause == Cause::none) units_[u].cause = cause;
    return true;
  }

  PlanarOutcome sum_up() {
    PlanarOutcome out;
    PlanarReport& r = out.report;
    r.asked = true;
    std::int32_t whole = 0;
    std::set<std::int32_t> let_go;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      const auto added = static_cast<std::int32_t>(cuts_[u].size());
      whole += added == 0 && !uncut_[u] && !units_[u].left;
      r.faces_added += added;
      if (units_[u].scan.snapped && !units_[u].held) let_go.insert(s_.labels.charts[units_[u].chart].region);
      switch (added == 0 ? Cause::none : units_[u].cause) {
        case Cause::none:
        case Cause::apart:
          r.added_for_apart += added;
          break;
        case Cause::crossing:
          r.added_for_crossing += added;
          break;
        case Cause::flipped:
          r.added_for_flipped += added;
          break;
        case Cause::meeting:
          r.added_for_meeting += added;
          break;
      }
    }
    r.whole = units_.empty() ? 1.0 : whole / static_cast<double>(units_.size());
    out.let_go.assign(let_go.begin(), let_go.end());
    r.planar = is_planar(s_);
    out.stuck = std::move(stuck_);
    remember(out.stuck);
    return out;
  }

  /// Saves the results for the next try, except within kRings rings of the stuck charts.
  void remember(const std::vector<std::int32_t>& stuck) {
    std::vector<std::int32_t> all;
    for (const std::int32_t l : stuck)
      for (std::int32_t u = first_[l]; u < first_[l + 1]; ++u) all.push_back(u);
    const std::vector<bool> is_near = within_rings(units_, around_, std::move(all), kRings);
    memory_.units.clear();
    memory_.reach = places_.reach;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      if (is_near[u]) {
        for (const std::int32_t c : units_[u].loop) memory_.reach[c] = std::numeric_limits<double>::infinity();
        continue;
      }
      std::vector<std::int32_t> loop = units_[u].loop;
      memory_.units.emplace(std::move(loop), std::move(units_[u]));
    }
  }

  State& s_;
  Defects& f_;
  Memory& memory_;
  const bool is_last_;
  const Job& job_;
  std::vector<Unit> units_;  // in the order of their charts
  Places places_;
  const Around around_;
  Near near_;
  const std::vector<std::vector<std::array<std::int32_t, 2>>> diagonals_;  // diagonals at the start
  Edges edges_;
  std::vector<std::vector<Edge>> own_;         // by unit
  std::vector<std::int32_t> first_;            // by chart: its first unit
  std::vector<std::uint8_t> kinds_;            // by chart: the defects at the start
  std::set<std::array<std::int32_t, 2>> met_;  // pairs of charts that met
  std::vector<Vec3> at_;
  Kept kept_;
  std::vector<std::vector<Edge>> cuts_;       // by unit
  std::vector<bool> uncut_, acted_;           // by unit: there is no way to cut it; `give_up` changed it in this round
  std::vector<bool> is_dirty_, is_moving_;    // by unit, by corner: listed in ...
  std::vector<std::int32_t> dirty_, moving_;  // ... units to be cut and corners to be placed in the next round
  std::vector<std::int32_t> judged_, stuck_;  // charts
};

}  // namespace

PlanarOutcome make_planar(State& state, Defects& defects, Memory& memory, bool is_last, const Job& job) {
  return Planarizer(state, defects, memory, is_last, job).run();
}

bool is_planar(const State& state) {
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    bool all = true;
    state.polygons.for_each_of(l, [&](std::int32_t q) {
      all = all && is_flat(state.polygons.of(q), state.corners.position, kPlanar * state.mesh.diagonal());
    });
    if (!all) return false;
  }
  return true;
}

}  // namespace isimp::meshing::planar
