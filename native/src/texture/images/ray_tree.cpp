#include "images/ray_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace isimp::detail {

RayTree::RayTree(const Mesh& mesh, std::span<const std::int32_t> some, Job& job) {
  const auto corner = [&](std::int32_t f, int k) -> Eigen::Vector3f {
    return mesh.vertices()[mesh.triangles()[f][k]].cast<float>();
  };
  std::vector<meshing::NumberedBox> boxes;
  boxes.reserve(some.size());
  for (const std::int32_t f : some) {
    const Eigen::Array3f a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    meshing::NumberedBox& face = boxes.emplace_back();
    face.index = f;
    face.box.low.head<3>() = a.min(b).min(c);
    face.box.high.head<3>() = a.max(b).max(c);
  }
  tree_ = meshing::BoxTree(std::move(boxes), &job);
  faces_.reserve(tree_.size());
  for (std::int32_t place = 0; place < static_cast<std::int32_t>(some.size()); ++place) {
    const std::int32_t f = tree_.at(place).index;
    const Eigen::Vector3f a = corner(f, 0);
    faces_.push_back({a, corner(f, 1) - a, corner(f, 2) - a, f});
  }
}

/// Moeller and Trumbore 1997, from both sides.
bool RayTree::hits_face(const Face& face, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                        float reach) const {
  const Eigen::Vector3f p = direction.cross(face.v);
  const float det = face.u.dot(p);
  if (det == 0) return false;
  const float over = 1 / det;
  const Eigen::Vector3f s = origin - face.corner;
  const float b = s.dot(p) * over;
  if (!(b >= 0 && b <= 1)) return false;
  const Eigen::Vector3f q = s.cross(face.u);
  const float c = direction.dot(q) * over;
  if (!(c >= 0 && b + c <= 1)) return false;
  const float t = face.v.dot(q) * over;
  return t > 0 && t <= reach;
}

bool RayTree::hits(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float reach,
                   std::int32_t skip) const {
  const Eigen::Array3f from = origin.array(), over = direction.array().inverse();
  const auto misses = [&](const meshing::Box& around) {
    const Eigen::Array3f a = (around.low.head<3>() - from) * over, b = (around.high.head<3>() - from) * over;
    const float enter = std::max(a.min(b).maxCoeff(), 0.0F), leave = std::min(a.max(b).minCoeff(), reach);
    return enter > leave * 1.00001F;  // a face in a side of its box counts
  };
  return tree_.any_place(misses, [&](std::int32_t place) {
    const Face& face = faces_[place];
    return face.number != skip && hits_face(face, origin, direction, reach);
  });
}

}  // namespace isimp::detail
