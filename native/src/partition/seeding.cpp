#include "isimp/partition/seeding.h"

#include <algorithm>
#include <numeric>

namespace isimp {
namespace {

/// The graph's faces component by component, each in rising order; those of component c at [start[c], start[c + 1]).
struct FacesByPart {
  std::vector<std::int32_t> start, face;
};

FacesByPart faces_by_part(const Mesh& mesh, const Parts& parts) {
  const FaceGraph& graph = mesh.graph();
  FacesByPart by;
  by.start.assign(parts.parts.size() + 1, 0);
  for (std::size_t c = 0; c < parts.parts.size(); ++c) by.start[c + 1] = by.start[c] + parts.parts[c].sum.faces;
  by.face.resize(static_cast<std::size_t>(graph.size()));
  std::vector<std::int32_t> fill = by.start;
  for (std::int32_t i = 0; i < graph.size(); ++i) by.face[fill[mesh.component()[graph.mesh_face[i]]]++] = i;
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

std::vector<Place> places_of(const Mesh& mesh, std::span<const std::int32_t> faces) {
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

}  // namespace

std::vector<std::int32_t> random_seeds(const Mesh& mesh, const Parts& parts, const std::vector<std::int32_t>& share,
                                       std::uint64_t seed, Job& job) {
  const FacesByPart by = faces_by_part(mesh, parts);
  job.poll();
  Random random(seed);
  std::vector<bool> taken(by.face.size(), false);
  std::vector<std::int32_t> seeds;
  for (std::size_t c = 0; c < share.size(); ++c) {
    const std::int32_t faces = by.start[c + 1] - by.start[c];
    // Floyd's way to draw distinct numbers: one draw each, however many are taken.
    for (std::int32_t last = faces - share[c]; last < faces; ++last) {
      auto at = static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(last) + 1));
      if (taken[by.start[c] + at]) at = last;
      taken[by.start[c] + at] = true;
      seeds.push_back(by.face[by.start[c] + at]);
    }
  }
  return seeds;
}

std::vector<std::int32_t> farthest_seeds(const Mesh& mesh, const Parts& parts, const std::vector<std::int32_t>& share,
                                         std::uint64_t seed, Job& job) {
  const FacesByPart by = faces_by_part(mesh, parts);
  Random random(seed);
  std::vector<std::int32_t> seeds;
  const auto total = static_cast<double>(std::accumulate(share.begin(), share.end(), 0LL));
  for (std::size_t c = 0; c < share.size(); ++c) {
    if (share[c] == 0) continue;
    const auto faces = std::span(by.face).subspan(by.start[c], static_cast<std::size_t>(by.start[c + 1] - by.start[c]));
    const std::vector<Place> places = places_of(mesh, faces);
    std::vector<float> distance(faces.size(), 100.0F);  // to the nearest seed so far; below 0: is one
    std::size_t newest = random.below(faces.size());
    for (std::int32_t k = 0; k < share[c]; ++k) {
      job.report(static_cast<double>(seeds.size()) / total);
      seeds.push_back(faces[newest]);
      distance[newest] = -1.0F;
      const Place from = places[newest];
      float farthest = -1.0F;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        distance[i] = std::min(distance[i], places[i].distance(from));
        if (distance[i] > farthest) {
          farthest = distance[i];
          newest = i;
        }
      }
    }
  }
  return seeds;
}

}  // namespace isimp
