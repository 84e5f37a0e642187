#include "points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isimp::curved {
namespace {

const double kJoins = std::cos(33 * std::numbers::pi / 180);  ///< least cosine between normals of joined points

}  // namespace

Points points_of(const Faces& faces, std::span<const std::int32_t> small, std::span<const std::uint8_t> locked,
                 Job& job) {
  const FaceGraph& graph = faces.graph();
  const auto count = small.empty() ? 0 : static_cast<std::size_t>(1 + *std::max_element(small.begin(), small.end()));
  Points points;
  points.area.assign(count, 0.0);
  points.centre.assign(count, Vec3::Zero());
  points.normal.assign(count, Vec3::Zero());
  points.rim.assign(count, 0);
  points.faces.assign(count, 0);
  points.of_face.resize(static_cast<std::size_t>(faces.size()));
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    const bool is_free = locked.empty() || locked[i] == 0;
    const std::int32_t p = points.of_face[i] = is_free ? small[graph.mesh_face[i]] : kNone;
    if (p == kNone) continue;
    const double a = faces.area(i);
    ++points.faces[p];
    points.area[p] += a;
    points.centre[p] += a * faces.centre(i);
    points.normal[p] += a * faces.normal(i);
  }
  for (std::size_t p = 0; p < count; ++p) {
    if (points.area[p] > 0) points.centre[p] /= points.area[p];
    const double length = points.normal[p].norm();
    if (length > 0) points.normal[p] /= length;
  }
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    const std::int32_t p = points.of_face[i];
    if (p == kNone) continue;
    for (const std::int32_t j : graph.neighbours[i]) {
      const std::int32_t q = j == graph.size() ? kNone : points.of_face[j];
      if (q == kNone) ++points.rim[p];
      if (p < q) points.edges.push_back({p, q});
    }
  }
  std::sort(points.edges.begin(), points.edges.end());
  for (const auto& [p, q] : points.edges) {
    const bool is_same = !points.beside.empty() && points.beside.back().a == p && points.beside.back().b == q;
    if (!is_same) points.beside.push_back({p, q, 0});
    ++points.beside.back().edges;
  }
  points.edges.clear();
  for (const Points::Beside& s : points.beside)
    if (points.normal[s.a].dot(points.normal[s.b]) > kJoins) points.edges.push_back({s.a, s.b});
  points.near.resize(count);
  for (const auto& [p, q] : points.edges) {
    points.near[p].push_back(q);
    points.near[q].push_back(p);
  }
  return points;
}

}  // namespace isimp::curved
