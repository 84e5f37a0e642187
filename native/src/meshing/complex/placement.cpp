#include "complex/placement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "complex/flat_fit.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

// tuned places
constexpr double kTruncate = 0.2;    ///< held planes whose eigenvalues have a smaller share of the largest fix no place
constexpr double kOfShortest = 0.5;  ///< share of the shortest edge: the furthest move of a corner to where cells meet
constexpr double kMeets = 1e-6;      ///< rounding: share of the shortest edge: the distance at which planes meet

// The least work that is worth another thread:
constexpr std::int32_t kPlaced = 64;   ///< work: corners that are placed
constexpr std::int32_t kFitted = 192;  ///< work: polygons that are fitted in a turn

/// The shortest edge at a corner.
/// \param place  returns the place of a corner
template <class Place>
double shortest_edge(const Polygons& polygons, std::int32_t corner, Place place) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const std::int32_t q : polygons.at(corner)) {
    const auto loop = polygons.of(q);
    const std::size_t n = loop.size(), i = std::find(loop.begin(), loop.end(), corner) - loop.begin();
    for (const std::size_t k : {i + 1, i + n - 1})
      shortest = std::min(shortest, (place(corner) - place(loop[k % n])).norm());
  }
  return shortest;
}

/// Whether all held planes of a corner meet, not further off than the edges allow, and each is the plane of a cell of a
/// round part: such planes meet by symmetry, also at small angles.
bool do_cells_meet(std::span<const Plane* const> held, const Polygons& polygons, std::int32_t corner,
                   const Corners& corners) {
  if (held.size() < 2 || !std::all_of(held.begin(), held.end(), [](const Plane* p) { return p->round; })) return false;
  const Vec3& from = corners.position[corner];
  const double shortest =
      shortest_edge(polygons, corner, [&](std::int32_t c) -> const Vec3& { return corners.position[c]; });
  Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
  const Vec3 d = step_onto(held, kParallel, from, free);
  if (!(d.norm() <= kOfShortest * shortest)) return false;
  return std::all_of(held.begin(), held.end(),
                     [&](const Plane* p) { return std::abs(p->normal.dot(from + d - p->centre)) < kMeets * shortest; });
}

/// Where a corner may be.
struct Anchor {
  Vec3 at;               ///< its place where it would move least, on the held planes
  Vec3 centre;           ///< where its vertex would move least
  double radius;         ///< largest distance from `centre`
  Eigen::Matrix3d free;  ///< projects to the directions in which it may move
};

/// Corners that depend on each other, and the polygons at these corners.
struct CornerGroup {
  std::vector<std::int32_t> corners, polygons;
  std::vector<Anchor> anchors;                      ///< by corner
  std::vector<double> weight;                       ///< by polygon: the area that each of its corners stands for
  std::vector<std::int32_t> round, round_start{0};  ///< by corner: its polygons, as indices into `polygons`
  std::vector<Fit> fits;                            ///< by polygon

  [[nodiscard]] std::span<const std::int32_t> round_of(std::int32_t i) const {
    return std::span(round).subspan(round_start[i], round_start[i + 1] - round_start[i]);
  }
};

std::vector<CornerGroup> groups_of(const Polygons& polygons, std::span<const std::int32_t> moving) {
  std::vector<std::int32_t> all;  // in rising order; from here on polygons are named by their index
  for (const std::int32_t c : moving) all.insert(all.end(), polygons.at(c).begin(), polygons.at(c).end());
  sort_unique(all);
  const auto index = [&](std::int32_t q) {
    return static_cast<std::int32_t>(std::lower_bound(all.begin(), all.end(), q) - all.begin());
  };
  // Polygons that have a moving corner in common hang together, each on a lower one down to the lowest.
  std::vector<std::int32_t> on = numbers_below(static_cast<std::int32_t>(all.size()));
  const auto lowest = [&](std::int32_t i) {
    while (on[i] != i) i = on[i] = on[on[i]];
    return i;
  };
  for (const std::int32_t c : moving) {
    std::int32_t low = kNone;
    for (const std::int32_t q : polygons.at(c)) {
      const std::int32_t other = lowest(index(q));
      if (low != kNone) on[std::max(low, other)] = std::min(low, other);
      low = low == kNone ? other : std::min(low, other);
    }
  }
  std::vector<CornerGroup> groups;
  std::vector<std::int32_t> group(all.size()), place(all.size());
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(all.size()); ++i) {
    const std::int32_t low = lowest(i);
    if (low == i) groups.emplace_back();
    group[i] = low == i ? static_cast<std::int32_t>(groups.size()) - 1 : group[low];
    place[i] = static_cast<std::int32_t>(groups[group[i]].polygons.size());
    groups[group[i]].polygons.push_back(all[i]);
  }
  for (const std::int32_t c : moving) {
    CornerGroup& g = groups[group[index(polygons.at(c)[0])]];
    g.corners.push_back(c);
    for (const std::int32_t q : polygons.at(c)) g.round.push_back(place[index(q)]);
    g.round_start.push_back(static_cast<std::int32_t>(g.round.size()));
  }
  for (CornerGroup& g : groups) g.fits.resize(g.polygons.size());
  return groups;
}

