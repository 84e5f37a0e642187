#include "repair/repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "complex/diagonal.h"
#include "complex/transaction.h"
#include "isimp/core/sorted.h"
#include "isimp/core/to_integer.h"
#include "judge/bounds.h"
#include "judge/defects.h"
#include "place/improve.h"
#include "place/keep_planes.h"
#include "place/rims.h"
#include "place/slide.h"
#include "place/symmetry.h"
#include "planar/planar.h"
#include "repair/coarsen.h"
#include "repair/junctions.h"
#include "repair/list_defects.h"
#include "repair/plans.h"

namespace isimp::meshing {
namespace {

constexpr int kRounds = 40;
constexpr double kPull = 0.5;       ///< share of a corner's distance from its vertex that a pull leaves
constexpr double kLeastPull = 0.1;  ///< share of its radius below which a pull returns the corner to its vertex
constexpr std::size_t kShard = 16;  ///< faces of a chart that falls apart into them where nothing else helped
constexpr std::size_t kMostForDiagonal = 64;  ///< corners of a polygon beyond which it is split at once
constexpr std::int32_t kLeastBudget = 100;    ///< splits that are always allowed
constexpr double kOfOpening = 4;              ///< polygons that a border or handle of the scan may take
constexpr int kPasses = 4;                    ///< passes that join split polygons
constexpr double kManyMore = 1.05;            ///< times the regions: fewer polygons are not joined in further passes
constexpr double kWorthwhile = 0.97;          ///< a pass that leaves more of the polygons is the last

class Repairer {
 public:
  Repairer(State& state, Job& job) : s_(state), job_(job), defects_(state, bounds_of(state), job) {
    const std::int32_t charts = s_.labels.chart_count();
    const double all = charts + kOfOpening * openings_of(s_.mesh);
    most_polygons_ = charts + to_integer(s_.options.repair_budget * all, kLeastBudget,
                                         std::numeric_limits<std::int32_t>::max() - charts);
    if (s_.options.planar) defects_.judge_planar();
  }

  RepairOutcome run() {
    {
      const Job::Stage stage(job_, "repairing", 0.0, 0.25);
      s_.update({});
      usual_ = s_.scale();
      std::vector<Join> joins = join_junctions(s_, job_);
      judge(all_charts());
      s_.take_stale();
      take_back_joins(joins);
      outcome_.joined = static_cast<std::int32_t>(joins.size());
      mend();
    }
    join_again();
    improve_places(s_, defects_, job_);
    const Job::Stage stage(job_, "repairing", 0.75, 1.0);
    if (fall_back()) {
      coarsen(s_, defects_, usual_, job_);
      fall_back();
    }
    slide_corners(s_, defects_, job_);
    straighten_rims(s_, defects_, job_);
    outcome_.let_go = keep_to_planes(s_, defects_, job_);
    mirror_corners(s_, defects_, job_);
    if (s_.options.planar) {
      make_planar();
    } else {
      outcome_.planar.planar = planar::is_planar(s_);
    }
    outcome_.mirrored = mirrored_corners(s_);
    outcome_.rims = rims_of(s_);
    list_defects(s_, defects_, outcome_, job_);
    return outcome_;
  }

 private:
  /// Undoes the joins at charts that moves of corners do not mend, since a split would cost more polygons.
  void take_back_joins(std::vector<Join>& joins) {
    if (joins.empty()) return;
    may_split_ = false;
    mend();
    may_split_ = true;
    while (true) {
      std::vector<bool> defective = defects_.defective(kCrossing | kFlipped | kNoArea);
      const std::vector<std::int32_t> image = chart_images(s_);  // a join and its image are undone together
      for (std::size_t l = 0; l < image.size(); ++l)
        if (image[l] != kNone && defective[l]) defective[image[l]] = true;
      if (!take_back(s_, defective, joins)) return;
      for (const std::int32_t l : s_.labels.touched) tries_[l] = 0;
      changed_ = s_.labels.touched;
      bring_up_to_date();
    }
  }

  /// Joins split polygons and mends the result, in turn, while there are many more polygons than regions. Each join may
  /// make others possible.
  void join_again() {
    for (int pass = 0; pass < kPasses; ++pass) {
      const double from = 0.75 - 0.5 * std::pow(0.4, pass);  // most meshes need one pass
      const Job::Stage stage(job_, "repairing", from, 0.75 - 0.2 * std::pow(0.4, pass));
      const std::int32_t before = s_.polygons.count();
      coarsen(s_, defects_, usual_, job_);
      std::fill(tries_.begin(), tries_.end(), 0);
      mend();
      const std::int32_t now = s_.polygons.count();
      // Mending may have made more of them than joining took back; that is joined again.
      if (now < kManyMore * s_.regions || (now > kWorthwhile * before && now <= before)) return;
    }
  }

