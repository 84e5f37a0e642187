#include "kept_mesh.h"

namespace isimp::bindings {

std::span<const Vec3> KeptMesh::placed_vertices() const {
  if (origin().isZero(0)) return vertices();
  std::call_once(once_placed_, [&] {
    placed_.assign(vertices().begin(), vertices().end());
    for (Vec3& v : placed_) v += origin();
  });
  return placed_;
}

}  // namespace isimp::bindings
