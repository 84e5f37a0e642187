#include "complex/placement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "complex/flat_fit.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

/// Eigenvalues below this share of the largest do not fix a point.
constexpr double kTruncate = 0.2;
/// Planes of cells whose eigenvalues have a smaller share are parallel.
constexpr double kParallel = 1e-6;
/// Shares of the shortest edge: the furthest move of a corner to where cells meet; the distance at which planes meet.
constexpr double kOfShortest = 0.5, kMeets = 1e-6;
// The least work that is worth another thread:
constexpr std::int32_t kTogether = 64;  ///< corners that are placed
constexpr std::int32_t kFitted = 192,
                       kMoved = 384;  ///< in a turn, polygons that are fitted and corners that are moved

/// The step d, |d| <= radius, that best meets `a` d = `g` in the directions that `a` fixes.
Vec3 trusted_step(const Eigen::Matrix3d& a, const Vec3& g, double radius) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
  const Vec3 lambda = solver.eigenvalues();
  const Vec3 along = solver.eigenvectors().transpose() * g;
  const auto step = [&](double damping) {
    Vec3 d = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      if (lambda[i] > kTruncate * lambda[2]) d += along[i] / (lambda[i] + damping) * solver.eigenvectors().col(i);
    return d;
  };
  Vec3 free = step(0);
  if (free.norm() <= radius) return free;
  double low = 0, high = lambda[2] * 1e3;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (step(middle).norm() > radius ? low : high) = middle;
  }
  const Vec3 damped = step(high);
  return damped.norm() <= radius ? damped : Vec3(damped * (radius / damped.norm()));
}

/// The step of a corner from a place to where the planes at the corner meet, at most `radius` long.
/// \param held_only  only held planes count
Vec3 step_to(std::span<const Plane> planes, const Polygons& polygons, std::int32_t corner, const Vec3& from,
             double radius, bool held_only) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 g = Vec3::Zero();
  for (const std::int32_t q : polygons.at(corner)) {
    const Plane& p = planes[polygons.chart(q)];
    if (held_only && !p.held) continue;
    a += p.normal * p.normal.transpose();
    g += p.normal * p.normal.dot(p.centre - from);
  }
  return trusted_step(a, g, radius);
}

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

/// The nearest point where all held planes of a corner meet, if each is the plane of a cell of a round part: such planes
/// meet by symmetry, also at small angles. No value if they do not meet, or further off than the edges allow.
std::optional<Vec3> meeting_of_cells(std::span<const Plane> planes, const Polygons& polygons, std::int32_t corner,
                                     const Corners& corners) {
  if (corners.radius[corner] == 0) return std::nullopt;
  const Vec3& from = corners.position[corner];
  std::vector<const Plane*> held;
  for (const std::int32_t q : polygons.at(corner)) {
    const Plane& p = planes[polygons.chart(q)];
    if (!p.held) continue;
    if (!p.round) return std::nullopt;
    held.push_back(&p);
  }
  if (held.size() < 2) return std::nullopt;
  const double shortest =
      shortest_edge(polygons, corner, [&](std::int32_t c) -> const Vec3& { return corners.position[c]; });
  Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
  const Vec3 d = step_onto(held, kParallel, from, free);
  if (!(d.norm() <= kOfShortest * shortest)) return std::nullopt;
  const bool is_met = std::all_of(held.begin(), held.end(), [&](const Plane* p) {
    return std::abs(p->normal.dot(from + d - p->centre)) < kMeets * shortest;
  });
  return is_met ? std::optional(Vec3(from + d)) : std::nullopt;
}

/// Corners that depend on each other in the turns of flattening, and the polygons at these corners.
struct Group {
  std::vector<std::int32_t> corners, polygons;
  std::vector<std::int32_t> round, round_start{0};  ///< by corner: its polygons, as indices into `polygons`
  std::vector<Fit> fits;                            ///< by polygon

  [[nodiscard]] std::span<const std::int32_t> round_of(std::int32_t i) const {
    return std::span(round).subspan(round_start[i], round_start[i + 1] - round_start[i]);
  }
};

std::vector<Group> groups_of(const Polygons& polygons, std::span<const std::int32_t> moving) {
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
  std::vector<Group> groups;
  std::vector<std::int32_t> group(all.size()), place(all.size());
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(all.size()); ++i) {
    const std::int32_t low = lowest(i);
    if (low == i) groups.emplace_back();
    group[i] = low == i ? static_cast<std::int32_t>(groups.size()) - 1 : group[low];
    place[i] = static_cast<std::int32_t>(groups[group[i]].polygons.size());
    groups[group[i]].polygons.push_back(all[i]);
  }
  for (const std::int32_t c : moving) {
    Group& g = groups[group[index(polygons.at(c)[0])]];
    g.corners.push_back(c);
    for (const std::int32_t q : polygons.at(c)) g.round.push_back(place[index(q)]);
    g.round_start.push_back(static_cast<std::int32_t>(g.round.size()));
  }
  for (Group& g : groups) g.fits.resize(g.polygons.size());
  return groups;
}

}  // namespace

