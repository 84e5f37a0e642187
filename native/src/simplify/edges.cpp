#include "isimp/simplify/edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>

#include "exact_sums.h"
#include "isimp/core/errors.h"
#include "isimp/core/tiny.h"

namespace isimp {
namespace {

/// The lower vertex first.
VertexPair ends_of(const Mesh& mesh, std::int32_t h) {
  const std::int32_t a = mesh.from(h), b = mesh.to(h);
  return {std::min(a, b), std::max(a, b)};
}

/// The half-edges of lower number of the inner edges that pass a test, by lower vertex, then by upper vertex.
template <class Test>
std::vector<std::int32_t> inner_halfedges(const Mesh& mesh, Job& job, Test test) {
  std::vector<std::int32_t> chosen;
  std::vector<std::int32_t> first(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0);
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    if ((h & 0xffff) == 0) job.poll();
    if (mesh.opposite(h) < h || !test(h)) continue;
    chosen.push_back(h);
    ++first[ends_of(mesh, h)[0] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::int32_t> fill(first.begin(), first.end() - 1), sorted(chosen.size());
  for (const std::int32_t h : chosen) sorted[fill[ends_of(mesh, h)[0]]++] = h;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((v & 0xffff) == 0) job.poll();
    std::sort(sorted.begin() + first[v], sorted.begin() + first[v + 1],
              [&](std::int32_t a, std::int32_t b) { return ends_of(mesh, a)[1] < ends_of(mesh, b)[1]; });
  }
  return sorted;
}

std::vector<VertexPair> ends_of(const Mesh& mesh, std::span<const std::int32_t> halfedges) {
  std::vector<VertexPair> ends(halfedges.size());
  std::transform(halfedges.begin(), halfedges.end(), ends.begin(), [&](std::int32_t h) { return ends_of(mesh, h); });
  return ends;
}

/// A set of pairs of numbers.
class PairSet {
 public:
  /// \param size  pairs with a number that is not in [0, size) are left out
  PairSet(std::span<const VertexPair> pairs, std::int32_t size) : first_(static_cast<std::size_t>(size) + 1, 0) {
    const auto each = [&](auto take) {
      for (const auto& [a, b] : pairs)
        if (std::min(a, b) >= 0 && std::max(a, b) < size) take(std::min(a, b), std::max(a, b));
    };
    each([&](std::int32_t low, std::int32_t) { ++first_[low + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    high_.resize(static_cast<std::size_t>(first_.back()));
    std::vector<std::int32_t> fill(first_.begin(), first_.end() - 1);
    each([&](std::int32_t low, std::int32_t high) { high_[fill[low]++] = high; });
  }
  /// \param low, high  in [0, size)
  [[nodiscard]] bool contains(std::int32_t low, std::int32_t high) const {
    const auto end = high_.begin() + first_[low + 1];
    return std::find(high_.begin() + first_[low], end, high) != end;
  }

 private:
  std::vector<std::int32_t> first_, high_;
};

struct FaceNormal {
  Vec3 unit = Vec3::Zero();
  bool whole = false;  // it has an area
};

constexpr double kThin = 1e-12;  // rounding: times the square of its longest side: a face of less area has no normal

std::vector<FaceNormal> face_normals(const Mesh& mesh, Job& job) {
  std::vector<FaceNormal> normals(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & 0xffff) == 0) job.poll();
    const auto corner = [&](int k) -> const Vec3& { return mesh.vertices()[mesh.triangles()[f][k]]; };
    const Vec3 ab = corner(1) - corner(0), ac = corner(2) - corner(0), bc = corner(2) - corner(1);
    const Vec3 cross = ab.cross(ac);
    const double length = detail::norm(cross);
    const double longest = std::max({detail::dot(ab, ab), detail::dot(ac, ac), detail::dot(bc, bc)});
    normals[f] = {cross / std::max(length, kTiny), length > kThin * longest};
  }
  return normals;
}

}  // namespace

InnerEdges inner_edges(const Mesh& mesh, Job& job) {
  const std::vector<std::int32_t> halfedges = inner_halfedges(mesh, job, [](std::int32_t) { return true; });
  InnerEdges result{ends_of(mesh, halfedges), {}, {}};
  for (const std::int32_t h : halfedges) {
    result.face.push_back(Mesh::face(h));
    result.beside.push_back(Mesh::face(mesh.opposite(h)));
  }
  return result;
}

std::vector<VertexPair> sharp_edges(const Mesh& mesh, double angle, Job& job) {
  if (!(angle >= 0 && angle <= std::numbers::pi))
    throw InvalidInput("angle must be in [0, pi], got " + (std::ostringstream() << angle).str());
  const std::vector<FaceNormal> normals = face_normals(mesh, job);
  const double least = std::cos(angle);
  return ends_of(mesh, inner_halfedges(mesh, job, [&](std::int32_t h) {
                   const FaceNormal &a = normals[Mesh::face(h)], &b = normals[Mesh::face(mesh.opposite(h))];
                   return a.whole && b.whole && detail::dot(a.unit, b.unit) < least;
                 }));
}

std::vector<VertexPair> marked_edges(const Mesh& mesh, std::span<const VertexPair> marked, Job& job) {
  if (marked.empty()) return {};
  const std::span<const std::int32_t> source = mesh.source_vertex();
  const PairSet set(marked, 1 + std::max(0, *std::max_element(source.begin(), source.end())));
  return ends_of(mesh, inner_halfedges(mesh, job, [&](std::int32_t h) {
                   const std::int32_t a = source[mesh.from(h)], b = source[mesh.to(h)];
                   return std::min(a, b) >= 0 && set.contains(std::min(a, b), std::max(a, b));
                 }));
}

}  // namespace isimp
