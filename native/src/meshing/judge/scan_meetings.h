#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/mesh.h"
#include "judge/judge.h"

namespace isimp::meshing {

/// Which regions of a partition meet in the scan itself. Their polygons may meet as well: no repair can part them.
class ScanMeetings {
 public:
  using Pair = std::array<std::int32_t, 2>;  ///< two regions in rising order, or one twice

  /// \param regions  their number; the labels in `face_region` are below it, or kNone
  /// \param patches  whether the patches that cover openings of the scan count as faces
  ScanMeetings(const Mesh& mesh, std::span<const std::int32_t> face_region, std::int32_t regions, bool patches)
      : mesh_(mesh), face_region_(face_region), patches_(patches), parts_(regions) {}

  /// Tests the pairs that have not been tested.
  /// Cost: O(F) at the first call, then O(n log n) for n faces of the regions of new pairs.
  void test(std::span<const Pair> pairs, const Threads& threads, const Job& job);
  /// Whether the regions of a pair meet elsewhere than in the vertices they share; false for a pair without a test.
  [[nodiscard]] bool meet(const Pair& pair) const {
    const auto found = meet_.find(pair);
    return found != meet_.end() && found->second;
  }

 private:
  void sort_faces();

  const Mesh& mesh_;
  std::span<const std::int32_t> face_region_;
  bool patches_;
  std::map<Pair, bool> meet_;
  std::vector<std::int32_t> start_, faces_;       // faces by region, made at first use
  std::vector<std::unique_ptr<ScanPart>> parts_;  // by region, each made at first use
};

}  // namespace isimp::meshing
