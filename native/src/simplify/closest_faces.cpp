#include "closest_faces.h"

#include <algorithm>

#include "density/noise.h"
#include "isimp/simplify/within.h"
#include "rounded_box.h"

namespace isimp {
namespace {

constexpr double kFacing = 0.25;  // cosine of the angle between normals from which a face counts

}  // namespace

ClosestFaces::ClosestFaces(const Mesh& mesh, std::span<const std::int32_t> faces)
    : mesh_(mesh), least_(std::max(mean_edge(mesh), 1e-9 * mesh.diagonal())) {
  std::vector<meshing::NumberedBox> entries;
  entries.reserve(faces.size());
  for (const std::int32_t f : faces) {
    const auto [a, b, c] = corners(f);
    entries.push_back({box_between(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)), f});
  }
  tree_ = meshing::BoxTree(std::move(entries));
}

std::array<Vec3, 3> ClosestFaces::corners(std::int32_t face) const {
  const auto& [a, b, c] = mesh_.triangles()[face];
  return {mesh_.vertices()[a], mesh_.vertices()[b], mesh_.vertices()[c]};
}

Vec3 ClosestFaces::normal(std::int32_t face) const {
  const FaceGraph& graph = mesh_.graph();
  const FaceRecord& f = graph.faces[graph.graph_face[face]];
  return {f.nx, f.ny, f.nz};
}

ClosestFace ClosestFaces::find(const Vec3& place, const Vec3& facing, double guess, double most) const {
  const bool any_side = facing.isZero(0);
  ClosestFace best;
  most = std::min(most, 2 * mesh_.diagonal() + place.norm());
  double reach = std::max(least_, guess);  // the former, if the guess is not a number
  while (true) {
    reach = std::min(reach, most);
    const Vec3 around = Vec3::Constant(reach);
    (void)tree_.any(box_between(place - around, place + around), [&](const meshing::NumberedBox& entry) {
      if (!any_side && normal(entry.index).dot(facing) < kFacing) return false;
      const double distance = distance_to_triangle(place, corners(entry.index));
      if (distance < best.distance || (distance == best.distance && entry.index < best.face))
        best = {entry.index, distance};
      return false;
    });
    if (best.distance <= reach) return best;  // any nearer face meets the box
    if (!(reach < most)) return best.distance <= most ? best : ClosestFace{};
    reach = best.face != kNone ? best.distance : reach > 0 ? 2 * reach : most;
  }
}

}  // namespace isimp
