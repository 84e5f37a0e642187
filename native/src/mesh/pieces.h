#pragma once

#include <algorithm>
#include <cstddef>

#include "isimp/core/job.h"

namespace isimp::detail {

/// Vertices or faces between two polls in a plain loop: about a millisecond of work.
inline constexpr std::size_t kPollEvery = 1 << 16;

/// Calls visit(i) for i in [0, n), polling the job between pieces.
template <class Visit>
void for_each_index(std::size_t n, Job& job, Visit visit) {
  for (std::size_t begin = 0; begin < n; begin += kPollEvery) {
    job.poll();
    const std::size_t end = std::min(n, begin + kPollEvery);
    for (std::size_t i = begin; i < end; ++i) visit(i);
  }
}

}  // namespace isimp::detail
