#include "kept_planes.h"

#include <algorithm>
#include <optional>

#include "isimp/partition/keep_regions.h"
#include "kept_part.h"

namespace isimp::regular {

Partition on_kept_planes(const Mesh& mesh, const Partition& partition, const OnPlanes& operation, Job& job) {
  const auto& locked = partition.region_locked;
  const bool has_all = std::ranges::find(partition.face_region, kNone) == partition.face_region.end() ||
                       std::ranges::any_of(locked, [](std::uint8_t lock) { return lock >= kLeftOut; });
  if (has_all) return operation(mesh, partition);
  const std::optional<meshing::KeptPart> part = meshing::kept_part(mesh, partition, job);
  Partition out = operation(part->mesh, part->partition);
  to_whole_faces(out, part->face, partition.face_region.size());
  out.guided = partition.guided;
  if (out.region_count() == partition.region_count()) return out;
  out.error = 0;  // the sums are shares of the whole mesh
  for (const RegionSum& s : out.region_sum) out.error += s.error();
  out.error *= Surface(mesh, out.guided).graph().area;
  out.history.assign(1, out.error);
  return out;
}

}  // namespace isimp::regular
