#include "planar/planar.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
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
constexpr std::size_t kFew = 8;           ///< corners of a unit that is rather triangulated than held back
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

/// Whether a point is no further than this from a triangle.
bool is_within(const Vec3& p, const std::array<Vec3, 3>& t, double most) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  bool inside = n.squaredNorm() > 0;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = t[k], &b = t[(k + 1) % 3];
    const Vec3 side = b - a;
    const double length = side.squaredNorm();
    const double share = length > 0 ? std::clamp((p - a).dot(side) / length, 0.0, 1.0) : 0.0;
    least = std::min(least, (p - a - share * side).squaredNorm());
    inside = inside && n.dot(side.cross(p - a)) >= 0;
  }
  return least <= most * most || (inside && std::abs(n.dot(p - t[0])) <= most * n.norm());
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
    f_.judge_planar();
  }

  Outcome run() {
    solve();
    for (int round = 0; round < kRounds; ++round) {
      apply();
      if (!hold_back(round >= kGentle)) break;
    }
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

  /// Puts corners on their planes, nearer to where they were if they leave the scan there.
  void place() {
    constexpr int kTries = 4;
    for (int go = 0; go < kTries; ++go) {
      kept_ = meet(units_, around_, places_, s_.threads, job_, at_);
      bool any = false;
      for (std::int32_t c = 0; c < s_.corners.count(); ++c)
        if (!is_near_scan(c)) {
          places_.reach[c] = go + 2 < kTries ? 0.6 * (at_[c] - places_.start[c]).norm() : 0;
          any = true;
        }
      if (!any) return;
    }
  }

  /// Whether a corner is where it was, or no further from the scan than it may be from its vertex or than the reach.
  [[nodiscard]] bool is_near_scan(std::int32_t c) {
    const double step = (at_[c] - places_.start[c]).norm();
    const Vec3& home = s_.mesh.vertices()[s_.corners.vertex[c]];
    if (step <= places_.base || (at_[c] - home).norm() <= s_.options.reach * places_.diagonal) return true;
    for (const Around::Use& use : around_.of(c)) {
      std::vector<std::int32_t>& faces = faces_[units_[use.unit].piece];
      if (faces.empty()) faces = s_.labels.faces_of(units_[use.unit].piece);
      for (const std::int32_t f : faces) {
        const Triangle& t = s_.mesh.triangles()[f];
        const auto& v = s_.mesh.vertices();
        if (is_within(at_[c], {v[t[0]], v[t[1]], v[t[2]]}, places_.base)) return true;
      }
    }
    return false;
  }

  /// Puts corners and cuts where the planes ask for them, and judges what has changed.
  void apply() {
    place();
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
  std::map<std::int32_t, std::vector<std::int32_t>> faces_;  // of the scan, by piece: those that were asked for
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
