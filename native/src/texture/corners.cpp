#include "isimp/texture/corners.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "isimp/core/errors.h"
#include "place.h"

namespace isimp {
namespace {

constexpr double kNear = 1e-9;  // rounding: share of the diagonal
// tuned texture
constexpr double kRepairReach = 0.02;    // share of the diagonal by which a repair may have moved a corner
constexpr std::int32_t kPoll = 1 << 16;  // work

class Finder {
 public:
  Finder(const Mesh& mesh, std::span<const Vec3> vertices, std::span<const Triangle> triangles)
      : mesh_(mesh), vertices_(vertices), triangles_(triangles) {}

  SourceCorners run(Job& job) {
    SourceCorners found;
    const std::int32_t faces = mesh_.face_count();
    found.face.assign(faces, kNone);
    found.weight.resize(faces);
    for (std::int32_t f = 0; f < faces; ++f) {
      if (f % kPoll == 0) job.poll();
      const std::int32_t source = mesh_.source_face()[f];
      if (source == kNone) continue;
      if (source < 0 || source >= static_cast<std::int32_t>(triangles_.size())) other_arrays(f);
      if (same_corners(f, source, found)) continue;
      ++found.turned;
      if (!nearest(f, found)) ++found.lost;
    }
    if (found.turned > faces / 2 && found.lost > faces / 4) other_arrays(0);
    return found;
  }

 private:
  [[noreturn]] void other_arrays(std::int32_t f) const {
    throw InvalidInput("face " + std::to_string(f) +
                       " of the mesh does not come from the source's triangles; give the mesh made from the source's "
                       "own vertices and triangles");
  }
  [[nodiscard]] Vec3 corner(std::int32_t f, int k) const { return mesh_.vertices()[mesh_.triangles()[f][k]]; }
  [[nodiscard]] Vec3 place(std::int32_t t, int k) const { return vertices_[triangles_[t][k]] - mesh_.origin(); }

  bool same_corners(std::int32_t f, std::int32_t source, SourceCorners& found) const {
    std::array<float, 6> weight{};
    int used = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = corner(f, k);
      int at = -1;
      for (int i = 0; i < 3 && at < 0; ++i)
        if ((used & (1 << i)) == 0 && p == place(source, i)) at = i;
      if (at < 0) return false;
      used |= 1 << at;
      if (at > 0) weight[2 * k + at - 1] = 1;
    }
    found.face[f] = source;
    found.weight[f] = weight;
    return true;
  }

  /// The source triangles of this face and of those around its corners, its own first.
  void collect(std::int32_t f) {
    candidates_.clear();
    candidates_.push_back(mesh_.source_face()[f]);
    for (const std::int32_t v : mesh_.triangles()[f]) {
      const std::int32_t start = mesh_.vertex_halfedge()[v];
      std::int32_t h = start;
      do {
        const std::int32_t source = mesh_.source_face()[Mesh::face(h)];
        if (source >= 0 && source < static_cast<std::int32_t>(triangles_.size()) &&
            std::find(candidates_.begin(), candidates_.end(), source) == candidates_.end())
          candidates_.push_back(source);
        h = mesh_.next_outgoing(h);
      } while (h != kNone && h != start);
    }
  }

  bool nearest(std::int32_t f, SourceCorners& found) {
    collect(f);
    double least = kRepairReach * mesh_.diagonal();
    const double near = kNear * mesh_.diagonal();
    for (const std::int32_t t : candidates_) {
      const std::array<Vec3, 3> v = {place(t, 0), place(t, 1), place(t, 2)};
      if (!v[0].allFinite() || !v[1].allFinite() || !v[2].allFinite()) continue;
      std::array<float, 6> weight{};
      double away = 0;
      for (int k = 0; k < 3; ++k) {
        const detail::Place p = detail::closest_on(corner(f, k), v[0], v[1] - v[0], v[2] - v[0]);
        weight[2 * k] = static_cast<float>(p.b);
        weight[2 * k + 1] = static_cast<float>(p.c);
        away = std::max(away, std::sqrt(p.squared));
      }
      if (!(away < least) || away > least - near) continue;
      least = away;
      found.face[f] = t;
      found.weight[f] = weight;
    }
    return found.face[f] != kNone;
  }

  const Mesh& mesh_;
  std::span<const Vec3> vertices_;
  std::span<const Triangle> triangles_;
  std::vector<std::int32_t> candidates_;
};

}  // namespace

SourceCorners source_corners(const Mesh& mesh, std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                             Job& job) {
  return Finder(mesh, vertices, triangles).run(job);
}

}  // namespace isimp
