#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// Flooding by bursts: each region grows from its seed, the face of least error next, until every face has a region.
///
/// The plain way is one priority queue of (error, face, region). Two observations make it several times faster. (1)
/// Call the largest error popped yet the level of the water. A face at or below the level, next to the face just
/// popped, would be popped next, and for the same region: so it is labelled at once, by a depth-first walk (a burst)
/// without the queue. (2) The other entries come off the queue in rising order, so that it may be an array of lists,
/// one for each range of errors. Within a list the order is that of arrival, not of error: with `kSteps` lists to a
/// factor of two of error the total differs by chance alone.
///
/// A face waiting in a list stores the best region found yet: entries that are no better are never made. Every region
/// is connected and keeps its seed. Components without a seed stay kNone. The same input gives the same labels.
/// Cost: O(F + L) with L lists; each face is pushed about half a time.
/// Source: the order is that of Cohen-Steiner, Alliez, Desbrun 2004, section 3.3.
class Flooding {
 public:
  Flooding() : lists_(kLists) {}

  /// \param proxies, seeds  (R) of each region; the seeds are distinct graph indices
  /// \param label           (n + 1) is overwritten; kNone where no seed reaches
  void run(const FaceGraph& graph, std::span<const NormalMetric::Proxy> proxies, std::span<const std::int32_t> seeds,
           std::vector<std::int32_t>& label, Job& job);

  /// The list an error belongs to, and the upper end of its range.
  static std::int32_t list_of(float error) {
    const auto at = static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(error) >> kShift) - kBase;
    return at < 0 ? 0 : at >= kLists ? kLists - 1 : at;
  }
  static float upper_end(std::int32_t list) {
    return std::bit_cast<float>((static_cast<std::uint32_t>(list + kBase + 1) << kShift) - 1);
  }

 private:
  // work: the bits of a positive float rise with its value: exponent and four bits of mantissa number the lists.
  static constexpr std::int32_t kShift = 19, kSteps = 1 << (23 - kShift);
  static constexpr std::int32_t kBase = (127 - 24) * kSteps;  // work: errors below 2^-24 are rounding of the normals
  static constexpr std::int32_t kLists = (127 + 3) * kSteps - kBase;  // work: no error is above 4

  void burst(std::int32_t face, std::int32_t region);

  std::vector<std::vector<std::int32_t>> lists_;
  std::vector<std::int32_t> stack_;
  const FaceGraph* graph_ = nullptr;
  const NormalMetric::Proxy* proxies_ = nullptr;
  std::int32_t* label_ = nullptr;  // region, kNone, or the code of the region that waits for the face
  float level_ = -1.0F;
};

}  // namespace isimp
