// The kernels as the C++ compiler makes them, for the CPU.
#include "kernels.cu"

namespace isimp::parallel {

const Kernels& cpu_kernels() { return on_cpu::device_kernels(); }

}  // namespace isimp::parallel
