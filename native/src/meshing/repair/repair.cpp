#include "repair/repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "isimp/core/sorted.h"
#include "isimp/core/to_integer.h"
#include "judge/bounds.h"
#include "judge/defects.h"
#include "place/improve.h"
#include "place/keep_planes.h"
#include "place/rims.h"
#include "place/slide.h"
#include "planar/planar.h"
#include "repair/coarsen.h"
#include "repair/convex.h"
#include "repair/junctions.h"
#include "repair/list_defects.h"

namespace isimp::meshing {
namespace {

constexpr int kMendRounds = 40;  // limit
constexpr int kSteps = 14;       // limit: times that a chart is found defective and mended
// tuned plans
// A pull costs no polygon. How often a step leaves the chart, or both halves of it, without a defect in the next round
// (39,000 steps; scans, buildings, household things and nasty meshes at 30 to 1,000 regions): crossing .30 by a pull
// and .25 by a split, flipped .59 and .33, meeting .28 and .26, bent .23 by a split. Source: own trials.
constexpr int kPulls = 3;       ///< steps before the first split; after it every third one is a pull
constexpr int kAfterSplit = 8;  ///< step at which a chart continues after a split
// tuned unrecorded
constexpr double kPull = 0.5;       ///< share of a corner's distance from its vertex that a pull leaves
constexpr std::size_t kShard = 16;  ///< limit: faces of a chart that falls apart into them where nothing else helped
constexpr std::int32_t kLeastBudget = 100;  ///< limit: splits that are always allowed
constexpr double kOfOpening = 4;            ///< limit: polygons that a border or handle of the scan may take
constexpr int kJoinPasses = 4;              ///< passes that join split polygons

/// Changes defective charts and judges them again, within a budget of splits.
class Mender {
 public:
  /// \param outcome  rounds and `capped` are counted here
  Mender(State& state, Defects& defects, RepairOutcome& outcome, Job& job)
      : s_(state), defects_(defects), outcome_(outcome), job_(job) {
    const std::int32_t charts = s_.labels.chart_count();
    const double all = charts + kOfOpening * openings_of(s_.mesh);
    most_polygons_ = charts + to_integer(s_.options.repair_budget * all, kLeastBudget,
                                         std::numeric_limits<std::int32_t>::max() - charts);
  }

  /// Acts and looks again, until nothing is defective, nothing helps or the rounds are over.
  /// \param may_split  else corners move only
  void mend(bool may_split = true) {
    for (int round = 0; round < kMendRounds; ++round, ++outcome_.rounds) {
      job_.report(std::min(0.95, round / 20.0));
      if (!act(may_split)) break;
      bring_up_to_date();
    }
  }

  /// Calls `mend` after all charts are set to their first steps.
  void mend_anew() {
    std::fill(tries_.begin(), tries_.end(), 0);
    mend();
  }

  /// The last resort: remaining defective polygons are replaced by the scan's triangles, so that every remaining defect
  /// exists in the scan.
  /// \return whether any polygon was replaced
  bool fall_back() {
    bool ever = false;
    for (bool any = true; any; ++outcome_.rounds) {
      job_.poll();
      any = false;
      polygons_ = s_.polygons.count();
      const std::vector<bool> defective = defects_.defective();
      for (std::int32_t l = 0; l < static_cast<std::int32_t>(defective.size()); ++l)
        if (defective[l]) any = shatter(l) || any;
      if (any) bring_up_to_date();
      ever = ever || any;
    }
    return ever;
  }

  /// Splits some charts without regard to the budget.
  /// \param to_faces  small charts fall apart into their faces at once
  /// \return whether any was split
  bool break_up(std::span<const std::int32_t> charts, bool to_faces) {
    polygons_ = 0;
    bool any = false;
    for (const std::int32_t l : charts) any = (!to_faces && split(l)) || shatter(l) || any;
    bring_up_to_date();
    return any;
  }

  void judge_all() { judge(numbers_below(s_.labels.chart_count())); }

  /// Judges charts whose labels were changed, and mends them as if they were new.
  void judge_again(const std::vector<std::int32_t>& charts) {
    for (const std::int32_t l : charts) tries_[l] = 0;
    changed_ = charts;
    bring_up_to_date();
  }

 private:
  void bring_up_to_date() {
    std::vector<std::int32_t> changed = s_.update_in_place(std::exchange(changed_, {}));
    changed.insert(changed.end(), also_.begin(), also_.end());
    also_.clear();
    sort_unique(changed);
    judge(changed);
  }

  void judge(std::span<const std::int32_t> charts) {
    defects_.judge(charts);
    tries_.resize(s_.labels.charts.size(), 0);
  }

  /// One step for every defective chart.
  /// \return whether anything was done
  bool act(bool may_split) {
    const std::int32_t charts = s_.labels.chart_count();
    // If two charts meet, the smaller is not split, but in each third round.
    std::vector<bool> meets(charts, false), is_spared(charts, false);
    for (const Hit& h : defects_.hits()) {
      if (h.excused) continue;
      meets[h.a] = meets[h.b] = true;
      if (h.a != h.b && outcome_.rounds % 3 != 0)
        is_spared[s_.planes[h.a].area < s_.planes[h.b].area ? h.a : h.b] = true;
    }
    bool any = false;
    polygons_ = s_.polygons.count();
    for (std::int32_t l = 0; l < charts; ++l) {
      const std::uint8_t kinds = defects_.kinds(l);
      if ((kinds == 0 && !meets[l]) || tries_[l] >= kSteps) continue;
      const bool is_bent = kinds == kBent && !meets[l];  // a pull does not mend that
      const bool pulls = !is_bent && (tries_[l] < kPulls || tries_[l] % 3 == 2);
      if (!pulls && !may_split) continue;
      job_.poll();
      ++tries_[l];
      any = (pulls ? pull(l) : (is_spared[l] && kinds == 0) || split(l)) || any;
    }
    return any;
  }

