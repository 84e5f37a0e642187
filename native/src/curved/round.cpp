#include "isimp/curved/round.h"

#include <algorithm>
#include <utility>

#include "patches.h"
#include "rounding.h"

namespace isimp {
namespace {

using namespace curved;

constexpr std::int32_t kFacesAPoint = 20, kFewestPoints = 120, kMostPoints = 450, kFinePoints = 700;
constexpr std::int32_t kFineFaces = 100000;

}  // namespace

std::int32_t round_points(std::int32_t faces) {
  const std::int32_t most = faces > kFineFaces ? kFinePoints : kMostPoints;
  return std::min(faces, std::clamp(faces / kFacesAPoint, kFewestPoints, most));
}

Partition round_parts(const Surface& surface, Partition part, const Partition& data, const RoundLengths& lengths,
                      std::span<const std::uint8_t> stays, Job& job) {
  check_is_of(surface.mesh(), part);
  check_is_of(surface.mesh(), data);
  const Faces faces(surface);
  Scene scene = [&] {
    const Job::Part stage(job, "finding round parts", 0.0, 0.8);
    return find_patches(faces, part, data, lengths, stays, job);
  }();
  if (scene.patches.empty()) return part;
  const Job::Part stage(job, "cutting round parts", 0.8, 1.0);
  choose_grids(faces, scene, std::max(0.3 * lengths.tolerance, 2.5 * lengths.noise), job);
  return with_cells(surface, part, std::move(scene), job);
}

}  // namespace isimp
