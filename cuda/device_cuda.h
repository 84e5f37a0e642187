#pragma once

#include <thrust/iterator/counting_iterator.h>
#include <thrust/scan.h>
#include <thrust/system/cuda/error.h>
#include <thrust/system/cuda/execution_policy.h>
#include <thrust/system_error.h>
#include <thrust/transform_reduce.h>

#include <cstdint>
#include <cuda/atomic>

#include "launch.h"
#include "memory.h"

#define ISIMP_KERNEL __host__ __device__

/// A CUDA device.
namespace isimp::parallel::ISIMP_DEVICE {

inline constexpr const char* kName = "cuda";

/// \throws thrust::system_error
inline void check(cudaError_t error) {
  if (error == cudaSuccess) return;
  (void)cudaGetLastError();  // or the next caller would get this error too
  throw thrust::system_error(error, thrust::cuda_category());
}
inline void* device_new(std::size_t bytes) {
  void* block = nullptr;
  const cudaError_t error = cudaMalloc(&block, bytes);
  if (error != cudaErrorMemoryAllocation) check(error);
  (void)cudaGetLastError();
  return block;
}
inline void device_delete(void* block) noexcept { (void)cudaFree(block); }
inline void device_copy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) check(cudaMemcpy(to, from, bytes, cudaMemcpyDefault));
}

template <class T>
using Readable = Copied<T>;

/// Provides Thrust with scratch memory for a sum or a scan.
struct Scratch {
  using value_type = char;
  Memory* memory;
  char* allocate(std::ptrdiff_t bytes) { return static_cast<char*>(memory->take(static_cast<std::size_t>(bytes))); }
  void deallocate(char* block, std::size_t /*bytes*/) { memory->give(block); }
};

template <class Kernel>
__global__ void run_kernel(std::int64_t begin, std::int64_t end, Kernel kernel) {
  const std::int64_t i = begin + blockIdx.x * static_cast<std::int64_t>(blockDim.x) + threadIdx.x;
  if (i < end) kernel(i);
}

/// Not thrust::for_each, which nvcc compiles ten times as long for each kernel.
template <class Kernel>
void for_all(std::int64_t begin, std::int64_t end, Kernel kernel) {
  if (begin >= end) return;
  run_kernel<<<static_cast<unsigned>(blocks_for(end - begin)), kThreadsOfBlock>>>(begin, end, kernel);
  check(cudaGetLastError());
}

template <class Kernel, class Value, class Merge>
Value reduce_all(Memory& memory, std::int64_t end, Kernel kernel, Value start, Merge merge) {
  Scratch scratch{&memory};
  const thrust::counting_iterator<std::int64_t> zero(0);
  return thrust::transform_reduce(thrust::cuda::par(scratch), zero, zero + end, kernel, start, merge);
}

template <class From>
void scan_all(Memory& memory, From from, std::int64_t count, std::int32_t* to) {
  Scratch scratch{&memory};
  thrust::exclusive_scan(thrust::cuda::par(scratch), from, from + count, to);
}

template <class T>
ISIMP_KERNEL cuda::atomic_ref<T, cuda::thread_scope_device> shared(T& number) {
  return cuda::atomic_ref<T, cuda::thread_scope_device>(number);
}
inline constexpr auto kRelaxed = cuda::memory_order_relaxed;

/// The device has threads of its own.
class Threads {
 public:
  explicit Threads(std::int32_t /*wanted*/) {}
};

}  // namespace isimp::parallel::ISIMP_DEVICE
