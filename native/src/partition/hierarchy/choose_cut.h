#pragma once

#include <cstdint>
#include <functional>
#include <span>

namespace isimp {

// tuned houses
/// Deviations of the noise that count as tolerance: regions that differ by less are one.
inline constexpr double kNoiseDeviations = 2.4;
/// Deviations below which all is noise: faces merge up to here by their filtered normals, and the search for gaps
/// begins here.
// tuned found
inline constexpr double kLeastNoise = 2.5;
/// Share of the area: lower costs of merges are rounding errors.
inline constexpr double kNoCost = 1e-9;  // rounding

/// The limit of the increase of error by a merge, for regions that are off their planes by about t: 16 t^2.
///
/// Merging the halves of a square of side L that meet at a small angle a raises it by L^2 a^2 / 4, and their joint
/// plane is off by at most L a / 8, a quarter of the root. t does not fall below `deviations` of the noise.
/// \param tolerance, noise  t and the noise's standard deviation, scene units
/// \return scene units squared
double merge_limit(double tolerance, double noise, double deviations = kNoiseDeviations);

/// The cut of a merge tree.
struct Cut {
  double cost = 0.0;     ///< merges up to this are made, scene units squared
  bool snapped = false;  ///< it lies in a gap of the costs that can't be chance: the number of planes is the shape's
                         ///< own
};

/// Cuts near merge_limit(tolerance, noise), or at a significant gap of the costs above it. "Near" means: the number of
/// regions is the geometric mean of the numbers at tolerances from t / 1.2 to 1.2 t. So the number depends less on
/// single costs, which noise and the triangles of the scan move past the limit.
///
/// If a shape has no number of planes of its own, the costs fall steadily: with C_P the cost of the merge from P
/// regions to P - 1, (P / 2) ln(C_P / C_(P+1)) is then exponentially distributed with mean 1. Gaps that reach into [t,
/// 4 t], where the ratio is above 2 and that value above ln(W + 1) + 4, with W merges inside, are significant; the
/// widest that `fits` is taken and cut in its geometric middle. Under noise the window begins at kLeastNoise.
/// \param falling     the costs, largest first, scene units squared; 20,000 of them are enough
/// \param components  number of clusters that remain when everything is merged
/// \param rounding    costs below this are none
/// \param finest      the costs are complete for tolerances from this up, scene units; no finer one is used
/// \param fits        whether a cost in a gap may be taken; empty: each may
Cut choose_cut(std::span<const double> falling, std::int32_t components, double rounding, double tolerance,
               double finest, double noise, bool snap, const std::function<bool(double)>& fits = {});

}  // namespace isimp
