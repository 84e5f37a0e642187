// Shortest paths on the scan, for cuts.
#include <algorithm>

#include "discs/discs.h"

namespace isimp::meshing {

void Search::start() {
  reached.clear();
  queue_.clear();
}

bool Search::reach(std::int32_t i, double d, std::int32_t from_via) {
  if (!reached.add(i) && !(d < distance[i])) return false;
  distance[i] = d;
  via[i] = from_via;
  queue_.push_back({d, i});
  std::push_heap(queue_.begin(), queue_.end());
  return true;
}

std::int32_t Search::take() {
  while (!queue_.empty()) {
    const Waiting nearest = queue_.front();
    std::pop_heap(queue_.begin(), queue_.end());
    queue_.pop_back();
    if (nearest.distance == distance[nearest.index]) return nearest.index;
  }
  return kNone;
}

Cutter::Cutter(Labels& l)
    : labels(l),
      vertices(l.mesh.vertex_count()),
      face_place(std::make_unique_for_overwrite<std::int32_t[]>(l.mesh.face_count())),
      vertex_loop(std::make_unique_for_overwrite<std::int32_t[]>(l.mesh.vertex_count())),
      vertex_marks(l.mesh.vertex_count()),
      blocked(l.mesh.vertex_count()),
      halfedge_marks(3 * static_cast<std::size_t>(l.mesh.face_count())),
      face_marks(l.mesh.face_count()) {}

}  // namespace isimp::meshing
