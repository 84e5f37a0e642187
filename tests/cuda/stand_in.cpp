#include "stand_in.h"

#include <cuda_runtime_api.h>

#include <cstdlib>
#include <cstring>
#include <map>
#include <utility>

namespace isimp::stand_in {
namespace {

struct State {
  Settings settings;
  Record record;
  std::map<std::uintptr_t, std::size_t> blocks;
  std::size_t held = 0;
  cudaError_t last = cudaSuccess;
  dim3 grid, block;
};
State& state() {
  static State one;
  return one;
}

/// The result of a call that may fail.
cudaError_t result(cudaError_t error = cudaSuccess) {
  State& s = state();
  if (s.record.calls++ == s.settings.failing) error = static_cast<cudaError_t>(s.settings.error);
  if (error != cudaSuccess) s.last = error;
  return error;
}

void note_stream(cudaStream_t stream) {
  if (stream != nullptr && stream != cudaStreamLegacy) ++state().record.other_streams;
}

/// Whether an address on the device has this many bytes behind it; main memory of the caller is always valid.
bool is_sound(const void* at, std::size_t bytes) {
  const auto address = reinterpret_cast<std::uintptr_t>(at);
  auto block = state().blocks.upper_bound(address);
  if (block == state().blocks.begin()) return true;
  --block;
  return address >= block->first + block->second || address + bytes <= block->first + block->second;
}

cudaError_t copy(void* to, const void* from, std::size_t bytes, cudaStream_t stream) {
  note_stream(stream);
  const cudaError_t error = result();
  if (error != cudaSuccess) return error;
  if (!is_sound(to, bytes) || !is_sound(from, bytes)) {
    ++state().record.misused;
    return result(cudaErrorInvalidValue);
  }
  std::memcpy(to, from, bytes);
  return cudaSuccess;
}

cudaError_t launch(dim3 grid, dim3 block, cudaStream_t stream) {
  note_stream(stream);
  const std::uint64_t blocks = std::uint64_t{grid.x} * grid.y * grid.z, threads = std::uint64_t{block.x} * block.y;
  state().record.launches.push_back({blocks, threads * block.z});
  const bool good = blocks > 0 && grid.x < (1U << 31) && threads > 0 && threads <= 1024;
  return result(good ? cudaSuccess : cudaErrorInvalidConfiguration);
}

}  // namespace

void set(const Settings& settings) {
  state().settings = settings;
  state().record = {};
  state().last = cudaSuccess;
  for (const auto& [address, bytes] : state().blocks)
    std::memset(reinterpret_cast<void*>(address), settings.filling, bytes);
}

Record record() {
  Record record = state().record;
  record.live = static_cast<std::int64_t>(state().blocks.size());
  return record;
}

}  // namespace isimp::stand_in

using isimp::stand_in::state;

extern "C" {

cudaError_t cudaMalloc(void** block, size_t bytes) {
  auto& s = state();
  s.record.wanted.push_back(bytes);
  const bool fits = bytes <= s.settings.most - s.held;
  const cudaError_t error = isimp::stand_in::result(fits ? cudaSuccess : cudaErrorMemoryAllocation);
  if (error != cudaSuccess) return error;
  *block = std::malloc(bytes);
  if (*block == nullptr) return isimp::stand_in::result(cudaErrorMemoryAllocation);
  std::memset(*block, s.settings.filling, bytes);
  s.blocks[reinterpret_cast<std::uintptr_t>(*block)] = bytes;
  s.held += bytes;
  return cudaSuccess;
}
cudaError_t cudaFree(void* block) {
  auto& s = state();
  if (block == nullptr) return cudaSuccess;
  const auto at = s.blocks.find(reinterpret_cast<std::uintptr_t>(block));
  if (at == s.blocks.end()) {
    ++s.record.misused;
    return isimp::stand_in::result(cudaErrorInvalidValue);
  }
  s.held -= at->second;
  s.blocks.erase(at);
  std::free(block);
  return isimp::stand_in::result();  // an error of an earlier kernel may be reported here
}
cudaError_t cudaMemcpy(void* to, const void* from, size_t bytes, cudaMemcpyKind /*kind*/) {
  return isimp::stand_in::copy(to, from, bytes, nullptr);
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, size_t bytes, cudaMemcpyKind /*kind*/, cudaStream_t stream) {
  return isimp::stand_in::copy(to, from, bytes, stream);
}
cudaError_t cudaStreamSynchronize(cudaStream_t /*stream*/) { return isimp::stand_in::result(); }

cudaError_t cudaGetLastError() { return std::exchange(state().last, cudaSuccess); }
cudaError_t cudaPeekAtLastError() { return state().last; }
const char* cudaGetErrorName(cudaError_t /*error*/) { return "an error"; }
const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaErrorMemoryAllocation ? "out of memory" : "the device met an error";
}

