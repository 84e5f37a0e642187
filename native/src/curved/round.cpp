#include "isimp/curved/round.h"

#include <utility>

#include "cells/patches.h"
#include "cells/rounding.h"

namespace isimp {

Partition round_parts(const Surface& surface, Partition part, std::span<const std::int32_t> small,
                      const RoundLengths& lengths, std::span<const std::uint8_t> stays, Job& job) {
  using namespace curved;
  check_is_of(surface.mesh(), part);
  const Faces faces(surface);
  Scene scene = [&] {
    const Job::Stage stage(job, "finding round parts", 0.0, 0.8);
    return find_patches(faces, part, small, lengths, stays, job);
  }();
  if (scene.patches.empty()) return part;
  const Job::Stage stage(job, "cutting round parts", 0.8, 1.0);
  choose_grids(faces, scene, job);
  return with_cells(surface, part, std::move(scene), job);
}

}  // namespace isimp
