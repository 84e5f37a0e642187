#include "seeding.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isimp {
namespace {

/// The graph's faces by component, each in rising order; those of component c at [start[c], start[c + 1]).
struct FacesByComponent {
  std::vector<std::int32_t> start, face;
};

FacesByComponent faces_by_component(const Surface& surface, const Components& components) {
  const FaceGraph& graph = surface.graph();
  FacesByComponent by;
  by.start.assign(components.all.size() + 1, 0);
  for (std::size_t c = 0; c < components.all.size(); ++c) by.start[c + 1] = by.start[c] + components.all[c].sum.faces;
  by.face.resize(static_cast<std::size_t>(graph.size()));
  std::vector<std::int32_t> fill = by.start;
  for (std::int32_t i = 0; i < graph.size(); ++i) by.face[fill[surface.component()[graph.mesh_face[i]]]++] = i;
  return by;
}

/// A face as a point: normal, and centroid in units of the component's radius.
struct Place {
  float normal[3], at[3];
  [[nodiscard]] float distance(const Place& o) const {
    float sum = 0;
    for (int k = 0; k < 3; ++k) {
      const float n = normal[k] - o.normal[k], p = at[k] - o.at[k];
      sum += n * n + p * p;
    }
    return sum;
  }
};

std::vector<Place> places_of(const Surface& surface, std::span<const std::int32_t> faces) {
  const Mesh& mesh = surface.mesh();
  const auto centroid = [&](std::int32_t i) -> Vec3 {
    const Triangle& t = mesh.triangles()[mesh.graph().mesh_face[i]];
    return (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3.0;
  };
  Vec3 low = centroid(faces[0]), high = low;
  for (const std::int32_t i : faces) {
    low = low.cwiseMin(centroid(i));
    high = high.cwiseMax(centroid(i));
  }
  const Vec3 middle = (low + high) / 2;
  const double radius = (high - low).norm() / 2;
  const double scale = radius > 0 ? 1.0 / radius : 0.0;
  std::vector<Place> places(faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const FaceRecord& f = mesh.graph().faces[faces[k]];
    const Vec3 p = (centroid(faces[k]) - middle) * scale;
    places[k] = {{f.nx, f.ny, f.nz}, {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}};
  }
  return places;
}

/// Draws distinct faces, each with a chance that is the root of its weight: that many more regions are wanted there.
void draw_by_weight(std::span<const std::int32_t> faces, std::span<const float> weight, std::int32_t count,
                    Random& random, std::vector<std::int32_t>& seeds) {
  std::vector<double> up_to(faces.size());  // sum of chances up to each face
  double sum = 0.0;
  for (std::size_t k = 0; k < faces.size(); ++k) up_to[k] = sum += std::sqrt(weight[faces[k]]);
  std::vector<bool> taken(faces.size(), false);
  for (std::int32_t drawn = 0; drawn < count; ++drawn) {
    const double at = sum * 0x1p-53 * static_cast<double>(random.below(1ULL << 53));
    auto k = static_cast<std::size_t>(std::upper_bound(up_to.begin(), up_to.end(), at) - up_to.begin());
    while (k >= faces.size() || taken[k]) k = k + 1 < faces.size() ? k + 1 : 0;
    taken[k] = true;
    seeds.push_back(faces[k]);
  }
}

}  // namespace

std::vector<std::int32_t> random_seeds(const Surface& surface, const Components& components,
                                       const std::vector<std::int32_t>& share, std::uint64_t seed, Job& job) {
  const FacesByComponent by = faces_by_component(surface, components);
  job.poll();
  Random random(seed);
  std::vector<bool> taken(by.face.size(), false);
  std::vector<std::int32_t> seeds;
  for (std::size_t c = 0; c < share.size(); ++c) {
    const std::int32_t faces = by.start[c + 1] - by.start[c];
    if (!surface.weight().empty()) {
      const auto of_component = std::span(by.face).subspan(by.start[c], static_cast<std::size_t>(faces));
      draw_by_weight(of_component, surface.weight(), share[c], random, seeds);
      continue;
    }
    // Floyd's way to draw distinct numbers: one draw each.
    for (std::int32_t last = faces - share[c]; last < faces; ++last) {
      auto at = static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(last) + 1));
      if (taken[by.start[c] + at]) at = last;
      taken[by.start[c] + at] = true;
      seeds.push_back(by.face[by.start[c] + at]);
    }
  }
  return seeds;
}

std::vector<std::int32_t> farthest_seeds(const Surface& surface, const Components& components,
                                         const std::vector<std::int32_t>& share, std::uint64_t seed, Job& job) {
  const FacesByComponent by = faces_by_component(surface, components);
  Random random(seed);
  std::vector<std::int32_t> seeds;
  const auto total = static_cast<double>(std::accumulate(share.begin(), share.end(), 0LL));
  for (std::size_t c = 0; c < share.size(); ++c) {
    if (share[c] == 0) continue;
    const auto faces = std::span(by.face).subspan(by.start[c], static_cast<std::size_t>(by.start[c + 1] - by.start[c]));
    const std::vector<Place> places = places_of(surface, faces);
    std::vector<float> distance(faces.size(), 100.0F);  // to the nearest seed yet; below 0: is one
    std::size_t newest = random.below(faces.size());
    for (std::int32_t k = 0; k < share[c]; ++k) {
      job.report(static_cast<double>(seeds.size()) / total);
      seeds.push_back(faces[newest]);
      distance[newest] = -1.0F;
      const Place from = places[newest];
      const auto wanted = [&](std::size_t i) {
        return surface.weight().empty() ? distance[i] : distance[i] * std::sqrt(surface.weight()[faces[i]]);
      };
      float farthest = -1.0F;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        distance[i] = std::min(distance[i], places[i].distance(from));
        if (wanted(i) > farthest) {
          farthest = wanted(i);
          newest = i;
        }
      }
    }
  }
  return seeds;
}

}  // namespace isimp
