#include "walls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "enclose.h"

namespace isimp::detail {
namespace {

constexpr double kBent = 0.1;    ///< share of the tolerance: deeper corners of a face are reflex
constexpr double kSpread = 1.0;  ///< the most by which the back of a slab is wider at an edge, in thicknesses

using Edge = std::array<std::int32_t, 2>;

/// A convex polygon.
struct Face {
  std::vector<std::int32_t> loop;  ///< vertices
  std::int32_t region = 0;
};

/// The faces of a surface, with their edges and normals.
class Surface {
 public:
  Surface(std::vector<Vec3> vertices, std::vector<Face> faces, double slack)
      : vertices_(std::move(vertices)), faces_(std::move(faces)), slack_(slack) {}

  [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
  [[nodiscard]] Loop corners(const Face& face) const {
    Loop loop;
    for (const std::int32_t v : face.loop) loop.push_back(vertices_[v]);
    return loop;
  }

  /// Joins faces of one region along edges that they share, the longest first, where that is convex.
  void join() {
    std::map<Edge, std::int32_t> face_of;  // by directed edge
    std::vector<std::pair<double, Edge>> inner;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for_each_edge(faces_[f], [&](const Edge& e) { face_of[e] = static_cast<std::int32_t>(f); });
    for (const auto& [e, f] : face_of) {
      const auto other = face_of.find({e[1], e[0]});
      if (e[0] < e[1] && other != face_of.end() && faces_[f].region == faces_[other->second].region)
        inner.emplace_back((vertices_[e[0]] - vertices_[e[1]]).squaredNorm(), e);
    }
    std::ranges::stable_sort(inner, std::ranges::greater{}, &std::pair<double, Edge>::first);
    for (const auto& [length, e] : inner) {
      const std::int32_t f = face_of.at(e), g = face_of.at({e[1], e[0]});
      if (f == g) continue;
      Face both{united(faces_[f].loop, faces_[g].loop, e), faces_[f].region};
      if (both.loop.empty() || !is_convex(both)) continue;
      for_each_edge(faces_[g], [&](const Edge& of_g) { face_of[of_g] = f; });
      faces_[f] = std::move(both);
      faces_[g].loop.clear();
    }
    std::erase_if(faces_, [](const Face& face) { return face.loop.empty(); });
  }

  /// By directed edge: the normal of its face.
  [[nodiscard]] std::map<Edge, Vec3> normals() const {
    std::map<Edge, Vec3> normals;
    for (const Face& face : faces_) {
      const Vec3 normal = area_vector(corners(face)).normalized();
      for_each_edge(face, [&](const Edge& e) { normals[e] = normal; });
    }
    return normals;
  }

 private:
  template <class Function>
  static void for_each_edge(const Face& face, Function fn) {
    for (std::size_t i = 0; i < face.loop.size(); ++i)
      fn(Edge{face.loop[i], face.loop[i + 1 < face.loop.size() ? i + 1 : 0]});
  }

  /// Two loops as one; empty if they share more than the edge, which runs forwards in the first.
  static std::vector<std::int32_t> united(std::vector<std::int32_t> p, std::vector<std::int32_t> q, const Edge& e) {
    std::rotate(p.begin(), std::ranges::find(p, e[1]), p.end());  // it ends with the edge's first vertex
    std::rotate(q.begin(), std::ranges::find(q, e[0]), q.end());  // it ends with the edge's second one
    q.pop_back();
    q.erase(q.begin());
    if (std::ranges::find_first_of(p, q) != p.end()) return {};
    p.insert(p.end(), q.begin(), q.end());
    return p;
  }

  [[nodiscard]] bool is_convex(const Face& face) const {
    const Loop loop = corners(face);
    const Vec3 normal = area_vector(loop).normalized();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 &a = loop[i], &b = loop[(i + 1) % loop.size()], &c = loop[(i + 2) % loop.size()];
      if ((b - a).cross(c - b).dot(normal) < -slack_ * (c - a).norm()) return false;
      if ((b - a).dot(c - b) < 0 && (b - a).cross(c - b).dot(normal) <= 0) return false;  // it turns back
    }
    return true;
  }

