#include "planar/planar.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <utility>

#include "planar/cut.h"
#include "planar/fit.h"
#include "planar/meet.h"
#include "planar/unit.h"
#include "sorted.h"

namespace isimp::meshing::planar {
namespace {

constexpr int kPasses = 5;                ///< fits without the corners that did not fit
constexpr Schedule kAgain{10, 1e2, 1e6};  ///< of these
constexpr int kRounds = 80;               ///< of judging and holding back ...
constexpr int kGentle = 12;               ///< ... in the first of which corners keep half their way
constexpr std::size_t kFew = 4;           ///< corners of a unit that is rather triangulated than held back
constexpr double kLeast = 1e-3;           ///< of the diagonal: corners held back to less than this stay where they were

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
  Planarizer(State& state, Findings& findings, const Job& job)
      : s_(state),
        f_(findings),
        job_(job),
        units_(units_of(state)),
        places_(places_of(state, units_, state.options.planar_reach * state.mesh.diagonal())),
        around_(units_, state.corners.count()),
        diagonals_(state.diagonals),
        first_(state.labels.pieces.size() + 1, 0) {
    for (const Unit& u : units_) ++first_[u.piece + 1];
    for (std::size_t l = 1; l < first_.size(); ++l) first_[l] += first_[l - 1];
    for (std::size_t l = 0; l + 1 < first_.size(); ++l)
      faults_.push_back(f_.faults(static_cast<std::int32_t>(l)) & ~kBent);
    for (const Hit& h : f_.hits()) met_.insert({h.a, h.b});
    f_.judge_parts_apart();
  }

  Outcome run() {
    auto T=[]{return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();};
    double t0=T();
    solve();
    double t1=T();
    int round = 0;
    for (; round < kRounds; ++round) {
      apply();
      int faulty=0; 
      const bool any=hold_back(round >= kGentle);
      for (bool b:acted_) faulty+=b;
      if (getenv("PDEBUG")) fprintf(stderr,"  round %d acted %d stuck %zu\n",round,faulty,stuck_.size());
      if (!any) break;
    }
    if (getenv("PDEBUG")) {fprintf(stderr,"units %zu solve %.2f rest %.2f rounds %d stuck %zu\n",units_.size(),t1-t0,T()-t1,round,stuck_.size());
     for (auto l:stuck_) { std::string x; for (int i=0;i<s_.polygons.count_of(l);++i) { x+=' '; x+=std::to_string(s_.polygons.of(s_.polygons.first_of(l)+i).size()); x+=':'; x+=std::to_string(f_.of(l).polygons[i].faults);} fprintf(stderr,"   stuck %d faces %zu base %d uncut %d: %s\n",l,s_.labels.faces_of(l).size(),faults_[l],(int)uncut_[first_[l]],x.c_str());} }
    return sum_up();
  }

 private:
  void solve() {
    Kept kept;
    for (const Unit& u : units_) kept.emplace_back(u.loop.size(), 1);
    std::vector<Vec3> at = places_.start;
    fit(units_, places_, kept, {}, at, job_);
    for (int pass = 1; pass < kPasses; ++pass) {
      kept = meet(units_, around_, places_, s_.threads, job_, at_);
      fit(units_, places_, kept, kAgain, at, job_);
    }
  }

  /// Puts corners and cuts where the planes ask for them, and judges what has changed.
  void apply() {
    kept_ = meet(units_, around_, places_, s_.threads, job_, at_);
    std::set<Edge> edges;
    for (const Unit& u : units_)
      for (std::size_t i = 0; i < u.loop.size(); ++i) {
        const auto [a, b] = std::minmax(u.loop[i], u.loop[i + 1 < u.loop.size() ? i + 1 : 0]);
        edges.insert({a, b});
      }
    s_.corners.position = at_;
    cuts_.assign(units_.size(), {});
    uncut_.assign(units_.size(), false);
    Diagonals diagonals = diagonals_;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      const Unit& unit = units_[u];
      if (unit.free) kept_[u].assign(unit.loop.size(), 0);
      const Rules rules{s_.planes[unit.piece].normal, f_.bounds().thickness};
      uncut_[u] = !cut(unit, kept_[u], at_, rules, edges, cuts_[u]);
      for (const auto& [a, b] : cuts_[u]) diagonals[unit.piece].push_back({s_.corners.vertex[a], s_.corners.vertex[b]});
    }
    std::vector<std::int32_t> changed;
    for (std::int32_t l = 0; l < s_.labels.piece_count(); ++l)
      if (diagonals[l] != s_.diagonals[l]) changed.push_back(l);
    s_.diagonals = std::move(diagonals);
    s_.polygons.collect(s_.complex, s_.labels, s_.diagonals, s_.corners, changed);
    std::vector<std::int32_t> all;
    for (const Unit& u : units_) all.push_back(u.piece);
    sort_unique(all);
    f_.judge(all);
  }

