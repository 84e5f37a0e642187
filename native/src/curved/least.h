#pragma once

namespace isimp::curved {

inline constexpr double kTiny = 1e-300;    ///< rounding: the least divisor
inline constexpr double kDamping = 1e-12;  ///< rounding: share of the diagonal of a system, for one that is singular

}  // namespace isimp::curved
