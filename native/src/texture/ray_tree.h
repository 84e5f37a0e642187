#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"

namespace isimp::detail {

/// A tree of boxes over the faces of a mesh, to find whether a ray meets any of them.
///
/// Faces are split where the boxes' areas times their faces are least, of 16 places along the longest axis (Wald 2007,
/// On fast construction of SAH-based bounding volume hierarchies).
class RayTree {
 public:
  /// Cost: O(F log F).
  RayTree(const Mesh& mesh, Job& job);

  /// Whether any face but `skip` lies along a ray, from its origin up to `reach` times its direction away.
  [[nodiscard]] bool hits(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float reach,
                          std::int32_t skip) const;

 private:
  struct Node {
    Eigen::Array3f low, high;
    std::int32_t first = 0;  ///< first of the faces; of an inner node its second child, the first one follows it
    std::int32_t count = 0;  ///< number of faces; 0: an inner node
  };
  struct Face {
    Eigen::Vector3f corner, u, v;  ///< the first corner, and the edges from there
    std::int32_t number = kNone;
  };
  struct Builder;

  [[nodiscard]] bool hits_face(const Face& face, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                               float reach) const;

  std::vector<Node> nodes_;
  std::vector<Face> faces_;
};

}  // namespace isimp::detail
