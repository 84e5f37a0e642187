#pragma once

#include <string>

#include "isimp/parallel/backend.h"

namespace isimp::parallel {

/// The kernels of cuda/kernels.cu as the C++ compiler makes them.
const Kernels& cpu_kernels();

/// The same as nvcc makes them; only where `cuda_obstacle` finds none.
const Kernels& cuda_kernels();

/// What keeps CUDA from working here ("no CUDA device was found"); "" if nothing does.
std::string cuda_obstacle();

}  // namespace isimp::parallel
