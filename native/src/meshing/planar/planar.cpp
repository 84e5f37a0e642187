#include "planar/planar.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <utility>

#include "discs/no_length.h"
#include "isimp/core/sorted.h"
#include "judge/trials.h"
#include "planar/cut.h"
#include "planar/draft.h"

namespace isimp::meshing::planar {
namespace {

// tuned planar
constexpr int kGentle = 12;       ///< limit: rounds in which corners that are held back keep half their way
constexpr std::size_t kFew = 12;  ///< most corners of a unit that is triangulated before its corners are held back
constexpr std::array kShares{0.95, 0.5, 0.25, 0.0};  ///< shares of its way kept by a corner that mends a defect
constexpr double kWhole = 1.5;   ///< cost of the first corner that a polygon loses; each further one costs 1
constexpr double kOfFace = 0.7;  ///< cost of each face of a polygon that is triangulated. Source: own trials

/// Moves corners back and triangulates polygons, against defects that the polygons did not have before.
class HoldBack {
 public:
  /// \param defects  of the polygons before; later of the planar ones
  HoldBack(const Defects& defects, Draft& draft, bool is_last)
      : s_(draft.state), f_(defects), draft_(draft), is_last_(is_last) {
    for (std::int32_t l = 0; l < s_.labels.chart_count(); ++l) kinds_.push_back(f_.kinds(l) & ~kBent);
    for (const Hit& h : f_.hits()) met_.insert({h.a, h.b});
  }

  /// Moves the corners of polygons that are defective or not planar less far, or triangulates these polygons.
  /// \param judged  charts whose polygons have changed
  /// \return whether anything was done; false if nothing is defective
  bool act(std::vector<std::int32_t> judged, bool firmly) {
    acted_.assign(draft_.units.size(), false);
    bool any = false;
    judged.insert(judged.end(), stuck_.begin(), stuck_.end());
    sort_unique(judged);
    stuck_.clear();
    for (const std::int32_t l : judged) any = act_on_chart(l, firmly) || any;
    for (const Hit& h : f_.hits()) {
      if (h.excused || met_.contains({h.a, h.b})) continue;
      if (!firmly && settle(h)) {
        any = true;
        continue;
      }
      const std::span<const std::int32_t> corners(h.corners);
      const bool a = give_up(h.a, corners.first(3), Cause::meeting, firmly);
      const bool b = give_up(h.b, corners.last(3), Cause::meeting, firmly);
      if (!a && !b) stuck_.insert(stuck_.end(), {h.a, h.b});
      any = any || a || b;
    }
    sort_unique(stuck_);
    return any;
  }

  /// The charts with a defect against which no step was left, in rising order.
  [[nodiscard]] const std::vector<std::int32_t>& stuck() const { return stuck_; }

 private:
  /// The defects of a chart's polygon that the chart did not have before.
  [[nodiscard]] std::uint8_t new_kinds(std::int32_t l, const PolygonDefects& found) const {
    return found.kinds & ~(kBent | kGiven | kinds_[l]);
  }

