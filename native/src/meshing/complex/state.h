#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "complex/complex.h"
#include "complex/placement.h"
#include "complex/polygons.h"
#include "complex/tips.h"
#include "discs/discs.h"
#include "discs/logged.h"
#include "isimp/core/threads.h"
#include "isimp/meshing/polygonize.h"

namespace isimp::meshing {

constexpr std::int32_t kLeastClosed = 4;  ///< unit: no closed surface has fewer polygons

/// How long the boundary of a chart is, and the part of it that each other chart is across of.
struct SharedBoundary {
  std::map<std::int32_t, double> with;    ///< charts of its region
  std::map<std::int32_t, double> others;  ///< charts of other regions
  double all = 0;
};

/// The data of a mesh that becomes polygons, from labels to positions, and their update after a local change. All
/// changes are calls of member functions; the public data can only be read.
///
/// A change of labels, corners or diagonals is followed by `update` or `update_in_place`, which derives polygons and
/// positions from it. Several changes may come before one update. A `Transaction` can undo changes and their effects.
class State {
 public:
  /// \param job  `update` polls it too, so it must outlive the state
  State(const Mesh& m, const Partition& p, const MeshingOptions& o, Job& job);

  /// The charts across the chords of one, in rising order.
  [[nodiscard]] std::vector<std::int32_t> neighbours(std::int32_t chart) const;
  /// Calls fn(chart) for each of them, once for each chord.
  template <class Function>
  void for_each_neighbour(std::int32_t chart, Function fn) const {
    for (const std::int32_t h : complex.chords(chart))
      if (const std::int32_t l = labels.across(h); l != kNone) fn(l);
  }
  /// Adds them to some charts, in rising order then.
  void add_neighbours(std::vector<std::int32_t>& charts) const;
  /// The region of a chart with these faces. The first chart of a region stays its chart while it has a face of it, so
  /// that every region keeps a polygon; other charts are of the region that has most of their area. That may be another
  /// one than before: joining junctions hands faces over to a neighbour.
  [[nodiscard]] std::int32_t region_of(std::int32_t chart, std::span<const std::int32_t> faces) const;
  [[nodiscard]] SharedBoundary shared_boundary(std::int32_t chart) const;
  [[nodiscard]] Scale scale() const { return scale_of(labels, planes_); }
  /// The boundary that two charts would have together, as half-edges in order; empty where that would be no disc.
  /// Cost: O(their boundaries), of which the complex must be up to date.
  [[nodiscard]] std::vector<std::int32_t> loop_together(std::int32_t kept, std::int32_t gone) const;

  // Changes of labels.
  /// Splits a chart in halves (and on, until all of it is discs).
  /// \return false for a single face
  bool split(std::int32_t chart, Job& job);
  /// Makes each face of a chart a chart of its own, all corners of which stay on the mesh.
  /// \return whether that is new
  bool shatter(std::int32_t chart);
  /// Makes two charts one, which must be a disc.
  /// \param loop  the result of `loop_together` for them
  /// Cost: O(faces of the absorbed chart + boundaries of both).
  void unite(std::int32_t kept, std::int32_t gone, std::vector<std::int32_t> loop);
  /// Marks some charts, so that the next `update` measures their faces again.
  void touch(std::span<const std::int32_t> charts);
  /// Moves some faces of one chart to another, neither of which may cease to be a disc. The next update need not measure
  /// all faces of these charts, and must come before changes of other kinds.
  /// \param charts  all charts whose boundary, or a neighbour across it, has changed
  /// Cost: O(faces).
  void hand_over(std::int32_t giver, std::int32_t taker, std::span<const std::int32_t> faces,
                 std::span<const std::int32_t> charts);

  // Changes of polygons, as in Complex. Charts with changed diagonals are an argument of `update`.
  void add_corner(std::int32_t vertex) { complex_.add_corner(vertex); }
  bool drop_corner(std::int32_t vertex) { return complex_.drop_corner(vertex); }
  /// The corner at a vertex, a new one if there is none.
  std::int32_t corner_at(std::int32_t vertex) { return corners_.at(vertex); }
  void set_diagonals(std::int32_t chart, std::vector<std::array<std::int32_t, 2>> all) {
    diagonals_.set(chart, std::move(all));
  }
  /// Rebuilds the polygons of changed charts with corners at their present places; see Polygons::collect.
  void collect(std::vector<std::int32_t>& changed) {
    polygons_.collect(complex_, labels_, diagonals_, corners_, changed);
  }

  // Changes of positions, which `update` takes no notice of.
  void move(std::int32_t corner, const Vec3& place) { corners_.position.set(corner, place); }
  /// Moves corners to the places of least energy for the given planes, and onto the held ones.
  void move_onto(std::span<const Plane> planes_by_chart, std::span<const std::int32_t> moving);

