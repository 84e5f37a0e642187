// The judge of polygons: defects of one polygon, of pairs and of the topology.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "discs/labels.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/meshing/polygonize.h"
#include "judge/boxes.h"

namespace isimp::meshing {

/// The defects of a polygon on its own.
enum DefectKinds : std::uint8_t { kCrossing = 1, kFlipped = 2, kNoArea = 4, kBent = 8 };
/// mark: replaces kNoArea if the polygon is a face of the scan that has no area itself, which is no defect.
constexpr std::uint8_t kGiven = 16;

/// A triangle of a polygon's triangulation, by corners.
struct Facet {
  std::array<std::int32_t, 3> corner;
  std::int32_t chart;
  std::int32_t part;  ///< which of the chart's polygons
};

/// The defects of a polygon. All tests are exact on coordinates rounded to float32, as they will be stored.
struct PolygonDefects {
  std::uint8_t kinds = 0;
  double bend = 0;                               ///< largest distance of a corner from the plane
  std::array<std::int32_t, 2> crossing{-1, -1};  ///< two edges that meet, by the index of their first corner
};

// tuned unrecorded
/// The cosine between a polygon and its chart up to which it counts as flipped.
constexpr double kFacingChart = 0.2;
/// Polygons that planar ones were cut into are flipped up to this cosine. They may be steep where the bent one was.
constexpr double kFacingApart = 0.02;

struct Bounds {
  double bend = 0;       ///< scene units; no bound if not above 0
  double thickness = 0;  ///< scene units; a polygon thinner than this has no area
  /// Polygons are planar, so any triangulation will do: triangles that are about as thin are avoided, as the long side
  /// of one would run through a corner that lies on it.
  bool no_slivers = false;
  double facing = kFacingChart;  ///< the cosine up to which a polygon counts as flipped
};

struct FlatPolygon;  // in judge_polygon.cpp
/// A simple polygon seen along its normal, null for others.
using FlatView = std::shared_ptr<const FlatPolygon>;

/// \param normal  that of the chart: a polygon that faces away from it is flipped
/// \param view  is set, for `triangulate`; null if it is not needed
PolygonDefects judge_polygon(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Vec3& normal,
                             const Bounds& bounds, FlatView* view = nullptr);

/// Triangulates a polygon that `judge_polygon` found to be simple.
/// \param view  the result of `judge_polygon` for the same polygon, positions and bounds
/// \param facets  the triangles are added here, marked as `like`
void triangulate(const FlatPolygon& view, std::span<const std::int32_t> polygon, std::span<const Vec3> position,
                 const Bounds& bounds, const Facet& like, std::vector<Facet>& facets);

/// The plane through a triangle, for a quick test whether points lie to one side of it.
struct Facing {
  Vec3 normal;   ///< its length is twice the area
  double slack;  ///< times the largest coordinate distance of a point: bound of the rounding error of its side
};

/// The facets of a chart's polygons with boxes for searches.
struct FacetSet {
  std::vector<Facet> facets;
  std::vector<std::array<Vec3, 3>> solids;  ///< positions of the corners of each, rounded to float32
  std::vector<Facing> facings;              ///< plane of each
  std::vector<Box> boxes;                   ///< box of each
  std::vector<std::int32_t> solid;          ///< the facets that have area: the others meet nothing
  Box around = Box::nowhere();              ///< the box of all solid facets
  bool given = false;                       ///< one face of the scan, its corners at their vertices

  void clear() { facets.clear(); }
  /// Derives all other members but `given` from the facets. To be called again when a corner has moved.
  void locate(std::span<const Vec3> position);
};

/// The boxes of all charts. `given` charts have boxes of their own, as pairs of two given charts are not searched for.
struct Arounds {
  MovingBoxes free, given;
  void set(std::int32_t chart, const FacetSet& facets);
  /// To be called after charts were set, before a search.
  void settle();
};

/// Two polygons that meet elsewhere than in shared corners and edges.
struct Hit {
  std::int32_t a, part_a, b, part_b;    ///< two charts, a <= b, and the polygon of each
  std::array<std::int32_t, 6> corners;  ///< corners of the two facets that meet there
  bool excused = false;                 ///< whether their regions meet in the scan itself
  [[nodiscard]] std::array<std::int32_t, 4> key() const { return {a, b, part_a, part_b}; }
};

/// All pairs of polygons that intersect and of which one at least is of a `changed` chart, in rising order. Pairs of
/// two `given` charts are left out.
/// \param charts  their facets, by chart
/// \param arounds  by chart, their boxes
/// \param known  by chart: pairs of two such are left out
/// Cost: O(c log(charts) + pairs of boxes) for c changed charts.
std::vector<Hit> find_hits(std::span<const FacetSet* const> charts, const Arounds& arounds,
                           const std::vector<bool>& changed, const std::vector<bool>& known, const Threads& threads,
                           const Job& job);

/// Whether a polygon of a chart meets one of another; of the same chart, where both are one set.
bool facets_meet(const FacetSet& a, const FacetSet& b);

/// Pairs of faces of the scan, at their places, that meet.
struct GivenHits {
  std::vector<Hit> first;  ///< some of them, in rising order of the first, then of the second
  std::int64_t count = 0;  ///< pairs that were counted
  bool is_all = true;      ///< whether these are all pairs
};

/// The pairs of `given` charts that meet.
/// \param most  pairs that are listed
/// \param most_counted  pairs after which the search ends
GivenHits find_given_hits(std::span<const FacetSet* const> charts, const Arounds& arounds, std::size_t most,
                          std::int64_t most_counted, const Job& job);

/// Some faces of the scan in a search tree.
/// Cost: O(n log n) to make.
struct ScanPart {
  ScanPart() = default;
  ScanPart(const Mesh& mesh, std::span<const std::int32_t> faces);
  BoxTree tree;  ///< the boxes of the faces that have area
};

/// Whether one of some faces of the scan meets one of some others elsewhere than in the vertices they share. Vertices
/// at one place that were not welded, or were parted where the scan is not manifold, are not shared. Exact on
/// coordinates rounded as above.
bool scan_intersects(const Mesh& mesh, const ScanPart& some, const ScanPart& others);

/// Sets the members of the report that depend on edges and fans: closed, manifold, euler.
void judge_topology(PolygonMesh& mesh);

}  // namespace isimp::meshing