  /// Acts and looks again, until nothing is defective, nothing helps or the rounds are over.
  void mend() {
    for (int round = 0; round < kRounds; ++round, ++outcome_.rounds) {
      job_.report(std::min(0.95, round / 20.0));
      if (!act()) break;
      bring_up_to_date();
    }
  }

  void bring_up_to_date() {
    std::vector<std::int32_t> changed = s_.update_in_place(std::exchange(changed_, {}));
    changed.insert(changed.end(), also_.begin(), also_.end());
    also_.clear();
    sort_unique(changed);
    judge(changed);
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
      find_met();
      const std::vector<bool> defective = defects_.defective();
      for (std::int32_t l = 0; l < static_cast<std::int32_t>(defective.size()); ++l)
        if (defective[l]) any = shatter(l) || any;
      if (any) bring_up_to_date();
      ever = ever || any;
    }
    return ever;
  }

  /// Makes polygons planar. A chart whose polygon cannot become planar is split, after kSplits tries down to faces of
  /// the scan, and the step is repeated. After kTries tries the polygon stays bent.
  void make_planar() {
    constexpr int kSplits = 6, kTries = 16;
    planar::Memory memory;
    bool is_last = false;
    for (int go = 0;; ++go) {
      Transaction transaction(s_);
      defects_.keep();
      const planar::PlanarOutcome outcome = planar::make_planar(s_, defects_, memory, is_last, job_);
      outcome_.planar = outcome.report;
      outcome_.let_go = outcome.let_go;
      if (outcome.stuck.empty() || is_last) return transaction.commit();
      transaction.rollback();
      polygons_ = 0;  // these splits are not counted
      find_met();
      bool any = false;
      for (const std::int32_t l : outcome.stuck) any = (go < kSplits ? split(l) || shatter(l) : shatter(l)) || any;
      is_last = !any || go + 1 == kTries;
      bring_up_to_date();
      judge(all_charts());
      std::fill(tries_.begin(), tries_.end(), 0);
      mend();
      fall_back();
    }
  }

  /// Finds the charts that meet in the present hits. To be called after each judgement, which replaces the hits.
  void find_met() {
    met_.assign(s_.labels.charts.size(), false);
    for (const Hit& h : defects_.hits())
      if (!h.excused) met_[h.a] = met_[h.b] = true;
  }

  [[nodiscard]] std::vector<std::int32_t> all_charts() const { return numbers_below(s_.labels.chart_count()); }

  bool shatter(std::int32_t l) {
    const std::size_t faces = s_.labels.faces_of(l).size();
    if (faces > kShard || (faces > 1 && spent())) return split(l);
    polygons_ += static_cast<std::int32_t>(faces) - 1;
    changed_.push_back(l);
    const bool any = s_.shatter(l);
    tries_.resize(s_.labels.charts.size(), 0);
    return any;
  }

  void judge(std::span<const std::int32_t> charts) {
    defects_.judge(charts);
    tries_.resize(s_.labels.charts.size(), 0);
  }

  /// One step of its plan for every defective chart.
  /// \return whether anything was done
  bool act() {
    find_met();
    // If two charts meet, the smaller is not split, but in each third round.
    const std::int32_t charts = s_.labels.chart_count();
    std::vector<bool> is_spared(charts, false);
    if (outcome_.rounds % 3 != 0)
      for (const Hit& h : defects_.hits())
        if (!h.excused && h.a != h.b) is_spared[s_.planes[h.a].area < s_.planes[h.b].area ? h.a : h.b] = true;
    bool any = false;
    polygons_ = s_.polygons.count();
    for (std::int32_t l = 0; l < charts; ++l) {
      const Action action = next_action(l);
      if (action == Action::none) continue;
      job_.poll();
      ++tries_[l];
      any = take(action, l, is_spared[l] && defects_.kinds(l) == 0) || any;
    }
    return any;
  }

  /// The next action in the plan for a chart; none if the chart has no defect or the plan is used up.
  [[nodiscard]] Action next_action(std::int32_t l) const {
    const std::uint8_t kinds = defects_.kinds(l);
    if (kinds == 0 && !met_[l]) return Action::none;
    const Plan plan = plan_for(l, kinds);
    if (tries_[l] >= static_cast<int>(plan.size())) return Action::none;
    const Action action = plan[tries_[l]];
    return may_split_ || action == Action::pull ? action : Action::none;
  }

