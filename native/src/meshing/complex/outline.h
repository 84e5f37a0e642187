// The outline of a chart against the scan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"

namespace isimp::meshing {

/// The vector area between each chord of a chart and the boundary of the scan that it stands for, by chord.
std::vector<Vec3> areas_beyond_chords(const State& state, std::int32_t chart);

/// For each edge of a polygon of a chart: the number of the chord that it is, kNone for a diagonal.
std::vector<std::int32_t> chords_of(const State& state, std::int32_t chart, std::span<const std::int32_t> polygon);

/// The direction of the part of the scan that a polygon of a chart stands for: all surfaces with one outline have one
/// vector area. Diagonals stand for themselves, as straight lines between vertices of the scan.
/// \return unit; that of the chart where the outline has no area
Vec3 direction_on_scan(const State& state, std::int32_t chart, std::span<const std::int32_t> polygon,
                       std::span<const Vec3> beyond_chords);

}  // namespace isimp::meshing
