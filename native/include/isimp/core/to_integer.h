#pragma once

#include <concepts>

namespace isimp {

/// The integer part of a number, clamped to [low, high]. NaN gives `low`.
///
/// A plain conversion of a number that the type can't hold is undefined, and std::clamp returns NaN as it is. Numbers
/// that come from coordinates may be either, even if checked earlier: they overflow and cancel on the way.
template <std::integral Integer, std::floating_point Number>
constexpr Integer to_integer(Number x, Integer low, Integer high) {
  if (!(x > static_cast<Number>(low))) return low;
  return x < static_cast<Number>(high) ? static_cast<Integer>(x) : high;
}

}  // namespace isimp
