// Decides which half-edges of a soup become one edge.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "surface/soup.h"

namespace isimp::detail {
namespace {

constexpr double kSameAngle = 1e-9;  // rounding: radians between faces that lie on each other except for rounding

/// Joins pairs that were an edge of two faces already before welding, and leaves the others in `group`.
void keep_old_pairs(Soup& soup, std::vector<std::int32_t>& group) {
  const auto name = [&](std::int32_t h) {
    const Triangle& t = soup.named[h / 3];
    return std::minmax({t[h % 3], t[(h + 1) % 3]});
  };
  std::stable_sort(group.begin(), group.end(), [&](std::int32_t g, std::int32_t h) { return name(g) < name(h); });
  std::vector<std::int32_t> rest;
  for (std::size_t i = 0; i < group.size();) {
    std::size_t end = i + 1;
    while (end < group.size() && name(group[end]) == name(group[i])) ++end;
    if (end - i == 2) {
      soup.join(group[i], group[i + 1]);
    } else {
      rest.insert(rest.end(), group.begin() + static_cast<std::ptrdiff_t>(i),
                  group.begin() + static_cast<std::ptrdiff_t>(end));
    }
    i = end;
  }
  group = std::move(rest);
}

/// A face at a non-manifold edge, as seen along the edge.
struct Leaf {
  std::int32_t half_edge;
  bool ends_wedge;  ///< the solid that the face bounds lies before it in the order of angles, not after it
  double angle;     ///< in [0, 2 pi), counter-clockwise
  int rank = 0;     ///< rank among faces that lie on each other
};

std::vector<Leaf> leaves_by_angle(const Soup& soup, const std::vector<std::int32_t>& group,
                                  const std::vector<char>& reversed) {
  const std::int32_t u = std::min(soup.from(group[0]), soup.to(group[0]));
  const std::int32_t v = std::max(soup.from(group[0]), soup.to(group[0]));
  const Vec3 axis = (soup.vertices[v] - soup.vertices[u]).normalized();
  Vec3 x = Vec3::Zero(), y = Vec3::Zero();
  std::vector<Leaf> leaves;
  for (const std::int32_t h : group) {
    const Vec3 side = soup.vertices[soup.apex(h)] - soup.vertices[u];
    const Vec3 across = side - axis * axis.dot(side);
    if (x.isZero(0) && across.norm() > kSameAngle * side.norm()) {  // the first face that has an area is at angle 0
      x = across.normalized();
      y = axis.cross(x);
    }
    const bool along = (soup.from(h) == u) != (!reversed.empty() && reversed[h / 3]);
    double angle = std::atan2(across.dot(y), across.dot(x));
    if (angle < -kSameAngle) angle += 2 * std::numbers::pi;
    leaves.push_back({h, along, std::max(angle, 0.0)});
  }
  std::sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) {
    return std::pair(a.angle, a.half_edge) < std::pair(b.angle, b.half_edge);
  });
  for (std::size_t i = 1; i < leaves.size(); ++i)
    leaves[i].rank = leaves[i - 1].rank + (leaves[i].angle - leaves[i - 1].angle > kSameAngle);
  // Where two solids share a wall, the one before it ends before the one after it begins.
  std::stable_sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) {
    return std::pair(a.rank, !a.ends_wedge) < std::pair(b.rank, !b.ends_wedge);
  });
  return leaves;
}

}  // namespace

Undecided join_simple_edges(Soup& soup, const EdgeGroups& edges, Job& job) {
  soup.opposite.assign(3 * soup.named.size(), kNone);
  Undecided undecided;
  std::vector<std::int32_t> group;
  const auto join = [&](std::int32_t g, std::int32_t h) {
    soup.join(g, h);
    if (soup.from(g) == soup.from(h)) undecided.same_way.push_back(g);
  };
  edges.for_each(job, [&](const EdgeGroup& edge) {
    if (edge.size() == 2) return join(edge[0], edge[1]);
    if (edge.size() < 3) return;
    group.clear();
    for (std::size_t i = 0; i < edge.size(); ++i) group.push_back(edge[i]);
    soup.contested.insert(soup.contested.end(), group.begin(), group.end());
    if (!soup.welded.empty()) {
      keep_old_pairs(soup, group);
      for (std::size_t i = 0; i < edge.size(); ++i)
        if (const std::int32_t g = edge[i], h = soup.opposite[g]; h > g && soup.from(g) == soup.from(h))
          undecided.same_way.push_back(g);
    }
    if (group.size() == 2) join(group[0], group[1]);
    if (group.size() > 2) undecided.non_manifold.push_back(group);
  });
  return undecided;
}

/// Around the edge, wedges of solids begin and end like brackets. The face that opens a bracket is joined to the one
/// that closes it, so the faces of one wedge stay joined. Faces without a partner get a border.
void join_non_manifold_edges(Soup& soup, const std::vector<std::vector<std::int32_t>>& non_manifold,
                             const std::vector<char>& reversed) {
  for (const std::vector<std::int32_t>& group : non_manifold) {
    soup.count_face(RepairKind::split_edges, group[0] / 3);
    const std::vector<Leaf> leaves = leaves_by_angle(soup, group, reversed);
    std::vector<std::int32_t> open;
    for (std::size_t i = 0; i < 2 * leaves.size(); ++i) {  // twice around, since the start was arbitrary
      const Leaf& leaf = leaves[i % leaves.size()];
      if (!leaf.ends_wedge) {
        if (i < leaves.size()) open.push_back(leaf.half_edge);
      } else if (!open.empty() && soup.opposite[leaf.half_edge] == kNone) {
        soup.join(open.back(), leaf.half_edge);
        open.pop_back();
      }
    }
  }
}

}  // namespace isimp::detail
