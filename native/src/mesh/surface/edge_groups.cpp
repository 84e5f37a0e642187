#include "surface/edge_groups.h"

#include <algorithm>
#include <utility>

namespace isimp::detail {
namespace {

void sort_entries(std::uint64_t* begin, std::uint64_t* end) {
  if (end - begin > 24) {  // insertion beats std::sort for fewer
    std::sort(begin, end);
    return;
  }
  for (std::uint64_t* i = begin; i < end; ++i) {
    const std::uint64_t x = *i;
    std::uint64_t* j = i;
    for (; j > begin && j[-1] > x; --j) *j = j[-1];
    *j = x;
  }
}

}  // namespace

EdgeGroups::EdgeGroups(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job)
    : entries_(3 * triangles.size()), bucket_end_(vertex_count, 0) {
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    if (f % kPollEvery == 0) job.poll();
    const auto& [a, b, c] = triangles[f];
    ++bucket_end_[std::min(a, b)];
    ++bucket_end_[std::min(b, c)];
    ++bucket_end_[std::min(c, a)];
  }
  std::uint32_t begin = 0;
  for (std::uint32_t& end : bucket_end_) begin += std::exchange(end, begin);  // now the start of each bucket
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    if (f % kPollEvery == 0) job.poll();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangles[f][k], to = triangles[f][k == 2 ? 0 : k + 1];
      const auto larger = static_cast<std::uint64_t>(std::max(from, to));
      entries_[bucket_end_[std::min(from, to)]++] = larger << 32 | (3 * f + k);
    }
  }
  begin = 0;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    if (v % kPollEvery == 0) job.poll();
    sort_entries(entries_.data() + begin, entries_.data() + bucket_end_[v]);
    begin = bucket_end_[v];
  }
}

}  // namespace isimp::detail