  /// Updates polygons and positions after splits, new corners or new diagonals. All corners of polygons that have
  /// changed are placed again.
  /// \param changed  charts whose diagonals changed; the others are known
  /// \return the charts of which a polygon may have changed its place, in rising order
  std::vector<std::int32_t> update(std::vector<std::int32_t> changed) { return update(std::move(changed), false); }
  /// The same, but only new corners are placed. A corner that a polygon used before keeps its place; within a
  /// transaction, one that a polygon used as it began has the place of then.
  std::vector<std::int32_t> update_in_place(std::vector<std::int32_t> changed) {
    return update(std::move(changed), true);
  }
  /// The corners of polygons that have changed since the last call, those marked included.
  std::vector<std::int32_t> take_stale();
  /// Adds a corner to the result of the next `take_stale`.
  void mark_stale(std::int32_t corner) { stale_.set(corner, 1); }
  /// The places of some corners if they were placed together and all others stayed.
  /// \param from_vertices  whether they begin at their vertices, else at their places
  [[nodiscard]] std::vector<Vec3> better_places(std::span<const std::int32_t> moving, bool from_vertices);

  // A `Transaction` calls these.
  /// Pre: the state is up to date.
  /// Cost: O(charts).
  void begin_transaction();
  void commit();
  /// Restores labels, charts, planes, diagonals, corners, polygons and positions, the numbers of polygons included.
  void rollback();
  /// Calls fn(array) for each array that a transaction takes back.
  template <class Function>
  void for_each_array(Function fn) const {
    for_each_array(*this, fn);
  }

 private:
  /// A touched chart that needs no search of its faces, since its plane is known. Its boundary is known too, or is the
  /// old one but at faces that were handed over.
  struct Known {
    std::int32_t touches = 0;        ///< included here; another number of them makes this invalid
    bool has_moved = false;          ///< the boundary
    std::vector<std::int32_t> loop;  ///< the new boundary, if it is known
  };
  /// The changes since the last update.
  struct Pending {
    std::vector<std::int32_t> united;        ///< charts absorbed by others
    std::map<std::int32_t, Disc> discs;      ///< by chart: the disc found by its split
    std::map<std::int32_t, Known> known;     ///< by touched chart
    std::vector<std::int32_t> handed_faces;  ///< faces moved from one chart to another
    std::vector<std::int32_t> at_home;       ///< corners that were put to their vertices
  };
  /// The boundary of a changed chart, from a half-edge that was already on it; empty if there is none. The vertices of
  /// all faces that were handed over are marked.
  [[nodiscard]] std::vector<std::int32_t> loop_again(std::int32_t chart) const;
  /// The touched charts that are there, in rising order and each once; none is touched afterwards.
  /// \param known  loses the charts that were touched by other changes too
  [[nodiscard]] std::vector<std::int32_t> take_touched(std::map<std::int32_t, Known>& known);
  /// Derives the boundaries, planes and regions of touched charts from their faces, where they are not known.
  void derive_charts(std::span<const std::int32_t> touched, Pending& pending);

  std::vector<std::int32_t> update(std::vector<std::int32_t> changed, bool in_place);
  /// Parts the tips that changes of charts have spoilt.
  /// \return the charts at these
  std::vector<std::int32_t> part_tips();
  /// Sets the radii of some corners; 0 for corners that must stay at their vertices.
  void limit(std::span<const std::int32_t> moving);
  /// Places some corners by the energy, beginning at their vertices or where they are.
  void place(std::span<const std::int32_t> moving, bool from_vertices);
  template <class Self, class Function>
  static void for_each_array(Self& self, Function fn) {
    fn(self.labels_.label);
    fn(self.labels_.charts);
    fn(self.planes_);
    fn(self.diagonals_);
    fn(self.stale_);
    Complex::for_each_array(self.complex_, fn);
    Corners::for_each_array(self.corners_, fn);
    Polygons::for_each_array(self.polygons_, fn);
  }

  Labels labels_;
  Cutter cutter_;
  Logged<Plane> planes_;
  Complex complex_;
  Diagonals diagonals_;
  Corners corners_;
  Polygons polygons_;
  std::vector<Tip> tips_;
  const Job& job_;
  std::int32_t merged_without_area_ = 0;
  std::int64_t placed_ = 0;
  Pending pending_;
  Logged<std::uint8_t> stale_;  // by corner: whether a polygon of it has changed since `take_stale`

 public:
  const Mesh& mesh;
  const Partition& partition;
  const MeshingOptions& options;
  const Threads threads;
  const std::int32_t regions;  ///< number of regions in the partition
  // Read-only views of the private data.
  const std::int32_t& merged_without_area = merged_without_area_;  ///< charts given to a neighbour, for lack of area
  const std::int64_t& placed = placed_;                            ///< placements of corners, repeated ones included
  const Labels& labels = labels_;
  const Cutter& cutter = cutter_;
  const Logged<Plane>& planes = planes_;  ///< by chart
  const Complex& complex = complex_;
  const Diagonals& diagonals = diagonals_;  ///< by chart
  const Corners& corners = corners_;
  const Polygons& polygons = polygons_;
};

}  // namespace isimp::meshing
