// Describes openings, and finds the openings that the caller keeps.
#include <algorithm>

#include "cleaning/close.h"

namespace isimp::detail {
namespace {

// tuned repairs
constexpr double kReach =
    0.25;  // share of an opening's length: a circle's radius is .16 of it, its neighbour's center .32 off

/// The center of a loop's length, which does not depend on how its vertices are spread.
Vec3 center_of(const MeshArrays& arrays, const std::vector<std::int32_t>& loop) {
  Vec3 sum = Vec3::Zero();
  double total = 0;
  const Vec3& first = arrays.vertices[loop[0]];  // sums of differences are exact enough far from zero, too
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = arrays.vertices[loop[i]], &b = arrays.vertices[loop[(i + 1) % loop.size()]];
    const double each = (b - a).norm();
    sum += each * ((a - first) + (b - first)) / 2;
    total += each;
  }
  return total > 0 ? Vec3(first + sum / total) : first;
}

double distance_from_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (a + t * along - p).norm();
}

}  // namespace

FoundOpening found_opening(const MeshArrays& arrays, const Opening& opening, bool kept) {
  FoundOpening found;
  found.handle = opening.kind == RepairKind::cut_handles;
  found.kept = kept;
  found.length = opening.length;
  const Vec3 first = center_of(arrays, opening.loops.front());
  found.center = first + (center_of(arrays, opening.loops.back()) - first) / 2;
  for (const std::vector<std::int32_t>& loop : opening.loops) {
    std::vector<Vec3>& line = found.loops.emplace_back();
    for (const std::int32_t v : loop) line.push_back(arrays.vertices[v]);
  }
  return found;
}

bool is_kept(const MeshArrays& arrays, const Opening& opening, const std::vector<Vec3>& keep) {
  if (keep.empty()) return false;
  const Vec3 a = center_of(arrays, opening.loops.front()), b = center_of(arrays, opening.loops.back());
  return std::any_of(keep.begin(), keep.end(),
                     [&](const Vec3& p) { return distance_from_segment(p, a, b) <= kReach * opening.length; });
}

}  // namespace isimp::detail
