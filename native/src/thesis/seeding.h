#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "components.h"
#include "isimp/core/job.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Random numbers that are the same on every machine: the generator is fixed by the standard, the draw is our own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// A number in [0, bound), all equally likely.
  std::uint64_t below(std::uint64_t bound) {
    const std::uint64_t limit = UINT64_MAX - UINT64_MAX % bound;
    for (;;)
      if (const std::uint64_t draw = engine_(); draw < limit) return draw % bound;
  }

 private:
  std::mt19937_64 engine_;
};

/// Distinct faces drawn at random, `share[c]` of them in component c; where there are weights, by their roots.
/// \return graph indices, component by component
/// Source: the thesis's `init`.
std::vector<std::int32_t> random_seeds(const Surface& surface, const Components& components,
                                       const std::vector<std::int32_t>& share, std::uint64_t seed, Job& job);

/// In each component: first a face drawn at random, then always the one whose normal and place together are farthest
/// from all before. Distance squared is |n - n'|^2 + |p - p'|^2 / r^2, r the component's radius, times the root of the
/// weight.
/// Cost: O(F * P).
std::vector<std::int32_t> farthest_seeds(const Surface& surface, const Components& components,
                                         const std::vector<std::int32_t>& share, std::uint64_t seed, Job& job);

}  // namespace isimp
