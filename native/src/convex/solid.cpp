#include "solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "isimp/core/errors.h"

namespace isimp::convex {
namespace {

constexpr double kSnap = 1e-9;  // rounding: share of the diagonal
// tuned colliders
constexpr double kSame = 0.4;    // share of the tolerance, and at most of the default one
constexpr double kSlight = 0.1;  // share of the tolerance

/// The polygons of a region.
struct Group {
  std::vector<std::int32_t> facets;
  Vec3 area = Vec3::Zero();
  Eigen::AlignedBox3d box;
};

void check(const PolygonSoup& polygons, std::span<const std::int32_t> region) {
  polygons.check();
  if (!region.empty() && std::ssize(region) != polygons.polygon_count())
    throw InvalidInput("region needs one number a polygon: " + std::to_string(polygons.polygon_count()) + ", got " +
                       std::to_string(region.size()));
  for (std::size_t i = 0; i < polygons.vertices.size(); ++i)
    if (!polygons.vertices[i].allFinite()) throw InvalidInput("vertex " + std::to_string(i) + " is not finite");
}

/// Whether the boxes of two polygons of nearly one plane share more than a border.
bool opposite(const Group& g, const Group& h, double length) {
  return (g.box.intersection(h.box).sizes().array() > length).count() >= 2;
}

/// Finds the plane of each group: the plane of a larger group if all its corners are near to it, else its own.
void find_planes(std::vector<Group>& groups, Solid& solid) {
  std::vector<std::int32_t> order(groups.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::int32_t g) { return groups[g].area.squaredNorm(); });
  std::vector<std::vector<std::int32_t>> members;
  for (const std::int32_t g : order) {
    Group& group = groups[g];
    if (group.facets.empty()) continue;
    const Vec3 normal = group.area.normalized();
    const auto lies_in = [&](std::int32_t plane) {
      const double turn = normal.dot(solid.planes[plane].normal);
      if (std::abs(turn) < kLikeNormal) return false;
      for (const std::int32_t f : group.facets)
        for (const Vec3& p : solid.facets[f].corners)
          if (std::abs(solid.planes[plane].height(p)) > solid.lengths.same) return false;
      // The two sides of a thin plate are in two planes.
      return std::ranges::none_of(members[plane], [&](std::int32_t m) {
        return groups[m].area.dot(group.area) < 0 && opposite(groups[m], group, solid.lengths.same);
      });
    };
    std::int32_t plane = 0;
    while (plane < std::ssize(members) && !lies_in(plane)) ++plane;
    if (plane == std::ssize(members)) {
      Vec3 middle = Vec3::Zero();
      double area = 0;
      for (const std::int32_t f : group.facets) {
        const auto& [a, b, c] = solid.facets[f].corners;
        const double share = (b - a).cross(c - a).norm();
        middle += share / 3 * (a + b + c);
        area += share;
      }
      solid.planes.push_back({normal, normal.dot(middle) / area});
      solid.both_ways.push_back(0);
      members.emplace_back();
    }
    if (normal.dot(solid.planes[plane].normal) < 0) solid.both_ways[plane] = 1;
    members[plane].push_back(g);
    for (const std::int32_t f : group.facets) solid.facets[f].plane = plane;
  }
}

}  // namespace

bool Solid::is_far(const Vec3& p, double distance) const {
  const double square = distance * distance;
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.corners;
    const double h = facet.normal.dot(p - a);
    if (std::abs(h) > distance) continue;
    if ((a.cwiseMin(b).cwiseMin(c) - p).maxCoeff() > distance) continue;
    if ((p - a.cwiseMax(b).cwiseMax(c)).maxCoeff() > distance) continue;
    bool above = true;
    for (int k = 0; k < 3; ++k) {
      const Vec3 &q = facet.corners[k], &r = facet.corners[(k + 1) % 3];
      const Vec3 along = r - q;
      if (facet.normal.cross(along).dot(p - q) >= 0) continue;
      above = false;
      const double length = along.squaredNorm();
      const double at = length > 0 ? std::clamp(along.dot(p - q) / length, 0.0, 1.0) : 0.0;
      if ((q + at * along - p).squaredNorm() <= square) return false;
    }
    if (above) return false;
  }
  return true;
}

double Solid::winding(const Vec3& p) const {
  double sum = 0;
  for (const Facet& facet : facets) {
    const Vec3 a = facet.corners[0] - p, b = facet.corners[1] - p, c = facet.corners[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double det = a.dot(b.cross(c));
    const double scale = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if (det == 0 && scale == 0) continue;
    sum += std::atan2(det, scale);
  }
  return sum / (2 * std::numbers::pi);
}

Solid solid_of(const PolygonSoup& polygons, std::span<const std::int32_t> region, const Vec3& origin, double tolerance,
               Job& job) {
  check(polygons, region);
  PolygonSoup near = polygons;
  Solid solid;
  for (Vec3& p : near.vertices) p -= origin;
  solid.box = box_of(near.vertices);
  const double diagonal = solid.box.diagonal().norm();
  solid.lengths = {.snap = kSnap * diagonal,
                   .same = kSame * std::min(tolerance, kTolerance * diagonal),
                   .slight = kSlight * tolerance,
                   .deep = tolerance};
  const Triangulation cut = triangulate(near, job);
  std::int32_t count = polygons.polygon_count();
  for (const std::int32_t r : region) {
    if (r < 0) throw InvalidInput("region has a number below 0");
    if (r == std::numeric_limits<std::int32_t>::max()) throw InvalidInput("region has a number above 2^31 - 2");
    if (r >= count) count = r + 1;
  }
  std::vector<Group> groups(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < cut.triangles.size(); ++t) {
    const auto [a, b, c] = cut.triangles[t];
    Facet facet{.corners = {near.vertices[a], near.vertices[b], near.vertices[c]}};
    const Vec3 area = area_vector(facet.corners);
    if (area.squaredNorm() == 0) continue;
    facet.normal = area.normalized();
    const std::int32_t q = cut.source_polygon[t];
    Group& group = groups[region.empty() ? q : region[q]];
    group.box.extend(box_of(facet.corners));
    group.facets.push_back(static_cast<std::int32_t>(solid.facets.size()));
    group.area += area;
    solid.facets.push_back(facet);
  }
  if (solid.facets.empty()) throw InvalidInput("there are no polygons with an area, so there is no solid");
  find_planes(groups, solid);
  return solid;
}

}  // namespace isimp::convex
