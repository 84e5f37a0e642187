#pragma once

#include <cstdint>

/// The sizes of launches on a CUDA device.
namespace isimp::parallel {

inline constexpr std::int64_t kThreadsOfBlock = 256;
inline constexpr std::int64_t kMostOfLaunch = ((std::int64_t{1} << 31) - 1) * kThreadsOfBlock;

/// Blocks of threads of a launch for `count` numbers, at most kMostOfLaunch.
constexpr std::int64_t blocks_for(std::int64_t count) { return (count + kThreadsOfBlock - 1) / kThreadsOfBlock; }

}  // namespace isimp::parallel
