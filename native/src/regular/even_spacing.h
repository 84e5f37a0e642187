#pragma once

#include <span>
#include <vector>

namespace isimp::regular {

/// One of some parallel planes: where it lies along their common normal.
struct ParallelPlane {
  double offset = 0;
  double low = 0, high = 0;  ///< it may be moved as far as this
  double area = 0;           ///< what it weighs
  bool faces_along = true;   ///< the common normal; else against it
  bool is_fixed = false;     ///< it stays, and others may follow it
};

/// Planes that were found to belong together, and where they are then.
struct EvenSpacing {
  std::vector<double> offset;  ///< of each plane
  int series = 0;  ///< of three or more planes of one facing at equal distances, as storeys and stairs have them
  int sizes = 0;   ///< that three or more pairs of planes have in common, as windows have their widths
  int planes = 0;  ///< in one of these
};

/// Moves parallel planes to equal distances. Series with nearly the same distance get the same one. A series or a size
/// counts where chance alone would give less than one in ten such among as many planes.
///
/// \param tolerance  of an offset: how far a plane may miss its place to be taken for one of a series, above 0
/// Source: the count of false alarms as in Desolneux, Moisan, Morel 2000; the rest is our own.
/// Cost: O(P^3); of P planes the 100 largest of each facing can be in a series.
EvenSpacing even_spacing(std::span<const ParallelPlane> planes, double tolerance);

}  // namespace isimp::regular
