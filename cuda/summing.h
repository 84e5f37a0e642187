#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "device.h"
#include "isimp/core/errors.h"
#include "isimp/parallel/sums.h"

/// Sums over the faces of each region, of integers, so that the order of adding does not matter.
namespace isimp::parallel::ISIMP_DEVICE {

using Integer = long long;  // the type of CUDA's atomic addition

/// The result of one pass over all faces.
struct Survey {
  double largest_area;     ///< not a float, so that no byte between the two is copied before it is set
  std::int64_t first_bad;  ///< the first face whose numbers or label can't be used; N if there is none
};

struct LookAtFace {
  const float* faces;
  const std::int32_t* labels;  ///< null: no labels to check
  std::int64_t count;
  std::int32_t regions;

  ISIMP_KERNEL Survey operator()(std::int64_t i) const {
    const float* f = faces + 4 * i;
    const float longest = 1.001F;  // squared, with room for rounding; written so that NaN fails
    const bool good = f[0] * f[0] + f[1] * f[1] + f[2] * f[2] <= longest && f[3] >= 0 && f[3] <= 3.4e38F &&
                      (labels == nullptr || (labels[i] >= -1 && labels[i] < regions));
    return {good ? f[3] : 0.0, good ? count : i};
  }
};

struct MergeSurveys {
  ISIMP_KERNEL Survey operator()(const Survey& a, const Survey& b) const {
    return {a.largest_area < b.largest_area ? b.largest_area : a.largest_area,
            b.first_bad < a.first_bad ? b.first_bad : a.first_bad};
  }
};

inline Survey survey(Memory& memory, const float* faces, const std::int32_t* labels, std::int64_t count,
                     std::int32_t regions) {
  return reduce_all(memory, count, LookAtFace{faces, labels, count, regions}, Survey{0.0, count}, MergeSurveys{});
}

inline std::string complaint(std::int64_t i, const float* f) {
  return "face " + std::to_string(i) + " needs a unit normal and a finite area that is not negative, but has (" +
         std::to_string(f[0]) + ", " + std::to_string(f[1]) + ", " + std::to_string(f[2]) + ") and " +
         std::to_string(f[3]);
}

/// The power of two by which areas are multiplied before they become integers: no sum can reach 2^61 then (1.001 of it
/// with a normal's rounding).
inline int shift_for(double largest_area, std::int64_t count) {
  int exponent = 0;
  std::frexp(largest_area * static_cast<double>(count), &exponent);
  return 61 - exponent;
}

/// Adds the faces of one run of kRun to the sums of their regions: area, area times normal, and area times centre where
/// there are kColumns = 7. Neighbours in memory mostly share a region, so a run is summed first and needs few atomic
/// additions.
template <int kColumns>
struct AddRun {
  static constexpr std::int64_t kRun = 16;

  const float* faces;
  const float* centres;  ///< (3 N) within [-1, 1]; null for 4 columns
  const std::int32_t* labels;
  std::int64_t count;
  double scale;   ///< a power of two, so that the only rounding is that to an integer
  Integer* sums;  ///< (kColumns R)

  ISIMP_KERNEL void operator()(std::int64_t run) const {
    const std::int64_t end = (run + 1) * kRun < count ? (run + 1) * kRun : count;
    std::int32_t region = -1;
    Integer sum[kColumns] = {};
    for (std::int64_t i = run * kRun; i < end; ++i) {
      if (labels[i] != region) {
        add(region, sum);
        region = labels[i];
      }
      const float* f = faces + 4 * i;
      const double area = f[3] * scale;
      sum[0] += llrint(area);
      for (int k = 0; k < 3; ++k) sum[k + 1] += llrint(area * f[k]);
      if constexpr (kColumns == 7)
        for (int k = 0; k < 3; ++k) sum[k + 4] += llrint(area * centres[3 * i + k]);
    }
    add(region, sum);
  }

 private:
  ISIMP_KERNEL void add(std::int32_t region, Integer (&sum)[kColumns]) const {
    for (int k = 0; k < kColumns; ++k) {
      if (region >= 0) shared(sums[kColumns * static_cast<std::int64_t>(region) + k]).fetch_add(sum[k], kRelaxed);
      sum[k] = 0;
    }
  }
};

/// The sums of all regions, kColumns for each, as real numbers.
template <int kColumns>
std::vector<double> sum_up(Memory& memory, const float* faces, const float* centres, const std::int32_t* labels,
                           std::int64_t count, std::int32_t regions, int shift) {
  Array<Integer> sums(memory, kColumns * static_cast<std::size_t>(regions));
  set_all(sums, Integer{0});
  constexpr std::int64_t kRun = AddRun<kColumns>::kRun;
  for_all(0, (count + kRun - 1) / kRun,
          AddRun<kColumns>{faces, centres, labels, count, std::ldexp(1.0, shift), sums.data()});
  const std::vector<Integer> integers = sums.read();
  std::vector<double> result(integers.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = std::ldexp(static_cast<double>(integers[i]), -shift);
  return result;
}

}  // namespace isimp::parallel::ISIMP_DEVICE
