#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "surface/parallel_loops.h"

namespace isimp::detail {

/// The half-edges along one edge, in both directions, by number.
class EdgeGroup {
 public:
  explicit EdgeGroup(std::span<const std::uint64_t> entries) : entries_(entries) {}
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] std::int32_t operator[](std::size_t i) const {
    return static_cast<std::int32_t>(entries_[i] & 0xffffffffU);
  }

 private:
  std::span<const std::uint64_t> entries_;
};

/// The half-edges of triangles, grouped by edge.
///
/// Half-edge h = 3 * f + k runs along face f from its corner k to its corner k + 1.
/// Cost: O(V + F) by a counting sort on the smaller vertex; a vertex with d edges adds O(d log d). 24 bytes a face.
class EdgeGroups {
 public:
  EdgeGroups(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job);

  /// Calls visit(EdgeGroup) for every edge, by smaller vertex, then by larger.
  template <class Visit>
  void for_each(Job& job, Visit visit) const {
    std::size_t begin = 0;
    for (std::size_t v = 0; v < bucket_end_.size(); ++v) {
      if (v % kPollEvery == 0) job.poll();
      while (begin < bucket_end_[v]) {
        std::size_t end = begin + 1;
        while (end < bucket_end_[v] && entries_[end] >> 32 == entries_[begin] >> 32) ++end;
        visit(EdgeGroup(std::span(entries_).subspan(begin, end - begin)));
        begin = end;
      }
    }
  }

 private:
  std::vector<std::uint64_t> entries_;     // the edge's larger vertex above the half-edge
  std::vector<std::uint32_t> bucket_end_;  // (V) past the entries of the edges whose smaller vertex it is
};

}  // namespace isimp::detail