cudaError_t cudaGetDevice(int* device) {
  *device = 0;
  return cudaSuccess;
}
cudaError_t cudaSetDevice(int /*device*/) { return cudaSuccess; }
cudaError_t cudaGetDeviceCount(int* count) {
  *count = state().settings.devices;
  return *count > 0 ? cudaSuccess : cudaErrorNoDevice;
}
cudaError_t cudaDriverGetVersion(int* version) {
  *version = 13000;
  return cudaSuccess;
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int /*device*/) {
  *value = attribute == cudaDevAttrComputeCapabilityMajor   ? 9
           : attribute == cudaDevAttrComputeCapabilityMinor ? 0
           : attribute == cudaDevAttrMultiProcessorCount    ? 132
           : attribute == cudaDevAttrMaxGridDimX            ? 2147483647
                                                            : 65536;
  return cudaSuccess;
}
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* attributes, const void* /*function*/) {
  *attributes = {};
  attributes->ptxVersion = attributes->binaryVersion = 90;
  attributes->maxThreadsPerBlock = 1024;
  return cudaSuccess;
}
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags(int* blocks, const void* /*function*/, int /*size*/,
                                                                   size_t /*shared*/, unsigned /*flags*/) {
  *blocks = 4;
  return cudaSuccess;
}

cudaError_t cudaLaunchKernelExC(const cudaLaunchConfig_t* config, const void* /*function*/, void** /*arguments*/) {
  return isimp::stand_in::launch(config->gridDim, config->blockDim, config->stream);
}
cudaError_t cudaLaunchCooperativeKernel(const void* /*function*/, dim3 grid, dim3 block, void** /*arguments*/,
                                        size_t /*shared*/, cudaStream_t stream) {
  return isimp::stand_in::launch(grid, block, stream);
}
cudaError_t cudaLaunchKernel(const void* /*function*/, dim3 grid, dim3 block, void** /*arguments*/, size_t /*shared*/,
                             cudaStream_t stream) {
  return isimp::stand_in::launch(grid, block, stream);
}

// Functions that nvcc's own code calls.
cudaError_t __cudaLaunchKernel(cudaKernel_t /*kernel*/, dim3 grid, dim3 block, void** /*arguments*/, size_t /*shared*/,
                               cudaStream_t stream) {
  return isimp::stand_in::launch(grid, block, stream);
}
cudaError_t __cudaGetKernel(cudaKernel_t* kernel, const void* /*function*/) {
  *kernel = nullptr;
  return cudaSuccess;
}
unsigned __cudaPushCallConfiguration(dim3 grid, dim3 block, size_t /*shared*/, CUstream_st* /*stream*/) {
  state().grid = grid;
  state().block = block;
  return 0;
}
cudaError_t __cudaPopCallConfiguration(dim3* grid, dim3* block, size_t* shared, void* stream) {
  *grid = state().grid;
  *block = state().block;
  *shared = 0;
  *static_cast<cudaStream_t*>(stream) = nullptr;
  return cudaSuccess;
}
void** __cudaRegisterFatBinary(void* /*binary*/) {
  static void* handle = nullptr;
  return &handle;
}
void __cudaRegisterFatBinaryEnd(void** /*handle*/) {}
void __cudaUnregisterFatBinary(void** /*handle*/) {}
void __cudaRegisterFunction(void** /*handle*/, const char* /*host*/, char* /*device*/, const char* /*name*/,
                            int /*limit*/, uint3* /*thread*/, uint3* /*block*/, dim3* /*block_dim*/, dim3* /*grid_dim*/,
                            int* /*warp*/) {}
void __cudaRegisterVar(void** /*handle*/, char* /*host*/, char* /*device*/, const char* /*name*/, int /*external*/,
                       size_t /*size*/, int /*constant*/, int /*global*/) {}

}  // extern "C"
