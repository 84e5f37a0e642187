#include <algorithm>
#include <limits>

#include "discs.h"

namespace isimp::meshing {
namespace {

Vec3 centre(const Mesh& mesh, std::int32_t f) {
  const Triangle& t = mesh.triangles()[f];
  return (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3;
}

/// Reaches all faces of a piece from one or two of them. \return the farthest; faces.via holds which seed is nearest
/// \param lag  by how much the first seed comes later than the others
std::int32_t grow(Cutter& cutter, std::span<const std::int32_t> seeds, double lag = 0) {
  const Labels& labels = cutter.labels;
  const Mesh& mesh = labels.mesh;
  const double least = 1e-9 * mesh.diagonal();  // keeps distances rising where faces have no size
  cutter.faces.start();
  for (std::size_t i = 0; i < seeds.size(); ++i)
    cutter.faces.reach(seeds[i], i == 0 ? lag : 0, static_cast<std::int32_t>(i));
  std::int32_t last = seeds[0];
  for (std::int32_t f = cutter.faces.take(); f != kNone; f = cutter.faces.take()) {
    last = f;
    const Vec3 from = centre(mesh, f);
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      if (!labels.inner(h)) continue;
      const std::int32_t g = mesh.opposite(h) / 3;
      cutter.faces.reach(g, cutter.faces.distance[f] + (centre(mesh, g) - from).norm() + least, cutter.faces.via[f]);
    }
  }
  return last;
}

/// The face of each seed's part that is nearest to the part's middle.
std::vector<std::int32_t> middles(const Cutter& cutter, std::span<const std::int32_t> faces, std::size_t parts) {
  const Mesh& mesh = cutter.labels.mesh;
  std::vector<Vec3> sum(parts, Vec3::Zero());
  std::vector<double> count(parts, 0);
  for (const std::int32_t f : faces) {
    sum[cutter.faces.via[f]] += centre(mesh, f);
    ++count[cutter.faces.via[f]];
  }
  std::vector<std::int32_t> nearest(parts, kNone);
  std::vector<double> least(parts, std::numeric_limits<double>::max());
  for (const std::int32_t f : faces) {
    const std::int32_t k = cutter.faces.via[f];
    const double d = (centre(mesh, f) - sum[k] / count[k]).squaredNorm();
    if (d >= least[k]) continue;
    least[k] = d;
    nearest[k] = f;
  }
  return nearest;
}

}  // namespace

std::int32_t split_evenly(Cutter& cutter, std::int32_t piece, std::int32_t parts, Cause cause) {
  constexpr int kRounds = 6;
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(piece);
  const std::size_t n = std::min<std::size_t>(parts, faces.size());
  std::vector<std::int32_t> seeds{grow(cutter, std::array{faces[0]})};
  while (seeds.size() < n) seeds.push_back(grow(cutter, seeds));
  for (int round = 0; round < kRounds; ++round) {
    grow(cutter, seeds);
    seeds = middles(cutter, faces, n);
  }
  grow(cutter, seeds);
  std::vector<std::vector<std::int32_t>> part(n);
  for (const std::int32_t f : faces) part[cutter.faces.via[f]].push_back(f);
  for (std::size_t k = 1; k < n; ++k) cutter.labels.part(part[k], part[0][0], cause);
  return static_cast<std::int32_t>(n) - 1;
}

std::int32_t part_near(Cutter& cutter, std::int32_t piece, const Vec3& place, Cause cause) {
  constexpr double kLag = 0.5;  // leaves the near part about a quarter of the way to the farthest face
  const Mesh& mesh = cutter.labels.mesh;
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(piece);
  if (faces.size() < 2) return kNone;
  const std::int32_t near = *std::min_element(faces.begin(), faces.end(), [&](std::int32_t f, std::int32_t g) {
    const double a = (centre(mesh, f) - place).squaredNorm(), b = (centre(mesh, g) - place).squaredNorm();
    return a < b || (a == b && f < g);
  });
  const std::int32_t far = grow(cutter, std::array{near});
  grow(cutter, std::array{near, far}, kLag * cutter.faces.distance[far]);
  std::vector<std::int32_t> part;
  for (const std::int32_t f : faces)
    if (cutter.faces.via[f] == 0) part.push_back(f);
  return cutter.labels.part(part, far, cause);
}

std::int32_t bisect(Cutter& cutter, std::int32_t piece, Cause cause, std::array<std::int32_t, 2> seeds) {
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(piece);
  if (faces.size() < 2) return kNone;
  if (seeds[0] == kNone) {
    const std::int32_t a = grow(cutter, std::array{faces[0]});
    const std::int32_t b = grow(cutter, std::array{a});
    seeds = {b, grow(cutter, std::array{b})};
  }
  grow(cutter, seeds);
  std::vector<std::int32_t> half;
  for (const std::int32_t f : faces)
    if (cutter.faces.via[f] == 1) half.push_back(f);
  return cutter.labels.part(half, seeds[0], cause);
}

}  // namespace isimp::meshing
