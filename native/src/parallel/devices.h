// The kernels of each device.
#pragma once

#include <string>

#include "isimp/parallel/backend.h"

namespace isimp::parallel {

/// The kernels of cuda/kernels.cu as the C++ compiler makes them.
const Kernels& cpu_kernels();

/// The kernels compiled by nvcc; to be called only where `cuda_obstacle` finds none.
const Kernels& cuda_kernels();

/// The reason why CUDA does not work here ("no CUDA device was found"); "" if it works.
std::string cuda_obstacle();

}  // namespace isimp::parallel