void set_radii(const Polygons& polygons, const Mesh& mesh, double reach, std::span<const std::int32_t> moving,
               Corners& corners) {
  const auto home = [&](std::int32_t c) -> const Vec3& { return mesh.vertices()[corners.vertex[c]]; };
  for (const std::int32_t c : moving)
    corners.radius.edit(c) = std::min(reach, kOfEdge * shortest_edge(polygons, c, home));
}

void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, const Threads& threads, Corners& corners) {
  const std::span<Vec3> position = corners.position.edit_all(moving);
  const auto is_met = [&](std::int32_t q, const Vec3& home) {
    const Plane& p = planes[polygons.chart(q)];
    return std::abs(p.normal.dot(p.centre - home)) < corners.still;
  };
  const auto place_one = [&](std::int32_t c) {
    const Vec3& home = mesh.vertices()[corners.vertex[c]];
    const auto around = polygons.at(c);
    const bool stays = std::all_of(around.begin(), around.end(), [&](std::int32_t q) { return is_met(q, home); });
    position[c] = stays ? home : home + step_to(planes, polygons, c, home, corners.radius[c], false);
  };
  threads.blocks(static_cast<std::int32_t>(moving.size()), kTogether,
                 [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                   for (const std::int32_t c : moving.subspan(begin, end - begin)) place_one(c);
                 });
}

void place_on_held(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
                   std::span<const std::int32_t> moving, const Threads& threads, Corners& corners) {
  // Where cells meet is found before any corner moves, since it depends on the edges.
  std::vector<std::optional<Vec3>> meeting;
  for (const std::int32_t c : moving) meeting.push_back(meeting_of_cells(planes, polygons, c, corners));
  for (std::size_t i = 0; i < moving.size(); ++i)
    if (meeting[i]) {
      const double far = (*meeting[i] - mesh.vertices()[corners.vertex[moving[i]]]).norm();
      if (far > corners.radius[moving[i]]) corners.radius.edit(moving[i]) = far;
    }
  const std::span<Vec3> position = corners.position.edit_all(moving);
  threads.blocks(static_cast<std::int32_t>(moving.size()), kTogether,
                 [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                   for (std::int32_t i = begin; i < end; ++i) {
                     const std::int32_t c = moving[i];
                     Vec3& at = position[c];
                     if (meeting[i]) {
                       at = *meeting[i];
                       continue;
                     }
                     at = within(at + step_to(planes, polygons, c, at, 2 * corners.radius[c], true),
                                 mesh.vertices()[corners.vertex[c]], corners.radius[c]);
                   }
                 });
}

void flatten(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
             std::span<const std::int32_t> moving, int rounds, const Threads& threads, Corners& corners) {
  std::vector<Group> groups = groups_of(polygons, moving);
  const std::span<Vec3> position = corners.position.edit_all(moving);
  const double still = corners.still * corners.still;
  // Large groups come first, so that no thread is left with one at the end.
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.corners.size() > b.corners.size(); });
  const auto fit = [&](Group& g, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i)
      g.fits[i].to(polygons.of(g.polygons[i]), position, planes[polygons.chart(g.polygons[i])]);
  };
  const auto move = [&](Group& g, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i) {
      const std::int32_t c = g.corners[i];
      const std::span<const std::int32_t> round = g.round_of(i);
      Vec3& at = position[c];
      Vec3 step = Vec3::Zero();
      for (const std::int32_t k : round) step -= g.fits[k].normal * g.fits[k].normal.dot(at - g.fits[k].centre);
      if (step.squaredNorm() < still) continue;
      at = within(at + step * (kRelax / static_cast<double>(round.size())), mesh.vertices()[corners.vertex[c]],
                  corners.radius[c]);
    }
  };
  // All threads share a large group in each turn. One thread computes all turns of a smaller group.
  std::int32_t large = 0;
  for (Group& g : groups) {
    const auto fits = static_cast<std::int32_t>(g.fits.size()), moves = static_cast<std::int32_t>(g.corners.size());
    if (fits < 2 * kFitted) break;
    ++large;
    for (int turn = 0; turn < rounds; ++turn) {
      threads.blocks(fits, kFitted, [&](std::int32_t, std::int32_t begin, std::int32_t end) { fit(g, begin, end); });
      threads.blocks(moves, kMoved, [&](std::int32_t, std::int32_t begin, std::int32_t end) { move(g, begin, end); });
    }
  }
  const auto small = static_cast<std::int32_t>(groups.size()) - large;
  const std::int32_t together = moving.size() < kTogether ? std::max(small, 1) : 1;
  threads.blocks(small, together, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = large + begin; i < large + end; ++i)
      for (int turn = 0; turn < rounds; ++turn) {
        fit(groups[i], 0, static_cast<std::int32_t>(groups[i].fits.size()));
        move(groups[i], 0, static_cast<std::int32_t>(groups[i].corners.size()));
      }
  });
}

}  // namespace isimp::meshing
