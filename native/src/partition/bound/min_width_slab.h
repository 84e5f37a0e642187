// The narrowest slab between two planes that holds a region.
#pragma once

#include <span>
#include <vector>

#include "bound/bound.h"
#include "bound/dissolve.h"

namespace isimp::detail {

/// Points of a region that were its outermost along some normals, and so bound its width across similar normals.
using Core = std::vector<Vec3>;

/// The slab of some points across the normal near `from` across which they are narrowest: the plane that fits them best
/// in the sense of Chebyshev, up to a per cent or so; or the first one found that is no wider than `enough`.
/// Source: Rice, Usow: The Lawson algorithm and extensions, 1968.
Slab narrowest(std::span<const Vec3> points, const Vec3& from, double enough);

/// Turns a slab around the points of two lists so that it is no wider than `width`, if that is possible.
///
/// \param slab  its normal is the start of the search; afterwards, if it fits, the slab that does
/// \param core  the known extreme points; the search adds to them
/// \return whether it fits
/// Cost: a few passes over all points; none where the core decides.
bool turn_to_fit(const Corners& corners, std::span<const std::int32_t> some, std::span<const std::int32_t> others,
                 double width, Slab& slab, Core& core);

}  // namespace isimp::detail
