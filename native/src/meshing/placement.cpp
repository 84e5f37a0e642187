#include "placement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sorted.h"

namespace isimp::meshing {
namespace {

/// Eigenvalues below this share of the largest do not fix a point.
constexpr double kTruncate = 0.2;
/// How much further than to the mean of its projections a corner goes in a turn; from 2 on it would not settle.
constexpr double kRelax = 1.7;
/// A corner may move by this times the length of its shortest edge.
constexpr double kOfEdge = 1.5;

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

/// Fits a plane to the corners of a polygon, held near that of the piece: flat polygons could else settle anywhere, and
/// those of a bulge would drift inwards. Where the corners do not fix a plane, that of the piece.
struct Fit {
  Vec3 normal, centre;
};

Fit fit(std::span<const std::int32_t> polygon, std::span<const Vec3> position, const Plane& plane) {
  constexpr double kOfSpread = 0.05;  // how much the piece's own spread counts beside the corners'
  constexpr double kOfPlane = 0.1;    // how far towards the plane of the piece that of the corners is shifted
  Fit f{plane.normal, Vec3::Zero()};
  for (const std::int32_t c : polygon) f.centre += position[c];
  f.centre /= static_cast<double>(polygon.size());
  Eigen::Matrix3d k = Eigen::Matrix3d::Zero();
  for (const std::int32_t c : polygon) k += (position[c] - f.centre) * (position[c] - f.centre).transpose();
  k /= static_cast<double>(polygon.size());
  if (k.trace() <= 0) return f;
  k += kOfSpread * plane.spread;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(k);
  if (solver.eigenvalues()[1] < 1e-4 * solver.eigenvalues()[2]) return f;
  const Vec3 n = solver.eigenvectors().col(0);
  const double same = n.dot(plane.normal);
  if (std::abs(same) < 0.3) return f;
  f.normal = same < 0 ? Vec3(-n) : n;
  f.centre += kOfPlane * f.normal.dot(plane.centre - f.centre) * f.normal;
  return f;
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
    corners.radius[c] = least * corners.pull[c];
  }
}

void place(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
           std::span<const std::int32_t> moving, Corners& corners) {
  for (const std::int32_t c : moving) {
    const Vec3& home = mesh.vertices()[corners.vertex[c]];
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Vec3 g = Vec3::Zero();
    for (const std::int32_t q : polygons.at(c)) {
      const Plane& p = planes[polygons.piece[q]];
      a += p.normal * p.normal.transpose();
      g += p.normal * p.normal.dot(p.centre - home);
    }
    corners.position[c] = home + trusted_step(a, g, corners.radius[c]);
  }
}

void flatten(const Polygons& polygons, const Mesh& mesh, std::span<const Plane> planes,
             std::span<const std::int32_t> moving, int rounds, Corners& corners) {
  std::vector<std::int32_t> near;  // the polygons round the moving corners
  for (const std::int32_t c : moving) near.insert(near.end(), polygons.at(c).begin(), polygons.at(c).end());
  sort_unique(near);
  std::vector<Fit> fits(polygons.piece.size());
  std::vector<Vec3> next(moving.size());
  for (int round = 0; round < rounds; ++round) {
    for (const std::int32_t q : near) fits[q] = fit(polygons.of(q), corners.position, planes[polygons.piece[q]]);
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const std::int32_t c = moving[i];
      const Vec3& at = corners.position[c];
      Vec3 move = Vec3::Zero();
      for (const std::int32_t q : polygons.at(c)) move -= fits[q].normal * fits[q].normal.dot(at - fits[q].centre);
      next[i] = within(at + move * (kRelax / static_cast<double>(polygons.at(c).size())),
                       mesh.vertices()[corners.vertex[c]], corners.radius[c]);
    }
    for (std::size_t i = 0; i < moving.size(); ++i) corners.position[moving[i]] = next[i];
  }
}

}  // namespace isimp::meshing
