#include "inherited.h"

#include <string>
#include <vector>

#include "isimp/core/errors.h"

namespace isimp {

void take_how_found(Partition& part, const Partition& before) {
  part.bound = before.bound;
  part.distance_max = before.distance_max;
  part.smooth = before.smooth;
  part.tolerance = before.tolerance;
  part.noise = before.noise;
  part.snapped = before.snapped;
  part.symmetry = before.symmetry;
}

Partition inherited(Partition part, const Partition& before) {
  if (part.face_region.size() != before.face_region.size())
    throw InvalidInput("one partition has " + std::to_string(part.face_region.size()) + " faces, the other " +
                       std::to_string(before.face_region.size()));
  std::vector<std::int32_t> parent;
  for (const std::int32_t seed : part.region_seed) parent.push_back(before.face_region[seed]);
  const auto take = [&](auto& values, const auto& from) {
    if (from.empty()) return;
    values.resize(parent.size());
    for (std::size_t r = 0; r < parent.size(); ++r)
      if (parent[r] >= 0) values[r] = from[parent[r]];
  };
  take(part.region_locked, before.region_locked);
  take(part.region_held, before.region_held);
  if (before.bound > 0 || !before.region_held.empty()) {
    take(part.region_normal, before.region_normal);
    take(part.region_offset, before.region_offset);
  }
  take_how_found(part, before);
  part.proxies_asked = before.proxies_asked;
  part.proxies_needed = before.proxies_needed;
  part.parts_left_out = before.parts_left_out;
  part.area_left_out = before.area_left_out;
  return part;
}

}  // namespace isimp
