#include "images/relief.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

namespace isimp::detail {

std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Vec3> sum(mesh.vertex_count(), Vec3::Zero());
  const auto v = mesh.vertices();
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 n = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
    for (const std::int32_t vertex : t) sum[vertex] += n;
  }
  std::vector<Eigen::Vector3f> normals(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) normals[i] = sum[i].normalized().cast<float>();
  return normals;
}

Eigen::Vector3f smooth_normal(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, std::int32_t face, float b,
                              float c) {
  const Triangle& t = mesh.triangles()[face];
  return (1 - b - c) * normals[t[0]] + b * normals[t[1]] + c * normals[t[2]];
}

Eigen::Vector3f Relief::operator()(std::int32_t face, float b, float c) const {
  Eigen::Vector3f n = smooth_normal(mesh_, normals_, face, b, c).normalized();
  if (look_.image[face] == kNone) return n;
  const float* t = look_.uv.data() + 6 * static_cast<std::size_t>(face);
  const float u1 = t[2] - t[0], v1 = t[3] - t[1], u2 = t[4] - t[0], v2 = t[5] - t[1];
  const float turn = u1 * v2 - u2 * v1;
  const Triangle& corner = mesh_.triangles()[face];
  const auto v = mesh_.vertices();
  const Eigen::Vector3f e1 = (v[corner[1]] - v[corner[0]]).cast<float>();
  const Eigen::Vector3f e2 = (v[corner[2]] - v[corner[0]]).cast<float>();
  const float sign = turn < 0 ? -1.0F : 1.0F;
  Eigen::Vector3f tangent = sign * (v2 * e1 - v1 * e2);
  tangent -= n.dot(tangent) * n;
  const float length = tangent.norm();
  if (!(std::abs(turn) > 0) || !(length > 0)) return n;  // no direction to bend it in
  tangent /= length;
  const Rgba stored = sampler_(face, b, c) / 127.5F - 1;
  const Eigen::Vector3f bent = stored[0] * tangent + stored[1] * sign * n.cross(tangent) + stored[2] * n;
  const float size = bent.norm();
  return size > 0 ? Eigen::Vector3f(bent / size) : n;
}

}  // namespace isimp::detail
