#include "walls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "enclose.h"

namespace isimp::convex {
namespace {

constexpr double kAlong = 1e-6;  ///< rounding: cosine: a facet this upright on a polygon is not in front of it

using Edge = std::array<std::int32_t, 2>;

/// A convex polygon of one or more triangles of a region.
struct Face {
  std::vector<std::int32_t> loop;  ///< vertices
  std::vector<Edge> edges;         ///< the border of its triangles; all are in the loop, or in its inside
  std::int32_t region = 0;
};

/// Whether a point is in a convex polygon.
bool is_in(const Vec3& p, const Loop& loop, const Vec3& normal) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    if ((b - a).cross(p - a).dot(normal) < 0) return false;
  }
  return true;
}

/// Whether a point can be seen from the front of a polygon: the next facet in front of it faces it, or there is none.
bool is_seen(const Vec3& p, const Vec3& normal, const Solid& solid) {
  double nearest = std::numeric_limits<double>::infinity();
  bool faces = true;
  for (const Facet& facet : solid.facets) {
    const double turn = facet.normal.dot(normal);
    if (std::abs(turn) < kAlong) continue;
    const double away = facet.normal.dot(facet.corners[0] - p) / turn;
    if (away <= solid.lengths.deep || away >= nearest) continue;
    const Loop loop(facet.corners.begin(), facet.corners.end());
    if (!is_in(p + away * normal, loop, facet.normal)) continue;
    nearest = away;
    faces = turn < 0;
  }
  return faces;
}

/// The faces of a surface, with their edges and normals.
class Surface {
 public:
  Surface(std::vector<Vec3> vertices, std::vector<Face> faces, double slack)
      : vertices_(std::move(vertices)), faces_(std::move(faces)), slack_(slack) {
    for (const Face& face : faces_) triangles_[face.region].push_back(corners(face));
  }

