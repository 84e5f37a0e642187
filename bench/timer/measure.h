#pragma once

#include <cstdint>
#include <utility>

namespace isimp::bench {

/// Times of a piece of work.
struct Lap {
  double cpu_ms = 0.0;   ///< processor time of all threads: other processes on the machine hardly change it
  double own_ms = 0.0;   ///< processor time of the calling thread, without its waits for others
  double wall_ms = 0.0;  ///< elapsed time
};

/// Runs from when it is made.
class Stopwatch {
 public:
  Stopwatch();
  [[nodiscard]] Lap lap() const;

 private:
  Lap start_;
};

template <class Work>
Lap timed(Work&& work) {
  const Stopwatch watch;
  std::forward<Work>(work)();
  return watch.lap();
}

/// Peak memory of a piece of work, from the kernel's figures for this process. Linux only: elsewhere all is zero.
///
/// The constructor returns free memory to the system and resets the kernel's high-water mark, so that memory that was
/// freed before does not count.
class MemoryGauge {
 public:
  MemoryGauge();
  /// Resident bytes when this was made.
  [[nodiscard]] std::int64_t before() const { return before_; }
  /// The most that has been resident since, beyond `before`.
  [[nodiscard]] std::int64_t peak() const;

 private:
  std::int64_t before_;
};

/// The most memory that has been resident since the process began, or since the last MemoryGauge; bytes.
std::int64_t peak_memory();

}  // namespace isimp::bench
