#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/complex.h"
#include "isimp/partition/partition.h"

namespace isimp::meshing {

/// The tip of a round part, such as the apex of a cone.
struct Tip {
  std::vector<std::int32_t> vertices;  ///< in rising order
  std::int32_t nearest = kNone;        ///< the one of them that is nearest to the planes of its cells
};

/// The tips of round parts. No vertex of a scan has room for all segments of a ring: at its end on the axis its cells meet
/// in several junctions, which form a tree. Cells of one ring that all touch such a tree are to meet in one corner.
/// Cost: O(chords of cells).
std::vector<Tip> tips_of(const Labels& labels, const Complex& complex, const Partition& partition);

/// The charts at some vertices, in rising order.
std::vector<std::int32_t> charts_of(const Labels& labels, std::span<const std::int32_t> vertices);

/// The corners between two charts of a tip, in rising order: planes of cells meet in a straight line.
/// Cost: O(chords of these charts).
std::vector<std::int32_t> bends_at(const Labels& labels, const Complex& complex, const Tip& tip);

/// Whether every chart at a tip has it at one place of its boundary, and two more corners.
/// Cost: O(chords of these charts).
bool is_whole(const Labels& labels, const Complex& complex, const Tip& tip);

}  // namespace isimp::meshing
