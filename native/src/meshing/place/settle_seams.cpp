#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "complex/flat_fit.h"
#include "complex/polygons.h"
#include "isimp/core/errors.h"
#include "isimp/core/options.h"
#include "isimp/core/sorted.h"
#include "isimp/core/threads.h"
#include "isimp/meshing/part.h"
#include "judge/bounds.h"
#include "judge/judge.h"
#include "judge/together.h"

namespace isimp {
namespace {

using namespace meshing;

constexpr double kNoDirection = 1e-12;  ///< of the area: with a shorter vector area a piece has no direction
constexpr std::int32_t kFitted = 192;   ///< polygons that one thread fits at a time,
constexpr std::int32_t kMoved = 384;    ///< and vertices that it moves
/// Steps from the place by the planes back to where a vertex was, and on to its place in the scan.
constexpr std::uint8_t kBack = 3, kHome = 5;

/// \param across  vector area of the polygon, for a piece without a direction
Plane plane_of(const Vec3& vector_area, const SurfaceMoments& m, const Vec3& origin, const Vec3& across) {
  Plane p;
  p.area = m.area;
  p.centre = m.centre - origin;
  p.projected = vector_area.norm();
  const bool has_direction = m.area > 0 && p.projected > kNoDirection * m.area;
  if (has_direction || across.norm() > 0) p.normal = (has_direction ? vector_area : across).normalized();
  if (!has_direction) return p;
  for (int i = 0, k = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j, ++k) p.spread(i, j) = p.spread(j, i) = m.second[k] / m.area;
  return p;
}

/// Moves the vertices of polygons round seams, and takes back what does not become them.
class Settler {
 public:
  Settler(const PolygonMesh& mesh, std::span<const std::int32_t> part, const SeamPlaces& places,
          const MeshingOptions& options, const Job& job)
      : mesh_(mesh),
        part_(part),
        options_(options),
        job_(job),
        threads_(options.threads),
        bounds_(bounds_of(options, places.regions, 0, places.diagonal)),
        reach_(options.reach * places.diagonal),
        position_(near_zero(mesh, mesh.vertices)),
        seen_(position_),
        home_(near_zero(mesh, places.home)) {
    planes_.reserve(places.moments.size());
    for (std::size_t q = 0; q < places.moments.size(); ++q)
      planes_.push_back(plane_of(places.vector_area[q], places.moments[q], mesh.vertices.front(),
                                 vector_area(loop_of(mesh, static_cast<std::int32_t>(q)), position_)));
    gather();
  }

  void run() {
    if (moving_.empty()) return;
    judge_all();
    aim();
    level_.assign(moving_.size(), 0);
    std::vector<std::int32_t> moved(moving_.size());
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = static_cast<std::int32_t>(i);
    while (!moved.empty()) {
      for (const std::int32_t i : moved) position_[moving_[i]] = place(i);
      judge(moved);
      moved = step_back();
    }
  }

  /// The polygons that are at fault and were not so before, but for those that cross themselves.
  [[nodiscard]] std::vector<Imperfection> flaws() const {
    std::vector<Imperfection> list;
    for (const std::int32_t q : concerned_)
      for (const auto& [fault, flaw] :
           {std::pair{kFlipped, Flaw::flipped}, {kNoArea, Flaw::no_area}, {kBent, Flaw::bent}})
        if ((faults_[q] & ~before_[q] & fault) != 0) list.push_back({q, flaw});
    return list;
  }

  /// Largest distance of a vertex from its place in the scan.
  [[nodiscard]] double distance() const {
    double most = 0;
    for (std::size_t v = 0; v < position_.size(); ++v) most = std::max(most, (position_[v] - home_[v]).norm());
    return most;
  }

  /// The vertices where they are now; those that have not moved are the same bits.
  [[nodiscard]] std::vector<Vec3> vertices() const {
    std::vector<Vec3> result = mesh_.vertices;
    for (const std::int32_t v : moving_)
      if (position_[v] != seen_[v]) result[v] = position_[v] + mesh_.vertices.front();
    return result;
  }

 private:
  [[nodiscard]] std::span<const std::int32_t> around(std::int32_t v) const {
    return std::span(around_).subspan(around_start_[v], around_start_[v + 1] - around_start_[v]);
  }