  /// What is at fault, and what is not planar, moves its corners less or is triangulated.
  /// \return whether anything was done; there is nothing to do where nothing is at fault
  bool hold_back(bool firmly) {
    acted_.assign(units_.size(), false);
    bool any = false;
    stuck_.clear();
    for (std::size_t l = 0; l + 1 < first_.size(); ++l)
      any = hold_back_piece(static_cast<std::int32_t>(l), firmly) || any;
    for (const Hit& h : f_.hits()) {
      if (met_.contains({h.a, h.b})) continue;
      const std::span<const std::int32_t> corners(h.corners);
      const bool a = give_up(h.a, h.part_a, corners.first(3), Cause::meeting, firmly);
      const bool b = give_up(h.b, h.part_b, corners.last(3), Cause::meeting, firmly);
      if (!a && !b && !h.excused) stuck_.insert(stuck_.end(), {h.a, h.b});
      any = any || a || b;
    }
    sort_unique(stuck_);
    return any;
  }

  bool hold_back_piece(std::int32_t l, bool firmly) {
    bool any = false;
    const double most = kPlanar * s_.mesh.diagonal();
    const auto& verdicts = f_.of(l).polygons;
    for (std::int32_t part = 0; part < s_.polygons.count_of(l); ++part) {
      const auto loop = s_.polygons.of(s_.polygons.first_of(l) + part);
      const std::uint8_t faults = verdicts[part].faults & ~(kBent | kGiven | faults_[l]);
      const bool flat = is_flat(loop, at_, most);
      if (faults == 0 && flat) continue;
      const Cause cause = faults & (kCrossing | kNoArea) ? Cause::crossing : faults ? Cause::flipped : Cause::apart;
      if (give_up(l, part, loop, cause, firmly)) {
        any = true;
      } else {
        stuck_.push_back(l);
      }
    }
    return any;
  }

  /// The unit that a polygon of a piece is cut from.
  [[nodiscard]] std::int32_t unit_of(std::int32_t l, std::int32_t part) const {
    const auto loop = s_.polygons.of(s_.polygons.first_of(l) + part);
    for (std::int32_t u = first_[l]; u + 1 < first_[l + 1]; ++u) {
      const auto& all = units_[u].loop;
      const auto has = [&](std::int32_t c) { return std::find(all.begin(), all.end(), c) != all.end(); };
      if (std::all_of(loop.begin(), loop.end(), has)) return u;
    }
    return first_[l + 1] - 1;
  }

  /// \param corners  those concerned
  /// \return whether there was something left to give up
  bool give_up(std::int32_t l, std::int32_t part, std::span<const std::int32_t> corners, Cause cause, bool firmly) {
    const std::int32_t u = unit_of(l, part);
    Unit& unit = units_[u];
    if (acted_[u]) return true;
    double most = 0;
    for (const std::int32_t c : corners) most = std::max(most, (at_[c] - places_.start[c]).norm());
    const bool moved = most > 1e-9 * places_.diagonal;
    if (!unit.free && (unit.loop.size() <= kFew || !moved) && !unit.held) {
      unit.free = unit.loop.size() > 3;
      if (unit.free) return note(u, cause);
    }
    if (moved) {
      const double left = firmly || most / 2 < kLeast * places_.diagonal ? 0 : most / 2;
      for (const std::int32_t c : corners)
        if ((at_[c] - places_.start[c]).norm() > most / 2) places_.reach[c] = std::min(places_.reach[c], left);
      return note(u, cause);
    }
    if (!unit.free && unit.loop.size() > 3) {
      unit.free = true;
      return note(u, cause);
    }
    if (firmly) {  // what is round it may have moved
      for (const std::int32_t c : unit.loop)
        if (at_[c] != places_.start[c]) {
          places_.reach[c] = 0;
          acted_[u] = true;
        }
      if (acted_[u]) return note(u, cause);
    }
    if (unit.plain || unit.loop.size() == 3 || cause != Cause::meeting) return false;
    unit.plain = true;
    return note(u, cause);
  }

  bool note(std::int32_t u, Cause cause) {
    acted_[u] = true;
    if (units_[u].cause == Cause::none) units_[u].cause = cause;
    return true;
  }

  Outcome sum_up() {
    Outcome out;
    PlanarReport& r = out.report;
    r.asked = true;
    std::int32_t whole = 0;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      const auto added = static_cast<std::int32_t>(cuts_[u].size());
      whole += added == 0 && !uncut_[u];
      r.faces_added += added;
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
    r.planar = is_planar(s_);
    out.stuck = std::move(stuck_);
    return out;
  }

  State& s_;
  Findings& f_;
  const Job& job_;
  std::vector<Unit> units_;  // in the order of their pieces
  Places places_;
  const Around around_;
  const Diagonals diagonals_;                  // as they were
  std::vector<std::int32_t> first_;            // by piece: its first unit
  std::vector<std::uint8_t> faults_;           // by piece: as they were
  std::set<std::array<std::int32_t, 2>> met_;  // pairs of pieces that met
  std::vector<Vec3> at_;
  Kept kept_;
  std::vector<std::vector<Edge>> cuts_;  // by unit
  std::vector<bool> uncut_, acted_;      // by unit: there is no way to cut it; it has given up something in this round
  std::vector<std::int32_t> stuck_;
};

}  // namespace

Outcome make_planar(State& state, Findings& findings, const Job& job) { return Planarizer(state, findings, job).run(); }

bool is_planar(const State& state) {
  for (std::int32_t l = 0; l < state.labels.piece_count(); ++l) {
    bool all = true;
    state.polygons.for_each_of(l, [&](std::int32_t q) {
      all = all && is_flat(state.polygons.of(q), state.corners.position, kPlanar * state.mesh.diagonal());
    });
    if (!all) return false;
  }
  return true;
}

}  // namespace isimp::meshing::planar
