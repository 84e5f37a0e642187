#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "discs/labels.h"

namespace isimp::meshing {

/// A transfer of faces from one chart to another, by which one junction moves to another along the boundary between two
/// charts.
struct Gift {
  std::int32_t giver, taker;        ///< charts
  std::int32_t keeps, moves;        ///< vertices: the junction that stays, and the one that moves there
  std::vector<std::int32_t> faces;  ///< in rising order
};

/// The charts at a vertex, counter-clockwise; empty at a border of the mesh.
std::vector<std::int32_t> charts_around(const Labels& labels, std::int32_t vertex);

/// The half-edges from one junction to another along the boundary between two charts, with one of these on their left.
/// \return empty if another chart meets the path
/// Cost: O(path).
std::vector<std::int32_t> path_between(const Labels& labels, std::int32_t from, std::int32_t to,
                                       std::span<const std::int32_t> charts);

/// Sets the faces of a gift: the giver's faces at the vertices of a path, except at the junction that stays.
void fill(Gift& gift, const Labels& labels, std::span<const std::int32_t> path);

/// Whether all charts stay discs and no other junction changes by a gift. Clears and uses face_marks and vertex_marks.
/// \param all  in rising order: the charts that shall meet in the junction that stays
/// Cost: O(faces).
bool keeps_discs(const Labels& labels, const Gift& gift, const std::vector<std::int32_t>& all);

}  // namespace isimp::meshing
