#pragma once

#include <cstdint>
#include <vector>

#include "complex/state.h"
#include "isimp/core/job.h"
#include "judge/defects.h"

namespace isimp::meshing {

/// Makes corners mirror in the plane of the partition, if it has one.
///
/// Charts are paired with their images, and corners by their charts. Corners along one border that the border's image
/// lacks are dropped or, if polygons become defective by that, added to the image. Then each pair is put at the mean of
/// the one and the other's image, and a corner that is its own image on the plane. If that makes a polygon defective, the
/// pair is put at the one and its image, else at the other and its image, else it stays.
/// Cost: O(corners log corners), and up to three trials a pair.
void mirror_corners(State& state, Defects& defects, Job& job);

/// By chart: the chart at its mirror image, kNone where there is none. Empty without a plane.
std::vector<std::int32_t> chart_images(const State& state);

/// How many corners lie exactly at the image of another one, or on the plane. 0 without a plane.
std::int32_t mirrored_corners(const State& state);

}  // namespace isimp::meshing
