#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "isimp/parallel/backend.h"

/// A device that disturbs: the kernels of cuda/ on one thread of the CPU, with a random order wherever a real device
/// may use any. Blocks of 256 threads run in random order, the last one is ragged. Threads are interleaved at every
/// atomic operation. Memory holds rubbish before it is written. An allocation may fail.
namespace isimp::chaos {

struct Settings {
  std::uint64_t seed = 1;
  std::int64_t failing = -1;  ///< the allocation that fails, from 0; -1: none
};

/// Applies to all later calls, and counts allocations from 0 again.
void set(const Settings& settings);

struct Count {
  std::int64_t allocations = 0;  ///< since `set`, the failed one among them
  std::int64_t live = 0;         ///< blocks that are held now
  std::int64_t misused = 0;      ///< deletions of addresses that were no block
  std::int64_t switches = 0;     ///< times that a thread waited at an atomic operation
};
[[nodiscard]] Count count();

/// The back end. It is not among `backends()`.
const parallel::Kernels& kernels();

// For its header:

/// Calls kernel(i) for i in [begin, end), in the worst order for it.
void run(std::int64_t begin, std::int64_t end, const std::function<void(std::int64_t)>& kernel);
/// Makes other threads run first, perhaps. Does nothing outside `run`.
void wait();
/// A number in [0, below).
[[nodiscard]] std::size_t random(std::size_t below);
/// \return null if it fails
void* allocate(std::size_t bytes);
void release(void* block) noexcept;

}  // namespace isimp::chaos
