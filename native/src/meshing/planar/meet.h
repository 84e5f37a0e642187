#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "planar/fit.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// Which of the units round each corner have it, and on which of their planes it is.
struct Around {
  struct Use {
    std::int32_t unit, place;  ///< place in the unit's loop
  };
  explicit Around(const std::vector<Unit>& units, std::int32_t corners);
  [[nodiscard]] std::span<const Use> of(std::int32_t corner) const {
    return std::span(uses_).subspan(start_[corner], start_[corner + 1] - start_[corner]);
  }
  [[nodiscard]] std::int32_t corners() const { return static_cast<std::int32_t>(start_.size()) - 1; }

 private:
  std::vector<Use> uses_;
  std::vector<std::int32_t> start_;
};

/// By unit: whether it is one of some units or fewer than `rings` rings away from one.
std::vector<bool> within_rings(const std::vector<Unit>& units, const Around& around, std::vector<std::int32_t> rim,
                               int rings);

/// Largest distance of a corner from a plane that it is said to be on, as a share of the diagonal.
constexpr double kOnPlane = 1e-7;

/// Puts each corner on the heaviest set of the planes round it that meet in a place where it may be, the nearest such
/// place to where it started; on none, where that is where it started. Units that do not bind have no plane.
/// \param at  (C) where the corners are then
/// \return which corners are on the planes of which units
/// Cost: O(corners * 2^planes), at most 7 planes of each.
Kept meet(const std::vector<Unit>& units, const Around& around, const Places& places, const Threads& threads,
          const Job& job, std::vector<Vec3>& at);
/// The same for one corner.
/// \param kept  by unit, by place in its loop: what is said of this corner is changed
/// \return where it is then
Vec3 meet_at(std::int32_t corner, const std::vector<Unit>& units, const Around& around, const Places& places,
             Kept& kept);

}  // namespace isimp::meshing::planar