  /// Which polygons are round each vertex, which vertices move and which polygons change with them.
  void gather() {
    const auto vertices = static_cast<std::int32_t>(mesh_.vertices.size());
    around_start_.assign(vertices + 1, 0);
    for (const std::int32_t v : mesh_.loops) ++around_start_[v + 1];
    for (std::int32_t v = 0; v < vertices; ++v) around_start_[v + 1] += around_start_[v];
    around_.resize(mesh_.loops.size());
    std::vector<std::int32_t> next(around_start_.begin(), around_start_.end() - 1);
    for (std::int32_t q = 0; q < mesh_.polygon_count(); ++q)
      for (const std::int32_t v : loop_of(mesh_, q)) around_[next[v]++] = q;
    std::vector<bool> seam(vertices), moves(vertices);
    for (std::int32_t v = 0; v < vertices; ++v) {
      const auto round = around(v);
      seam[v] = std::any_of(round.begin(), round.end(), [&](std::int32_t q) { return part_[q] != part_[round[0]]; });
    }
    for (std::int32_t q = 0; q < mesh_.polygon_count(); ++q) {
      const auto loop = loop_of(mesh_, q);
      if (std::any_of(loop.begin(), loop.end(), [&](std::int32_t v) { return seam[v]; }))
        for (const std::int32_t v : loop) moves[v] = true;
    }
    index_.assign(vertices, kNone);
    for (std::int32_t v = 0; v < vertices; ++v) {
      if (!moves[v]) continue;
      index_[v] = static_cast<std::int32_t>(moving_.size());
      moving_.push_back(v);
      const auto round = around(v);
      concerned_.insert(concerned_.end(), round.begin(), round.end());
    }
    sort_unique(concerned_);
    fit_.assign(mesh_.loop_start.size(), kNone);
    for (std::size_t i = 0; i < concerned_.size(); ++i) fit_[concerned_[i]] = static_cast<std::int32_t>(i);
  }

  void judge_all() {
    sets_.resize(mesh_.loop_start.size());
    faults_.resize(sets_.size());
    crossing_.resize(sets_.size());
    for (const FacetSet& set : sets_) by_polygon_.push_back(&set);
    const std::vector<bool> all(sets_.size(), true);
    for (std::int32_t q = 0; q < mesh_.polygon_count(); ++q) judge_one(q);
    arounds_.settle();
    hits_ = find_hits(by_polygon_, arounds_, position_, all, std::vector<bool>(sets_.size(), false), threads_, job_);
    before_ = faults_;
    // What a part knows of its own polygons is in its report.
    for (const Hit& hit : hits_)
      if (part_[hit.a] == part_[hit.b]) known_.push_back({hit.a, hit.b});
    sort_unique(known_);
  }

  void judge_one(std::int32_t q) {
    job_.poll();
    sets_[q].clear();
    const PolygonVerdict verdict =
        judge_polygon(loop_of(mesh_, q), position_, planes_[q].normal, bounds_, Facet{{}, q, 0}, &sets_[q].facets);
    faults_[q] = verdict.faults;
    crossing_[q] = verdict.crossing;
    sets_[q].locate(position_);
    arounds_.set(q, sets_[q]);
  }

  /// Makes the polygons flat by turns, as `flatten` does.
  void aim() {
    const auto vertices = static_cast<std::int32_t>(moving_.size()),
               polygons = static_cast<std::int32_t>(concerned_.size());
    const std::vector<double> radius = radii();
    std::vector<Fit> fits(concerned_.size());
    for (int turn = 0; turn < options_.flatten; ++turn) {
      job_.poll();
      threads_.blocks(polygons, kFitted, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
        for (std::int32_t k = begin; k < end; ++k)
          fits[k].to(loop_of(mesh_, concerned_[k]), position_, planes_[concerned_[k]]);
      });
      threads_.blocks(vertices, kMoved, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
        for (std::int32_t i = begin; i < end; ++i) {
          const std::int32_t v = moving_[i];
          const auto round = around(v);
          Vec3 step = Vec3::Zero();
          for (const std::int32_t q : round) {
            const Fit& fit = fits[fit_[q]];
            step -= fit.normal * fit.normal.dot(position_[v] - fit.centre);
          }
          position_[v] =
              within(position_[v] + step * (kRelax / static_cast<double>(round.size())), home_[v], radius[v]);
        }
      });
    }
    target_.reserve(moving_.size());
    for (const std::int32_t v : moving_) target_.push_back(position_[v]);
  }