  [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
  [[nodiscard]] Loop corners(const Face& face) const {
    Loop loop;
    for (const std::int32_t v : face.loop) loop.push_back(vertices_[v]);
    return loop;
  }

  /// Joins faces of one region along edges that they share, the longest first: where that is convex, then where their
  /// hull adds only what is hidden behind other facets, as the floor under a cupboard is.
  /// \param spacing  of the points at which it is looked
  void join(const Solid& solid, double spacing, Job& job) {
    std::map<Edge, std::int32_t> face_of;  // by directed edge
    std::vector<std::pair<double, Edge>> inner;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (const Edge& e : faces_[f].edges) face_of[e] = static_cast<std::int32_t>(f);
    for (const auto& [e, f] : face_of) {
      const auto other = face_of.find({e[1], e[0]});
      if (e[0] < e[1] && other != face_of.end() && faces_[f].region == faces_[other->second].region)
        inner.emplace_back((vertices_[e[0]] - vertices_[e[1]]).squaredNorm(), e);
    }
    std::ranges::stable_sort(inner, std::ranges::greater{}, &std::pair<double, Edge>::first);
    for (const bool fill : {false, true})
      for (const auto& [length, e] : inner) {
        const std::int32_t f = face_of.at(e), g = face_of.at({e[1], e[0]});
        if (f == g) continue;
        job.poll();
        Face both = hull(faces_[f], faces_[g]);
        if (fill ? is_any_seen(both, faces_[f], faces_[g], solid, spacing) : adds(both, faces_[f], faces_[g])) continue;
        for (const Edge& of_g : faces_[g].edges) face_of[of_g] = f;
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
      for (const Edge& e : face.edges) normals[e] = normal;
    }
    return normals;
  }

  /// The normal of the face beyond a side of a face: beyond the longest of its edges in the line of this side, the
  /// opposite of its own normal without such an edge.
  [[nodiscard]] Vec3 beyond(const Face& face, const Edge& side, const std::map<Edge, Vec3>& normals) const {
    const Vec3 &a = vertices_[side[0]], along = (vertices_[side[1]] - a).normalized();
    double longest = 0;
    Vec3 found = area_vector(corners(face)).normalized();
    for (const auto& [from, to] : face.edges) {
      const auto next = normals.find({to, from});
      const Vec3 p = vertices_[from] - a, q = vertices_[to] - a;
      const bool in_line = p.cross(along).norm() <= slack_ && q.cross(along).norm() <= slack_;
      if (next == normals.end() || !in_line || (q - p).dot(along) <= longest) continue;
      longest = (q - p).dot(along);
      found = next->second;
    }
    return found;
  }

 private:
  /// The convex hull of two faces of one plane.
  [[nodiscard]] Face hull(const Face& f, const Face& g) const {
    Face both{{}, f.edges, f.region};
    for (const Edge& e : g.edges)
      if (std::erase(both.edges, Edge{e[1], e[0]}) == 0) both.edges.push_back(e);
    std::vector<std::int32_t> all = f.loop;
    for (const std::int32_t v : g.loop)
      if (std::ranges::find(f.loop, v) == f.loop.end()) all.push_back(v);
    const Vec3 normal = (area_vector(corners(f)) + area_vector(corners(g))).normalized();
    const Vec3 right = normal.unitOrthogonal(), up = normal.cross(right);
    const auto place = [&](std::int32_t v) { return std::pair(right.dot(vertices_[v]), up.dot(vertices_[v])); };
    std::ranges::sort(all, {}, place);
    for (const int way : {1, -1}) {  // the lower side from left to right, the upper side back (Andrew 1979)
      const std::size_t first = both.loop.size();
      for (std::size_t k = 0; k < all.size(); ++k) {
        const std::int32_t v = all[way > 0 ? k : all.size() - 1 - k];
        while (both.loop.size() >= first + 2) {
          const Vec3 &a = vertices_[both.loop.end()[-2]], &b = vertices_[both.loop.back()];
          if ((b - a).cross(vertices_[v] - b).dot(normal) > slack_ * (vertices_[v] - a).norm()) break;
          both.loop.pop_back();
        }
        both.loop.push_back(v);
      }
      if (!both.loop.empty()) both.loop.pop_back();  // the other side begins with it
    }
    return both;
  }

  /// Whether the hull of two faces that do not overlap has more than these.
  [[nodiscard]] bool adds(const Face& hull, const Face& f, const Face& g) const {
    double around = 0;
    const Loop loop = corners(hull);
    for (std::size_t i = 0; i < loop.size(); ++i) around += (loop[(i + 1) % loop.size()] - loop[i]).norm();
    return area_vector(loop).norm() >
           area_vector(corners(f)).norm() + area_vector(corners(g)).norm() + slack_ * around / 4;
  }

  /// Whether anything that the hull of two faces adds can be seen.
  [[nodiscard]] bool is_any_seen(const Face& hull, const Face& f, const Face& g, const Solid& solid,
                                 double spacing) const {
    const Loop loop = corners(hull);
    const Vec3 normal = area_vector(loop).normalized(), right = normal.unitOrthogonal(), up = normal.cross(right);
    std::vector<Loop> known = triangles_.at(hull.region);
    known.push_back(corners(f));
    known.push_back(corners(g));
    Eigen::AlignedBox2d box;
    for (const Vec3& p : loop) box.extend(Eigen::Vector2d(right.dot(p - loop[0]), up.dot(p - loop[0])));
    const Eigen::Vector2d steps = (box.sizes() / spacing).array().ceil();
    for (double i = 0.5; i < steps.x(); ++i)
      for (double j = 0.5; j < steps.y(); ++j) {
        const Eigen::Vector2d at = box.min() + spacing * Eigen::Vector2d(i, j);
        const Vec3 p = loop[0] + at.x() * right + at.y() * up;
        const auto has = [&](const Loop& each) { return is_in(p, each, normal); };
        if (has(loop) && !std::ranges::any_of(known, has) && is_seen(p, normal, solid)) return true;
      }
    return false;
  }

  std::vector<Vec3> vertices_;
  std::vector<Face> faces_;
  double slack_;
  std::map<std::int32_t, std::vector<Loop>> triangles_;  // by region
};

/// The plane at an edge of a slab: halfway to the next face.
/// \param next  its normal; the opposite of `normal` if there is none
Plane side_of_slab(const Vec3& from, const Vec3& to, const Vec3& normal, const Vec3& next) {
  const Vec3 out = (to - from).cross(normal).normalized();
  const Vec3 halfway = normal + next;
  const double deep = normal.dot(halfway), wide = -out.dot(halfway);  // measures a side's direction
  // A side leans outwards where faces meet as in the corner of a room, at most by the thickness, inwards as at a pillar.
  const double spread = wide < deep ? wide / std::max(deep, 1e-12) : 1;
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
  Eigen::AlignedBox3d around = box_of(loop);
  for (const Vec3& p : loop)
    for (const int side : {-1, 1}) around.extend(p - thickness * normal + Vec3::Constant(side * thickness));
  double room = thickness;
  for (const Facet& facet : solid.facets) {
    const auto& [a, b, c] = facet.corners;
    if (!around.intersects(box_of(facet.corners))) continue;
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
    const auto& [a, b, c] = corners;
    triangles.push_back({{a, b, c}, {{a, b}, {b, c}, {c, a}}, region.empty() ? q : region[q]});
  }
  Surface surface(near.vertices, std::move(triangles), solid.lengths.slight);
  surface.join(solid, thickness / 2, job);
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
      const Vec3 next = surface.beyond(faces[f], {faces[f].loop[i], faces[f].loop[j]}, normals);
      planes.push_back(side_of_slab(loop[i], loop[j], normal, next));
    }
    const double room = room_behind(loop, normal, planes, thickness, solid), offset = normal.dot(mean_of(loop));
    planes.push_back({normal, offset});
    planes.push_back({-normal, room - offset});
    const Eigen::AlignedBox3d box = box_of(loop);
    const Vec3 around = Vec3::Constant(2 * thickness);
    ConvexPart part = space_below(planes, box.min() - around, box.max() + around, solid.lengths.snap, most_vertices);
    if (!part.vertices.empty()) made.push_back(std::move(part));
  }
  return made;
}

}  // namespace isimp::convex
