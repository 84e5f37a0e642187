#include "isimp/simplify/within.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace isimp {
namespace {

// tuned bound
constexpr double kShares[] = {1.0, 0.5, 0.25};  // share of the bound; borders and corners may use up half of it
constexpr double kStep = 0.75;                  // factor for the regions' own bound, of one try
constexpr double kLeast = 0.2;                  // least share of the bound that is tried

/// Area and diagonal of the box of the faces of which polygons are made.
std::pair<double, double> size_of_kept(const Mesh& mesh, const Partition& partition) {
  const auto vertices = mesh.vertices();
  double area = 0;
  Box box;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (partition.kept_region(f) == kNone) continue;
    const auto& [a, b, c] = mesh.triangles()[f];
    area += (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).norm() / 2;
    for (const std::int32_t v : {a, b, c}) box.extend(vertices[v]);
  }
  return {area, box.diagonal().norm()};
}

}  // namespace

BoundSearch::BoundSearch(double allowed, bool anew) : allowed_(allowed), anew_(anew), next_bound_(kStep) {}

BoundSearch::Step BoundSearch::step(bool anew, double share) {
  const double begin = std::exchange(done_, (1 + done_) / 2);
  return {anew, share, begin, done_};
}

std::optional<BoundSearch::Step> BoundSearch::next() {
  if (found_) return std::nullopt;
  if (next_share_ < std::size(kShares)) return step(false, kShares[next_share_++]);
  if (!anew_ || next_bound_ < kLeast) return std::nullopt;
  next_share_ = 0;
  return step(true, std::exchange(next_bound_, next_bound_ * kStep));
}

bool BoundSearch::take(double distance) {
  ++tries_;
  found_ = distance <= allowed_;
  if (least_ && !(distance < *least_)) return false;
  least_ = distance;
  return true;
}

MeshingOptions tightened(const Mesh& mesh, const Partition& partition, double bound, const MeshingOptions& given) {
  const auto [area, diagonal] = size_of_kept(mesh, partition);
  const double region = std::sqrt(area / std::max(partition.region_count(), 1));
  MeshingOptions options = given;
  options.chord_tolerance = std::min(bound / 2 / region, given.chord_tolerance);
  options.reach = std::min(bound / 2 / diagonal, given.reach);
  options.flatness = std::min(bound / 2 / diagonal, given.flatness);
  options.flatness_from = 0;
  return options;
}

}  // namespace isimp
