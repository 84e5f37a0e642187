#pragma once

#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/scan.h>
#include <thrust/transform_reduce.h>

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

template <class From>
void scan_all(Memory& /*memory*/, From from, std::int64_t count, std::int32_t* to) {
  with_policy(count, [&](const auto& policy) { return thrust::exclusive_scan(policy, from, from + count, to); });
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
