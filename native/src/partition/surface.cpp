#include "isimp/partition/surface.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/mesh/find_edge.h"
#include "parts.h"

namespace isimp {
namespace {

constexpr double kLeastWeight =
    1e-4;  // rounding: share of the largest: without any weight a face would have no normal either
constexpr double kLargest =
    1e30;  // rounding: largest of weights, so that they and their sums with areas stay finite as
           // float
constexpr double kSmallest = 1e-30;  // rounding: smallest, so that they do not vanish

std::string shown(double number) { return (std::ostringstream() << number).str(); }

void check_weights(const Mesh& mesh, std::span<const double> weights) {
  if (weights.size() != static_cast<std::size_t>(mesh.face_count()))
    throw InvalidInput("there are " + std::to_string(weights.size()) + " weights, but the mesh has " +
                       std::to_string(mesh.face_count()) + " faces: give one for each");
  for (std::size_t f = 0; f < weights.size(); ++f)
    if (!(weights[f] >= 0) || !std::isfinite(weights[f]))
      throw InvalidInput("the weight of face " + std::to_string(f) + " is " + shown(weights[f]) +
                         "; weights must be finite and at least 0");
  const auto largest = std::max_element(weights.begin(), weights.end());
  if (*largest <= 0) throw InvalidInput("all weights are 0; at least one must be above 0");
  if (*largest > kLargest || *largest < kSmallest)
    throw InvalidInput("the largest weight, that of face " + std::to_string(largest - weights.begin()) + ", is " +
                       shown(*largest) + "; the largest must be in [1e-30, 1e+30]");
}

void weigh(GuidedGraph& guided, std::span<const float> weights) {
  FaceGraph& graph = guided.graph;
  if (guided.weight.empty()) {
    guided.weight.assign(weights.begin(), weights.end());
  } else {
    for (std::size_t i = 0; i < weights.size(); ++i) guided.weight[i] *= weights[i];
  }
  std::vector<double> areas(weights.size());
  double total = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    areas[i] = static_cast<double>(weights[i]) * graph.faces[i].area;
    total += areas[i];
  }
  if (!(total > 0)) return;  // no face has an area
  for (std::size_t i = 0; i < areas.size(); ++i) graph.faces[i].area = static_cast<float>(areas[i] / total);
  graph.area *= total;
}

void cut(const Mesh& mesh, std::span<const std::array<std::int32_t, 2>> barriers, GuidedGraph& guided, Job& job) {
  FaceGraph& graph = guided.graph;
  for (std::size_t k = 0; k < barriers.size(); ++k) {
    if ((k & 0xffff) == 0) job.poll();
    const auto [a, b] = barriers[k];
    const std::int32_t h = find_edge(mesh, a, b);
    if (h == kNone)
      throw InvalidInput("barrier " + std::to_string(k) + " runs between vertices " + std::to_string(a) + " and " +
                         std::to_string(b) + ", but there is no such edge in the mesh");
    for (const std::int32_t side : {h, mesh.opposite(h)})
      if (side != kNone) graph.neighbours[graph.graph_face[Mesh::face(side)]][side % 3] = graph.size();
  }
  Parts parts = parts_of(
      graph, [](std::int32_t) { return 0; }, job);
  guided.component = std::move(parts.of_face);
  guided.component_count = parts.count;
}

}  // namespace

Surface::Surface(const Mesh& mesh, const Guides& guides, Job& job) : Surface(mesh) {
  if (!guides.weights.empty()) check_weights(mesh, guides.weights);
  if (guides.weights.empty() && guides.barriers.empty()) return;
  auto guided = std::make_shared<GuidedGraph>();
  guided->graph = mesh.graph();
  if (!guides.barriers.empty()) cut(mesh, guides.barriers, *guided, job);
  if (!guides.weights.empty()) {
    const double least = kLeastWeight * *std::max_element(guides.weights.begin(), guides.weights.end());
    std::vector<float> weights(guides.weights.size());
    for (std::int32_t i = 0; i < mesh.face_count(); ++i)
      weights[i] = static_cast<float>(std::max(guides.weights[mesh.graph().mesh_face[i]], least));
    weigh(*guided, weights);
  }
  guided_ = std::move(guided);
}

Surface Surface::weighted(std::span<const float> weights) const {
  auto guided = guided_ ? std::make_shared<GuidedGraph>(*guided_) : std::make_shared<GuidedGraph>();
  if (!guided_) guided->graph = mesh_->graph();
  weigh(*guided, weights);
  return {*mesh_, std::move(guided)};
}

std::vector<std::array<std::int32_t, 2>> separated_faces(const Surface& surface) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  if (!surface.guided()) return pairs;
  const Mesh& mesh = surface.mesh();
  const FaceGraph& graph = surface.graph();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (std::int32_t k = 0; k < 3; ++k) {
      const std::int32_t o = mesh.opposite(3 * f + k);
      if (o != kNone && f < o / 3 && graph.neighbours[graph.graph_face[f]][k] == graph.size())
        pairs.push_back({f, o / 3});
    }
  return pairs;
}

}  // namespace isimp
