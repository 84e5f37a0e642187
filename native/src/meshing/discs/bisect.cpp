// Splits a chart in two parts of equal size.
#include <algorithm>
#include <limits>
#include <utility>

#include "discs/discs.h"

namespace isimp::meshing {
namespace {

/// The faces of a chart, and shortest paths over them from middle to middle. The class writes only to places of the
/// cutter's arrays that belong to this chart.
class Ground {
 public:
  Ground(const Cutter& cutter, std::span<const std::int32_t> faces)
      : faces_(faces), least_(1e-9 * cutter.labels.mesh.diagonal()), place_(cutter.face_place.get()) {
    const Labels& labels = cutter.labels;
    const Mesh& mesh = labels.mesh;
    for (std::size_t i = 0; i < faces.size(); ++i) place_[faces[i]] = static_cast<std::int32_t>(i);
    steps_.reserve(faces.size());
    for (const std::int32_t f : faces) {
      const Triangle& t = mesh.triangles()[f];
      Step& s = steps_.emplace_back();
      s.centre = (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3;
      for (int k = 0; k < 3; ++k) s.beside[k] = labels.inner(3 * f + k) ? place_[mesh.opposite(3 * f + k) / 3] : kNone;
    }
  }

  /// Reaches all faces from one or some of them.
  /// \return the farthest
  std::int32_t grow(std::span<const std::int32_t> seeds) {
    for (Step& s : steps_) s.distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < seeds.size(); ++i) reach(place_[seeds[i]], 0, static_cast<std::int32_t>(i));
    std::int32_t last = seeds[0];
    while (!queue_.empty()) {
      const Front nearest = queue_.front();
      std::pop_heap(queue_.begin(), queue_.end());
      queue_.pop_back();
      const Step& from = steps_[nearest.place];
      if (nearest.distance != from.distance) continue;
      last = nearest.face;
      for (const std::int32_t k : from.beside)
        if (k != kNone) reach(k, from.distance + (steps_[k].centre - from.centre).norm() + least_, from.seed);
    }
    return last;
  }

  /// The faces that are nearest to a seed.
  [[nodiscard]] std::vector<std::int32_t> nearest_to(std::int32_t seed) const {
    std::vector<std::int32_t> some;
    for (std::size_t i = 0; i < faces_.size(); ++i)
      if (steps_[i].seed == seed) some.push_back(faces_[i]);
    return some;
  }

 private:
  struct Step {
    Vec3 centre;
    double distance = 0;
    std::int32_t seed = 0;
    std::array<std::int32_t, 3> beside{};  // places, kNone across the boundary
  };
  struct Front {
    double distance;
    std::int32_t face, place;
    bool operator<(const Front& other) const {  // std::push_heap puts the largest first; ties by face
      return distance > other.distance || (distance == other.distance && face > other.face);
    }
  };

  void reach(std::int32_t place, double distance, std::int32_t seed) {
    Step& s = steps_[place];
    if (distance >= s.distance) return;
    s.distance = distance;
    s.seed = seed;
    queue_.push_back({distance, faces_[place], place});
    std::push_heap(queue_.begin(), queue_.end());
  }

  std::span<const std::int32_t> faces_;
  double least_;         // keeps distances rising where faces have no size
  std::int32_t* place_;  // by face of the mesh, valid for faces of the chart
  std::vector<Step> steps_;
  std::vector<Front> queue_;
};

}  // namespace

std::int32_t bisect(Cutter& cutter, std::int32_t chart, Cause cause, std::array<std::int32_t, 2> seeds) {
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(chart);
  if (faces.size() < 2) return kNone;
  Ground ground(cutter, faces);
  if (seeds[0] == kNone) {
    const std::int32_t a = ground.grow(std::array{faces[0]});
    const std::int32_t b = ground.grow(std::array{a});
    seeds = {b, ground.grow(std::array{b})};
  }
  ground.grow(seeds);
  return cutter.labels.part(ground.nearest_to(1), seeds[0], cause);
}

}  // namespace isimp::meshing