  bool act_on_chart(std::int32_t l, bool firmly) {
    bool any = false;
    for (std::int32_t part = 0; part < s_.polygons.count_of(l); ++part) {
      const auto loop = s_.polygons.of(s_.polygons.first_of(l) + part);
      const std::uint8_t kinds = new_kinds(l, f_.of(l).polygons[part]);
      const std::int32_t u = draft_.unit_of[l];
      if (kinds == 0 && (draft_.is_flat(loop) || draft_.units[u].left)) continue;
      const Cause cause = kinds & (kCrossing | kNoArea) ? Cause::crossing : kinds ? Cause::flipped : Cause::apart;
      const auto is_mended = [&] { return new_kinds(l, f_.defects_now(l, part)) == 0; };
      if ((kinds != 0 && !firmly && settle(loop, {u}, cause, is_mended)) || give_up(l, loop, cause, firmly)) {
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
        std::any_of(corners.begin(), corners.end(), [&](std::int32_t c) { return draft_.moving.has(c); }))
      return true;
    Way best;
    for (const std::int32_t c : corners) find_way(c, is_mended, best);
    std::int32_t freed = kNone;
    for (const std::int32_t u : blamed) {
      const Unit& unit = draft_.units[u];
      const std::size_t n = unit.loop.size();
      const double cost = kOfFace * (static_cast<double>(n) - 2);
      if (n == 3 || n > kFew || unit.free || unit.held || cost >= best.cost) continue;
      best.cost = cost;
      freed = u;
    }
    if (freed != kNone) {
      draft_.units.edit(freed).free = true;
      return note(freed, cause);
    }
    if (best.corner == kNone) return false;
    draft_.lower(best.corner, best.reach);
    for (const std::int32_t u : blamed) blame(u, cause);
    return true;
  }
  bool settle(const Hit& h) {
    std::vector<std::int32_t> corners(h.corners.begin(), h.corners.end());
    sort_unique(corners);
    return settle(corners, {draft_.unit_of[h.a], draft_.unit_of[h.b]}, Cause::meeting,
                  [&] { return !f_.meet_now(h.a, h.b); });
  }

  /// Replaces `best` if a shorter move of a corner mends a defect at a lower cost.
  template <class Function>
  void find_way(std::int32_t c, Function is_mended, Way& best) {
    const Vec3 was = s_.corners.position[c];
    const double moved = draft_.moved(c), reach = draft_.places.reach[c], before = worth(c);
    if (moved <= kNoLength * draft_.places.diagonal) return;
    for (const double share : kShares) {
      draft_.places.reach.set(c, share * moved);
      const Vec3 to = draft_.meet(c);
      s_.move(c, to);
      const double cost = before - worth(c);
      if (cost < best.cost && to != was && is_mended()) best = {cost, c, share * moved};
    }
    s_.move(c, was);
    draft_.places.reach.set(c, reach);
  }

  /// The loss of the polygons at a corner if it were on none of their planes.
  [[nodiscard]] double worth(std::int32_t c) const {
    double sum = 0;
    for (const auto& [u, place] : draft_.around.of(c)) {
      const Unit& unit = draft_.units[u];
      const auto is_on = [&](std::int32_t d) { return draft_.is_on(unit, d); };
      if (unit.free || unit.loop.size() == 3 || !is_on(c)) continue;
      sum += std::all_of(unit.loop.begin(), unit.loop.end(), is_on) ? kWhole : 1;
    }
    return sum;
  }

  /// Applies the next step against a defect of a polygon: triangulates its unit, or moves its corners less.
  /// \param corners  the corners of the defect
  /// \return whether there was a step left
  bool give_up(std::int32_t l, std::span<const std::int32_t> corners, Cause cause, bool firmly) {
    const std::int32_t u = draft_.unit_of[l];
    return acted_[u] || (take_step(draft_.units.edit(u), corners, firmly) && note(u, cause));
  }

  bool take_step(Unit& unit, std::span<const std::int32_t> corners, bool firmly) {
    const auto set = [](bool& flag) { return !std::exchange(flag, true); };
    const bool is_triangle = unit.loop.size() == 3;
    double most = 0;
    for (const std::int32_t c : corners) most = std::max(most, draft_.moved(c));
    const bool moved = most > kNoLength * draft_.places.diagonal;
    if (!is_triangle && !unit.held && (unit.loop.size() <= kFew || !moved) && set(unit.free)) return true;
    if (moved) {
      const double left = firmly ? 0 : most / 2;
      for (const std::int32_t c : corners)
        if (draft_.moved(c) > most / 2) draft_.lower(c, left);
      return true;
    }
    if (!is_triangle && set(unit.free)) return true;
    bool any = false;  // the polygons around it may have moved
    for (const std::int32_t c : unit.loop)
      if (s_.corners.position[c] != draft_.places.start[c]) {
        draft_.lower(c, 0);
        any = true;
      }
    return any || (is_last_ && set(unit.left));
  }

  void blame(std::int32_t u, Cause cause) {
    if (Unit& unit = draft_.units.edit(u); unit.cause == Cause::none) unit.cause = cause;
  }

  bool note(std::int32_t u, Cause cause) {
    acted_[u] = true;
    draft_.ask(u);
    blame(u, cause);
    return true;
  }

  State& s_;
  const Defects& f_;
  Draft& draft_;
  const bool is_last_;
  std::vector<std::uint8_t> kinds_;            // by chart: the defects at the start
  std::set<std::array<std::int32_t, 2>> met_;  // pairs of charts that met at the start
  std::vector<bool> acted_;                    // by unit: `note` was called in this round
  std::vector<std::int32_t> stuck_;            // charts
};

/// Undoes steps of HoldBack that later ones have made needless, where fewer polygons and no defect result.
class TakeBack {
 public:
  /// \param reach  by corner: its largest move before any was held back
  TakeBack(Defects& defects, Draft& draft, const std::vector<double>& reach, const Job& job)
      : s_(draft.state), f_(defects), draft_(draft), reach_(reach), job_(job) {}

