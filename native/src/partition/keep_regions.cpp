#include "isimp/partition/keep_regions.h"

#include <utility>
#include <vector>

namespace isimp {

void keep_regions(Partition& partition, std::span<const std::int32_t> regions) {
  const auto keep = [&](auto& values) {
    if (values.empty()) return;
    for (std::size_t r = 0; r < regions.size(); ++r) values[r] = values[regions[r]];
    values.resize(regions.size());
  };
  keep(partition.region_seed);
  keep(partition.region_normal);
  keep(partition.region_sum);
  keep(partition.region_offset);
  keep(partition.region_locked);
  keep(partition.region_held);
  keep(partition.region_cell);
}

void to_whole_faces(Partition& partition, std::span<const std::int32_t> face, std::size_t count) {
  std::vector<std::int32_t> labels(count, kNone);
  for (std::size_t k = 0; k < face.size(); ++k) labels[face[k]] = partition.face_region[k];
  partition.face_region = std::move(labels);
  for (std::int32_t& seed : partition.region_seed) seed = face[seed];
}

}  // namespace isimp
