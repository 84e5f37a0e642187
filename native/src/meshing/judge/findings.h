#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "complex/state.h"
#include "judge/judge.h"

namespace isimp::meshing {

/// What the judge found of the polygons of each piece, kept up to date while they change.
class Findings {
 public:
  Findings(const State& state, const Bounds& bounds, const Job& job) : s_(state), bounds_(bounds), job_(job) {}

  /// All that the judge looks at in a piece.
  struct Source {
    std::vector<std::int32_t> loops;  ///< corners of its polygons, kNone after each
    std::vector<Vec3> places;         ///< of these corners
    Vec3 normal = Vec3::Zero();
    bool is_face = false;  ///< one of the scan
    bool operator==(const Source&) const = default;
  };
  /// What was found of a piece's polygons.
  struct Found {
    Source source;
    std::vector<PolygonVerdict> polygons;
    FacetSet facets;
  };

  /// Judges the polygons of some pieces, and which they meet, again. Those that are what they were are left alone.
  /// Cost: O(changed polygons * log(all) + pieces).
  void judge(std::span<const std::int32_t> pieces);
  /// From now on polygons are to be planar. Of a piece of several each has to face as the piece or as its own part of
  /// the scan does (outline.h), as those that are cut off along its boundary may be steep; and triangles that are
  /// slivers are avoided, as any triangulation will do.
  void judge_planar() { apart_ = bounds_.no_slivers = true; }
  /// Keeps what is found now, so that it need not be found again of pieces that a trial changes and its undoing makes
  /// what they were. In place of what was kept before.
  void keep();
  /// Judges the polygons round a corner that has been moved. If none has a fault that it had not, and none meets another
  /// that is not excused, these findings replace those before, and `renew_hits` must follow the last of such moves.
  /// \param pieces  those that the corner is of, each once
  /// \return whether it is so
  /// Cost: that of judging these pieces, of whose facets those are looked up that are others than before.
  bool accepts(std::span<const std::int32_t> pieces, std::int32_t corner);
  /// Finds what the pieces of accepted moves meet. The findings are kept then.
  void renew_hits();
  [[nodiscard]] const Found& of(std::int32_t piece) const { return found_[piece]; }
  /// What is found of one of a piece's polygons with its corners where they are now.
  [[nodiscard]] PolygonVerdict verdict(std::int32_t piece, std::int32_t part) const;
  /// Whether polygons of two pieces meet with their corners where they are now.
  [[nodiscard]] bool meet_now(std::int32_t a, std::int32_t b) const;
  /// Whether the regions of two polygons that meet do so in the scan itself, without the patches that cover its openings.
  /// The repair spares those that meet in patches too: no polygon of a region that meets another can be put right.
  /// Cost: O(F) where the mesh has patches.
  [[nodiscard]] bool meet_in_scan(const Hit& h) const;
  /// All faults of a piece's polygons together.
  [[nodiscard]] std::uint8_t faults(std::int32_t piece) const { return faults_[piece]; }
  /// Pairs of polygons that meet, in rising order; but for those of two faces of the scan at their places.
  [[nodiscard]] const std::vector<Hit>& hits() const { return hits_; }
  /// Those of two faces of the scan at their places.
  [[nodiscard]] GivenHits given_hits(std::size_t most, std::int64_t most_counted) const;
  /// By piece: whether it has one of some faults of its own, or meets another and is not excused.
  [[nodiscard]] std::vector<bool> faulty(std::uint8_t which = 0xff) const;
  [[nodiscard]] const Bounds& bounds() const { return bounds_; }
  /// How many polygons were judged, each as often as it was.
  [[nodiscard]] std::int64_t judged() const { return judged_; }

 private:
  [[nodiscard]] Source source_of(std::int32_t piece) const;
  /// Whether that of a piece is this one still.
  [[nodiscard]] bool is_source(const Source& s, std::int32_t piece) const;
  /// What a piece that is judged again was before.
  enum class Was : std::uint8_t { same, kept, other };
  void set(std::int32_t piece, Found found);
  /// The facets of a piece that are not where or what they were before a corner was moved.
  [[nodiscard]] FacetSet moved_facets(std::int32_t piece, const Found& fresh, std::int32_t corner) const;
  /// Whether one of some moved facets of piece `i` of the given ones meets another that is not excused.
  [[nodiscard]] bool meets_any(std::size_t i, std::span<const std::int32_t> pieces, std::span<const Found> fresh,
                               const FacetSet& moved) const;
  /// Replaces the hits of changed pieces. Pairs of two `same` pieces are those that were kept.
  void find_hits_of(const std::vector<bool>& changed, const std::vector<bool>& same);
  [[nodiscard]] std::array<std::int32_t, 2> regions_of(const Hit& h) const;
  /// Tells which of some hits are of regions that meet in the scan; what was found of a pair of regions is kept.
  void find_excuses(std::span<Hit> hits);
  [[nodiscard]] Found find(std::int32_t piece, Source source) const;
  /// The areas beyond the chords of a piece of several polygons that are to be planar; of others none.
  [[nodiscard]] std::vector<Vec3> areas_beyond(std::int32_t piece) const;
  /// \param beyond  what that says
  PolygonVerdict judge_one(std::int32_t piece, std::int32_t part, std::span<const Vec3> beyond,
                           std::vector<Facet>* facets) const;
  /// Whether a piece is a face of the scan that has no area.
  [[nodiscard]] bool is_given(std::int32_t piece) const;
  void sort_faces_by_region();

  const State& s_;
  Bounds bounds_;
  const Job& job_;
  bool apart_ = false;
  std::vector<std::int32_t> accepted_;  // pieces, of moves since the last `renew_hits`
  std::vector<Found> found_;            // by piece
  std::int64_t judged_ = 0;
  std::vector<std::uint8_t> faults_;                       // by piece
  Arounds around_;                                         // by piece: its facets' box
  std::vector<Hit> hits_;                                  // in rising order
  std::vector<std::unique_ptr<Found>> kept_;               // of the pieces that are no more what they were at `keep`
  std::vector<Hit> kept_hits_;                             // all of then
  std::map<std::array<std::int32_t, 2>, bool> excuses_;    // by pair of regions
  std::vector<std::int32_t> region_start_, region_faces_;  // faces by region, made when first asked for
  std::vector<std::unique_ptr<ScanPart>> scan_parts_;      // by region, each made when first asked for
};

}  // namespace isimp::meshing
