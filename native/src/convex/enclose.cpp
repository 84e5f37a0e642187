#include "enclose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "cell.h"
#include "isimp/mesh/meet.h"

namespace isimp::convex {
namespace {

// tuned colliders
constexpr double kLooser = 1.05;     // times the volume: for which fewer facets are worth it
constexpr double kRounding = 1e-12;  // rounding: share of the coordinates: the first distance that planes are moved

/// The planes of a part, the largest facets first. Each has the whole part below it.
std::vector<Plane> few_planes(const ConvexPart& part, double same) {
  std::vector<std::pair<double, Plane>> facets;
  for (const auto& [a, b, c] : part.triangles) {
    const Vec3 &p = part.vertices[a], &q = part.vertices[b], &r = part.vertices[c];
    const Vec3 area = (q - p).cross(r - p);
    if (area.squaredNorm() > 0) facets.push_back({area.norm(), {area.normalized(), area.normalized().dot(p)}});
  }
  std::vector<std::int32_t> order(facets.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::int32_t f) { return facets[f].first; });
  std::vector<Plane> planes;
  for (const std::int32_t f : order) {
    const bool known = std::ranges::any_of(planes, [&](const Plane& plane) {
      const auto near = [&](std::int32_t v) { return std::abs(plane.height(part.vertices[v])) <= same; };
      return plane.normal.dot(facets[f].second.normal) > 0 && std::ranges::all_of(part.triangles[f], near);
    });
    if (known) continue;
    Plane plane = facets[f].second;
    for (const Vec3& p : part.vertices) plane.offset = std::max(plane.offset, plane.normal.dot(p));
    planes.push_back(plane);
  }
  return planes;
}

double farthest_out(const std::vector<Plane>& planes, const Vec3& p) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Plane& plane : planes) most = std::max(most, plane.height(p));
  return most;
}

bool contains(const ConvexPart& part, const Vec3& p) {
  return std::ranges::all_of(part.triangles, [&](const Triangle& t) {
    return side_of({part.vertices[t[0]], part.vertices[t[1]], part.vertices[t[2]]}, p) <= 0;
  });
}

std::size_t corner_count(const Cell& cell) {
  std::size_t corners = 0;
  for (const CellFace& face : cell.faces) corners += face.loop.size();
  return corners / 3;  // three faces meet in a corner, or more
}

}  // namespace

ConvexPart space_below(const std::vector<Plane>& planes, const Vec3& low, const Vec3& high, double snap,
                       std::int32_t most_vertices) {
  std::vector<Plane> all;
  Cell cell = box_cell(low, high, all);
  for (const Plane& plane : planes) {
    const auto [lowest, highest] = cell.heights(plane);
    if (highest <= snap || lowest >= -snap) continue;
    all.push_back(plane);
    Cell rest = divide(cell, all, static_cast<std::int32_t>(all.size()) - 1, snap).side[1];
    if (corner_count(rest) <= static_cast<std::size_t>(most_vertices)) cell = std::move(rest);
  }
  return hull_of(cell.corners, 4 * snap);
}

void enclose(std::vector<ConvexPart>& parts, std::span<const Vec3> points, double same, std::int32_t most_vertices,
             Job& job) {
  std::vector<std::vector<Plane>> planes;
  planes.reserve(parts.size());
  for (const ConvexPart& part : parts) planes.push_back(few_planes(part, same));
  std::vector<std::vector<std::int32_t>> taken(parts.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 1024 == 0) job.report(static_cast<double>(i) / static_cast<double>(points.size()));
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double out = farthest_out(planes[k], points[i]);
      if (!(out < least)) continue;
      least = out;
      best = k;
    }
    taken[best].push_back(static_cast<std::int32_t>(i));
  }
  for (std::size_t k = 0; k < parts.size(); ++k) {
    job.poll();
    Eigen::AlignedBox3d box;
    const auto cover = [&](const Vec3& p) {
      box.extend(p);
      for (Plane& plane : planes[k]) plane.offset = std::max(plane.offset, plane.normal.dot(p));
    };
    for (const Vec3& p : parts[k].vertices) cover(p);
    for (const std::int32_t i : taken[k]) cover(points[i]);
    const Vec3 low = box.min(), high = box.max();
    const double size = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    for (double slack = kRounding * size;; slack *= 4) {
      job.poll();
      std::vector<Plane> moved = planes[k];
      for (Plane& plane : moved) plane.offset += slack;
      const Vec3 around = Vec3::Constant(2 * slack);
      // A large box cuts nothing off; where planes leave a side open, as there may be too few, a tight one closes it.
      const ConvexPart wide =
          space_below(moved, low - (high - low) - around, high + (high - low) + around, slack / 16, most_vertices);
      const ConvexPart tight = space_below(moved, low - around, high + around, slack / 16, most_vertices);
      const bool is_wide = !wide.vertices.empty() && wide.volume <= kLooser * tight.volume;
      ConvexPart part = is_wide ? wide : tight;
      if (part.vertices.empty()) continue;
      if (!std::ranges::all_of(taken[k], [&](std::int32_t i) { return contains(part, points[i]); })) continue;
      parts[k] = std::move(part);
      break;
    }
  }
}

}  // namespace isimp::convex
