#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "judge/boxes.h"

namespace isimp::detail {

/// The faces of a mesh in a tree of boxes, to find whether a ray meets any of them.
class RayTree {
 public:
  /// \param some  the faces that stop rays
  /// Cost: O(F log F).
  RayTree(const Mesh& mesh, std::span<const std::int32_t> some, Job& job);

  /// Whether any face but `skip` lies along a ray, from its origin up to `reach` times its direction away.
  [[nodiscard]] bool hits(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float reach,
                          std::int32_t skip) const;

 private:
  struct Face {
    Eigen::Vector3f corner, u, v;  ///< the first corner, and the edges from there
    std::int32_t number = kNone;
  };

  [[nodiscard]] bool hits_face(const Face& face, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                               float reach) const;

  meshing::BoxTree tree_;
  std::vector<Face> faces_;  // by place in the tree
};

}  // namespace isimp::detail
