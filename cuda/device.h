#pragma once

#include <thrust/device_vector.h>
#include <thrust/memory.h>

#include <cstdint>
#include <span>

#ifdef _OPENMP
#include <omp.h>
#endif

/// What differs between the back ends, so that kernels.cu need not know.
///
/// ISIMP_KERNEL marks a function that runs on the device.
#ifdef __CUDACC__
#define ISIMP_KERNEL __host__ __device__
#else
#define ISIMP_KERNEL
#endif

namespace isimp::parallel {

/// The caller's numbers where kernels can read them: in place on the CPU, a copy on a CUDA device.
template <class T>
class Readable {
 public:
  explicit Readable(std::span<const T> numbers) : numbers_(numbers.data(), numbers.data() + numbers.size()) {}
  [[nodiscard]] const T* data() const { return thrust::raw_pointer_cast(numbers_.data()); }

 private:
#ifdef __CUDACC__
  thrust::device_vector<T> numbers_;
#else
  std::span<const T> numbers_;
#endif
};

/// While it lives, kernels that this thread starts use so many threads; 0: as many as there are cores.
class Threads {
#ifdef _OPENMP
 public:
  explicit Threads(std::int32_t wanted) : before_(omp_get_max_threads()) {
    omp_set_num_threads(wanted > 0 ? wanted : omp_get_num_procs());
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
