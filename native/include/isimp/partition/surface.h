#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/mesh/mesh.h"

namespace isimp {

/// A caller's settings for single faces and edges.
struct Guides {
  /// (F) at least 0, the largest in [1e-30, 1e30]: factors of the faces' areas; empty: 1 everywhere. The density of
  /// regions grows with the root of the weight, so a painted density d needs the weight d^2. Weights below 1e-4 of the
  /// largest count as 1e-4 of it.
  std::vector<double> weights;
  /// (K) pairs of vertices, edges of the mesh that no region may cross.
  std::vector<std::array<std::int32_t, 2>> barriers;
};

/// Weights of faces, relative to their mean by area.
struct RelativeWeight {
  std::span<const float> weight;  ///< (n) by graph index; empty: 1 everywhere
  float mean = 1;
  [[nodiscard]] float of(std::int32_t i) const { return weight.empty() ? 1.0F : weight[i] / mean; }
};

/// A face graph changed by guides: other areas, or cut along barriers into other components.
struct GuidedGraph {
  FaceGraph graph;
  std::vector<float> weight;            ///< (n) by graph index, factors of the areas; empty: none
  std::vector<std::int32_t> component;  ///< (F) by face of the mesh, numbered by first face; empty: the mesh's own
  std::int32_t component_count = 0;     ///< where `component` is not empty
};

/// A mesh in the form for partitioning: its own face graph, or a guided one. A view: the mesh must outlive it.
class Surface {
 public:
  Surface(const Mesh& mesh) : Surface(mesh, nullptr) {}  // NOLINT(google-explicit-constructor): one without guides

  /// \param guided  null: the mesh's own graph
  Surface(const Mesh& mesh, std::shared_ptr<const GuidedGraph> guided) : mesh_(&mesh), guided_(std::move(guided)) {}

  /// \throws InvalidInput  the number of weights is not F; a weight is not finite or below 0; the largest is out of range;
  ///                       a barrier is not an edge
  Surface(const Mesh& mesh, const Guides& guides, Job& job);

  /// This surface with its areas multiplied once more.
  /// \param weights  (n) by graph index, above 0
  [[nodiscard]] Surface weighted(std::span<const float> weights) const;

  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  [[nodiscard]] const FaceGraph& graph() const { return guided_ ? guided_->graph : mesh_->graph(); }
  [[nodiscard]] std::span<const std::int32_t> component() const {
    return own_components() ? std::span(guided_->component) : mesh_->component();
  }
  [[nodiscard]] std::int32_t component_count() const {
    return own_components() ? guided_->component_count : mesh_->component_count();
  }
  /// (n) factors of the areas by graph index; empty: no factors.
  [[nodiscard]] std::span<const float> weight() const {
    return guided_ ? std::span<const float>(guided_->weight) : std::span<const float>();
  }
  [[nodiscard]] RelativeWeight relative_weight() const {
    const double area = mesh_->graph().area;
    return {weight(), area > 0 ? static_cast<float>(graph().area / area) : 1.0F};
  }
  [[nodiscard]] std::int32_t face_count() const { return mesh_->face_count(); }
  [[nodiscard]] const std::shared_ptr<const GuidedGraph>& guided() const { return guided_; }

 private:
  [[nodiscard]] bool own_components() const { return guided_ && !guided_->component.empty(); }

  const Mesh* mesh_;
  std::shared_ptr<const GuidedGraph> guided_;
};

/// The pairs of faces of the mesh that share an edge, but are no neighbours on the surface: a barrier separates them.
/// \return (K) by first face, the lower face of each pair first
/// Cost: O(F); nothing where there are no guides.
std::vector<std::array<std::int32_t, 2>> separated_faces(const Surface& surface);

}  // namespace isimp
