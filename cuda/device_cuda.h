#pragma once

#include <cooperative_groups.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/system/cuda/error.h>
#include <thrust/system/cuda/execution_policy.h>
#include <thrust/system_error.h>
#include <thrust/transform_reduce.h>

#include <cstdint>
#include <cuda/atomic>

#include "launch.h"
#include "memory.h"

#define ISIMP_KERNEL __host__ __device__

#include "gather.h"

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

template <class T>
ISIMP_KERNEL cuda::atomic_ref<T, cuda::thread_scope_device> shared(T& number) {
  return cuda::atomic_ref<T, cuda::thread_scope_device>(number);
}
inline constexpr auto kRelaxed = cuda::memory_order_relaxed;

/// One atomic operation for all threads of a warp that are here.
ISIMP_KERNEL inline std::int32_t reserve(std::int32_t& count, std::int32_t more) {
#ifdef __CUDA_ARCH__
  const unsigned here = __activemask(), lane = threadIdx.x % 32, before = (1U << lane) - 1;
  const unsigned ones = __ballot_sync(here, more & 1), twos = __ballot_sync(here, more & 2);
  const int leader = __ffs(static_cast<int>(here)) - 1;
  std::int32_t first = 0;
  if (static_cast<int>(lane) == leader) first = shared(count).fetch_add(__popc(ones) + 2 * __popc(twos), kRelaxed);
  return __shfl_sync(here, first, leader) + __popc(ones & before) + 2 * __popc(twos & before);
#else
  return shared(count).fetch_add(more, kRelaxed);
#endif
}

/// The device has threads of its own.
class Threads {
 public:
  explicit Threads(std::int32_t /*wanted*/) {}
};

/// The steps of a call of repeat: some milliseconds, after which a job is polled.
inline constexpr std::int32_t kStepsOfCall = 512;
inline constexpr int kThreadsOfStep = 512;
/// The most faces of a step that one block makes alone, without waiting for the others.
inline constexpr std::int32_t kFewFaces = 512;

/// Makes one step with the threads of a group: all blocks, or one block.
template <class Flood, class Group>
__device__ void make_step(const Flood& flood, std::int32_t step, std::int32_t size, const Group& group) {
  const auto first = static_cast<std::int32_t>(group.thread_rank()), threads = static_cast<std::int32_t>(group.size());
  for (std::int32_t i = first; i < size; i += threads) flood.choose(i, step);
  group.sync();
  const Gather gather{flood.applied(step + 1)};
  for (std::int32_t i = first; i < size; i += threads) gather(i);
  group.sync();
}

/// All blocks of the grid run at the same time, so they can wait for each other: the host starts no step.
template <class Flood>
__global__ void __launch_bounds__(kThreadsOfStep, 2) run_steps(Flood flood, std::int32_t step) {
  const auto grid = cooperative_groups::this_grid();
  const auto block = cooperative_groups::this_thread_block();
  std::int32_t steps = 0, size = flood.size(step);
  while (steps < kStepsOfCall && size > 0) {
    if (size > kFewFaces) {
      make_step(flood, step + steps++, size, grid);
    } else {
      for (; blockIdx.x == 0 && steps < kStepsOfCall && size > 0 && size <= kFewFaces; size = flood.size(step + steps))
        make_step(flood, step + steps++, size, block);
      if (grid.thread_rank() == 0) flood.progress->steps = steps;
      grid.sync();
      steps = flood.progress->steps;
    }
    size = flood.size(step + steps);
  }
  if (grid.thread_rank() == 0) flood.progress->steps = steps;
}

template <class Flood>
void repeat(Flood flood, std::int32_t step) {
  int device = 0, processors = 0;
  check(cudaGetDevice(&device));
  check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device));
  const dim3 blocks(static_cast<unsigned>(processors)), threads(kThreadsOfStep);
  void* arguments[] = {&flood, &step};
  check(cudaLaunchCooperativeKernel(run_steps<Flood>, blocks, threads, arguments, 0, nullptr));
}

}  // namespace isimp::parallel::ISIMP_DEVICE
