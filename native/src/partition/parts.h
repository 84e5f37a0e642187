#pragma once

#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/mesh/face_graph.h"

namespace isimp {

/// work: a loop over faces or vertices polls where these bits of its number are 0.
inline constexpr std::int32_t kPollMask = 0xffff;

/// The connected parts of the faces of a label.
struct Parts {
  std::vector<std::int32_t> of_face;  ///< by face of the mesh; kNone without a label
  std::int32_t count = 0;
};

/// Numbers the parts in the order of their first faces of the mesh.
/// \param label_of  the label of a face of the mesh; kNone if it has none
template <class Label>
Parts parts_of(const FaceGraph& graph, Label label_of, const Job& job) {
  Parts parts{std::vector<std::int32_t>(static_cast<std::size_t>(graph.size()), kNone)};
  std::vector<std::int32_t> stack;
  for (std::int32_t first = 0; first < graph.size(); ++first) {
    if ((first & kPollMask) == 0) job.poll();
    const std::int32_t label = label_of(first);
    if (label == kNone || parts.of_face[first] != kNone) continue;
    parts.of_face[first] = parts.count;
    stack.push_back(graph.graph_face[first]);
    while (!stack.empty()) {
      const std::int32_t i = stack.back();
      stack.pop_back();
      for (const std::int32_t j : graph.neighbours[i]) {
        if (j == graph.size()) continue;
        const std::int32_t g = graph.mesh_face[j];
        if (parts.of_face[g] != kNone || label_of(g) != label) continue;
        parts.of_face[g] = parts.count;
        stack.push_back(j);
      }
    }
    ++parts.count;
  }
  return parts;
}

}  // namespace isimp
