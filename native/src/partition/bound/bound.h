#pragma once

#include <limits>
#include <vector>

#include "components.h"
#include "hierarchy/hierarchy.h"
#include "isimp/core/job.h"
#include "isimp/partition/regions.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The room between two parallel planes that a region's vertices take up: normal * x in [low, high].
struct Slab {
  Vec3 normal = Vec3::Zero();
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  [[nodiscard]] double width() const { return high - low; }
  [[nodiscard]] double middle() const { return (low + high) / 2; }
  void add(const Vec3& p) {
    const double z = normal.dot(p);
    low = z < low ? z : low;
    high = z > high ? z : high;
  }
};

struct BoundedRegions {
  Regions regions;
  std::vector<Slab> slab;  ///< (R) none wider than twice the bound, except single faces without a normal
};

/// Few regions, each with all its vertices within `bound` of one plane.
///
/// 1. Down the hierarchy from its coarsest level, a node is taken whole if it fits well between two planes across its
///    mean normal, 2 * bound apart; else its children are tried, and finally single faces.
/// 2. Neighbours merge, cheapest first by the rise of the error, where both together fit between two such planes,
///    however these are turned.
/// 3. Regions dissolve, smallest first: their faces join neighbours between whose planes they lie, all or none.
/// 4. Borders relax, by moves only that keep every vertex between its region's planes.
/// 5. Small regions pass their neighbours the faces that lie between their planes, and 2 to 4 run again with the
///    others; twice at most.
/// Every component keeps as many regions as it needs.
/// \param bound  scene units, above 0
/// Cost: O(F log F), about a second for a million faces.
BoundedRegions bounded_regions(const Surface& surface, const Hierarchy& hierarchy, const Components& components,
                               double bound, Job& job);

/// The hierarchy for `bounded_regions`, with small patches.
Hierarchy hierarchy_for_bound(const Surface& surface, Job& job, std::int32_t threads);

}  // namespace isimp
