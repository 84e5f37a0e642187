#include "judge/scan_meetings.h"

#include <numeric>

#include "isimp/core/sorted.h"

namespace isimp::meshing {

void ScanMeetings::test(std::span<const Pair> pairs, const Threads& threads, const Job& job) {
  struct New {
    Pair pair;
    bool* meet;
  };
  std::vector<New> fresh;
  std::vector<std::int32_t> wanted;
  for (const Pair& pair : pairs) {
    const auto [at, is_new] = meet_.try_emplace(pair, false);
    if (!is_new) continue;
    fresh.push_back({pair, &at->second});
    for (const std::int32_t r : pair)
      if (!parts_[r]) wanted.push_back(r);
  }
  if (fresh.empty()) return;
  sort_unique(wanted);
  sort_faces();
  threads.blocks(static_cast<std::int32_t>(wanted.size()), 1, [&](std::int32_t i, std::int32_t, std::int32_t) {
    job.poll();
    const std::int32_t r = wanted[i];
    parts_[r] = std::make_unique<ScanPart>(mesh_, std::span(faces_).subspan(start_[r], start_[r + 1] - start_[r]));
  });
  threads.blocks(static_cast<std::int32_t>(fresh.size()), 1, [&](std::int32_t i, std::int32_t, std::int32_t) {
    job.poll();
    *fresh[i].meet = scan_intersects(mesh_, *parts_[fresh[i].pair[0]], *parts_[fresh[i].pair[1]]);
  });
}

void ScanMeetings::sort_faces() {
  if (!start_.empty()) return;
  const auto source = mesh_.source_face();
  const auto counts = [&](std::int32_t f) { return face_region_[f] != kNone && (patches_ || source[f] != kNone); };
  start_.assign(parts_.size() + 1, 0);
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f)
    if (counts(f)) ++start_[face_region_[f] + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  faces_.resize(start_.back());
  std::vector<std::int32_t> fill(start_.begin(), start_.end() - 1);
  for (std::int32_t f = 0; f < mesh_.face_count(); ++f)
    if (counts(f)) faces_[fill[face_region_[f]]++] = f;
}

}  // namespace isimp::meshing
