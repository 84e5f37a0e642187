#pragma once

#include <algorithm>
#include <cstdint>
#include <thread>

namespace isimp {

/// limit: largest number of threads, unless the machine has more cores: systems limit it.
inline constexpr std::int32_t kMostThreads = 256;

/// The number of threads for a requested number. All loops and libraries use it. Results never depend on it.
/// \param asked  0: as many as the machine has cores
inline std::int32_t thread_count(std::int32_t asked) {
  const std::int32_t cores = std::max(1, static_cast<std::int32_t>(std::thread::hardware_concurrency()));
  return asked > 0 ? std::min(asked, std::max(cores, kMostThreads)) : cores;
}

/// thread_count(asked), or fewer where the system refuses that number now. The first call in each thread starts that
/// many threads to find out. Libraries that end the process when a thread can't be started, such as OpenMP, need it.
std::int32_t startable_threads(std::int32_t asked);

}  // namespace isimp
