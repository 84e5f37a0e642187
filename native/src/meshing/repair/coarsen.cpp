#include "repair/coarsen.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "complex/joins.h"
#include "complex/planes.h"
#include "complex/transaction.h"
#include "isimp/core/sorted.h"
#include "place/improve.h"

namespace isimp::meshing {
namespace {

constexpr int kRounds = 40;
constexpr std::int32_t kTogether = 256;   ///< pieces in which one thread searches for candidates
constexpr double kGoOn = 0.8;             ///< rough share of the work that is left after a round
constexpr std::size_t kWorthwhile = 300;  ///< a round with fewer trials than one in kWorthwhile pieces is the last
/// A round of at least kMany trials of which fewer than 1 in kPoor succeed is the last one too: the remaining trials
/// cost as much as the first ones, and few will succeed.
constexpr std::size_t kMany = 64, kPoor = 8;
constexpr double kHopeless = 1.5;  ///< times the bound: no placement will make a polygon so bent flat
// Deviation that a union of two regions may add, as shares of the mean deviation of a region. Source: own trials, 15
// scans, buildings and nasty meshes at 50 to 1,000 regions.
constexpr double kError = 1, kSquare = 3;
constexpr int kRings = 2;      ///< rings around a new fault in which trials are blamed at first ...
constexpr int kMostRings = 5;  ///< ... and at most; beyond, all trials are blamed
/// Bound on the bend if none is set, as a share of the diagonal: intersections of a polygon that is bent more depend on
/// its triangulation.
constexpr double kFree = 0.05;

double error_of(const Plane& p) { return 2 * (p.area - p.projected); }
double square_of(const Plane& p) { return p.area * p.normal.dot(p.spread * p.normal); }

/// The actions of the repair that may turn out to be unnecessary.
enum class Act : std::int32_t { diagonal, split };

struct Candidate {
  Act act;
  std::int32_t piece;  ///< the piece that keeps its number
  std::int32_t other;  ///< split: the piece that is absorbed
  double score;        ///< the higher, the sooner it is tried
};

using Key = std::array<std::int32_t, 4>;  ///< an act, and the numbers that identify it within its kind

/// An act that was taken back.
struct Trial {
  Act act;
  std::int32_t piece;
  std::int32_t gone = kNone;                           ///< split: the piece that was absorbed ...
  std::int32_t region = kNone;                         ///< ... and its region
  std::array<std::int32_t, 2> diagonal{kNone, kNone};  ///< diagonal: its ends
};

class Coarsener {
 public:
  Coarsener(State& state, Findings& findings, const Misses& usual, Scope scope, Job& job)
      : s_(state),
        findings_(findings),
        usual_(usual),
        scope_(std::move(scope)),
        job_(job),
        pieces_of_(s_.mesh.component_count(), 0),
        pieces_in_(s_.regions, 0) {
    for (const Piece& p : s_.labels.pieces)
      if (p.face != kNone) {
        ++pieces_of_[s_.mesh.component()[p.face]];
        ++pieces_in_[p.region];
      }
  }

  std::int32_t run() {
    const std::int32_t before = s_.polygons.count();
    try_all(0.0, 0.5);
    // Better places make other unions possible.
    improve_places(s_, findings_, job_);
    tried_.clear();
    suspected_.clear();
    std::fill(unions_.begin(), unions_.end(), std::nullopt);
    ease(s_, findings_, scope_, job_);
    // Corners that can move again may not need diagonals that they needed before.
    std::erase_if(tried_, [](const auto& t) { return t[0] == static_cast<std::int32_t>(Act::diagonal); });
    try_all(0.6, 1.0);
    return before - s_.polygons.count();
  }

 private:
  [[nodiscard]] bool tried(Act act, std::int32_t a, std::int32_t b = kNone, std::int32_t c = kNone) const {
    return tried_.contains({static_cast<std::int32_t>(act), a, b, c});
  }
  void mark_tried(Act act, std::int32_t a, std::int32_t b = kNone, std::int32_t c = kNone) {
    tried_.insert({static_cast<std::int32_t>(act), a, b, c});
  }

