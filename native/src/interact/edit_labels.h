#pragma once

#include <cstdint>
#include <span>

#include "isimp/core/check.h"
#include "isimp/mesh/face_graph.h"

namespace isimp {

/// mark: the label shown for a face of a held region, so that no local change moves a face from or to that region.
inline constexpr std::int32_t kHeld = -3;

/// Labels by graph index that lie in an array of n in the order of the mesh; labels of held regions are hidden.
struct EditLabels {
  std::int32_t* region;
  const FaceGraph* graph;
  std::span<const std::uint8_t> held = {};  ///< by region; empty: no region is held

  [[nodiscard]] std::int32_t get(std::int32_t i) const {
    if (i == graph->size()) return kNone;
    const std::int32_t r = region[graph->mesh_face[i]];
    ISIMP_ASSERT(held.empty() || r < static_cast<std::int32_t>(held.size()), "labels are of regions");
    return !held.empty() && r >= 0 && held[r] != 0 ? kHeld : r;
  }
  void set(std::int32_t i, std::int32_t r) const { region[graph->mesh_face[i]] = r; }
};

}  // namespace isimp