  std::vector<Vec3> vertices_;
  std::vector<Face> faces_;
  double slack_;
};

/// The plane at an edge of a slab: halfway to the next face.
/// \param next  its normal; the opposite of `normal` if there is none
Plane side_of_slab(const Vec3& from, const Vec3& to, const Vec3& normal, const Vec3& next) {
  const Vec3 out = (to - from).cross(normal).normalized();
  const Vec3 halfway = normal + next;
  const double deep = normal.dot(halfway), wide = -out.dot(halfway);  // measures a side's direction
  // A side leans outwards where faces meet as in the corner of a room, inwards as at a pillar.
  const double spread = wide < kSpread * deep ? wide / std::max(deep, 1e-12) : kSpread;
  const Vec3 along = -normal + spread * out;
  const Vec3 side = along.cross(from - to).normalized();
  const Vec3 outwards = side.dot(out) < 0 ? Vec3(-side) : side;
  return {outwards, outwards.dot(from)};
}

/// How far behind a face other facets allow a slab.
/// \param sides  the planes at its edges
double room_behind(const Loop& loop, const Vec3& normal, const std::vector<Plane>& sides, double thickness,
                   const Solid& solid) {
  const Lengths& l = solid.lengths;
  const Plane front{normal, normal.dot(mean_of(loop))};
  Vec3 low = loop[0], high = loop[0];
  for (const Vec3& p : loop)
    for (const double depth : {0.0, thickness}) {
      const double wide = kSpread * depth;
      low = low.cwiseMin(p - depth * normal - Vec3::Constant(wide));
      high = high.cwiseMax(p - depth * normal + Vec3::Constant(wide));
    }
  double room = thickness;
  for (const Facet& facet : solid.facets) {
    const auto& [a, b, c] = facet.corners;
    if ((a.cwiseMin(b).cwiseMin(c) - high).maxCoeff() > 0 || (low - a.cwiseMax(b).cwiseMax(c)).maxCoeff() > 0) continue;
    const double share = normal.dot(facet.normal) > 0 ? 0.5 : 1.0;
    Loop rest{a, b, c};
    const auto keep_below = [&](const Plane& plane) {
      if (!rest.empty()) rest = divide(rest, plane, l.snap)[1];
    };
    keep_below({normal, front.offset - l.deep});
    keep_below({-normal, room / share - front.offset});
    for (const Plane& side : sides) keep_below({side.normal, side.offset - l.deep});
    for (const Vec3& p : rest) room = std::min(room, -share * front.height(p));
  }
  return std::max(room, l.deep);
}

}  // namespace

std::vector<ConvexPart> walls_of(const PolygonSoup& polygons, std::span<const std::int32_t> region, const Vec3& origin,
                                 const Solid& solid, double thickness, std::int32_t most_vertices, Job& job) {
  PolygonSoup near = polygons;
  for (Vec3& p : near.vertices) p -= origin;
  const Triangulation cut = triangulate(near, job);
  std::vector<Face> triangles;
  for (std::size_t t = 0; t < cut.triangles.size(); ++t) {
    const auto& corners = cut.triangles[t];
    const std::int32_t q = cut.source_polygon[t];
    triangles.push_back({{corners.begin(), corners.end()}, region.empty() ? q : region[q]});
  }
  Surface surface(near.vertices, std::move(triangles), kBent * solid.lengths.deep);
  surface.join();
  const std::map<Edge, Vec3> normals = surface.normals();
  std::vector<ConvexPart> made;
  const auto& faces = surface.faces();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    job.report(static_cast<double>(f) / static_cast<double>(faces.size()));
    const Loop loop = surface.corners(faces[f]);
    const Vec3 area = area_vector(loop);
    if (!(area.norm() > 0)) continue;
    const Vec3 normal = area.normalized();
    std::vector<Plane> planes;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::size_t j = (i + 1) % loop.size();
      const auto next = normals.find({faces[f].loop[j], faces[f].loop[i]});
      planes.push_back(side_of_slab(loop[i], loop[j], normal, next == normals.end() ? normal : next->second));
    }
    const double room = room_behind(loop, normal, planes, thickness, solid), offset = normal.dot(mean_of(loop));
    planes.push_back({normal, offset});
    planes.push_back({-normal, room - offset});
    Vec3 low = loop[0], high = loop[0];
    for (const Vec3& p : loop) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Vec3 around = Vec3::Constant((1 + kSpread) * thickness);
    ConvexPart part = space_below(planes, low - around, high + around, solid.lengths.snap, most_vertices);
    if (!part.vertices.empty()) made.push_back(std::move(part));
  }
  return made;
}

}  // namespace isimp::detail