  /// The first of a piece's diagonals that was not tried, their number if there is none.
  [[nodiscard]] std::size_t untried_diagonal(std::int32_t l) const {
    const auto& all = s_.diagonals[l];
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const auto& d) { return !tried(Act::diagonal, l, d[0], d[1]); });
    return static_cast<std::size_t>(at - all.begin());
  }

  /// The remaining candidates, the most promising first: unions whose pieces share most of their boundary.
  [[nodiscard]] std::vector<Candidate> candidates() {
    const std::int32_t count = s_.labels.piece_count();
    std::vector<std::vector<Candidate>> by_block(count / kTogether + 1);
    unions_.resize(count);
    s_.threads.blocks(count, kTogether, [&](std::int32_t block, std::int32_t begin, std::int32_t end) {
      job_.poll();
      for (std::int32_t l = begin; l < end; ++l) add_candidates(l, by_block[block]);
    });
    std::vector<Candidate> all;
    for (const auto& some : by_block) all.insert(all.end(), some.begin(), some.end());
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    return all;
  }

  void add_candidates(std::int32_t l, std::vector<Candidate>& all) {
    const Piece& p = s_.labels.pieces[l];
    if (p.face == kNone) return;
    if (scope_.has(l) && untried_diagonal(l) < s_.diagonals[l].size()) all.push_back({Act::diagonal, l, l, 0.5});
    if (p.cause != Cause::region && p.cause != Cause::closed) add_unions(l, all);
  }

  /// Whether two parts of a row of holes are long enough each for itself.
  [[nodiscard]] bool parts_row(std::int32_t a, std::int32_t b) const {
    const auto is_cut = [&](std::int32_t l) { return s_.labels.pieces[l].cause == Cause::hole; };
    return s_.cutter.perforated && is_cut(a) && is_cut(b) &&
           s_.complex.chords(a).size() + s_.complex.chords(b).size() > 2 * kLarge;
  }

  [[nodiscard]] bool may_unite(std::int32_t kept, std::int32_t gone) const {
    return (scope_.has(kept) || scope_.has(gone)) && !tried(Act::split, gone, kept);
  }

  /// Whether a larger piece of another region, or of two of one size that of the first region, is near enough to the
  /// plane of both.
  [[nodiscard]] bool is_alike(std::int32_t kept, std::int32_t gone) const {
    const Plane &a = s_.planes[kept], &b = s_.planes[gone];
    if (b.area > a.area || (b.area == a.area && s_.labels.pieces[kept].region > s_.labels.pieces[gone].region))
      return false;
    const Plane both = united(a, b);
    return error_of(both) - error_of(a) - error_of(b) <= kError * usual_.error &&
           square_of(both) - square_of(a) - square_of(b) <= kSquare * usual_.square;
  }

  /// Whether the region of the absorbed piece keeps another piece, and the union belongs to the region of the kept one.
  [[nodiscard]] bool may_change_region(const Candidate& c) const {
    const std::int32_t from = s_.labels.pieces[c.other].region, to = s_.labels.pieces[c.piece].region;
    if (from == to) return true;
    if (pieces_in_[from] < 2) return false;
    std::vector<std::int32_t> faces = s_.labels.faces_of(c.other);
    std::sort(faces.begin(), faces.end());
    if (!may_give(s_, c.other, c.piece, faces)) return false;
    const std::vector<std::int32_t> more = s_.labels.faces_of(c.piece);
    faces.insert(faces.end(), more.begin(), more.end());
    return s_.region_of(c.piece, faces) == to;
  }

  void add_unions(std::int32_t gone, std::vector<Candidate>& all) {
    if (!unions_[gone]) {
      const SharedBoundary shared = s_.shared_boundary(gone);
      unions_[gone].emplace();
      for (const auto& [k, length] : shared.with)
        if (!parts_wall(s_, k, gone) && !parts_row(k, gone))
          unions_[gone]->push_back({Act::split, k, gone, shared.all > 0 ? length / shared.all : 0});
      for (const auto& [k, length] : shared.others)
        if (s_.labels.pieces[gone].cause != Cause::unconnected && is_alike(k, gone))
          unions_[gone]->push_back({Act::split, k, gone, length / shared.all - 1});
    }
    for (const Candidate& c : *unions_[gone])
      if (may_unite(c.piece, gone)) all.push_back(c);
  }

