#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "discs/logged.h"
#include "discs/marks.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/mesh.h"

namespace isimp::meshing {

/// rounding: smallest share of the diagonal that float32 resolves. A thinner polygon counts as one without area.
constexpr double kThickness = 1e-6;

/// work: faces between the current one and the one whose corners or neighbours are prefetched.
constexpr std::int32_t kAhead = 12;

/// The reason for a chart.
enum class Cause : std::uint8_t { region, unconnected, pinch, hole, wall, handle, closed, repair };  ///< wall: of holes

/// The counter of a report that a chart of this cause adds to; null for the first chart of a region.
template <class Report>
std::int32_t* counter_of(Report& report, Cause cause) {
  switch (cause) {
    case Cause::unconnected:
      return &report.split_for_unconnected;
    case Cause::pinch:
      return &report.split_for_pinches;
    case Cause::hole:
    case Cause::wall:
      return &report.split_for_holes;
    case Cause::handle:
      return &report.split_for_handles;
    case Cause::closed:
      return &report.split_for_closed;
    case Cause::repair:
      return &report.split_for_repair;
    case Cause::region:
      break;
  }
  return nullptr;
}

/// A connected set of faces that is to become one polygon.
struct Chart {
  std::int32_t face = kNone;    ///< one of its faces
  std::int32_t region = kNone;  ///< the region of the partition it is a part of
  Cause cause = Cause::region;  ///< why it was parted from the rest of its region
};

/// How far a chart is from being a disc.
struct Shape {
  std::vector<std::vector<std::int32_t>> loops;  ///< boundary half-edges in order, the chart on their left
  std::int32_t components = 1;
  std::int32_t genus = 0;
  std::int32_t pinches = 0;           ///< visits of a boundary vertex beyond its first
  std::int32_t pinch_vertex = kNone;  ///< one that is visited more than once
  [[nodiscard]] bool is_disc() const;
  /// Which loop is taken for the outer one: the first of the longest.
  [[nodiscard]] std::int32_t longest_loop(const Mesh& mesh) const;
};

/// The mesh's faces under labels; label l is a connected chart. Every step of meshing up to the corners is a change of
/// labels, so the result of all steps is homeomorphic to the mesh.
struct Labels {
  explicit Labels(const Mesh& m);

  const Mesh& mesh;
  Logged<std::int32_t> label;                 ///< (F) kNone where a part was left out
  Logged<Chart> charts;                       ///< by label
  std::span<const std::int32_t> face_region;  ///< (F) the partition's
  std::vector<std::uint8_t> outlying;         ///< (F) see outlying_faces(); empty without `planar`
  std::vector<std::int32_t> touched;  ///< charts that were cut, or gained or lost faces, since `State` last updated
  mutable Marks face_marks, vertex_marks, halfedge_marks;  // scratch space of callers
  mutable std::atomic<std::int64_t> walked{0};             ///< number of faces visited by floods

  /// Whether h has the same chart on both sides.
  [[nodiscard]] bool inner(std::int32_t h) const {
    const std::int32_t o = mesh.opposite(h);
    return o != kNone && label[o / 3] == label[h / 3];
  }
  /// The label across h, kNone on the border.
  [[nodiscard]] std::int32_t across(std::int32_t h) const {
    const std::int32_t o = mesh.opposite(h);
    return o == kNone ? kNone : label[o / 3];
  }
  /// Whether h stands for its boundary edge: of the two sides one does, always the same.
  [[nodiscard]] bool owns(std::int32_t h) const { return across(h) < label[h / 3]; }
  /// The boundary half-edge after boundary half-edge h, turning inside the chart, so that a vertex where the chart
  /// touches itself is passed as two.
  [[nodiscard]] std::int32_t next_on_boundary(std::int32_t h) const {
    std::int32_t g = Mesh::next(h);
    while (inner(g)) g = Mesh::next(mesh.opposite(g));
    return g;
  }
  /// Whether a chart is a single face.
  [[nodiscard]] bool is_face(std::int32_t chart) const {
    const std::int32_t f = charts[chart].face;
    return f != kNone && !inner(3 * f) && !inner(3 * f + 1) && !inner(3 * f + 2);
  }
  /// The boundary loop of half-edge h, from there on.
  [[nodiscard]] std::vector<std::int32_t> loop_from(std::int32_t h) const;
  [[nodiscard]] std::int32_t chart_count() const { return static_cast<std::int32_t>(charts.size()); }

  /// The faces of a chart, by flooding from one of them. Clears and uses face_marks.
  [[nodiscard]] std::vector<std::int32_t> faces_of(std::int32_t chart) const;
  /// The same where no mark of face_marks is on the chart, so that threads may do several at a time.
  [[nodiscard]] std::vector<std::int32_t> flood(std::int32_t chart) const;
  /// Sets a new label for `faces`. They (except a strip along a handle) and the rest are connected and not empty.
  /// \param stays  a face that keeps its label
  std::int32_t part(std::span<const std::int32_t> faces, std::int32_t stays, Cause cause);
  /// Topology of a chart from its faces; connectivity is checked only if `check_components`.
  [[nodiscard]] Shape shape(std::span<const std::int32_t> faces, bool check_components = false) const;
};

/// Labels the faces: one label for each connected chart of a region.
/// \param face_region  (F) in [-1, R)
/// \return the boundary half-edges
/// Cost: about O(F).
Bits label_charts(Labels& labels, std::span<const std::int32_t> face_region, const Threads& threads, const Job& job);

/// Whether a chart without some of its faces still has one of its region: without one it would count as another's.
/// \param faces  in ascending order
/// Cost: O(log faces) mostly, at most the faces of the chart.
bool keeps_own(const Labels& labels, std::int32_t chart, std::span<const std::int32_t> faces);

/// Removes charts without a face. The remaining labels move down.
/// Cost: O(F).
void drop_gone(Labels& labels);

/// The boundary half-edges of all charts.
/// Cost: O(F).
Bits boundary_of(const Labels& labels);

/// Merges charts without any area, or thinner than `thickness` (scene units), into the neighbour with the longest
/// boundary, since no polygon can stand for them; a part of the mesh that has no other charts keeps them. The remaining
/// labels move down.
/// \param boundary  half-edges that are no boundary any more are removed
/// \return the number of merged charts
/// Cost: O(F).
std::int32_t merge_charts_without_area(Labels& labels, double thickness, Bits& boundary);

/// The boundary half-edges by chart: halfedges[start[l]] ... halfedges[start[l + 1] - 1] for chart l, one loop after
/// the other in order, the first one from the lowest half-edge.
struct Outlines {
  std::vector<std::int32_t> halfedges, start;
  std::vector<std::int32_t> loops;  ///< how many of each chart
  [[nodiscard]] std::span<const std::int32_t> of(std::int32_t chart) const {
    return std::span(halfedges).subspan(start[chart], start[chart + 1] - start[chart]);
  }
};

/// \param boundary  all boundary half-edges
/// Cost: O(these).
Outlines trace_outlines(const Labels& labels, const Bits& boundary, const Job& job);

/// The labels of charts that are not discs, in rising order.
/// Cost: O(F).
std::vector<std::int32_t> find_non_discs(Labels& labels, const Outlines& outlines, const Threads& threads,
                                         const Job& job);

}  // namespace isimp::meshing
