// Finds short loops of edges around handles or through them.
#pragma once

#include <cstdint>
#include <vector>

#include "cleaning/close.h"
#include "isimp/core/threads.h"

namespace isimp::detail {

/// A loop of edges about a handle or through it.
struct HandleLoop {
  double length = 0;
  std::vector<std::int32_t> vertices;
};

/// Loops of at most `longest`, shortest first; several of each handle.
/// \param search  null: everywhere
/// Cost: O(F), and two trees of shortest paths over all vertices for a search everywhere.
std::vector<HandleLoop> find_loops(const MeshArrays& arrays, const Topology& topology, double longest,
                                   const HandleSearch* search, const Threads& threads, Job& job);

}  // namespace isimp::detail
