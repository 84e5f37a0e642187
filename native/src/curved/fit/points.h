#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/partition/partition.h"
#include "isimp/partition/surface.h"

namespace isimp::curved {

using Some = std::vector<std::int32_t>;

/// The faces of a mesh by graph index, as curved patches are found in them.
class Faces {
 public:
  explicit Faces(const Surface& surface) : mesh_(&surface.mesh()), graph_(&surface.graph()) {}
  [[nodiscard]] const FaceGraph& graph() const { return *graph_; }
  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  [[nodiscard]] std::int32_t size() const { return graph_->size(); }
  [[nodiscard]] Vec3 normal(std::int32_t i) const {
    const FaceRecord& r = graph_->faces[i];
    return {r.nx, r.ny, r.nz};
  }
  /// As a share of the whole surface's area.
  [[nodiscard]] double area(std::int32_t i) const { return graph_->faces[i].area; }
  [[nodiscard]] Vec3 centre(std::int32_t i) const {
    const Triangle& t = mesh_->triangles()[graph_->mesh_face[i]];
    const auto v = mesh_->vertices();
    return (v[t[0]] + v[t[1]] + v[t[2]]) / 3;
  }

 private:
  const Mesh* mesh_;
  const FaceGraph* graph_;
};

/// Small regions of a partition as points of data. They take out the noise, since the vector area of a region depends
/// on its outline alone, and are dense where the surface bends.
struct Points {
  std::vector<double> area;  ///< shares of the whole surface's
  std::vector<Vec3> centre, normal;
  std::vector<Some> near;             ///< points that share an edge and have a normal within 33 degrees
  std::vector<std::int32_t> of_face;  ///< (n) by graph index; kNone where the face is not free

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(area.size()); }
  [[nodiscard]] double area_of(std::span<const std::int32_t> some) const {
    double sum = 0;
    for (const std::int32_t i : some) sum += area[i];
    return sum;
  }
};

/// \param small   (F) the small region of each face of the mesh, kNone where it is in none
/// \param locked  (n) by graph index, 1 where a face may get no other region; empty: none
/// Cost: O(F).
Points points_of(const Faces& faces, std::span<const std::int32_t> small, std::span<const std::uint8_t> locked,
                 Job& job);

}  // namespace isimp::curved