  /// The pieces that may change when a candidate is tried, some of them more than once. Large neighbours are left out:
  /// their faults have places, and if only one neighbour of a large piece could be tried per round, there would be as
  /// many rounds as neighbours.
  [[nodiscard]] std::vector<std::int32_t> zone_of(const Candidate& c) const {
    std::vector<std::int32_t> zone{c.piece};
    const auto add = [&](std::int32_t l) {
      if (!s_.is_large(l)) zone.push_back(l);
    };
    s_.for_each_neighbour(c.piece, add);
    if (c.act == Act::split) s_.for_each_neighbour(c.other, add);
    return zone;
  }

  void try_all(double from, double to) {
    const Job::Part part(job_, "joining polygons", from, to);
    double left = 1.0;
    for (int round = 0; round < kRounds; ++round, left *= kGoOn) {
      job_.report(1 - left);
      if (!try_some()) return;
    }
  }

  /// Tries candidates that are far enough from each other that a new fault identifies its cause.
  /// \return whether to go on
  bool try_some() {
    std::vector<bool> busy(s_.labels.pieces.size(), false);
    std::vector<Trial> trials;
    Transaction transaction(s_);
    for (const Candidate& c : candidates()) {
      if (busy[c.piece] || busy[c.other]) continue;
      const std::vector<std::int32_t> zone = zone_of(c);
      if (std::any_of(zone.begin(), zone.end(), [&](std::int32_t l) { return busy[l]; })) continue;
      std::optional<Trial> trial = start(c);
      if (!trial) continue;
      for (const std::int32_t l : zone) busy[l] = true;
      busy[c.other] = true;  // a large one is not in the zone
      trials.push_back(*trial);
    }
    if (trials.empty()) return false;
    const std::size_t tried = trials.size();
    const std::vector<bool> before = findings_.faulty();
    findings_.keep();
    judge(trials, s_.update_in_place(pieces_in(trials)));
    int rings = kRings;
    std::vector<bool> after = findings_.faulty();
    while (!trials.empty()) {
      std::vector<Trial> good, failed;
      // If even kMostRings rings do not contain the cause, all trials are undone.
      const std::vector<bool> near = near_fresh(std::min(rings, kMostRings), before, after);
      for (const Trial& t : trials)
        (rings > kMostRings || after[t.piece] || near[t.piece] ? failed : good).push_back(t);
      trials.swap(good);
      if (failed.empty()) {
        if (!any_fresh(before, after)) break;
        ++rings;  // corners that were added to keep polygons apart have moved polygons further away
        continue;
      }
      for (const Trial& t : failed) {
        undo(t, transaction);
        if (rings > kRings && suspected_.insert(key_of(t)).second) tried_.erase(key_of(t));
      }
      judge(failed, s_.update_in_place(pieces_in(failed)));
      after = findings_.faulty();  // an undone trial may spoil a neighbour
    }
    transaction.commit();
    for (const Trial& t : trials) forget_unions_round(t);
    const bool is_poor = tried >= kMany && trials.size() * kPoor < tried;
    return tried * kWorthwhile >= s_.labels.pieces.size() && !is_poor;
  }

  /// Clears the saved unions of the pieces that an act has changed and of their neighbours.
  void forget_unions_round(const Trial& t) {
    if (t.gone == kNone) return;
    unions_[t.piece].reset();
    unions_[t.gone].reset();
    s_.for_each_neighbour(t.piece, [&](std::int32_t l) { unions_[l].reset(); });
  }

