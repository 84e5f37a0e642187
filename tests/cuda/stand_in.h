#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// A CUDA runtime on main memory, for the host side of kernels.cu as nvcc compiles it: allocations and copies are real,
/// kernels do nothing. It records each launch and may let any call fail.
namespace isimp::stand_in {

/// cudaErrorMemoryAllocation, which a caller may mend by giving memory back.
inline constexpr int kOutOfMemory = 2;
inline constexpr int kIllegalAddress = 700, kLaunchFailure = 719;

struct Settings {
  int devices = 1;
  unsigned char filling = 0;                ///< content of all memory, since no kernel writes any
  std::int64_t failing = -1;                ///< the call that fails, from 0; -1: none
  int error = kIllegalAddress;              ///< error of the failing call
  std::size_t most = std::size_t{1} << 40;  ///< bytes that may be held
};

/// Applies to all later calls, and clears the record. Blocks stay, filled again.
void set(const Settings& settings);

struct Launch {
  std::uint64_t blocks, threads;  ///< threads a block
};

struct Record {
  std::int64_t calls = 0;  ///< calls of functions that may fail
  std::vector<Launch> launches;
  std::vector<std::size_t> wanted;  ///< bytes of each requested allocation
  std::int64_t live = 0;            ///< blocks held now
  std::int64_t misused = 0;         ///< blocks freed that were none, copies beyond a block
  std::int64_t other_streams = 0;   ///< launches and copies in another stream than the default one
};
[[nodiscard]] Record record();

}  // namespace isimp::stand_in
