#include "repair/flaws.h"

#include <algorithm>
#include <vector>

#include "judge/scan_meetings.h"

namespace isimp::meshing {

void list_flaws(const State& state, const Findings& findings, RepairOutcome& outcome, const Job& job) {
  auto& list = outcome.imperfect;
  for (std::int32_t l = 0; l < state.labels.piece_count(); ++l)
    for (std::size_t i = 0; i < findings.of(l).polygons.size(); ++i) {
      const std::int32_t q = state.polygons.first_of(l) + static_cast<std::int32_t>(i);
      const std::uint8_t faults = findings.of(l).polygons[i].faults;
      outcome.crossing += (faults & (kCrossing | kNoArea)) != 0;
      outcome.flipped += (faults & kFlipped) != 0;
      outcome.bent += (faults & kBent) != 0;
      if (faults & kCrossing) list.push_back({q, Flaw::crossing, kNone});
      if (faults & kNoArea) list.push_back({q, Flaw::no_area, kNone});
      if (faults & kFlipped) list.push_back({q, Flaw::flipped, kNone});
      if (faults & kBent) list.push_back({q, Flaw::bent, kNone});
      outcome.without_area += (faults & kGiven) != 0;
      if (faults & kGiven) list.push_back({q, Flaw::excused, kNone});
    }
  const auto add = [&](const Hit& h, Flaw flaw) {
    list.push_back({state.polygons.first_of(h.a) + h.part_a, flaw, state.polygons.first_of(h.b) + h.part_b});
  };
  // Regions that meet in patches alone are no excuse: a user of the polygons sees the scan.
  const auto source = state.mesh.source_face();
  const bool patched = std::find(source.begin(), source.end(), kNone) != source.end();
  std::vector<ScanMeetings::Pair> pairs;
  for (const Hit& h : findings.hits())
    if (h.excused && patched) pairs.push_back(findings.regions_of(h));
  ScanMeetings in_scan(state.mesh, state.partition.face_region, state.regions, false);
  in_scan.test(pairs, state.threads, job);
  for (const Hit& h : findings.hits()) {
    const bool excused = h.excused && (!patched || in_scan.meet(findings.regions_of(h)));
    ++(excused ? outcome.excused : outcome.intersecting);
    add(h, excused ? Flaw::excused : Flaw::intersecting);
  }
  const GivenHits given = findings.given_hits(kMostListed, kMostCounted);
  for (const Hit& h : given.first) add(h, Flaw::excused);
  outcome.excused += given.count;
  outcome.excused_at_least = !given.is_all;
  outcome.work = {state.labels.walked.load(), state.placed, findings.judged()};
  const RepairOutcome& o = outcome;
  outcome.capped = o.capped && o.crossing + o.flipped + o.bent + o.intersecting > 0;
}

}  // namespace isimp::meshing
