#pragma once

#include <span>
#include <vector>

#include "isimp/core/job.h"

namespace isimp::regular {

/// One of some parallel planes, with its place along their common normal.
struct ParallelPlane {
  double offset = 0;
  double low = 0, high = 0;  ///< range to which it may be moved
  double area = 0;           ///< weight
  bool faces_along = true;   ///< the common normal; else against it
  bool is_fixed = false;     ///< it stays, and others may follow it
};

/// The planes found to belong together, and their new places.
struct EvenSpacing {
  std::vector<double> offset;  ///< new offset of each plane
  int series = 0;  ///< number of series of three or more planes of one facing at equal distances, such as storeys and
                   ///< stairs
  int sizes = 0;   ///< number of sizes that three or more pairs of planes share, such as the widths of windows
  int planes = 0;  ///< number of planes in one of these
};

/// Moves parallel planes to equal distances. Series with nearly the same distance get the same one. A series or a size
/// counts if the expected number of such by chance among as many planes is below one in ten.
///
/// \param tolerance  of an offset: the largest distance of a plane from its place in a series, above 0
/// \param job  polled, if given
/// Source: the count of false alarms as in Desolneux, Moisan, Morel 2000; the rest is our own.
/// Cost: O(P^3); of P planes the 100 largest of each facing can be in a series.
EvenSpacing even_spacing(std::span<const ParallelPlane> planes, double tolerance, const Job* job = nullptr);

}  // namespace isimp::regular
