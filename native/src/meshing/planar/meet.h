#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/threads.h"
#include "planar/fit.h"
#include "planar/unit.h"

namespace isimp::meshing::planar {

/// The units that have each corner, with its place in their loops.
struct Around {
  struct Use {
    std::int32_t unit, place;  ///< place in the unit's loop
  };
  Around() = default;
  Around(const std::vector<Unit>& units, std::int32_t corners);
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

/// rounding: largest distance of a corner from a plane that counts as its own, as a share of the diagonal.
constexpr double kOnPlane = 1e-7;

/// Puts each corner on the heaviest set of its planes that meet in a place where it may be, at the place nearest to its
/// start; if there is no such set, at its start. Units that do not bind have no plane.
/// \param at  (C) the new places of the corners
/// \return the corners that are on the plane of each unit
/// Cost: O(corners * 2^planes), at most 7 planes of each.
Kept meet(const std::vector<Unit>& units, const Around& around, const Places& places, const Threads& threads,
          const Job& job, std::vector<Vec3>& at);
/// The place of one corner by `meet`.
Vec3 meet_at(std::int32_t corner, const std::vector<Unit>& units, const Around& around, const Places& places);

}  // namespace isimp::meshing::planar