  /// Moves the corners of a chart halfway back to their vertices.
  bool pull(std::int32_t l) {
    for (const std::int32_t c : s_.polygons.corners_of({&l, 1})) {
      const Vec3& home = s_.mesh.vertices()[s_.corners.vertex[c]];
      s_.move(c, home + kPull * (s_.corners.position[c] - home));
      s_.mark_stale(c);
      for (const std::int32_t q : s_.polygons.at(c)) also_.push_back(s_.polygons.chart(q));
    }
    return true;
  }

  [[nodiscard]] bool spent() const { return polygons_ >= most_polygons_; }

  bool split(std::int32_t l) {
    if (spent()) {
      outcome_.capped = true;
      return false;
    }
    if (!s_.split(l, job_)) return false;
    polygons_ += s_.labels.chart_count() - static_cast<std::int32_t>(tries_.size());
    tries_[l] = std::min(tries_[l], kAfterSplit);
    tries_.resize(s_.labels.charts.size(), tries_[l]);
    return true;
  }

  bool shatter(std::int32_t l) {
    const std::size_t faces = s_.labels.faces_of(l).size();
    if (faces > kShard || (faces > 1 && spent())) return split(l);
    polygons_ += static_cast<std::int32_t>(faces) - 1;
    changed_.push_back(l);
    const bool any = s_.shatter(l);
    tries_.resize(s_.labels.charts.size(), 0);
    return any;
  }

  State& s_;
  Defects& defects_;
  RepairOutcome& outcome_;
  Job& job_;
  std::int32_t most_polygons_ = 0, polygons_ = 0;  // polygons_: as they will be after the acts of this round
  std::vector<int> tries_;                         // by chart: steps against its defects
  std::vector<std::int32_t> also_;                 // charts to be judged in addition to the result of an update
  std::vector<std::int32_t> changed_;              // charts whose diagonals were changed in this round
};

/// Undoes the joins at charts that moves of corners do not mend, since a split would cost more polygons.
void take_back_joins(State& state, Defects& defects, Mender& mender, std::vector<Join>& joins) {
  if (joins.empty()) return;
  mender.mend(false);
  while (true) {
    if (!take_back(state, defects.defective(kCrossing | kFlipped | kNoArea), joins)) return;
    mender.judge_again(state.labels.touched);
  }
}

/// Joins split polygons and mends the result, in turn, while that leaves fewer. Each join may make others possible.
void join_again(State& state, Defects& defects, Mender& mender, const Scale& usual, Job& job) {
  for (int pass = 0; pass < kJoinPasses; ++pass) {
    const double from = 0.75 - 0.5 * std::pow(0.4, pass);  // most meshes need one pass
    const Job::Stage stage(job, "repairing", from, 0.75 - 0.2 * std::pow(0.4, pass));
    const std::int32_t before = state.polygons.count();
    coarsen(state, defects, usual, job);
    mender.mend_anew();
    if (state.polygons.count() >= before) return;
  }
}

/// Makes polygons planar. A chart whose polygon cannot become planar is split, after kSplits tries down to faces of
/// the scan, and the step is repeated. After kTries tries the polygon stays bent.
void make_planar(State& state, Defects& defects, Mender& mender, RepairOutcome& outcome, const Scale& usual, Job& job) {
  constexpr int kSplits = 6, kTries = 16;  // limit: steps until a chart falls apart; steps in all
  bool is_last = false;
  for (int go = 0;; ++go) {
    const planar::PlanarOutcome found = planar::make_planar(state, defects, is_last, job);
    if (found.stuck.empty()) {
      outcome.planar = found.report;
      outcome.let_go = found.let_go;
      return;
    }
    const bool any = mender.break_up(found.stuck, go >= kSplits);
    is_last = !any || go + 1 == kTries;
    mender.judge_all();
    mender.mend_anew();
    mender.fall_back();
    if (go >= kSplits) continue;  // charts that fell apart stay so: the steps come to an end
    coarsen(state, defects, usual, job);
    mender.fall_back();
    straighten_rims(state, defects, job);
  }
}

}  // namespace

RepairOutcome repair(State& state, Job& job) {
  RepairOutcome outcome;
  Defects defects(state, bounds_of(state), job);
  if (state.options.planar) defects.judge_planar();
  Mender mender(state, defects, outcome, job);
  Scale usual;  // scale of the regions before the repair
  {
    const Job::Stage stage(job, "repairing", 0.0, 0.25);
    state.update({});
    usual = state.scale();
    std::vector<Join> joins = join_junctions(state, job);
    mender.judge_all();
    state.take_stale();
    take_back_joins(state, defects, mender, joins);
    outcome.joined = static_cast<std::int32_t>(joins.size());
    mender.mend();
  }
  join_again(state, defects, mender, usual, job);
  const Job::Stage stage(job, "repairing", 0.75, 1.0);
  if (mender.fall_back()) {
    coarsen(state, defects, usual, job);
    mender.fall_back();
  }
  slide_corners(state, defects, job);
  if (state.options.planar) settle_places(state, defects, job);  // corners slide off the planes that are solved next
  straighten_rims(state, defects, job);
  outcome.let_go = keep_to_planes(state, defects, job);
  if (state.options.planar) make_planar(state, defects, mender, outcome, usual, job);
  if (state.options.convex) outcome.cut_to_be_convex = make_convex(state, defects, job);
  outcome.planar.planar = planar::is_planar(state);
  outcome.concave = count_concave(state);
  outcome.rims = rims_of(state);
  list_defects(state, defects, outcome, job);
  return outcome;
}

}  // namespace isimp::meshing
