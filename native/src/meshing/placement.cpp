#include "placement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace isimp::meshing {
namespace {

/// Eigenvalues below this share of the largest do not fix a point.
constexpr double kTruncate = 0.2;
/// How much further than to the mean of its projections a corner goes in a turn; from 2 on it would not settle.
constexpr double kRelax = 1.7;
/// A corner may move by this times the length of its shortest edge.
constexpr double kOfEdge = 1.5;
// What one thread does at a time, worth waking another:
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

Vec3 within(const Vec3& p, const Vec3& home, double radius) {
  const Vec3 d = p - home;
  const double length = d.norm();
  return length > radius ? Vec3(home + d * (radius / length)) : p;
}

/// The step of a corner from a place to where the planes round it meet, at most `radius` long.
/// \param held_only  only those that are held count
Vec3 step_to(std::span<const Plane> planes, const Polygons& polygons, std::int32_t corner, const Vec3& from,
             double radius, bool held_only) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3 g = Vec3::Zero();
  for (const std::int32_t q : polygons.at(corner)) {
    const Plane& p = planes[polygons.piece(q)];
    if (held_only && !p.held) continue;
    a += p.normal * p.normal.transpose();
    g += p.normal * p.normal.dot(p.centre - from);
  }
  return trusted_step(a, g, radius);
}

/// A symmetric matrix, its trace 1.
struct Spread {
  double xx, xy, xz, yy, yz, zz;

  [[nodiscard]] Vec3 times(const Vec3& n) const {
    return {xx * n[0] + xy * n[1] + xz * n[2], xy * n[0] + yy * n[1] + yz * n[2], xz * n[0] + yz * n[1] + zz * n[2]};
  }
  /// The sum of the products of two eigenvalues each.
  [[nodiscard]] double minors() const { return xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz; }
  /// The adjugate of this less a multiple of one, times n.
  [[nodiscard]] Vec3 adjugate_times(double less, const Vec3& n) const {
    const double a = xx - less, b = yy - less, c = zz - less;
    return Spread{b * c - yz * yz, xz * yz - xy * c, xy * yz - b * xz,
                  a * c - xz * xz, xy * xz - a * yz, a * b - xy * xy}
        .times(n);
  }
};

/// Of the largest eigenvalue: with the two smaller ones below it, a spread is a line, on which no plane is fixed.
constexpr double kLine = 1e-4;

/// Turns a unit vector that is near the direction of the smallest eigenvalue into that direction, unless the spread is
/// a line. Each step takes an error to about its third power.
/// \return whether it could; else it may be another's direction
/// Source: the Rayleigh quotient iteration.
bool refine(const Spread& k, Vec3& n) {
  constexpr int kSteps = 3;
  constexpr double kSmall = 1e-6;  // squared, of a step: the one after it would change nothing that counts
  double turned = 1;
  for (int step = 0; step < kSteps && turned > kSmall; ++step) {
    const Vec3 next = k.adjugate_times(n.dot(k.times(n)), n);
    const double length = next.norm();
    if (!(length > 1e-12)) return false;
    turned = (next / length - n).squaredNorm();
    n = next / length;
  }
  // Of the other two the sum and the product.
  const double least = n.dot(k.times(n)), sum = 1 - least, product = k.minors() - least * sum;
  const bool is_least = 2 * least < sum && product - least * sum + least * least > 0;
  return turned <= kSmall && is_least && product >= kLine * sum * sum;
}

/// A plane fitted to the corners of a polygon, held near that of the piece: flat polygons could else settle anywhere,
/// and those of a bulge would drift inwards. Where the corners do not fix a plane, that of the piece.
struct Fit {
  Vec3 normal, centre;
  bool fixed = false;

  void to(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane);

 private:
  bool find_normal(const Spread& k, const Vec3& of_piece);
};

/// In the turns after the first the normal is near the one before.
bool Fit::find_normal(const Spread& k, const Vec3& of_piece) {
  if (!fixed || !refine(k, normal)) {
    Eigen::Matrix3d full;
    full << k.xx, k.xy, k.xz, k.xy, k.yy, k.yz, k.xz, k.yz, k.zz;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(full);
    if (solver.eigenvalues()[1] < kLine * solver.eigenvalues()[2]) return false;
    normal = solver.eigenvectors().col(0);
  }
  const double same = normal.dot(of_piece);
  if (same < 0) normal = -normal;
  return std::abs(same) >= 0.3;
}

