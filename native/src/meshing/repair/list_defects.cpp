#include "repair/list_defects.h"

#include <algorithm>
#include <vector>

#include "judge/scan_meetings.h"

namespace isimp::meshing {

void list_defects(const State& state, const Defects& defects, RepairOutcome& outcome, const Job& job) {
  auto& list = outcome.defects;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l)
    for (std::size_t i = 0; i < defects.of(l).polygons.size(); ++i) {
      const std::int32_t q = state.polygons.first_of(l) + static_cast<std::int32_t>(i);
      const std::uint8_t kinds = defects.of(l).polygons[i].kinds;
      outcome.crossing += (kinds & (kCrossing | kNoArea)) != 0;
      outcome.flipped += (kinds & kFlipped) != 0;
      outcome.bent += (kinds & kBent) != 0;
      if (kinds & kCrossing) list.push_back({q, Defect::crossing, kNone});
      if (kinds & kNoArea) list.push_back({q, Defect::no_area, kNone});
      if (kinds & kFlipped) list.push_back({q, Defect::flipped, kNone});
      if (kinds & kBent) list.push_back({q, Defect::bent, kNone});
      outcome.without_area += (kinds & kGiven) != 0;
      if (kinds & kGiven) list.push_back({q, Defect::excused, kNone});
    }
  const auto add = [&](const Hit& h, Defect kind) {
    list.push_back({state.polygons.first_of(h.a) + h.part_a, kind, state.polygons.first_of(h.b) + h.part_b});
  };
  // Regions that meet in patches alone are no excuse: a user of the polygons sees the scan.
  const auto source = state.mesh.source_face();
  const bool patched = std::find(source.begin(), source.end(), kNone) != source.end();
  std::vector<ScanMeetings::Pair> pairs;
  for (const Hit& h : defects.hits())
    if (h.excused && patched) pairs.push_back(defects.regions_of(h));
  ScanMeetings in_scan(state.mesh, state.partition.face_region, state.regions, false);
  in_scan.test(pairs, state.threads, job);
  for (const Hit& h : defects.hits()) {
    const bool excused = h.excused && (!patched || in_scan.meet(defects.regions_of(h)));
    ++(excused ? outcome.excused : outcome.intersecting);
    add(h, excused ? Defect::excused : Defect::intersecting);
  }
  const GivenHits given = defects.given_hits(kMostListed, kMostCounted);
  for (const Hit& h : given.first) add(h, Defect::excused);
  outcome.excused += given.count;
  outcome.excused_at_least = !given.is_all;
  outcome.work = {state.labels.walked.load(), state.placed, defects.judged()};
  const RepairOutcome& o = outcome;
  outcome.capped = o.capped && o.crossing + o.flipped + o.bent + o.intersecting > 0;
}

}  // namespace isimp::meshing
