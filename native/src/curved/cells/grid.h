#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "fit/points.h"
#include "fit/surfaces.h"

namespace isimp::curved {

inline constexpr std::int32_t kMostSegments = 256, kMostRings = 64;  // limit
// tuned round
inline constexpr std::int32_t kLeastRound = 6;  ///< least number of segments of a full turn
inline constexpr double kMoreCells = 1.03;      ///< largest number of cells of a cut, over the wanted one
inline constexpr double kHalfCell = 0.5;        ///< cells that a cut may have beyond that

/// The faces of a patch, seen from its axis.
struct PatchFaces {
  Some face;  ///< by graph index
  std::vector<double> area, angle, rho, z, along;
  std::vector<double> out, up;  ///< parts of the surface's normal: away from the axis, and along it
  double whole = 0;             ///< sum of `area`
  double rough = 0;             ///< root mean square distance of the faces from the surface
  double edge = 0;              ///< mean length of their edges

  PatchFaces(const Faces& faces, const CurvedProxy& proxy, Some some);
};

/// How a patch is cut. The segments of an extrusion are strips between knots along its profile; it has one ring.
struct Grid {
  std::int32_t segments = 0, rings = 0, cells = 0;
  std::vector<double> knots;
  bool low_cap = false, high_cap = false;
  double cost = 0;  ///< sum of area times squared distance from the planes of the cells
};

/// The middle and the mean radius of a closed profile.
struct Tube {
  Vec2 middle = Vec2::Zero();
  double radius = 0;
};
Tube tube_of(const CurvedProxy& bend);  // (pipes.cpp)

/// The mean square distance of an arc of radius 1 from its chord through the mean.
inline double of_chord(double angle) {
  const double sinc = std::sin(angle / 2) / (angle / 2);
  return 0.5 + std::sin(angle) / (2 * angle) - sinc * sinc;
}

/// Sets whether the faces cover a full turn; if not, sets their first angle and the covered angle.
void set_span(CurvedProxy& proxy, const PatchFaces& patch);

/// Makes the closed profile of an extrusion begin at a border of its strips.
/// \param strips  about how many there will be
void begin_at_border(const Faces& faces, CurvedProxy& proxy, PatchFaces& patch, double strips);

class Profile;

/// The cuts of a patch, from sums over its profile that are made once.
class Cuts {
 public:
  /// \param proxy, patch  must outlive this
  Cuts(const CurvedProxy& proxy, const PatchFaces& patch);
  Cuts(Cuts&&) noexcept;
  ~Cuts();

  /// Finds the best rings along the profile for each number of segments, within a number of cells: dynamic programming
  /// over bins of the profile, VSA in one dimension, by squared distances in both directions.
  /// \param cells  the number of cells; a cut may have 3 % more
  /// \param rough  root mean square distance of the faces from the surface: no chord error is below it
  /// \return the grids that fit, by rising number of segments
  /// Cost: O(bins^2 cells log cells).
  [[nodiscard]] std::vector<Grid> within(double cells, double rough);

  /// The best grid with a given number of segments and, if above 0, of rings. The number of cells is no limit to these.
  [[nodiscard]] Grid of(std::int32_t segments, std::int32_t rings, double cells);

 private:
  [[nodiscard]] std::vector<Grid> strips_within(double cells, double rough);

  const CurvedProxy* proxy_;
  double largest_, edge_, area_;
  std::unique_ptr<Profile> profile_;
};

/// Sets segments, rings and knots. In a full turn `across` passes through the middle of a segment, not through an edge.
void apply(CurvedProxy& proxy, const Grid& grid);

}  // namespace isimp::curved
