#pragma once

#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/transform_reduce.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <cuda/atomic>
#include <new>
#include <span>

#include "isimp/core/thread_count.h"
#include "memory.h"

#ifdef _OPENMP
#include <omp.h>
#endif

#define ISIMP_KERNEL

/// The threads of the CPU, by Thrust.
namespace isimp::parallel::ISIMP_DEVICE {

inline constexpr const char* kName = "cpu";

inline void* device_new(std::size_t bytes) { return ::operator new(bytes, std::nothrow); }
inline void device_delete(void* block) noexcept { ::operator delete(block); }
inline void device_copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) std::memcpy(to, from, bytes);
}

/// In place.
template <class T>
class Readable {
 public:
  Readable(Memory& /*memory*/, std::span<const T> numbers) : numbers_(numbers) {}
  [[nodiscard]] const T* data() const { return numbers_.data(); }

 private:
  std::span<const T> numbers_;
};

/// The least number of steps for which threads are worth their start.
inline constexpr std::int64_t kWorthThreads = 1 << 13;

/// Calls work(policy) with the best policy for `count` steps.
template <class Work>
auto with_policy(std::int64_t count, Work work) {
  if (count < kWorthThreads) return work(thrust::seq);
  return work(thrust::device);
}

template <class Kernel>
void for_all(std::int64_t begin, std::int64_t end, Kernel kernel) {
  if (end - begin < kWorthThreads) {
    for (; begin < end; ++begin) kernel(begin);
  } else {
    const thrust::counting_iterator<std::int64_t> zero(0);
    thrust::for_each(thrust::device, zero + begin, zero + end, kernel);
  }
}

template <class Kernel, class Value, class Merge>
Value reduce_all(Memory& /*memory*/, std::int64_t end, Kernel kernel, Value start, Merge merge) {
  const thrust::counting_iterator<std::int64_t> zero(0);
  return with_policy(end, [&](const auto& policy) {
    return thrust::transform_reduce(policy, zero, zero + end, kernel, start, merge);
  });
}

/// One step, so that a job is polled between steps.
/// Many sources in two passes, since threads would wait for each other at a common number. The first one notes the bits in
/// place of the chosen labels.
template <class Source>
void gather(const Source& source, std::int64_t count) {
  const auto& flood = source.flood;
  std::int32_t& size = flood.progress->size[source.step % 3];
  if (count < kWorthThreads) {
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int32_t bits = source.bits(i);
      flood.add(source.face(i), bits, source.step, size);
      size += flood.number(bits);
    }
    return;
  }
  constexpr std::int64_t kRuns = 256;
  std::array<std::int32_t, kRuns + 1> first{size};
  const auto for_runs = [&](auto work) {
    const thrust::counting_iterator<std::int64_t> zero(0);
    thrust::for_each(thrust::device, zero, zero + kRuns,
                     [&](std::int64_t run) { work(run, run * count / kRuns, (run + 1) * count / kRuns); });
  };
  for_runs([&](std::int64_t run, std::int64_t begin, std::int64_t end) {
    std::int32_t found = 0;
    for (std::int64_t i = begin; i < end; ++i) found += flood.number(flood.chosen[i] = source.bits(i));
    first[run + 1] = found;
  });
  for (std::int64_t run = 0; run < kRuns; ++run) first[run + 1] += first[run];
  for_runs([&](std::int64_t run, std::int64_t begin, std::int64_t end) {
    std::int32_t at = first[run];
    for (std::int64_t i = begin; i < end; at += flood.number(flood.chosen[i++]))
      flood.add(source.face(i), flood.chosen[i], source.step, at);
  });
  size = first[kRuns];
}

/// One step, so that a job is polled between steps.
template <class Flood>
void repeat(const Flood& flood, std::int32_t step) {
  const std::int64_t size = flood.size(step);
  flood.progress->steps = size > 0 ? 1 : 0;
  for_all(0, size, [&](std::int64_t i) { flood.choose(i, step); });
  gather(flood.applied(step + 1), size);
}

template <class T>
cuda::atomic_ref<T, cuda::thread_scope_device> shared(T& number) {
  return cuda::atomic_ref<T, cuda::thread_scope_device>(number);
}
inline constexpr auto kRelaxed = cuda::memory_order_relaxed;

/// As many as startable_threads() has.
class Threads {
#ifdef _OPENMP
 public:
  explicit Threads(std::int32_t wanted) : before_(omp_get_max_threads()) {
    omp_set_num_threads(startable_threads(wanted));
  }
  ~Threads() { omp_set_num_threads(before_); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

 private:
  int before_;
#else
 public:
  explicit Threads(std::int32_t /*wanted*/) {}
#endif
};

}  // namespace isimp::parallel::ISIMP_DEVICE
