#pragma once

namespace isimp::curved {

inline constexpr double kDamping = 1e-12;  ///< rounding: share of the diagonal of a system, for one that is singular

}  // namespace isimp::curved