  /// By vertex, how far it may be from the scan.
  [[nodiscard]] std::vector<double> radii() const {
    std::vector<double> radius(home_.size(), reach_);
    for (const std::int32_t q : concerned_) {
      const auto loop = loop_of(mesh_, q);
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const std::int32_t v = loop[k], w = loop[(k + 1) % loop.size()];
        const double most = kOfEdge * (home_[v] - home_[w]).norm();
        radius[v] = std::min(radius[v], most);
        radius[w] = std::min(radius[w], most);
      }
    }
    return radius;
  }

  /// Of a vertex that does not move, the last.
  [[nodiscard]] std::uint8_t level_of(std::int32_t v) const { return index_[v] == kNone ? kHome : level_[index_[v]]; }

  /// Where a moving vertex is at its level.
  [[nodiscard]] Vec3 place(std::int32_t i) const {
    const Vec3 &seen = seen_[moving_[i]], &home = home_[moving_[i]];
    switch (level_[i]) {
      case 0:
        return target_[i];
      case 1:
        return (target_[i] + seen) / 2;
      case 2:
        return target_[i] / 4 + 3 * seen / 4;
      case kBack:
        return seen;
      case 4:
        return (seen + home) / 2;
      default:
        return home;
    }
  }

  /// Judges the polygons round vertices that have moved.
  void judge(std::span<const std::int32_t> moved) {
    std::vector<bool> changed(sets_.size(), false);
    std::vector<std::int32_t> polygons;
    for (const std::int32_t i : moved)
      for (const std::int32_t q : around(moving_[i])) polygons.push_back(q);
    sort_unique(polygons);
    for (const std::int32_t q : polygons) {
      judge_one(q);
      changed[q] = true;
    }
    arounds_.settle();
    std::erase_if(hits_, [&](const Hit& hit) { return changed[hit.a] || changed[hit.b]; });
    const std::vector<Hit> fresh =
        find_hits(by_polygon_, arounds_, position_, changed, std::vector<bool>(sets_.size(), false), threads_, job_);
    hits_.insert(hits_.end(), fresh.begin(), fresh.end());
  }

  /// Takes the vertices of polygons at fault a step back.
  /// \return those that could be, by their places in `moving_`
  std::vector<std::int32_t> step_back() {
    std::vector<std::pair<std::int32_t, std::uint8_t>> wanted;  // vertex, and the last level that it may get
    for (const std::int32_t q : concerned_) {
      const auto loop = loop_of(mesh_, q);
      const auto fresh = static_cast<std::uint8_t>(faults_[q] & ~before_[q]);
      if (fresh == 0) continue;
      // Where it was not at fault with all vertices where they were, others that go towards the scan made it so.
      const bool is_beyond = std::any_of(loop.begin(), loop.end(),
                                         [&](std::int32_t v) { return index_[v] != kNone && level_of(v) > kBack; });
      const std::uint8_t last = is_beyond ? kHome : kBack;
      const std::size_t known = wanted.size();
      if (fresh == kCrossing)
        for (const std::int32_t e : crossing_[q])
          for (const std::size_t k : {static_cast<std::size_t>(e), static_cast<std::size_t>(e) + 1})
            if (const std::int32_t v = loop[k % loop.size()]; level_of(v) < last) wanted.emplace_back(v, last);
      if (wanted.size() == known)
        for (const std::int32_t v : loop) wanted.emplace_back(v, last);
    }
    for (const Hit& hit : hits_) {
      const bool is_one = part_[hit.a] == part_[hit.b];
      if (is_one && std::binary_search(known_.begin(), known_.end(), std::array{hit.a, hit.b})) continue;
      for (const std::int32_t v : hit.corners) wanted.emplace_back(v, kHome);
    }
    std::vector<std::int32_t> moved;
    for (const auto& [v, last] : wanted)
      if (level_of(v) < last) moved.push_back(index_[v]);
    sort_unique(moved);
    for (const std::int32_t i : moved) ++level_[i];
    return moved;
  }

  const PolygonMesh& mesh_;
  std::span<const std::int32_t> part_;
  const MeshingOptions& options_;
  const Job& job_;
  const Threads threads_;
  const Bounds bounds_;
  const double reach_;
  std::vector<Vec3> position_, seen_, home_;  // by vertex: now, before, in the scan
  std::vector<Plane> planes_;                 // by polygon
  std::vector<std::int32_t> around_, around_start_;
  std::vector<std::int32_t> moving_, index_;           // vertices; by vertex its place there
  std::vector<std::int32_t> concerned_, fit_;          // polygons with moving vertices; by polygon its place there
  std::vector<Vec3> target_;                           // by place in moving_
  std::vector<std::uint8_t> level_;                    // by place in moving_
  std::vector<std::uint8_t> faults_, before_;          // by polygon
  std::vector<std::array<std::int32_t, 2>> crossing_;  // by polygon: two edges that cross
  std::vector<FacetSet> sets_;                         // by polygon
  std::vector<const FacetSet*> by_polygon_;
  Arounds arounds_;
  std::vector<Hit> hits_;
  std::vector<std::array<std::int32_t, 2>> known_;  // pairs of one part that met before
};

void check_places(const PolygonMesh& mesh, const SeamPlaces& places) {
  const std::size_t polygons = mesh.loop_start.size();
  if (places.home.size() != mesh.vertices.size() || places.vector_area.size() != polygons ||
      places.moments.size() != polygons)
    throw InvalidInput("there must be one place for each vertex, and one vector area and moments for each polygon");
}

}  // namespace

PolygonMesh settle_seams(PolygonMesh mesh, std::span<const std::int32_t> part, const SeamPlaces& places,
                         const MeshingOptions& options, const Job& job) {
  check_fields(options);
  check_parts(mesh, part);
  check_places(mesh, places);
  if (mesh.vertices.empty()) return judge_together(std::move(mesh), part, job);
  Settler settler(mesh, part, places, options, job);
  settler.run();
  const std::vector<Imperfection> flaws = settler.flaws();
  const double distance = settler.distance();
  mesh.vertices = settler.vertices();
  PolygonMesh result = judge_together(std::move(mesh), part, job);
  result.report.distance_max = distance;
  for (const Imperfection& each : flaws)
    ++(each.flaw == Flaw::bent      ? result.report.bent
       : each.flaw == Flaw::flipped ? result.report.flipped
                                    : result.report.crossing);
  result.report.imperfect.insert(result.report.imperfect.end(), flaws.begin(), flaws.end());
  std::sort(result.report.imperfect.begin(), result.report.imperfect.end());
  return result;
}

}  // namespace isimp