/// Where a corner may be: on the held planes at it, as far as these meet within its radius.
Anchor anchor_of(std::span<const Plane> planes, const Polygons& polygons, std::int32_t corner, const Vec3& home,
                 Corners& corners) {
  const Vec3& from = corners.position[corner];
  Anchor a{from, home, corners.radius[corner], Eigen::Matrix3d::Identity()};
  std::vector<const Plane*> held;
  for (const std::int32_t q : polygons.at(corner))
    if (planes[polygons.chart(q)].held) held.push_back(&planes[polygons.chart(q)]);
  if (held.empty() || a.radius == 0) return a;
  const bool is_met = do_cells_meet(held, polygons, corner, corners);
  a.at += step_onto(held, is_met ? kParallel : kTruncate, from, a.free);
  a.centre = a.at + a.free * (home - a.at);
  const double away = (a.centre - home).norm();
  if (is_met && away > a.radius) corners.radius.edit(corner) = a.radius = away;
  if (away > a.radius) a.at = a.centre = within(a.centre, home, a.radius);
  a.radius = std::sqrt(std::max(0.0, a.radius * a.radius - away * away));
  return a;
}

/// The place of least energy of corner i of a group for the planes of its polygons.
/// \param tie  the area that ties it to its place at the start
Vec3 place_of_least(const CornerGroup& g, std::int32_t i, double tie) {
  const Anchor& anchor = g.anchors[i];
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 r = Vec3::Zero();
  double area = 0;
  for (const std::int32_t k : g.round_of(i)) {
    const Vec3 n = anchor.free * g.fits[k].normal;
    area += g.weight[k];
    a += g.weight[k] * n * n.transpose();
    r += g.weight[k] * g.fits[k].normal.dot(g.fits[k].centre - anchor.at) * n;
  }
  if (!(area > 0)) return anchor.at;
  const Vec3 step = (a + tie / kOfBend * Eigen::Matrix3d::Identity()).inverse() * r;
  return within(anchor.at + step, anchor.centre, anchor.radius);
}

}  // namespace

void set_radii(const Polygons& polygons, const Mesh& mesh, double reach, std::span<const std::int32_t> moving,
               Corners& corners) {
  const auto home = [&](std::int32_t c) -> const Vec3& { return mesh.vertices()[corners.vertex[c]]; };
  for (const std::int32_t c : moving)
    corners.radius.edit(c) = std::min(reach, kOfEdge * shortest_edge(polygons, c, home));
}

void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, int rounds, const Threads& threads, Corners& corners) {
  std::vector<CornerGroup> groups = groups_of(polygons, moving);
  for (CornerGroup& g : groups)
    for (const std::int32_t q : g.polygons) {
      const std::int32_t l = polygons.chart(q);
      g.weight.push_back(planes[l].area / static_cast<double>(polygons.count_of(l) * std::ssize(polygons.of(q))));
    }
  for (CornerGroup& g : groups)
    for (const std::int32_t c : g.corners)
      g.anchors.push_back(anchor_of(planes, polygons, c, mesh.vertices()[corners.vertex[c]], corners));
  const std::span<Vec3> position = corners.position.edit_all(moving);
  const double tie = kOfTie * mesh.graph().area / mesh.vertex_count();
  const double still = corners.still * corners.still;
  // Large groups come first, so that no thread is left with one at the end.
  std::stable_sort(groups.begin(), groups.end(),
                   [](const CornerGroup& a, const CornerGroup& b) { return a.corners.size() > b.corners.size(); });
  // The first turn has the planes of the charts, as noise of the vertices would turn planes of few corners.
  const auto fit = [&](CornerGroup& g, std::int32_t begin, std::int32_t end, int turn) {
    for (std::int32_t i = begin; i < end; ++i)
      g.fits[i].to(polygons.of(g.polygons[i]), position, planes[polygons.chart(g.polygons[i])],
                   turn == 0 ? 0 : kOfBend);
  };
  const auto move = [&](CornerGroup& g, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) {
      const std::int32_t c = g.corners[i];
      const Vec3 to = place_of_least(g, i, tie);
      if ((to - position[c]).squaredNorm() >= still) position[c] = to;
    }
  };
  // All threads share a large group in each turn. One thread computes all turns of a smaller group.
  std::int32_t large = 0;
  for (CornerGroup& g : groups) {
    const auto fits = static_cast<std::int32_t>(g.fits.size()), moves = static_cast<std::int32_t>(g.corners.size());
    if (fits < 2 * kFitted) break;
    ++large;
    for (int turn = 0; turn < rounds; ++turn) {
      threads.blocks(fits, kFitted,
                     [&](std::int32_t, std::int32_t begin, std::int32_t end) { fit(g, begin, end, turn); });
      threads.blocks(moves, 384, [&](std::int32_t, std::int32_t begin, std::int32_t end) { move(g, begin, end); });
    }
  }
  const auto small = static_cast<std::int32_t>(groups.size()) - large;
  const std::int32_t together = moving.size() < kPlaced ? std::max(small, 1) : 1;
  threads.blocks(small, together, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = large + begin; i < large + end; ++i)
      for (int turn = 0; turn < rounds; ++turn) {
        fit(groups[i], 0, static_cast<std::int32_t>(groups[i].fits.size()), turn);
        move(groups[i], 0, static_cast<std::int32_t>(groups[i].corners.size()));
      }
  });
}

}  // namespace isimp::meshing
