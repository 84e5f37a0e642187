// The kernels, written once for all back ends: nvcc makes the CUDA ones of this file, the C++ compiler those of the
// CPU.
#include <thrust/copy.h>
#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/functional.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/system_error.h>
#include <thrust/transform_reduce.h>

#include <cmath>
#include <cuda/atomic>
#include <new>

#include "device.h"
#include "devices.h"
#include "isimp/core/errors.h"

namespace isimp::parallel {
namespace {

using Integer = long long;  // what CUDA has an atomic addition for

/// What one look at all faces finds.
struct Survey {
  float largest_area;
  std::int64_t first_bad;  ///< the first face whose numbers or label can't be used; N if there is none
};

struct LookAtFace {
  const float* faces;
  const std::int32_t* labels;
  std::int64_t count;
  std::int32_t regions;

  ISIMP_KERNEL Survey operator()(std::int64_t i) const {
    const float* f = faces + 4 * i;
    const float longest = 1.001F;  // squared, with room for rounding; written so that NaN fails
    const bool good = f[0] * f[0] + f[1] * f[1] + f[2] * f[2] <= longest && f[3] >= 0 && f[3] <= 3.4e38F &&
                      labels[i] >= -1 && labels[i] < regions;
    return {good ? f[3] : 0.0F, good ? count : i};
  }
};

struct MergeSurveys {
  ISIMP_KERNEL Survey operator()(const Survey& a, const Survey& b) const {
    return {a.largest_area < b.largest_area ? b.largest_area : a.largest_area,
            b.first_bad < a.first_bad ? b.first_bad : a.first_bad};
  }
};

/// Adds the faces of one run of kRun to the sums of their regions. Neighbours in memory mostly share a region, so a run
/// is added up first and goes out in a few atomic additions. Integers: the order in which they arrive is of no matter.
struct AddRun {
  static constexpr std::int64_t kRun = 16;

  const float* faces;
  const std::int32_t* labels;
  std::int64_t count;
  double scale;   ///< a power of two, so that the only rounding is that to an integer
  Integer* sums;  ///< (4 R) area, x, y, z

  ISIMP_KERNEL void operator()(std::int64_t run) const {
    const std::int64_t end = (run + 1) * kRun < count ? (run + 1) * kRun : count;
    std::int32_t region = -1;
    Integer sum[4] = {0, 0, 0, 0};
    for (std::int64_t i = run * kRun; i < end; ++i) {
      if (labels[i] != region) {
        add(region, sum);
        region = labels[i];
      }
      const float* f = faces + 4 * i;
      const double area = f[3] * scale;
      sum[0] += llrint(area);
      for (int k = 0; k < 3; ++k) sum[k + 1] += llrint(area * f[k]);
    }
    add(region, sum);
  }

