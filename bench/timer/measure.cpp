#include "measure.h"

#include <time.h>

#include <chrono>
#include <fstream>
#include <string>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace isimp::bench {
namespace {

Lap now() {
  const auto milliseconds = [](clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  };
  const auto wall = std::chrono::steady_clock::now().time_since_epoch();
  return {.cpu_ms = milliseconds(CLOCK_PROCESS_CPUTIME_ID),
          .own_ms = milliseconds(CLOCK_THREAD_CPUTIME_ID),
          .wall_ms = std::chrono::duration<double, std::milli>(wall).count()};
}

/// A line such as "VmHWM:   1234 kB" of /proc/self/status, in bytes; 0 where there is none.
std::int64_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == key) {
      std::int64_t kilobytes = 0;
      status >> kilobytes;
      return 1024 * kilobytes;
    }
  return 0;
}

}  // namespace

Stopwatch::Stopwatch() : start_(now()) {}

Lap Stopwatch::lap() const {
  const Lap end = now();
  return {.cpu_ms = end.cpu_ms - start_.cpu_ms,
          .own_ms = end.own_ms - start_.own_ms,
          .wall_ms = end.wall_ms - start_.wall_ms};
}

MemoryGauge::MemoryGauge() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  std::ofstream("/proc/self/clear_refs") << "5\n";  // resets VmHWM to the resident size
  before_ = status_bytes("VmRSS:");
}

std::int64_t MemoryGauge::peak() const { return peak_memory() - before_; }

std::int64_t peak_memory() { return status_bytes("VmHWM:"); }

}  // namespace isimp::bench
