#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "images/sampler.h"
#include "isimp/mesh/mesh.h"
#include "isimp/texture/bake.h"

namespace isimp::detail {

/// Unit normals of the vertices, each face by its area.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh);

/// The normal interpolated between the normals of a face's corners; not of unit length.
Eigen::Vector3f smooth_normal(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, std::int32_t face, float b,
                              float c);

/// The scan's normals, bent by its own tangent-space normal map.
///
/// The tangent is the direction in which u grows on the face, at right angles to the smooth normal; the bitangent is
/// the same for v. So a mirrored chart or a face that a repair has reversed shows the relief of the scan.
class Relief {
 public:
  /// \throws InvalidInput  arrays that are not of this mesh
  Relief(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, const Appearance& appearance)
      : mesh_(mesh), normals_(normals), look_(appearance), sampler_(mesh, appearance) {}

  /// The shaded normal at a point of a face, a unit vector.
  Eigen::Vector3f operator()(std::int32_t face, float b, float c) const;

 private:
  const Mesh& mesh_;
  const std::vector<Eigen::Vector3f>& normals_;
  const Appearance& look_;
  Sampler sampler_;
};

}  // namespace isimp::detail
