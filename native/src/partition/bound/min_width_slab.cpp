#include "bound/min_width_slab.h"

#include <algorithm>
#include <cmath>

#include "isimp/core/symmetric.h"

namespace isimp::detail {
namespace {

// tuned bound
constexpr int kSlabRounds = 12;     // rounds of reweighting the points
constexpr double kLeastTurn = 0.8;  // cosine: planes stay nearer than that to the mean normal
constexpr double kHopeless = 1.5;   // times the allowed width: no turning mends that
constexpr int kLooks = 5;           // passes over all points to make them fit
constexpr std::size_t kCore = 24;   // points kept

Slab across(std::span<const Vec3> points, const Vec3& normal) {
  Slab slab{.normal = normal};
  for (const Vec3& p : points) slab.add(p);
  return slab;
}

/// The slab of all points across a normal, its outermost points put in the core; stops where it is too wide.
Slab look(const Corners& corners, std::span<const std::int32_t> some, std::span<const std::int32_t> others,
          const Vec3& normal, double width, Core& core) {
  Slab slab{.normal = normal};
  Vec3 lowest = Vec3::Zero(), highest = Vec3::Zero();
  const auto add = [&](std::int32_t v) {
    const Vec3& p = corners.vertex(v);
    const double z = normal.dot(p);
    if (z < slab.low) {
      slab.low = z;
      lowest = p;
    }
    if (z > slab.high) {
      slab.high = z;
      highest = p;
    }
  };
  // Alternates between the lists, outwards from the place where both meet.
  for (std::size_t k = 0; k < std::max(some.size(), others.size()) && slab.width() <= width; ++k) {
    if (k < some.size()) add(some[some.size() - 1 - k]);
    if (k < others.size()) add(others[k]);
  }
  core.push_back(lowest);
  core.push_back(highest);
  return slab;
}

/// Keeps the points that are nearest to the planes of a slab.
void prune(Core& core, const Slab& slab) {
  if (core.size() <= kCore) return;
  const auto depth = [&](const Vec3& p) { return std::abs(slab.normal.dot(p) - slab.middle()); };
  std::stable_sort(core.begin(), core.end(), [&](const Vec3& a, const Vec3& b) { return depth(a) > depth(b); });
  core.resize(kCore);
}

}  // namespace

Slab narrowest(std::span<const Vec3> points, const Vec3& from, double enough) {
  Slab best = across(points, from);
  if (points.size() < 3) return best;
  const Vec3 right = from.unitOrthogonal(), up = from.cross(right);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  double reach = 0.0;
  for (const Vec3& p : points) reach = std::max(reach, (p - middle).norm());
  if (!(reach > 0)) return best;
  std::vector<double> weight(points.size(), 1.0);
  for (int round = 0; round < kSlabRounds && best.width() > enough; ++round) {
    Eigen::Matrix3d normal_matrix = 1e-9 * Eigen::Matrix3d::Identity();
    Vec3 rhs = Vec3::Zero();
    double total = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3 p = (points[k] - middle) / reach;
      const Vec3 row(right.dot(p), up.dot(p), 1.0);
      normal_matrix += weight[k] * row * row.transpose();
      rhs += weight[k] * from.dot(p) * row;
      total += weight[k];
    }
    const Vec3 plane = solve_definite(normal_matrix, rhs);
    if (!plane.allFinite()) break;
    const Vec3 normal = (from - plane.x() * right - plane.y() * up).normalized();
    if (normal.dot(from) < kLeastTurn) break;
    const Slab turned = across(points, normal);
    if (turned.width() < best.width()) best = turned;
    double most = 0.0, square = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3 p = (points[k] - middle) / reach;
      const double off = std::abs(from.dot(p) - plane.x() * right.dot(p) - plane.y() * up.dot(p) - plane.z());
      square += weight[k] * off * off;
      weight[k] *= off;
      most = std::max(most, weight[k]);
    }
    // No plane is nearer to all points than the weighted mean.
    if (2 * reach * std::sqrt(square / total) * normal.dot(from) > enough || !(most > 0)) break;
    for (double& w : weight) w /= most;
  }
  return best;
}

bool turn_to_fit(const Corners& corners, std::span<const std::int32_t> some, std::span<const std::int32_t> others,
                 double width, Slab& slab, Core& core) {
  Vec3 normal = slab.normal;
  const Vec3 mean = normal;
  for (int looks = 0; looks < kLooks; ++looks) {
    const double wide = across(core, normal).width();
    if (wide > kHopeless * width) return false;
    if (wide > width) {
      const Slab known = narrowest(core, mean, width);
      if (known.width() > width) return false;
      normal = known.normal;
    }
    const Slab seen = look(corners, some, others, normal, width, core);
    if (seen.width() > width) continue;
    slab = seen;
    prune(core, slab);
    return true;
  }
  return false;
}

}  // namespace isimp::detail
