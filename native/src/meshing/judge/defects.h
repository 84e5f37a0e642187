#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "complex/state.h"
#include "judge/judge.h"
#include "judge/scan_meetings.h"

namespace isimp::meshing {

/// The defects of the polygons of each chart, kept up to date while polygons change.
class Defects {
 public:
  Defects(const State& state, const Bounds& bounds, const Job& job)
      : s_(state), bounds_(bounds), job_(job), excuses_(state.mesh, state.partition.face_region, state.regions, true) {}

  /// The input of the judge for one chart.
  struct Source {
    std::vector<std::int32_t> loops;  ///< corners of its polygons, kNone after each
    std::vector<Vec3> places;         ///< positions of these corners
    Vec3 normal = Vec3::Zero();
    bool is_face = false;  ///< the chart is one face of the scan
    bool operator==(const Source&) const = default;
  };
  /// The judged polygons of a chart.
  struct Found {
    Source source;
    std::vector<PolygonDefects> polygons;
    FacetSet facets;
  };

  /// Judges the polygons of some charts again, and their intersections. Charts with unchanged input are skipped.
  /// Cost: O(changed polygons * log(all) + charts).
  void judge(std::span<const std::int32_t> charts);
  /// From now on polygons have to be planar. If a chart has several, each has to face in the direction of the chart or
  /// of its own part of the scan (outline.h), as polygons cut off along the boundary may be steep. Triangulations avoid
  /// slivers, as every triangulation of a planar polygon is valid.
  void judge_planar() { apart_ = bounds_.no_slivers = true; }
  /// Saves the present defects, so that the charts of a rolled-back trial need not be judged again. Replaces the
  /// defects saved before.
  void keep();
  /// Judges changed polygons. The change is accepted if no chart has a new defect and no changed facet has an unexcused
  /// intersection. The new defects then replace the old ones, and `renew_hits` must follow the last accepted change.
  /// \param charts  all charts that may have changed, each once
  /// \param whole  a chart that must have no defect at all, kNone for none
  /// \return whether the change is accepted
  /// Cost: that of judging the changed charts; intersections are searched for changed facets only.
  bool accepts(std::span<const std::int32_t> charts, std::int32_t whole = kNone);
  /// Finds the intersections of the charts of accepted changes, then calls `keep`.
  void renew_hits();
  [[nodiscard]] const Found& of(std::int32_t chart) const { return found_[chart]; }
  /// The defects of one of a chart's polygons with its corners at their present places.
  [[nodiscard]] PolygonDefects defects_now(std::int32_t chart, std::int32_t part) const;
  /// Whether polygons of two charts meet with their corners at their present places.
  [[nodiscard]] bool meet_now(std::int32_t a, std::int32_t b) const;
  /// The regions of two polygons that meet, in rising order.
  [[nodiscard]] ScanMeetings::Pair regions_of(const Hit& h) const;
  /// The kinds of defects of a chart's polygons.
  [[nodiscard]] std::uint8_t kinds(std::int32_t chart) const { return kinds_[chart]; }
  /// Pairs of polygons that meet, in rising order, except pairs of two faces of the scan at their places.
  [[nodiscard]] const std::vector<Hit>& hits() const { return hits_; }
  /// Pairs of two faces of the scan at their places that meet.
  [[nodiscard]] GivenHits given_hits(std::size_t most, std::int64_t most_counted) const;
  /// By chart: whether it has a defect of some kinds, or meets another and is not excused.
  [[nodiscard]] std::vector<bool> defective(std::uint8_t which = 0xff) const;
  [[nodiscard]] const Bounds& bounds() const { return bounds_; }
  /// The number of judgements of polygons, repeated ones included.
  [[nodiscard]] std::int64_t judged() const { return judged_; }

 private:
  [[nodiscard]] Source source_of(std::int32_t chart) const;
  /// Whether the chart's input is unchanged.
  [[nodiscard]] bool is_source(const Source& s, std::int32_t chart) const;
  /// The input of a chart that is judged again: same as last time, same as at `keep`, or new.
  enum class Was : std::uint8_t { same, kept, other };
  void set(std::int32_t chart, Found found);
  /// The facets of a chart that it did not have, at these places, when it was judged last.
  [[nodiscard]] FacetSet changed_facets(std::int32_t chart, const Found& fresh) const;
  /// Whether one of the changed facets of chart `i` of the given ones meets another that is not excused.
  [[nodiscard]] bool meets_any(std::size_t i, std::span<const std::int32_t> charts, std::span<const Found> fresh,
                               const FacetSet& changed);
  /// Replaces the hits of changed charts. Pairs of two `same` charts are taken from the kept hits.
  void find_hits_of(const std::vector<bool>& changed, const std::vector<bool>& same);
  /// Marks the hits whose regions meet in the scan. The result for each pair of regions is cached.
  void find_excuses(std::span<Hit> hits);
  /// The polygons of a chart before they are triangulated.
  struct Looked {
    std::vector<PolygonDefects> polygons;
    std::vector<FlatView> views;
  };
  /// Judges the polygons of a chart, up to the first that has another defect than the allowed ones.
  [[nodiscard]] Looked look(std::int32_t chart, std::uint8_t allowed) const;
  [[nodiscard]] Found find(std::int32_t chart, Source source) const {
    return find(chart, std::move(source), look(chart, 0xff));
  }
  /// The same from the result of `look`.
  [[nodiscard]] Found find(std::int32_t chart, Source source, Looked looked) const;
  /// The areas beyond the chords of a chart of several polygons that are to be planar; of others none.
  [[nodiscard]] std::vector<Vec3> areas_beyond(std::int32_t chart) const;
  /// \param beyond  the result of `areas_beyond`
  PolygonDefects judge_one(std::int32_t chart, std::int32_t part, std::span<const Vec3> beyond, FlatView* view) const;
  /// Whether a chart is a face of the scan that has no area.
  [[nodiscard]] bool is_given(std::int32_t chart) const;

  const State& s_;
  Bounds bounds_;
  const Job& job_;
  bool apart_ = false;
  std::vector<std::int32_t> accepted_;  // charts, of changes since the last `renew_hits`
  std::vector<Found> found_;            // by chart
  std::int64_t judged_ = 0;
  std::vector<std::uint8_t> kinds_;           // by chart
  Arounds around_;                            // by chart: its facets' box
  std::vector<Hit> hits_;                     // in rising order
  std::vector<std::unique_ptr<Found>> kept_;  // defects of charts that have changed since `keep`
  std::vector<Hit> kept_hits_;                // all hits at `keep`
  ScanMeetings excuses_;                      // with patches: the repair can't part regions that meet there
};

}  // namespace isimp::meshing
