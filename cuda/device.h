#pragma once

#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/transform_reduce.h>

#include <cstdint>
#include <cuda/atomic>
#include <span>

#include "isimp/core/thread_count.h"
#include "memory.h"

#ifdef __CUDACC__
#include <thrust/system/cuda/execution_policy.h>
#endif
#ifdef _OPENMP
#include <omp.h>
#endif

/// What differs between the back ends, so that the kernels need not know.
///
/// ISIMP_KERNEL marks a function that runs on the device.
#ifdef __CUDACC__
#define ISIMP_KERNEL __host__ __device__
#else
#define ISIMP_KERNEL
#endif

namespace isimp::parallel {

#ifdef __CUDACC__
inline constexpr const char* kName = "cuda";
#else
inline constexpr const char* kName = "cpu";
#endif

/// The caller's numbers where kernels can read them: in place on the CPU, a copy on a CUDA device.
template <class T>
class Readable {
 public:
#ifdef __CUDACC__
  Readable(Memory& memory, std::span<const T> numbers) : numbers_(memory) {
    numbers_.assign(numbers.data(), numbers.size());
  }
#else
  Readable(Memory& /*memory*/, std::span<const T> numbers) : numbers_(numbers) {}
#endif
  [[nodiscard]] const T* data() const { return numbers_.data(); }

 private:
#ifdef __CUDACC__
  Array<T> numbers_;
#else
  std::span<const T> numbers_;
#endif
};

/// From how many steps on a CPU's threads are worth their start.
inline constexpr std::int64_t kWorthThreads = 1 << 13;

/// Calls work(policy) with where `count` steps are best done.
template <class Work>
auto with_policy([[maybe_unused]] Memory& memory, [[maybe_unused]] std::int64_t count, Work work) {
#ifdef __CUDACC__
  Scratch scratch{&memory};
  return work(thrust::cuda::par(scratch));
#else
  if (count < kWorthThreads) return work(thrust::seq);
  return work(thrust::device);
#endif
}

#ifdef __CUDACC__
template <class Kernel>
__global__ void run_kernel(std::int64_t begin, std::int64_t end, Kernel kernel) {
  const std::int64_t i = begin + blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < end) kernel(i);
}
#endif

/// Calls kernel(i) for i in [begin, end), in no order.
template <class Kernel>
void for_all(std::int64_t begin, std::int64_t end, Kernel kernel) {
  if (begin >= end) return;
#ifdef __CUDACC__  // not thrust::for_each, which takes nvcc ten times as long for each kernel
  constexpr std::int64_t kBlock = 256;
  run_kernel<<<static_cast<unsigned>((end - begin + kBlock - 1) / kBlock), kBlock>>>(begin, end, kernel);
  check(cudaGetLastError());
#else
  if (end - begin < kWorthThreads) {
    for (; begin < end; ++begin) kernel(begin);
  } else {
    const thrust::counting_iterator<std::int64_t> zero(0);
    thrust::for_each(thrust::device, zero + begin, zero + end, kernel);
  }
#endif
}

template <class T>
struct Set {
  T* to;
  T value;
  ISIMP_KERNEL void operator()(std::int64_t i) const { to[i] = value; }
};
template <class T>
void set_all(Array<T>& array, T value) {
  for_all(0, static_cast<std::int64_t>(array.size()), Set<T>{array.data(), value});
}

/// What merge() makes of all kernel(i) for i in [0, end), in any order.
template <class Kernel, class Value, class Merge>
Value reduce_all(Memory& memory, std::int64_t end, Kernel kernel, Value start, Merge merge) {
  const thrust::counting_iterator<std::int64_t> zero(0);
  return with_policy(memory, end, [&](const auto& policy) {
    return thrust::transform_reduce(policy, zero, zero + end, kernel, start, merge);
  });
}

/// A number that kernels of one step change at the same time; the order must not matter.
template <class T>
ISIMP_KERNEL cuda::atomic_ref<T, cuda::thread_scope_device> shared(T& number) {
  return cuda::atomic_ref<T, cuda::thread_scope_device>(number);
}
inline constexpr auto kRelaxed = cuda::memory_order_relaxed;

/// While it lives, kernels that this thread starts use so many threads, as startable_threads() has them.
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

}  // namespace isimp::parallel
