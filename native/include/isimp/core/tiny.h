#pragma once

namespace isimp {

/// rounding: the least divisor
inline constexpr double kTiny = 1e-300;

}  // namespace isimp
