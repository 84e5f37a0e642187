#include "reference.h"

#include <limits>
#include <queue>
#include <random>
#include <span>

#include "measure.h"

namespace isimp::bench {
namespace {

struct Entry {
  double error;
  std::int32_t face, region;
  bool operator<(const Entry& o) const { return error > o.error; }  // std::priority_queue returns the greatest
};

struct State {
  std::vector<std::int32_t> label, seed;
  std::vector<Vec3> proxy;
};

void flood(const PlainSurface& surface, State& state) {
  std::fill(state.label.begin(), state.label.end(), kNone);
  std::priority_queue<Entry> queue;
  const auto offer_neighbours = [&](std::int32_t face, std::int32_t region) {
    for (const std::int32_t other : surface.neighbours[face])
      if (other != kNone && state.label[other] == kNone)
        queue.push({(surface.normal[other] - state.proxy[region]).squaredNorm(), other, region});
  };
  const auto regions = static_cast<std::int32_t>(state.seed.size());
  for (std::int32_t r = 0; r < regions; ++r) state.label[state.seed[r]] = r;
  for (std::int32_t r = 0; r < regions; ++r) offer_neighbours(state.seed[r], r);
  while (!queue.empty()) {
    const Entry least = queue.top();
    queue.pop();
    if (state.label[least.face] != kNone) continue;
    state.label[least.face] = least.region;
    offer_neighbours(least.face, least.region);
  }
}

/// Fits proxies and chooses seeds. With S the sum of area * normal over a region of area A, its error is 2 (A - |S|).
double fit(const PlainSurface& surface, State& state) {
  const std::size_t regions = state.seed.size();
  std::vector<Vec3> sum(regions, Vec3::Zero());
  std::vector<double> area(regions, 0.0);
  for (std::size_t f = 0; f < state.label.size(); ++f) {
    const std::int32_t r = state.label[f];
    if (r == kNone) continue;
    sum[r] += surface.area[f] * surface.normal[f];
    area[r] += surface.area[f];
  }
  double error = 0.0;
  for (std::size_t r = 0; r < regions; ++r) {
    const double length = sum[r].norm();
    error += 2 * (area[r] - length);
    if (length > 0) state.proxy[r] = sum[r] / length;
  }
  std::vector<double> least(regions, std::numeric_limits<double>::infinity());
  for (std::size_t f = 0; f < state.label.size(); ++f) {
    const std::int32_t r = state.label[f];
    if (r == kNone) continue;
    const double difference = (surface.normal[f] - state.proxy[r]).squaredNorm();
    if (difference >= least[r]) continue;
    least[r] = difference;
    state.seed[r] = static_cast<std::int32_t>(f);
  }
  return error;
}

}  // namespace

PlainSurface plain_surface(const Mesh& mesh) {
  const FaceGraph& graph = mesh.graph();
  const auto faces = static_cast<std::size_t>(mesh.face_count());
  PlainSurface surface;
  surface.normal.resize(faces);
  surface.area.resize(faces);
  surface.neighbours.resize(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    const FaceRecord& record = graph.faces[graph.graph_face[f]];
    surface.normal[f] = {record.nx, record.ny, record.nz};
    surface.area[f] = record.area;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t other = mesh.opposite()[3 * f + k];
      surface.neighbours[f][k] = other == kNone ? kNone : Mesh::face(other);
    }
  }
  return surface;
}

std::vector<std::int32_t> random_faces(std::int32_t faces, std::int32_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<bool> taken(static_cast<std::size_t>(faces), false);
  std::vector<std::int32_t> chosen;
  while (chosen.size() < static_cast<std::size_t>(count)) {
    const auto face = static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(faces));
    if (taken[face]) continue;
    taken[face] = true;
    chosen.push_back(face);
  }
  return chosen;
}

ReferenceResult reference(const PlainSurface& surface, const ReferenceOptions& options) {
  State state;
  state.label.resize(surface.area.size());
  state.seed = random_faces(surface.face_count(), options.proxies, options.seed);
  for (const std::int32_t face : state.seed) state.proxy.push_back(surface.normal[face]);
  ReferenceResult result;
  for (std::int32_t round = 0; round < options.rounds; ++round) {
    double error = 0.0;
    const Lap lap = timed([&] {
      flood(surface, state);
      error = fit(surface, state);
    });
    result.history.push_back(error);
    result.round_ms.push_back(lap.cpu_ms);
  }
  result.label = std::move(state.label);
  return result;
}

}  // namespace isimp::bench
