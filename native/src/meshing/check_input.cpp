#include "check_input.h"

#include <cstdint>
#include <string>

#include "isimp/core/errors.h"
#include "isimp/core/options.h"

namespace isimp::meshing {

void check_input(const Mesh& mesh, const Partition& partition, const MeshingOptions& options) {
  check_fields(options);
  check_is_of(mesh, partition);
  const std::int32_t regions = partition.region_count();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t r = partition.face_region[f];
    if (r < kNone || r >= regions)
      throw InvalidInput("face " + std::to_string(f) + " is in region " + std::to_string(r) + ", but there are " +
                         std::to_string(regions) + " regions");
  }
}

}  // namespace isimp::meshing
