#pragma once

#include <cstdint>

#include "memory.h"

/// The differences between the back ends, so that the kernels need not know them. A back end's header has:
///
/// - ISIMP_KERNEL, which marks a function that runs on the device, and kName;
/// - device_new, device_delete and device_copy of memory.h;
/// - Readable<T>(memory, span): the caller's numbers where kernels can read them;
/// - for_all(begin, end, kernel): calls kernel(i) for i in [begin, end), in no order;
/// - reduce_all(memory, end, kernel, start, merge): the result of merge() over all kernel(i) for i in [0, end), in any
///   order;
/// - gather(source, count): for all i in [0, count), source.flood.add of source.face(i) and source.bits(i), each to a
///   place of its own in the queue of source.step;
/// - repeat(flood, step): up to a back end's number of steps, while flood.size(step) > 0: flood.choose(i, step) for all i
///   in [0, size), then gather(flood.applied(++step), size); sets flood.progress->steps to their number;
/// - shared(number): a number that kernels of one step change at the same time; the order must not matter;
/// - Threads(wanted): during its life, kernels that this thread starts use so many threads.
#ifdef ISIMP_DEVICE_HEADER  // device of a test
#include ISIMP_DEVICE_HEADER
#elif defined(__CUDACC__)
#include "device_cuda.h"
#else
#include "device_cpu.h"
#endif

namespace isimp::parallel::ISIMP_DEVICE {

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

}  // namespace isimp::parallel::ISIMP_DEVICE
