#include "isimp/mesh/face_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace isimp {
namespace {

constexpr double kFlat = 1e-12;  // doubled area over longest edge squared, below which a normal is rounding noise
constexpr double kMortonCells = 2097151.0;  // 21 bits an axis

std::uint64_t spread_bits(std::uint64_t x) {  // every bit of the lower 21 goes to a place divisible by three
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffULL;
  x = (x | x << 16) & 0x1f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  x = (x | x << 2) & 0x1249249249249249ULL;
  return x;
}

std::vector<std::int32_t> morton_order(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) {
      low = low.cwiseMin(vertices[v]);
      high = high.cwiseMax(vertices[v]);
    }
  const double side = (high - low).maxCoeff();
  const double scale = side > 0 ? kMortonCells / side : 0.0;
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys(triangles.size());
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    const Triangle& t = triangles[f];
    const Vec3 cell = ((vertices[t[0]] + vertices[t[1]] + vertices[t[2]]) / 3.0 - low) * scale;
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) code |= spread_bits(static_cast<std::uint64_t>(std::max(0.0, cell[k]))) << k;
    keys[f] = {code, static_cast<std::int32_t>(f)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::int32_t> order(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

/// Faces without area take their normals from neighbours, breadth first from all faces that have one.
void fill_missing_normals(FaceGraph& graph, const std::vector<std::int32_t>& missing) {
  std::vector<std::int32_t> open = missing, next;
  const auto has_normal = [&](std::int32_t i) {
    const FaceRecord& r = graph.faces[i];
    return r.nx != 0 || r.ny != 0 || r.nz != 0;
  };
  while (!open.empty()) {
    std::vector<std::pair<std::int32_t, FaceRecord>> found;
    next.clear();
    for (const std::int32_t i : open) {
      std::int32_t source = graph.size();
      for (const std::int32_t j : graph.neighbours[i])
        if (j != graph.size() && has_normal(j) &&
            graph.mesh_face[j] < (source == graph.size() ? INT32_MAX : graph.mesh_face[source]))
          source = j;
      if (source == graph.size()) {
        next.push_back(i);
      } else {
        found.emplace_back(i, graph.faces[source]);
      }
    }
    if (found.empty()) return;  // a component without any area keeps zero normals
    for (const auto& [i, record] : found) graph.faces[i] = {record.nx, record.ny, record.nz, 0.0F};
    open.swap(next);
  }
}

}  // namespace

FaceGraph make_face_graph(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                          std::span<const std::int32_t> opposite) {
  FaceGraph graph;
  const auto n = static_cast<std::int32_t>(triangles.size());
  graph.mesh_face = morton_order(vertices, triangles);
  graph.graph_face.resize(triangles.size());
  for (std::int32_t i = 0; i < n; ++i) graph.graph_face[graph.mesh_face[i]] = i;
  graph.faces.assign(triangles.size() + 1, FaceRecord{});
  graph.neighbours.assign(triangles.size() + 1, {n, n, n});

  std::vector<double> areas(triangles.size());
  std::vector<std::int32_t> missing;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t f = graph.mesh_face[i];
    const Triangle& t = triangles[f];
    const Vec3 u = vertices[t[1]] - vertices[t[0]], v = vertices[t[2]] - vertices[t[0]];
    const Vec3 cross = u.cross(v);
    const double doubled = cross.norm();
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
    if (doubled > kFlat * longest) {
      const Vec3 normal = cross / doubled;
      graph.faces[i] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z()),
                        0};
      areas[i] = doubled / 2;
      graph.area += areas[i];
    } else {
      missing.push_back(i);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t other = opposite[3 * static_cast<std::size_t>(f) + k];
      if (other != kNone) graph.neighbours[i][k] = graph.graph_face[other / 3];
    }
  }
  if (graph.area > 0)
    for (std::int32_t i = 0; i < n; ++i) graph.faces[i].area = static_cast<float>(areas[i] / graph.area);
  fill_missing_normals(graph, missing);
  return graph;
}

}  // namespace isimp
