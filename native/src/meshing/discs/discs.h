// Cuts charts until each is a disc.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "discs/labels.h"
#include "isimp/core/job.h"

namespace isimp::meshing {

// tuned sides
/// Cosine of the largest angle at which a hole's wall and an adjacent surface may be one polygon.
constexpr double kSameWay = 0.5;

/// Shortest paths over vertices; the arrays are kept between searches.
struct Search {
  explicit Search(std::size_t n)
      : distance(std::make_unique_for_overwrite<double[]>(n)),
        via(std::make_unique_for_overwrite<std::int32_t[]>(n)),
        reached(n) {}
  /// Clears the reached vertices.
  void start();
  /// Reaches i over `from_via` if that is nearer than before.
  /// \return whether it was
  bool reach(std::int32_t i, double d, std::int32_t from_via);
  /// The nearest one not yet taken, kNone if there is none.
  std::int32_t take();

  std::unique_ptr<double[]> distance;   ///< valid where reached
  std::unique_ptr<std::int32_t[]> via;  ///< index over which each was reached
  Marks reached;

 private:
  struct Waiting {
    double distance;
    std::int32_t index;
    bool operator<(const Waiting& other) const {  // std::push_heap puts the largest first; ties by index
      return distance > other.distance || (distance == other.distance && index > other.index);
    }
  };
  std::vector<Waiting> queue_;
};

/// The shared data of the cuts: labels, and arrays of the mesh's size that are made once.
struct Cutter {
  explicit Cutter(Labels& l);

  Labels& labels;
  bool perforated = false;  ///< whether the mesh has many more openings than regions
  Search vertices;
  std::unique_ptr<std::int32_t[]> face_place;   ///< valid for faces of the current chart: their index in it
  std::unique_ptr<std::int32_t[]> vertex_loop;  ///< valid where vertex_marks: boundary loop of the vertex
  Marks vertex_marks, blocked, halfedge_marks, face_marks;
};

/// Parts a chart in two halves, each face to the nearer of two faces over the surface: the given ones or, where there
/// are none, two that are far apart.
/// \return the new label, kNone for a single face
std::int32_t bisect(Cutter& cutter, std::int32_t chart, Cause cause,
                    std::array<std::int32_t, 2> seeds = {kNone, kNone});

/// Parts a chart with many loops or handles by the directions its faces look in: the walls of holes from the plate that
/// they go through. No polygon can stand for both, and cuts from hole to hole would not part them.
/// \return how many labels are new, the last ones; 0 if the faces look in one direction or in too many
/// Cost: O(n) for n faces of the chart.
std::int32_t cut_by_direction(Cutter& cutter, std::int32_t chart);

/// The number of borders and handles of a mesh.
double openings_of(const Mesh& mesh);

/// Whether the faces of each chart form planar sides, as in a plate made by construction.
/// Cost: O(F).
bool has_flat_sides(const Cutter& cutter, const Job& job);

/// Whether a mesh has many more openings than regions, so that most of its polygons will surround openings.
/// Cost: O(1), or O(F) if `has_flat_sides` is needed.
bool is_perforated(const Cutter& cutter, std::int32_t regions, const Job& job);

/// Parts all charts by `cut_by_direction`, discs included.
/// Cost: O(F).
void part_walls(Cutter& cutter, const Job& job);

/// Cuts a chart of genus 0 with holes along chains of paths from loop to loop, each as straight as can
/// be, so that holes in rows are parted by rows. All paths come from one forest of shortest paths.
/// \return how many labels are new, the last ones; 0 if there is no such chain. Charts may have holes left.
/// Cost: O(n log n) for n faces of the chart.
std::int32_t cut_holes(Cutter& cutter, std::int32_t chart, const Shape& shape, Job& job);

/// Cuts a flat chart of genus 0 with holes along its main directions, given by the longest edges of its boundary: from
/// the outline over its holes, or if they are many over the holes of one row, and back to the outline.
/// \return how many labels are new, the last ones; 0 for a chart that is bent, has no main directions or has no such
///         cuts. Charts may have holes left.
/// Cost: O(n log n) for n faces of the chart, and O(corners of the holes * edges of its boundary).
std::int32_t cut_wall(Cutter& cutter, std::int32_t chart, const Shape& shape, const Job& job);

/// Parts some connected faces along the half-edges in `halfedge_marks`; each part but the one with the first face gets
/// a label.
/// \return how many labels are new, the last ones
/// Cost: O(faces).
std::int32_t part_along_marks(Cutter& cutter, std::span<const std::int32_t> faces);

/// Parts the faces along short loops round handles from the rest, so that genus falls with each. The loops are found
/// once; loops that an earlier one crosses are left to another call.
/// Source: Erickson, Whittlesey 2005 (tree and cotree); each boundary loop counts as one face.
/// \return how many labels are new, the last ones; 0 if none of the loops will do
/// Cost: O(n log n) for n faces of the chart, and O(n) a loop.
std::int32_t cut_handles(Cutter& cutter, std::int32_t chart, const Shape& shape, Job& job);

/// A chart that is a disc: its faces as they are flooded, and its boundary from the first of them with one on.
struct Disc {
  std::vector<std::int32_t> faces, loop;
};

/// Splits or changes charts until each of `todo`, and each of their parts, is a disc.
/// \param found  the discs are added here, by chart
void make_discs(Cutter& cutter, std::vector<std::int32_t> todo, std::map<std::int32_t, Disc>& found, Job& job);

/// Splits the charts of closed components until each has `least` (or one a face).
/// \param found  the new discs are added here, by chart
void split_closed_components(Cutter& cutter, std::int32_t least, std::map<std::int32_t, Disc>& found, Job& job);

}  // namespace isimp::meshing
