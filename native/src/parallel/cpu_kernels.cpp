// The kernels as the C++ compiler makes them, for the CPU.
#include "kernels.cu"
