#include "complex/diagonal.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <vector>

namespace isimp::meshing {
namespace {

/// Whether two corners follow each other in some polygon.
bool are_joined(const Polygons& polygons, std::int32_t a, std::int32_t b) {
  for (const std::int32_t q : polygons.at(a)) {
    const auto loop = polygons.of(q);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::int32_t c = loop[i], d = loop[(i + 1) % loop.size()];
      if ((c == a && d == b) || (c == b && d == a)) return true;
    }
  }
  return false;
}

}  // namespace

std::array<std::int32_t, 2> best_diagonal(const State& state, std::int32_t polygon, const Vec3& normal) {
  const auto loop = state.polygons.of(polygon);
  const auto n = loop.size();
  const auto& at = state.corners.position;
  std::array<std::int32_t, 2> best{kNone, kNone};
  double least = std::numeric_limits<double>::max();
  std::vector<std::int32_t> a, b;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n && j - i + 1 < n; ++j) {
      if (are_joined(state.polygons, loop[i], loop[j])) continue;
      a.assign(loop.begin() + static_cast<std::ptrdiff_t>(i), loop.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      b.assign(loop.begin() + static_cast<std::ptrdiff_t>(j), loop.end());
      b.insert(b.end(), loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      double cost = std::max(bend_of(a, at), bend_of(b, at)) + 0.02 * (at[loop[i]] - at[loop[j]]).norm();
      if (vector_area(a, at).dot(normal) <= 0 || vector_area(b, at).dot(normal) <= 0) cost += state.mesh.diagonal();
      if (cost >= least) continue;
      least = cost;
      best = {state.corners.vertex[loop[i]], state.corners.vertex[loop[j]]};
    }
  return best;
}

}  // namespace isimp::meshing
