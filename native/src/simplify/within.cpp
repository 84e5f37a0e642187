#include "isimp/simplify/within.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace isimp {
namespace {

constexpr double kShares[] = {1.0, 0.5, 0.25};  // share of the bound; borders and corners may use up half of it
// tuned bound
constexpr double kStep = 0.75;  // factor for the regions' own bound, of one try
constexpr double kLeast = 0.2;  // least share of the bound that is tried

/// The largest of some distances; NaN where there is none.
double largest(const std::vector<double>& distances) {
  double most = std::numeric_limits<double>::quiet_NaN();
  for (const double d : distances)
    if (!(d <= most) && !std::isnan(d)) most = d;
  return most;
}

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

Within polygonize_within(const Mesh& mesh, Partition partition, const MeshingOptions& options, const Again& again,
                         Job& job, double slack) {
  if (!(partition.bound > 0)) {
    PolygonMesh polygons = polygonize(mesh, partition, options, job);
    return {std::move(partition), std::move(polygons), std::nullopt, std::nullopt, 1};
  }
  const double bound = partition.bound;
  BoundSearch search(slack * bound, again != nullptr);
  Within best;
  while (const auto step = search.next()) {
    const Job::Stage stage(job, step->anew ? "partitioning" : "meshing", step->begin, step->end);
    if (step->anew) {
      partition = again(step->share, job);
      continue;
    }
    const double own = partition.bound > 0 ? partition.bound : bound;
    PolygonMesh polygons = polygonize(mesh, partition, tightened(mesh, partition, step->share * own, options), job);
    const DistanceOptions measured{.enough = search.allowed(), .threads = options.threads};
    const double distance = largest(scan_distances(mesh, partition, polygons, measured, job));
    if (search.take(distance)) best = {partition, std::move(polygons), distance, search.allowed(), 0};
  }
  best.tries = search.tries();
  return best;
}

Within partition_within(const Partitioner& partitioner, const PartitionOptions& options, const Constraints& constraints,
                        const MeshingOptions& meshing, Job& job, double slack) {
  const auto make = [&](double share, Job& j) {
    PartitionOptions lower = options;
    if (lower.bound) *lower.bound *= share;
    return partitioner.run(lower, constraints, j);
  };
  Partition partition = [&] {
    const Job::Stage stage(job, "partitioning", 0.0, 0.25);
    return make(1.0, job);
  }();
  const Job::Stage stage(job, "meshing", 0.25, 1.0);
  return polygonize_within(partitioner.mesh(), std::move(partition), meshing, make, job, slack);
}

}  // namespace isimp