void Fit::to(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane) {
  if (plane.held) {
    normal = plane.normal;
    centre = plane.centre;
    return;
  }
  constexpr double kOfSpread = 0.05;  // how much the piece's own spread counts beside the corners'
  constexpr double kOfPlane = 0.1;    // how far towards the plane of the piece that of the corners is shifted
  const double share = 1 / static_cast<double>(polygon.size());
  centre = Vec3::Zero();
  for (const std::int32_t c : polygon) centre += position[c];
  centre *= share;
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const std::int32_t c : polygon) {
    const Vec3 d = position[c] - centre;
    xx += d[0] * d[0];
    xy += d[0] * d[1];
    xz += d[0] * d[2];
    yy += d[1] * d[1];
    yz += d[1] * d[2];
    zz += d[2] * d[2];
  }
  const double trace = (xx + yy + zz) * share + kOfSpread * plane.spread.trace();
  const double a = share / trace, b = kOfSpread / trace;
  const auto& s = plane.spread;
  fixed = xx + yy + zz > 0 && find_normal({a * xx + b * s(0, 0), a * xy + b * s(0, 1), a * xz + b * s(0, 2),
                                           a * yy + b * s(1, 1), a * yz + b * s(1, 2), a * zz + b * s(2, 2)},
                                          plane.normal);
  if (!fixed) {
    normal = plane.normal;
    return;
  }
  centre += kOfPlane * normal.dot(plane.centre - centre) * normal;
}

/// Corners of which each may follow others in the turns of flattening, and the polygons round them.
struct Group {
  std::vector<std::int32_t> corners, polygons;
  std::vector<std::int32_t> round, round_start{0};  ///< by corner: the polygons round it, by their places here
  std::vector<Fit> fits;                            ///< by polygon

  [[nodiscard]] std::span<const std::int32_t> round_of(std::int32_t i) const {
    return std::span(round).subspan(round_start[i], round_start[i + 1] - round_start[i]);
  }
};

std::vector<Group> groups_of(const Polygons& polygons, std::span<const std::int32_t> moving) {
  // Polygons that have a moving corner in common hang together, each on a lower one down to the lowest.
  std::vector<std::int32_t> on(polygons.numbers(), kNone);
  const auto lowest = [&](std::int32_t q) {
    while (on[q] != q) q = on[q] = on[on[q]];
    return q;
  };
  for (const std::int32_t c : moving) {
    std::int32_t low = kNone;
    for (const std::int32_t q : polygons.at(c)) {
      if (on[q] == kNone) on[q] = q;
      const std::int32_t other = lowest(q);
      if (low != kNone) on[std::max(low, other)] = std::min(low, other);
      low = low == kNone ? other : std::min(low, other);
    }
  }
  std::vector<Group> groups;
  std::vector<std::int32_t> group(polygons.numbers()), place(polygons.numbers());
  for (std::int32_t q = 0; q < polygons.numbers(); ++q) {
    if (on[q] == kNone) continue;
    const std::int32_t low = lowest(q);
    if (low == q) groups.emplace_back();
    group[q] = low == q ? static_cast<std::int32_t>(groups.size()) - 1 : group[low];
    place[q] = static_cast<std::int32_t>(groups[group[q]].polygons.size());
    groups[group[q]].polygons.push_back(q);
  }
  for (const std::int32_t c : moving) {
    Group& g = groups[group[polygons.at(c)[0]]];
    g.corners.push_back(c);
    for (const std::int32_t q : polygons.at(c)) g.round.push_back(place[q]);
    g.round_start.push_back(static_cast<std::int32_t>(g.round.size()));
  }
  for (Group& g : groups) g.fits.resize(g.polygons.size());
  return groups;
}

}  // namespace

void set_radii(const Polygons& polygons, const Mesh& mesh, double reach, std::span<const std::int32_t> moving,
               Corners& corners) {
  const auto home = [&](std::int32_t c) -> const Vec3& { return mesh.vertices()[corners.vertex[c]]; };
  for (const std::int32_t c : moving) {
    double least = reach;
    for (const std::int32_t q : polygons.at(c)) {
      const auto loop = polygons.of(q);
      const std::size_t n = loop.size(), i = std::find(loop.begin(), loop.end(), c) - loop.begin();
      for (const std::size_t k : {i + 1, i + n - 1})
        least = std::min(least, kOfEdge * (home(c) - home(loop[k % n])).norm());
    }
    corners.radius.edit(c) = least * corners.pull[c];
  }
}

void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, const Threads& threads, Corners& corners) {
  const std::span<Vec3> position = corners.position.edit_all(moving);
  const auto is_met = [&](std::int32_t q, const Vec3& home) {
    const Plane& p = planes[polygons.piece(q)];
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
  const std::span<Vec3> position = corners.position.edit_all(moving);
  threads.blocks(static_cast<std::int32_t>(moving.size()), kTogether,
                 [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                   for (const std::int32_t c : moving.subspan(begin, end - begin)) {
                     Vec3& at = position[c];
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
  // Those that are large first, so that no thread is left with one at the end.
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.corners.size() > b.corners.size(); });
  const auto fit = [&](Group& g, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i)
      g.fits[i].to(polygons.of(g.polygons[i]), position, planes[polygons.piece(g.polygons[i])]);
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
  // A large one is shared in each turn, of the others each is done by one thread.
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