  [[nodiscard]] Plan plan_for(std::int32_t l, std::uint8_t kinds) const {
    if (kinds & kCrossing) return plans::kForCrossing;
    if (kinds & (kFlipped | kNoArea)) return plans::kForFlipped;
    return met_[l] ? Plan(plans::kForMeeting) : Plan(plans::kForBent);
  }

  /// Where an action can't be taken, the chart is split, or waits if it is spared.
  bool take(Action action, std::int32_t l, bool is_spared) {
    if (action == Action::pull) return pull(l);
    return (action == Action::add_corner && bend(l)) || (action == Action::add_diagonal && add_diagonal(l)) ||
           is_spared || split(l);
  }

  /// Moves the corners of a chart halfway back to their vertices.
  bool pull(std::int32_t l) {
    for (const std::int32_t c : s_.polygons.corners_of({&l, 1})) {
      const Vec3& home = s_.mesh.vertices()[s_.corners.vertex[c]];
      const Vec3 way = kPull * (s_.corners.position[c] - home);
      s_.move(c, way.norm() < kLeastPull * s_.corners.radius[c] ? home : Vec3(home + way));
      s_.mark_stale(c);
      for (const std::int32_t q : s_.polygons.at(c)) also_.push_back(s_.polygons.chart(q));
    }
    return true;
  }

  /// Adds a corner on the one of two chords that cross that its boundary leaves further.
  bool bend(std::int32_t l) {
    std::int32_t worse = kNone;
    double most = 0;
    for (std::size_t i = 0; i < defects_.of(l).polygons.size(); ++i) {
      const auto& crossing = defects_.of(l).polygons[i].crossing;
      const auto polygon = s_.polygons.of(s_.polygons.first_of(l) + static_cast<std::int32_t>(i));
      for (const std::int32_t e : crossing) {
        const std::int32_t chord = e < 0 ? kNone : chord_of(l, polygon[e], polygon[(e + 1) % polygon.size()]);
        const double depth = chord == kNone ? -1 : s_.complex.depth(chord);
        if (depth < most) continue;
        most = depth;
        worse = chord;
      }
    }
    return worse != kNone && s_.bend(worse);
  }

  /// The chord of a chart from one corner to another, kNone where that edge is a diagonal.
  [[nodiscard]] std::int32_t chord_of(std::int32_t l, std::int32_t from, std::int32_t to) const {
    const std::int32_t a = s_.corners.vertex[from], b = s_.corners.vertex[to];
    const auto chords = s_.complex.chords(l);
    for (std::size_t k = 0; k < chords.size(); ++k)
      if (s_.mesh.from(chords[k]) == a && s_.mesh.from(chords[(k + 1) % chords.size()]) == b) return chords[k];
    return kNone;
  }

  /// Splits the worst of the chart's polygons by a new edge between two of its corners.
  bool add_diagonal(std::int32_t l) {
    std::int32_t worst = kNone;
    double most = -1;
    for (std::size_t i = 0; i < defects_.of(l).polygons.size(); ++i) {
      const PolygonDefects& v = defects_.of(l).polygons[i];
      const double badness = v.bend + (v.kinds & ~kBent ? s_.mesh.diagonal() : 0.0);
      if (badness <= most) continue;
      most = badness;
      worst = s_.polygons.first_of(l) + static_cast<std::int32_t>(i);
    }
    if (s_.polygons.of(worst).size() > kMostForDiagonal) return false;
    const std::array<std::int32_t, 2> d = best_diagonal(s_, worst, s_.planes[l].normal);
    if (d[0] == kNone || spent()) return false;
    std::vector<std::array<std::int32_t, 2>> all = s_.diagonals[l];
    all.push_back(d);
    s_.set_diagonals(l, std::move(all));
    ++polygons_;
    changed_.push_back(l);
    ++outcome_.diagonals;
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

  State& s_;
  Job& job_;
  RepairOutcome outcome_;
  std::int32_t most_polygons_ = 0, polygons_ = 0;  // polygons_: as they will be after the acts of this round
  Defects defects_;
  std::vector<int> tries_;             // by chart
  std::vector<bool> met_;              // by chart: whether it meets another
  std::vector<std::int32_t> also_;     // charts to be judged in addition to the result of an update
  bool may_split_ = true;              // else acts only move corners
  std::vector<std::int32_t> changed_;  // charts whose diagonals were changed in this round
  Scale usual_;                        // scale of the regions before the repair
};

}  // namespace

RepairOutcome repair(State& state, Job& job) { return Repairer(state, job).run(); }

}  // namespace isimp::meshing
