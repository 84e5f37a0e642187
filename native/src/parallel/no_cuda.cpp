// Replaces the CUDA part in a build without it.
#include "devices.h"

namespace isimp::parallel {

std::string cuda_obstacle() { return "it was left out of this build"; }

const Kernels& cuda_kernels() { return cpu_kernels(); }

}  // namespace isimp::parallel
