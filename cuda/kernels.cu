// The kernels, written once for all back ends: nvcc makes the CUDA kernels of this file, the C++ compiler the kernels
// of the CPU.
#include "device.h"
#include "device_flooder.h"
#include "devices.h"
#include "isimp/core/errors.h"
#include "summing.h"

namespace isimp::parallel {
namespace ISIMP_DEVICE {
namespace {

void check_lengths(std::size_t faces, std::size_t labels, std::int32_t regions, std::int32_t threads) {
  if (faces != 4 * labels)
    throw InvalidInput("fitting wants 4 numbers a label, but got " + std::to_string(faces) + " for " +
                       std::to_string(labels) + " labels");
  if (regions < 0) throw InvalidInput("regions must be at least 0, got " + std::to_string(regions));
  if (threads < 0) throw InvalidInput("threads must be at least 0, got " + std::to_string(threads));
}

std::vector<RegionSum> fit_regions(std::span<const float> faces, std::span<const std::int32_t> labels,
                                   std::int32_t regions) {
  const auto count = static_cast<std::int64_t>(labels.size());
  Memory memory(kNoLimit);
  const Readable<float> read_faces(memory, faces);
  const Readable<std::int32_t> read_labels(memory, labels);
  const Survey found = survey(memory, read_faces.data(), read_labels.data(), count, regions);
  if (const std::int64_t bad = found.first_bad; bad < count) {
    if (labels[bad] < -1 || labels[bad] >= regions)
      throw InvalidInput("face " + std::to_string(bad) + " has label " + std::to_string(labels[bad]) +
                         ", but there are " + std::to_string(regions) + " regions");
    throw InvalidInput(complaint(bad, &faces[4 * bad]));
  }
  const std::vector<double> sums = sum_up<4>(memory, read_faces.data(), nullptr, read_labels.data(), count, regions,
                                             shift_for(found.largest_area, count));
  std::vector<RegionSum> result(static_cast<std::size_t>(regions));
  for (std::size_t r = 0; r < result.size(); ++r)
    result[r] = {sums[4 * r], sums[4 * r + 1], sums[4 * r + 2], sums[4 * r + 3]};
  return result;
}

class DeviceKernels final : public Kernels {
 public:
  std::vector<RegionSum> fit(std::span<const float> faces, std::span<const std::int32_t> labels, std::int32_t regions,
                             std::int32_t threads) const override {
    check_lengths(faces.size(), labels.size(), regions, threads);
    const Threads limit(threads);
    return guarded("fitting", labels.size(), [&] { return fit_regions(faces, labels, regions); });
  }

  [[nodiscard]] std::unique_ptr<Flooder> load(const FloodSurface& surface, std::size_t most) const override {
    return guarded("loading", surface.faces.size() / 4, [&] { return load_flooder(surface, most); });
  }
};

}  // namespace

const Kernels& device_kernels() {
  static const DeviceKernels kernels;
  return kernels;
}

}  // namespace ISIMP_DEVICE

#ifdef __CUDACC__

namespace {
__global__ void do_nothing() {}
}  // namespace

const Kernels& cuda_kernels() { return on_cuda::device_kernels(); }

std::string cuda_obstacle() {
  int version = 0, devices = 0;
  if (cudaDriverGetVersion(&version) == cudaSuccess && version == 0) return "no CUDA driver was found";
  cudaError_t error = cudaGetDeviceCount(&devices);
  if (error == cudaErrorNoDevice || (error == cudaSuccess && devices == 0)) return "no CUDA device was found";
  cudaFuncAttributes attributes;  // fails where this build has no code for the device
  if (error == cudaSuccess) error = cudaFuncGetAttributes(&attributes, do_nothing);
  return error == cudaSuccess ? "" : cudaGetErrorString(error);
}

#endif

}  // namespace isimp::parallel
