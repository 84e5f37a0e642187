#include "isimp/partition/keep_regions.h"

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

}  // namespace isimp
