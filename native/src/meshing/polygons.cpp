#include "polygons.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace isimp::meshing {

Polygons collect_polygons(const Complex& complex, const Labels& labels) {
  const Mesh& mesh = labels.mesh;
  Polygons p;
  std::vector<std::int32_t> corner_of(mesh.vertex_count(), kNone);
  p.start.push_back(0);
  for (std::int32_t l = 0; l < labels.piece_count(); ++l) {
    for (const std::int32_t h : complex.chords(l)) {
      std::int32_t& c = corner_of[mesh.from(h)];
      if (c == kNone) {
        c = p.corner_count();
        p.vertex.push_back(mesh.from(h));
      }
      p.corners.push_back(c);
    }
    p.piece.push_back(l);
    p.start.push_back(static_cast<std::int32_t>(p.corners.size()));
  }
  p.around_start.assign(p.vertex.size() + 1, 0);
  for (const std::int32_t c : p.corners) ++p.around_start[c + 1];
  std::partial_sum(p.around_start.begin(), p.around_start.end(), p.around_start.begin());
  std::vector<std::int32_t> fill(p.around_start.begin(), p.around_start.end() - 1);
  p.around.resize(p.corners.size());
  for (std::int32_t q = 0; q < p.count(); ++q)
    for (const std::int32_t c : p.of(q)) p.around[fill[c]++] = q;
  return p;
}

Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = position[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (position[polygon[i]] - origin).cross(position[polygon[i + 1]] - origin);
  return sum / 2;
}

double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  const Vec3 area = vector_area(polygon, position);
  const double length = area.norm();
  if (length == 0) return 0;
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t c : polygon) centre += position[c];
  centre /= static_cast<double>(polygon.size());
  double most = 0;
  for (const std::int32_t c : polygon) most = std::max(most, std::abs((position[c] - centre).dot(area)) / length);
  return most;
}

}  // namespace isimp::meshing