  /// Whether a polygon is so faulty, both with its corners at their present places and on the mesh, that a new
  /// placement is not worth a try.
  [[nodiscard]] bool is_hopeless(std::span<const std::int32_t> vertices, const Vec3& normal) const {
    if (vertices.size() < 3) return false;
    std::vector<std::int32_t> polygon(vertices.size());
    std::vector<Vec3> placed, home;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      polygon[i] = static_cast<std::int32_t>(i);
      const std::int32_t corner = s_.corners.of_vertex[vertices[i]];
      home.push_back(s_.mesh.vertices()[vertices[i]]);
      placed.push_back(corner == kNone ? home.back() : s_.corners.position[corner]);
    }
    const double bend = findings_.bounds().bend > 0 ? findings_.bounds().bend : kFree * s_.mesh.diagonal();
    const Bounds bounds{kHopeless * bend, findings_.bounds().thickness};
    return judge_polygon(polygon, placed, normal, bounds).faults != 0 &&
           judge_polygon(polygon, home, normal, bounds).faults != 0;
  }

  /// Whether the union of two pieces, with the given loop, or a neighbour that loses a corner by it is hopeless.
  [[nodiscard]] bool is_hopeless(std::span<const std::int32_t> loop, const Candidate& c) const {
    const Plane &a = s_.planes[c.piece], &b = s_.planes[c.other];
    std::vector<std::int32_t> vertices, lost;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t v = s_.mesh.from(loop[i]);
      if (!s_.complex.is_corner(v)) continue;
      const bool junction = s_.labels.label[loop[i] / 3] != s_.labels.label[loop[i > 0 ? i - 1 : loop.size() - 1] / 3];
      if (junction && s_.complex.boundary_edges(v) == 3) {  // two are left
        lost.push_back(loop[i]);
      } else {
        vertices.push_back(v);
      }
    }
    if (is_hopeless(vertices, (a.area * a.normal + b.area * b.normal).normalized())) return true;
    return std::any_of(lost.begin(), lost.end(), [&](std::int32_t h) { return spoils_beside(h); });
  }

  /// Whether the piece across a half-edge is hopeless without the corner that it leaves.
  [[nodiscard]] bool spoils_beside(std::int32_t h) const {
    const std::int32_t l = s_.labels.across(h);
    if (l == kNone || s_.is_large(l) || !s_.diagonals[l].empty() || findings_.faults(l) != 0) return false;
    std::vector<std::int32_t> vertices;
    for (const std::int32_t g : s_.complex.chords(l))
      if (s_.mesh.from(g) != s_.mesh.from(h)) vertices.push_back(s_.mesh.from(g));
    return is_hopeless(vertices, s_.planes[l].normal);
  }

  /// Undoes one act of the repair.
  /// \return nullopt if the act has to stay
  std::optional<Trial> start(const Candidate& c) {
    Trial trial{.act = c.act, .piece = c.piece};
    switch (c.act) {
      case Act::diagonal: {
        std::vector<std::array<std::int32_t, 2>> all = s_.diagonals[c.piece];
        const auto at = all.begin() + static_cast<std::ptrdiff_t>(untried_diagonal(c.piece));
        trial.diagonal = *at;
        mark_tried(Act::diagonal, c.piece, trial.diagonal[0], trial.diagonal[1]);
        all.erase(at);
        s_.set_diagonals(c.piece, std::move(all));
        break;
      }
      case Act::split: {
        mark_tried(Act::split, c.other, c.piece);
        std::int32_t& left = pieces_of_[s_.mesh.component()[s_.labels.pieces[c.other].face]];
        if (left <= kLeastClosed) return {};
        const std::vector<std::int32_t> loop = s_.loop_together(c.piece, c.other);
        if (loop.empty() || is_hopeless(loop, c) || !may_change_region(c)) return {};
        trial.gone = c.other;
        trial.region = s_.labels.pieces[c.other].region;
        s_.unite(c.piece, c.other, loop);
        scope_.add(c.piece);
        --left;
        --pieces_in_[trial.region];
      }
    }
    return trial;
  }

  [[nodiscard]] static Key key_of(const Trial& t) {
    const auto act = static_cast<std::int32_t>(t.act);
    return t.gone != kNone ? Key{act, t.gone, t.piece, kNone} : Key{act, t.piece, t.diagonal[0], t.diagonal[1]};
  }

  void undo(const Trial& t, Transaction& transaction) {
    switch (t.act) {
      case Act::diagonal: {
        std::vector<std::array<std::int32_t, 2>> all = s_.diagonals[t.piece];
        all.push_back(t.diagonal);
        s_.set_diagonals(t.piece, std::move(all));
        break;
      }
      case Act::split:
        transaction.part_again(t.piece, t.gone);
        ++pieces_of_[s_.mesh.component()[s_.labels.pieces[t.piece].face]];
        ++pieces_in_[t.region];
    }
  }

  [[nodiscard]] static std::vector<std::int32_t> pieces_in(const std::vector<Trial>& trials) {
    std::vector<std::int32_t> pieces;
    pieces.reserve(trials.size());
    for (const Trial& t : trials) pieces.push_back(t.piece);
    return pieces;
  }

  /// \param changed  by these trials
  void judge(const std::vector<Trial>& trials, std::vector<std::int32_t> changed) {
    for (const Trial& t : trials)
      if (t.gone != kNone) changed.push_back(t.gone);
    sort_unique(changed);
    findings_.judge(changed);
  }

  [[nodiscard]] static bool any_fresh(const std::vector<bool>& before, const std::vector<bool>& after) {
    for (std::size_t l = 0; l < after.size(); ++l)
      if (after[l] && !before[l]) return true;
    return false;
  }

  /// By piece: whether it is at most `rings` rings from a newly faulty piece and so counts as a possible cause. A
  /// neighbour of a large faulty piece counts only if it is at the place of a fault. Rings do not pass through large
  /// pieces, unless there are kMostRings.
  [[nodiscard]] std::vector<bool> near_fresh(int rings, const std::vector<bool>& before,
                                             const std::vector<bool>& after) const {
    std::vector<bool> near(after.size(), false);
    std::vector<std::int32_t> ring, next;
    const bool through = rings == kMostRings;
    const auto reach = [&](std::int32_t k) {
      if (near[k]) return;
      near[k] = true;
      next.push_back(k);
    };
    for (std::size_t l = 0; l < after.size(); ++l)
      if (after[l] && !before[l]) reach(static_cast<std::int32_t>(l));
    for (; rings > 0 && !next.empty(); --rings) {
      ring.swap(next);
      next.clear();
      for (const std::int32_t l : ring) {
        if (through || !s_.is_large(l)) {
          s_.for_each_neighbour(l, reach);
        } else if (after[l] && !before[l]) {
          for_each_at_fault(l, reach);
        }
      }
    }
    return near;
  }

  /// Calls fn(piece) for the pieces at the places of a piece's faults; for all neighbours if a fault has no place.
  template <class Function>
  void for_each_at_fault(std::int32_t l, Function fn) const {
    if ((findings_.faults(l) & ~kCrossing) != 0) return s_.for_each_neighbour(l, fn);
    const auto around = [&](std::int32_t c) {
      for (const std::int32_t q : s_.polygons.at(c)) fn(s_.polygons.piece(q));
    };
    for (std::int32_t i = 0; i < s_.polygons.count_of(l); ++i) {
      const auto loop = s_.polygons.of(s_.polygons.first_of(l) + i);
      for (const std::int32_t e : findings_.of(l).polygons[i].crossing)
        if (e >= 0)
          for (const std::size_t k : {e + std::size_t{0}, e + std::size_t{1}}) around(loop[k % loop.size()]);
    }
    for (const Hit& h : findings_.hits())
      if (!h.excused && (h.a == l || h.b == l)) std::for_each(h.corners.begin(), h.corners.end(), around);
  }

  State& s_;
  Findings& findings_;
  const Misses usual_;
  Scope scope_;
  Job& job_;
  std::vector<std::int32_t> pieces_of_;  // by component of the mesh
  std::vector<std::int32_t> pieces_in_;  // by region
  /// By piece that may be absorbed: its possible unions, tried or not; nullopt if they are to be computed again.
  std::vector<std::optional<std::vector<Candidate>>> unions_;
  std::set<Key> tried_;
  std::set<Key> suspected_;  // acts undone for a fault further away; each gets one more trial
};

}  // namespace

Misses mean_misses(const State& state) {
  Misses sum;
  double count = 0;
  for (std::size_t l = 0; l < state.labels.pieces.size(); ++l) {
    if (state.labels.pieces[l].face == kNone) continue;
    sum.error += error_of(state.planes[l]);
    sum.square += square_of(state.planes[l]);
    ++count;
  }
  return count > 0 ? Misses{sum.error / count, sum.square / count} : sum;
}

std::int32_t coarsen(State& state, Findings& findings, const Misses& usual, Scope scope, Job& job) {
  return Coarsener(state, findings, usual, std::move(scope), job).run();
}

}  // namespace isimp::meshing
