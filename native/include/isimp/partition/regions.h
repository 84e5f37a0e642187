#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// A partition during the computation: all arrays by graph index.
struct Regions {
  std::vector<std::int32_t> label;  ///< (n + 1) region of each face; kNone if left out, and for the sentinel
  std::vector<RegionSum> sum;       ///< (R)
  double off_planes = 0;            ///< error of the distances from planes, if these count

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(sum.size()); }
  /// Sum of the regions' errors, as a share of the whole surface's area.
  [[nodiscard]] double error() const {
    double total = 0.0;
    for (const RegionSum& s : sum) total += s.error();
    return total;
  }
};

/// Recomputes the sums of each region from its faces.
/// Cost: O(F), in sequence.
void sum_regions(const FaceGraph& graph, Regions& regions, Job& job, const Threads& threads = Threads(1));

/// The face of each region that is nearest to its proxy; ties to the lower graph index.
/// \return (R) graph indices
std::vector<std::int32_t> nearest_faces(const FaceGraph& graph, const Regions& regions, Job& job,
                                        const Threads& threads = Threads(1));

}  // namespace isimp