  /// Tries each unit that is cut, the largest first: all steps at it, then one after another.
  /// Cost: a cut and a judgement of the polygons around for each of them and of their corners held back.
  void run() {
    std::vector<std::int32_t> order;
    for (std::size_t u = 0; u < draft_.units.size(); ++u)
      if (draft_.added(draft_.units[u]) > 0) order.push_back(static_cast<std::int32_t>(u));
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return draft_.units[a].scan.area > draft_.units[b].scan.area; });
    for (const std::int32_t u : order) {
      job_.poll();
      const std::vector<std::int32_t> loop = draft_.units[u].loop;
      if (draft_.added(draft_.units[u]) == 0 || take_back(u, true, loop)) continue;
      take_back(u, true, {});
      for (const std::int32_t c : loop) take_back(u, false, {&c, 1});
    }
    f_.renew_hits();
  }

 private:
  /// Undoes the steps at a unit if fewer polygons and no defect result.
  /// \param bind     whether the plane of the unit is to count again
  /// \param corners  of the unit, which may move as far as at the start
  /// \return whether there were such steps, and they are taken back
  bool take_back(std::int32_t u, bool bind, std::span<const std::int32_t> corners) {
    const auto is_held = [&](std::int32_t c) { return draft_.places.reach[c] < reach_[c]; };
    if (!(bind && draft_.units[u].free) && std::none_of(corners.begin(), corners.end(), is_held)) return false;
    std::vector<std::int32_t> charts;
    const auto change = [&] {
      const std::int32_t before = s_.polygons.count();
      if (bind) draft_.units.edit(u).free = false;
      for (const std::int32_t c : corners) draft_.places.reach.set(c, reach_[c]);
      draft_.ask(u);
      draft_.place(job_);
      charts = renew_cuts(draft_, f_.bounds().thickness);
      return s_.polygons.count() < before && are_flat(charts);
    };
    return attempt(s_, f_, charts, kNone, change, meshing::Places::moved, draft_.units, draft_.places.reach,
                   draft_.beyond);
  }

  [[nodiscard]] bool are_flat(std::span<const std::int32_t> charts) const {
    bool all = true;
    for (const std::int32_t l : charts)
      if (!draft_.units[draft_.unit_of[l]].left)
        s_.polygons.for_each_of(l, [&](std::int32_t q) { all = all && draft_.is_flat(s_.polygons.of(q)); });
    return all;
  }

  State& s_;
  Defects& f_;
  Draft& draft_;
  const std::vector<double>& reach_;
  const Job& job_;
};

PlanarOutcome sum_up(const Draft& draft) {
  PlanarOutcome out;
  PlanarReport& r = out.report;
  r.asked = true;
  std::int32_t* const counts[] = {&r.added_for_apart, &r.added_for_apart, &r.added_for_crossing, &r.added_for_flipped,
                                  &r.added_for_meeting};  // in the order of Cause
  double whole = 0;
  for (const Unit& unit : draft.units) {
    const std::int32_t added = draft.added(unit);
    whole += added == 0 && !unit.left ? 1 : 0;
    r.faces_added += added;
    *counts[static_cast<std::size_t>(unit.cause)] += added;
    if (unit.scan.snapped && !unit.held) out.let_go.push_back(draft.state.labels.charts[unit.chart].region);
  }
  sort_unique(out.let_go);
  r.whole = draft.units.empty() ? 1.0 : whole / static_cast<double>(draft.units.size());
  return out;
}

}  // namespace

PlanarOutcome make_planar(State& state, Defects& defects, bool is_last, const Job& job) {
  Transaction transaction(state);
  defects.keep();
  Draft draft(state, job);
  HoldBack hold_back(defects, draft, is_last);
  const std::vector<double> reach = draft.places.reach;  // before corners are held back
  std::vector<std::int32_t> judged;
  for (int round = 0; round == 0 || hold_back.act(std::move(judged), round > kGentle); ++round) {
    job.poll();
    draft.place(job);
    judged = renew_cuts(draft, defects.bounds().thickness);
    defects.judge(judged);
  }
  if (!hold_back.stuck().empty() && !is_last) return {{}, {}, hold_back.stuck()};
  transaction.commit();
  TakeBack(defects, draft, reach, job).run();
  return sum_up(draft);
}

bool is_planar(const State& state) {
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    bool all = true;
    state.polygons.for_each_of(l, [&](std::int32_t q) {
      all = all && is_flat(state.polygons.of(q), state.corners.position, state.mesh.diagonal());
    });
    if (!all) return false;
  }
  return true;
}

}  // namespace isimp::meshing::planar
