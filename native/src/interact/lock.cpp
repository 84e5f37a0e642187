#include "isimp/interact/lock.h"

#include <algorithm>
#include <string>

#include "edit.h"
#include "isimp/core/errors.h"

namespace isimp {

Partition set_locked(const Mesh& mesh, const Partition& partition, std::span<const std::int32_t> faces,
                     std::uint8_t lock) {
  Edit edit(mesh, partition);
  if (faces.empty()) {
    const std::string purpose = lock == 0 ? "unlock" : lock == kLocked ? "lock" : "leave out";
    throw InvalidInput("there is no face: name one of each region to " + purpose);
  }
  std::vector<std::uint8_t>& flags = edit.result.region_locked;
  flags.resize(edit.result.region_sum.size(), 0);
  for (const std::int32_t face : faces) {
    const std::int32_t region = edit.result.face_region[edit.graph.mesh_face[edit.at(face)]];
    if (region == kNone) throw InvalidInput("face " + std::to_string(face) + " lies in a part that was left out");
    flags[region] = lock == kLocked ? std::max(flags[region], kLocked) : lock;
  }
  if (std::count(flags.begin(), flags.end(), 0) == static_cast<std::ptrdiff_t>(flags.size())) flags.clear();
  return std::move(edit.result);
}

}  // namespace isimp
