#include "flooding.h"

#include <algorithm>

#include "isimp/core/prefetch.h"

namespace isimp {
namespace {

/// Label of a face that waits in a list for a region, and back: below kNone, so that labels from 0 up are settled.
constexpr std::int32_t waiting(std::int32_t region) { return -2 - region; }

}  // namespace

void Flooding::burst(std::int32_t face, std::int32_t region) {
  const NormalMetric::Proxy proxy = proxies_[region];
  const FaceRecord* faces = graph_->faces.data();
  const auto* neighbours = graph_->neighbours.data();
  for (;;) {
    for (const std::int32_t next : neighbours[face]) {
      const std::int32_t old = label_[next];
      if (old >= 0) continue;
      const float error = NormalMetric::error(faces[next], proxy);
      if (error <= level_) {
        label_[next] = region;
        stack_.push_back(next);
        continue;
      }
      if (old != kNone && error >= NormalMetric::error(faces[next], proxies_[waiting(old)])) continue;
      label_[next] = waiting(region);
      lists_[list_of(error)].push_back(next);
    }
    if (stack_.empty()) return;
    face = stack_.back();
    stack_.pop_back();
  }
}

void Flooding::run(const FaceGraph& graph, std::span<const NormalMetric::Proxy> proxies,
                   std::span<const std::int32_t> seeds, std::vector<std::int32_t>& label, Job& job) {
  const std::int32_t n = graph.size();
  label.assign(static_cast<std::size_t>(n) + 1, kNone);
  label[n] = 0;  // the sentinel counts as settled while the water rises
  graph_ = &graph;
  proxies_ = proxies.data();
  label_ = label.data();
  for (auto& list : lists_) list.clear();
  stack_.clear();
  level_ = -1.0F;
  const auto count = static_cast<std::int32_t>(seeds.size());
  for (std::int32_t r = 0; r < count; ++r) label_[seeds[r]] = r;
  for (std::int32_t r = 0; r < count; ++r) burst(seeds[r], r);
  std::uint32_t polled = 0;
  for (std::int32_t k = 0; k < kLists; ++k) {
    level_ = upper_end(k);
    // Nothing is pushed to this list any more: faces at or below the level are labelled by bursts.
    const std::vector<std::int32_t>& list = lists_[k];
    const std::size_t size = list.size();
    for (std::size_t i = 0; i < size; ++i) {
      if ((++polled & 0xfff) == 0) job.poll();
      if (i + 8 < size) {
        prefetch(&label_[list[i + 8]]);
        prefetch(&graph.neighbours[list[i + 8]]);
      }
      if (i + 4 < size)
        for (const std::int32_t j : graph.neighbours[list[i + 4]]) {
          prefetch(&label_[j]);
          prefetch(&graph.faces[j]);
        }
      const std::int32_t face = list[i];
      if (label_[face] >= 0) continue;
      const std::int32_t region = waiting(label_[face]);
      label_[face] = region;
      burst(face, region);
    }
  }
  label[n] = kNone;
}

}  // namespace isimp
