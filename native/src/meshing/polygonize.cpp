#include "isimp/meshing/polygonize.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "check_input.h"
#include "complex/state.h"
#include "enclosing_boxes.h"
#include "isimp/core/errors.h"
#include "judge/judge.h"
#include "kept_part.h"
#include "repair/repair.h"

namespace isimp::meshing {
namespace {

constexpr double kOfPlanar = 0.6;  ///< work: progress of the planar attempt, if it may be discarded

void count_splits(const Labels& labels, const PolygonMesh& mesh, MeshingReport& report) {
  for (const Chart& p : labels.charts)
    if (p.face != kNone)
      if (std::int32_t* counter = counter_of(report, p.cause)) ++*counter;
  const std::vector<std::int32_t>& region = mesh.polygon_region;  // sorted; one chart may have several polygons
  for (std::size_t q = 0; q < region.size(); ++q) {
    const bool first = q == 0 || region[q] != region[q - 1];
    if (first) ++report.regions;
    if (first && q + 1 < region.size() && region[q] == region[q + 1]) ++report.regions_split;
  }
}

/// The polygons in the order of their regions, then of their charts.
/// \param place  by number: the place of each in that order
PolygonMesh assemble(const State& state, std::vector<std::int32_t>& place) {
  PolygonMesh out;
  const Polygons& polygons = state.polygons;
  const auto& position = state.corners.position;
  std::vector<std::int32_t> order, index(state.corners.count(), kNone);
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l)
    polygons.for_each_of(l, [&](std::int32_t q) { order.push_back(q); });
  const auto region = [&](std::int32_t q) { return state.labels.charts[polygons.chart(q)].region; };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return region(a) < region(b); });
  place.resize(polygons.numbers());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<std::int32_t>(i);
  double area = 0, bent = 0;
  for (const std::int32_t q : order) {
    out.loop_start.push_back(static_cast<std::int32_t>(out.loops.size()));
    out.polygon_region.push_back(region(q));
    for (const std::int32_t c : polygons.of(q)) {
      if (index[c] == kNone) {
        const std::int32_t v = state.corners.vertex[c];
        index[c] = static_cast<std::int32_t>(out.vertices.size());
        out.vertices.push_back(position[c] + state.mesh.origin());
        out.source_vertex.push_back(v);
        out.report.distance_max = std::max(out.report.distance_max, (position[c] - state.mesh.vertices()[v]).norm());
      }
      out.loops.push_back(index[c]);
    }
    out.planarity.push_back(bend_of(polygons.of(q), position));
    const double a = vector_area(polygons.of(q), position).norm();
    area += a;
    bent += a * out.planarity.back();
    out.report.planarity_max = std::max(out.report.planarity_max, out.planarity.back());
  }
  out.report.planarity_mean = area > 0 ? bent / area : 0.0;
  out.report.polygons = out.polygon_count();
  out.report.corners = static_cast<std::int32_t>(out.loops.size());
  out.report.vertices = static_cast<std::int32_t>(out.vertices.size());
  return out;
}

void report_repair(const RepairOutcome& outcome, std::span<const std::int32_t> place, MeshingReport& report) {
  report.crossing = outcome.crossing;
  report.flipped = outcome.flipped;
  report.bent = outcome.bent;
  report.intersecting = outcome.intersecting;
  report.excused = outcome.excused;
  report.without_area = outcome.without_area;
  report.joined_junctions = outcome.joined;
  report.repair_rounds = outcome.rounds;
  report.repair_capped = outcome.capped;
  report.work = outcome.work;
  report.planar = outcome.planar;
  report.concave = outcome.concave;
  report.cut_to_be_convex = outcome.cut_to_be_convex;
  report.rims = outcome.rims;
  report.planes_let_go = static_cast<std::int32_t>(outcome.let_go.size());
  report.excused_at_least = outcome.excused_at_least;
  std::vector<ListedDefect> list;  // with each pair under its first polygon
  list.reserve(outcome.defects.size());
  for (const auto& [polygon, kind, other] : outcome.defects) {
    list.push_back({place[polygon], kind, other == kNone ? kNone : place[other]});
    ListedDefect& i = list.back();
    if (i.other != kNone && i.other < i.polygon) std::swap(i.polygon, i.other);
  }
  std::sort(list.begin(), list.end());
  std::map<Defect, std::size_t> listed;
  for (const ListedDefect& i : list) {
    if (++listed[i.kind] > kMostListed) continue;
    report.imperfect.push_back(i);
    if (i.other != kNone) report.imperfect.push_back({i.other, i.kind, i.polygon});
  }
  std::sort(report.imperfect.begin(), report.imperfect.end());
}

PolygonMesh polygons_of(State& state, Job& job) {
  RepairOutcome outcome;
  {
    Job::Stage stage(job, "repairing", 0.1, 0.98);
    outcome = repair(state, job);
  }
  std::vector<std::int32_t> place;
  PolygonMesh result = assemble(state, place);
  report_repair(outcome, place, result.report);
  result.planes_let_go = std::move(outcome.let_go);
  result.report.merged_without_area = state.merged_without_area;
  count_splits(state.labels, result, result.report);
  judge_topology(result);
  return result;
}

}  // namespace
}  // namespace isimp::meshing

namespace isimp {

PolygonMesh polygonize(const Mesh& mesh, const Partition& partition, const MeshingOptions& options, Job& job) {
  using namespace meshing;
  check_input(mesh, partition, options);
  if (const std::optional<KeptPart> part = kept_part(mesh, partition, job)) {
    PolygonMesh result = polygonize(part->mesh, part->partition, options, job);
    to_whole(result, *part);
    add_enclosing_boxes(mesh, partition, result);
    return result;
  }
  const auto make = [&](const MeshingOptions& o, double from, double to) {
    Job::Stage stage(job, "meshing", from, to);
    State state(mesh, partition, o, job);
    return polygons_of(state, job);
  };
  const bool may_be_left_off = options.planar && options.planar_most < 1;
  PolygonMesh result = make(options, 0.0, may_be_left_off ? kOfPlanar : 1.0);
  const double whole = result.report.planar.whole;
  if (!may_be_left_off || 1 - whole <= options.planar_most) return result;
  MeshingOptions plain = options;
  plain.planar = false;
  result = make(plain, kOfPlanar, 1.0);
  result.report.planar.asked = result.report.planar.left_off = true;
  result.report.planar.whole = whole;
  return result;
}

}  // namespace isimp
