#include "repair/coarsen.h"

#include <algorithm>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "complex/joins.h"
#include "complex/planes.h"
#include "isimp/core/sorted.h"
#include "judge/trials.h"
#include "place/improve.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kChartsAThread = 256;  ///< work: charts in which one thread searches for candidates
// Deviation that a union of two regions may add, as shares of the mean deviation of a region. Source: own trials, 15
// scans, buildings and nasty meshes at 50 to 1,000 regions.
// tuned unions
constexpr double kError = 1, kSquare = 3;

// tuned holes
constexpr std::size_t kLongRow =
    128;  ///< limit: chords of two parts of a row of holes that stay apart if they have more

/// Whether a union may hold with its corners where they are, at other places only, or not at all.
enum class Forecast { possible, bent, hopeless };

/// A union that may turn out to need no split.
struct Candidate {
  double score;        ///< the higher, the sooner it is tried
  std::int32_t chart;  ///< the chart that keeps its number
  std::int32_t other;  ///< the chart that is absorbed
  int version = 0;     ///< that of the unions of `other`
  /// Whether another one is tried sooner.
  bool operator<(const Candidate& c) const {
    return std::tuple(score, c.other, c.chart) < std::tuple(c.score, other, chart);
  }
};

class Coarsener {
 public:
  Coarsener(State& state, Defects& defects, const Scale& usual, Job& job)
      : s_(state),
        defects_(defects),
        usual_(usual),
        job_(job),
        charts_of_(s_.mesh.component_count(), 0),
        charts_in_(s_.regions, 0) {
    for (const Chart& p : s_.labels.charts)
      if (p.face != kNone) {
        ++charts_of_[s_.mesh.component()[p.face]];
        ++charts_in_[p.region];
      }
  }

  void run() {
    try_all();
    improve_places(s_, defects_, job_);  // for the next pass, as other unions are possible then
    drop_corners();
  }

 private:
  /// Queues the candidates of all charts.
  void queue_all() {
    const std::int32_t count = s_.labels.chart_count();
    std::vector<std::vector<Candidate>> by_block(count / kChartsAThread + 1);
    version_.resize(count, 0);
    s_.threads.blocks(count, kChartsAThread, [&](std::int32_t block, std::int32_t begin, std::int32_t end) {
      job_.poll();
      for (std::int32_t l = begin; l < end; ++l) {
        add_unions(l, by_block[block]);
      }
    });
    std::vector<Candidate> all;
    for (const auto& some : by_block) all.insert(all.end(), some.begin(), some.end());
    queue_ = std::priority_queue<Candidate>({}, std::move(all));
  }

  /// Whether two parts of a row of holes are long enough each for itself.
  [[nodiscard]] bool parts_row(std::int32_t a, std::int32_t b) const {
    const auto is_cut = [&](std::int32_t l) { return s_.labels.charts[l].cause == Cause::hole; };
    return s_.cutter.perforated && is_cut(a) && is_cut(b) &&
           s_.complex.chords(a).size() + s_.complex.chords(b).size() > kLongRow;
  }

  [[nodiscard]] bool is_there(std::int32_t l) const { return s_.labels.charts[l].face != kNone; }

  [[nodiscard]] bool may_unite(std::int32_t kept, std::int32_t gone) const { return !tried_.contains({gone, kept}); }

  /// Whether a larger chart of another region, or of two of one size that of the first region, is near enough to the
  /// plane of both.
  [[nodiscard]] bool is_alike(std::int32_t kept, std::int32_t gone) const {
    const Plane &a = s_.planes[kept], &b = s_.planes[gone];
    if (b.area > a.area || (b.area == a.area && s_.labels.charts[kept].region > s_.labels.charts[gone].region))
      return false;
    const Plane both = united(a, b);
    return error_of(both) - error_of(a) - error_of(b) <= kError * usual_.error &&
           square_of(both) - square_of(a) - square_of(b) <= kSquare * usual_.square;
  }

  /// Whether the region of the absorbed chart keeps another chart, and the union belongs to the region of the kept one.
  [[nodiscard]] bool may_change_region(const Candidate& c) const {
    const std::int32_t from = s_.labels.charts[c.other].region, to = s_.labels.charts[c.chart].region;
    if (from == to) return true;
    if (charts_in_[from] < 2) return false;
    std::vector<std::int32_t> faces = s_.labels.faces_of(c.other);
    std::sort(faces.begin(), faces.end());
    if (!may_give(s_, c.other, c.chart, faces)) return false;
    const std::vector<std::int32_t> more = s_.labels.faces_of(c.chart);
    faces.insert(faces.end(), more.begin(), more.end());
    return s_.region_of(c.chart, faces) == to;
  }

