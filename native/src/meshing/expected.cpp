#include "isimp/meshing/expected.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "check_input.h"
#include "complex/state.h"
#include "isimp/core/sorted.h"
#include "judge/bounds.h"
#include "judge/defects.h"
#include "kept_part.h"

namespace isimp::meshing {
namespace {

// tuned expected
// Further polygons by cause. Source: least squares of the relative error over 21 scans at 30 to 1,000 regions.
constexpr double kOfSplit = 0.4;      ///< for each polygon that the topology needs, except walls, which are flat
constexpr double kOfBent = 1.4;       ///< times the root of the bend beyond the bound, in bounds
constexpr double kOfCrossing = 0.35;  ///< for a polygon that crosses itself
constexpr double kOfMeeting = 1.1;    ///< for a chart that meets others

/// Whether a wall continues in another region, so that both walls will be one polygon.
bool goes_on(const State& state, std::int32_t wall) {
  constexpr double kSameWay = 0.9;  // cosine of the angle
  bool found = false;
  state.for_each_neighbour(wall, [&](std::int32_t l) {
    const Chart &a = state.labels.charts[wall], &b = state.labels.charts[l];
    found = found || (a.region != b.region && b.cause == Cause::wall &&
                      state.planes[wall].normal.dot(state.planes[l].normal) > kSameWay);
  });
  return found;
}

/// The number of further polygons that the defects of a chart will need.
double cost_of(const Defects& defects, std::int32_t chart) {
  double cost = (defects.kinds(chart) & kCrossing) != 0 ? kOfCrossing : 0;
  const double bound = defects.bounds().bend;
  for (const PolygonDefects& v : defects.of(chart).polygons)
    if (bound > 0 && v.bend > bound) cost += kOfBent * std::sqrt(v.bend / bound - 1);
  return cost;
}

}  // namespace
}  // namespace isimp::meshing

namespace isimp {

ExpectedPolygons expected_polygons(const Mesh& mesh, const Partition& partition, const MeshingOptions& options,
                                   Job& job) {
  using namespace meshing;
  check_input(mesh, partition, options);
  if (const auto part = kept_part(mesh, partition, job))
    return expected_polygons(part->mesh, part->partition, options, job);
  const Job::Stage whole(job, "counting polygons", 0.0, 1.0);
  State state(mesh, partition, options, job);
  state.update({});
  Defects defects(state, bounds_of(state), job);
  defects.judge(numbers_below(state.labels.chart_count()));

  ExpectedPolygons e;
  std::set<std::int32_t> regions, meeting;
  std::int32_t charts = 0, splits = 0, walls = 0, halves = 0;
  double more = 0;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    const Chart& chart = state.labels.charts[l];
    if (chart.face == kNone) continue;
    ++charts;
    regions.insert(chart.region);
    if (std::int32_t* counter = counter_of(e, chart.cause)) {
      ++*counter;
      ++splits;
      walls += chart.cause == Cause::wall;
      halves += chart.cause == Cause::wall && goes_on(state, l);
    }
    more += cost_of(defects, l);
  }
  for (const Hit& h : defects.hits())
    if (!h.excused) meeting.insert(std::max(h.a, h.b));
  more += kOfMeeting * static_cast<double>(meeting.size());
  // A scan that is cut to discs nowhere and has no other defect keeps one polygon a chart.
  if (more > 0) more += kOfSplit * (splits - walls);
  e.regions = static_cast<std::int32_t>(regions.size());
  e.split_for_repair = static_cast<std::int32_t>(std::lround(more)) + (charts - e.regions - splits);
  e.split_for_holes -= halves / 2;
  e.polygons = e.regions + splits - halves / 2 + e.split_for_repair;
  return e;
}

}  // namespace isimp
