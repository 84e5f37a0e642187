// The corners of a profile that is cut into straight parts.
#include <Eigen/Geometry>
#include <algorithm>

#include "cells/cells.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

constexpr double kDampingOfCorners = 1e-6;  ///< rounding: share of the largest weight: a corner without faces stays

Vec2 across(const Vec2& edge) { return Vec2(edge.y(), -edge.x()).normalized(); }

}  // namespace

std::vector<Vec2> fitted_corners(std::vector<Vec2> corners, bool closed, std::span<const ProfileSample> samples) {
  const std::size_t parts = corners.size() - 1;
  // A corner moves along the mean of the normals of its two parts: one unknown, so that the system is linear.
  std::vector<Vec2> normal, way(corners.size(), Vec2::Zero());
  for (std::size_t k = 0; k < parts; ++k) {
    normal.push_back(across(corners[k + 1] - corners[k]));
    way[k] += normal[k];
    way[k + 1] += normal[k];
  }
  if (closed) way.front() = way.back() = Vec2(way.front() + way.back());
  for (std::size_t k = 0; k < way.size(); ++k)
    way[k] = way[k].norm() > 1 ? Vec2(way[k].normalized()) : normal[std::min(k, parts - 1)];
  const std::size_t unknowns = closed ? parts : parts + 1;
  const auto n = static_cast<Eigen::Index>(unknowns);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (const auto& [weight, place, part] : samples) {
    const Vec2 edge = corners[part + 1] - corners[part], from = place - corners[part];
    const double share = from.dot(edge) / edge.squaredNorm();
    const std::array<std::size_t, 2> at{part, (part + 1) % unknowns};
    const std::array<double, 2> moves{(1 - share) * way[part].dot(normal[part]),
                                      share * way[part + 1].dot(normal[part])};
    for (std::size_t i = 0; i < 2; ++i) {
      b[at[i]] += weight * moves[i] * from.dot(normal[part]);
      for (std::size_t j = 0; j < 2; ++j) a(at[i], at[j]) += weight * moves[i] * moves[j];
    }
  }
  a.diagonal().array() += kDampingOfCorners * std::max(a.diagonal().maxCoeff(), kTiny);
  const Eigen::VectorXd step = solve_definite(a, b);
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k] += step[static_cast<Eigen::Index>(k % unknowns)] * way[k];
  return corners;
}

}  // namespace isimp::curved