 private:
  ISIMP_KERNEL void add(std::int32_t region, Integer (&sum)[4]) const {
    for (int k = 0; k < 4; ++k) {
      if (region >= 0) {
        cuda::atomic_ref<Integer, cuda::thread_scope_device>(sums[4 * static_cast<std::int64_t>(region) + k])
            .fetch_add(sum[k], cuda::memory_order_relaxed);
      }
      sum[k] = 0;
    }
  }
};

void check_lengths(std::size_t faces, std::size_t labels, std::int32_t regions, std::int32_t threads) {
  if (faces != 4 * labels)
    throw InvalidInput("fitting wants 4 numbers a label, but got " + std::to_string(faces) + " for " +
                       std::to_string(labels) + " labels");
  if (regions < 0) throw InvalidInput("regions must be at least 0, got " + std::to_string(regions));
  if (threads < 0) throw InvalidInput("threads must be at least 0, got " + std::to_string(threads));
}

std::string complaint(std::int64_t i, const float* f, std::int32_t label, std::int32_t regions) {
  if (label < -1 || label >= regions)
    return "face " + std::to_string(i) + " has label " + std::to_string(label) + ", but there are " +
           std::to_string(regions) + " regions";
  return "face " + std::to_string(i) + " needs a unit normal and a finite area that is not negative, but has (" +
         std::to_string(f[0]) + ", " + std::to_string(f[1]) + ", " + std::to_string(f[2]) + ") and " +
         std::to_string(f[3]);
}

std::vector<RegionSum> sum_up(std::span<const float> faces, std::span<const std::int32_t> labels,
                              std::int32_t regions) {
  const auto count = static_cast<std::int64_t>(labels.size());
  const Readable<float> read_faces(faces);
  const Readable<std::int32_t> read_labels(labels);
  const thrust::counting_iterator<std::int64_t> zero(0);

  const Survey survey = thrust::transform_reduce(thrust::device, zero, zero + count,
                                                 LookAtFace{read_faces.data(), read_labels.data(), count, regions},
                                                 Survey{0.0F, count}, MergeSurveys{});
  if (const std::int64_t bad = survey.first_bad; bad < count)
    throw InvalidInput(complaint(bad, &faces[4 * bad], labels[bad], regions));

  int exponent = 0;  // no sum can reach 2^exponent (1.001 of it with a normal's rounding), so 2^61 steps leave room
  std::frexp(static_cast<double>(survey.largest_area) * static_cast<double>(count), &exponent);
  const int shift = 61 - exponent;
  thrust::device_vector<Integer> sums(4 * static_cast<std::size_t>(regions), 0);
  thrust::for_each(thrust::device, zero, zero + (count + AddRun::kRun - 1) / AddRun::kRun,
                   AddRun{read_faces.data(), read_labels.data(), count, std::ldexp(1.0, shift),
                          thrust::raw_pointer_cast(sums.data())});

  std::vector<Integer> integers(sums.size());
  thrust::copy(sums.begin(), sums.end(), integers.begin());
  std::vector<RegionSum> result(static_cast<std::size_t>(regions));
  const auto real = [&](std::size_t i) { return std::ldexp(static_cast<double>(integers[i]), -shift); };
  for (std::size_t r = 0; r < result.size(); ++r)
    result[r] = {real(4 * r), real(4 * r + 1), real(4 * r + 2), real(4 * r + 3)};
  return result;
}

class DeviceKernels final : public Kernels {
 public:
  std::vector<RegionSum> fit(std::span<const float> faces, std::span<const std::int32_t> labels, std::int32_t regions,
                             std::int32_t threads) const override {
    check_lengths(faces.size(), labels.size(), regions, threads);
    const Threads limit(threads);
    try {
      return sum_up(faces, labels, regions);
    } catch (const std::bad_alloc&) {
      throw Error("fitting " + std::to_string(labels.size()) + " faces ran out of memory on back end '" + kName + "'");
    } catch (const thrust::system_error& e) {
      throw Error(std::string("fitting failed on back end '") + kName + "': " + e.what());
    }
  }

 private:
#ifdef __CUDACC__
  static constexpr const char* kName = "cuda";
#else
  static constexpr const char* kName = "cpu";
#endif
};

}  // namespace

#ifdef __CUDACC__

namespace {
__global__ void do_nothing() {}
}  // namespace

const Kernels& cuda_kernels() {
  static const DeviceKernels kernels;
  return kernels;
}

std::string cuda_obstacle() {
  int version = 0, devices = 0;
  if (cudaDriverGetVersion(&version) == cudaSuccess && version == 0) return "no CUDA driver was found";
  cudaError_t error = cudaGetDeviceCount(&devices);
  if (error == cudaErrorNoDevice || (error == cudaSuccess && devices == 0)) return "no CUDA device was found";
  cudaFuncAttributes attributes;  // fails where this build has no code for the device
  if (error == cudaSuccess) error = cudaFuncGetAttributes(&attributes, do_nothing);
  return error == cudaSuccess ? "" : cudaGetErrorString(error);
}

#else

const Kernels& cpu_kernels() {
  static const DeviceKernels kernels;
  return kernels;
}

#endif

}  // namespace isimp::parallel