  /// Adds the unions that would absorb a chart: the larger the share of its boundary along the other, the sooner.
  void add_unions(std::int32_t gone, std::vector<Candidate>& all) const {
    const Chart& p = s_.labels.charts[gone];
    if (p.face == kNone || p.cause == Cause::region || p.cause == Cause::closed || p.cause == Cause::handle) return;
    const SharedBoundary shared = s_.shared_boundary(gone);
    const double first = p.cause == Cause::repair ? 1 : 0;  // cuts for holes are hardly ever needless
    const auto add = [&](std::int32_t k, double score) {
      if (may_unite(k, gone)) all.push_back({score + first, k, gone, version_[gone]});
    };
    for (const auto& [k, length] : shared.with)
      if (!parts_wall(s_, k, gone) && !parts_row(k, gone)) add(k, shared.all > 0 ? length / shared.all : 0);
    if (p.cause == Cause::unconnected) return;
    for (const auto& [k, length] : shared.others)
      if (is_alike(k, gone)) add(k, length / shared.all - 1);
  }

  /// Drops the corners that `Complex::bend` added, one after another, wherever no polygon becomes defective.
  void drop_corners() {
    std::vector<std::int32_t> bent(s_.complex.bent().begin(), s_.complex.bent().end());
    sort_unique(bent);
    for (const std::int32_t v : bent) {
      job_.poll();
      if (s_.complex.is_corner(v)) attempt(s_, defects_, {}, kNone, [&] { return s_.drop_corner(v); });
    }
    defects_.renew_hits();
  }

  /// Tries all candidates, the most promising first. Candidates around a union are queued again.
  void try_all() {
    const Job::Stage stage(job_, "joining polygons", 0.0, 1.0);
    queue_all();
    const std::size_t all = queue_.size();
    for (std::size_t done = 0; !queue_.empty(); ++done) {
      job_.report(std::min(1.0, static_cast<double>(done) / static_cast<double>(all)));
      const Candidate c = queue_.top();
      queue_.pop();
      if (is_there(c.chart) && is_there(c.other) && c.version == version_[c.other] && may_unite(c.chart, c.other))
        unite(c);
    }
    defects_.renew_hits();
  }

  void unite(const Candidate& c) {
    tried_.insert({c.other, c.chart});
    std::int32_t& left = charts_of_[s_.mesh.component()[s_.labels.charts[c.other].face]];
    if (left <= kLeastClosed) return;
    const std::int32_t region = s_.labels.charts[c.other].region;
    const std::vector<std::int32_t> loop = s_.loop_together(c.chart, c.other);
    if (loop.empty()) return;
    const Forecast forecast = foresee(loop, c);
    if (forecast == Forecast::hopeless || !may_change_region(c)) return;
    const auto join = [&] {
      s_.unite(c.chart, c.other, loop);
      return true;
    };
    const bool in_place = forecast == Forecast::possible && attempt(s_, defects_, {c.other}, c.chart, join);
    if (!in_place && !attempt(s_, defects_, {c.other}, c.chart, join, Places::fresh)) return;
    --left;
    --charts_in_[region];
    std::vector<std::int32_t> around = s_.neighbours(c.chart);
    around.push_back(c.chart);
    std::vector<Candidate> more;
    for (const std::int32_t l : around) {
      ++version_[l];
      tried_.erase({l, c.chart});
      tried_.erase({c.chart, l});
      add_unions(l, more);
    }
    for (const Candidate& m : more) queue_.push(m);
  }

  /// Predicts the union of two charts with the given loop from its corners where they are. A union is hopeless
  /// if it crosses itself there and on the mesh.
  [[nodiscard]] Forecast foresee(std::span<const std::int32_t> loop, const Candidate& c) const {
    std::vector<std::int32_t> polygon;
    std::vector<Vec3> placed, home;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t v = s_.mesh.from(loop[i]), before = loop[i > 0 ? i - 1 : loop.size() - 1];
      const bool is_end = s_.labels.label[loop[i] / 3] != s_.labels.label[before / 3];
      if (!s_.complex.is_corner(v) || (is_end && s_.complex.boundary_edges(v) == 3)) continue;  // two are left
      polygon.push_back(static_cast<std::int32_t>(polygon.size()));
      home.push_back(s_.mesh.vertices()[v]);
      placed.push_back(s_.corners.position[s_.corners.of_vertex[v]]);
    }
    if (polygon.size() < 3) return Forecast::possible;
    const Vec3 normal = united(s_.planes[c.chart], s_.planes[c.other]).normal;
    const double most = defects_.bounds().bend;
    const Bounds bounds{.thickness = defects_.bounds().thickness};
    const PolygonDefects here = judge_polygon(polygon, placed, normal, bounds);
    if (here.kinds != 0 && judge_polygon(polygon, home, normal, bounds).kinds != 0) return Forecast::hopeless;
    return most <= 0 || here.bend <= most ? Forecast::possible : Forecast::bent;
  }

  State& s_;
  Defects& defects_;
  const Scale usual_;
  Job& job_;
  std::vector<std::int32_t> charts_of_;  // by component of the mesh
  std::vector<std::int32_t> charts_in_;  // by region
  std::vector<int> version_;             // by chart: how often its possible unions have changed
  std::priority_queue<Candidate> queue_;
  std::set<std::array<std::int32_t, 2>> tried_;  // the absorbed chart and the other one
};

}  // namespace

void coarsen(State& state, Defects& defects, const Scale& usual, Job& job) {
  Coarsener(state, defects, usual, job).run();
}

}  // namespace isimp::meshing
