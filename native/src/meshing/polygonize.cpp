#include "isimp/meshing/polygonize.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>

#include "complex.h"
#include "discs.h"
#include "isimp/core/errors.h"
#include "judge.h"
#include "labels.h"
#include "placement.h"
#include "planes.h"
#include "polygons.h"

namespace isimp {
namespace {

using namespace meshing;

constexpr std::int32_t kLeastClosed = 4;  ///< no closed surface has fewer polygons

void check(const Mesh& mesh, const Partition& partition, const MeshingOptions& options) {
  const auto range = [](double x, double low, double high, const char* name) {
    if (!(x >= low && x <= high))
      throw InvalidInput(
          (std::ostringstream() << name << " must be in [" << low << ", " << high << "], got " << x).str());
  };
  range(options.chord_tolerance, 0, 100, "chord_tolerance");
  range(options.reach, 0, 1, "reach");
  range(options.flatten, 0, 10000, "flatten");
  if (partition.face_region.size() != static_cast<std::size_t>(mesh.face_count()))
    throw InvalidInput("the partition has labels for " + std::to_string(partition.face_region.size()) +
                       " faces, but the mesh has " + std::to_string(mesh.face_count()));
  const std::int32_t regions = partition.region_count();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t r = partition.face_region[f];
    if (r < kNone || r >= regions)
      throw InvalidInput("face " + std::to_string(f) + " is in region " + std::to_string(r) + ", but there are " +
                         std::to_string(regions) + " regions");
    for (std::int32_t h = 3 * f; r == kNone && h < 3 * f + 3; ++h)
      if (const std::int32_t o = mesh.opposite(h); o != kNone && partition.face_region[o / 3] != kNone)
        throw InvalidInput("face " + std::to_string(f) + " is left out, but face " + std::to_string(o / 3) +
                           " beside it is not; only whole parts can be left out");
  }
}

ChordTolerance chord_tolerance(const Mesh& mesh, std::span<const Plane> planes, std::int32_t regions,
                               const MeshingOptions& options) {
  double area = 0;
  for (const Plane& p : planes) area += p.area;
  const double tolerance = options.chord_tolerance * std::sqrt(area / std::max(regions, 1));
  ChordTolerance t;
  t.most = std::min(tolerance, 0.03 * mesh.diagonal());
  t.most_on_border = std::min(tolerance, 0.01 * mesh.diagonal());
  t.of_width = options.chord_width;
  t.least_sine = 0.15;
  return t;
}

void count_splits(const Labels& labels, std::int32_t regions, MeshingReport& report) {
  std::vector<std::int32_t> pieces(regions, 0);
  for (const Piece& p : labels.pieces) {
    ++pieces[p.region];
    report.split_for_unconnected += p.cause == Cause::unconnected;
    report.split_for_pinches += p.cause == Cause::pinch;
    report.split_for_holes += p.cause == Cause::hole;
    report.split_for_handles += p.cause == Cause::handle;
    report.split_for_closed += p.cause == Cause::closed;
    report.split_for_repair += p.cause == Cause::repair;
  }
  report.regions = static_cast<std::int32_t>(std::count_if(pieces.begin(), pieces.end(), [](int n) { return n > 0; }));
  report.regions_split =
      static_cast<std::int32_t>(std::count_if(pieces.begin(), pieces.end(), [](int n) { return n > 1; }));
}

/// The polygons in the order of their regions, then of their pieces.
PolygonMesh assemble(const Mesh& mesh, const Labels& labels, const Polygons& polygons, std::span<const Vec3> position) {
  PolygonMesh out;
  std::vector<std::int32_t> order(polygons.count()), index(polygons.vertex.size(), kNone);
  std::iota(order.begin(), order.end(), 0);
  const auto region = [&](std::int32_t q) { return labels.pieces[polygons.piece[q]].region; };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return region(a) < region(b); });
  double area = 0, bent = 0;
  for (const std::int32_t q : order) {
    out.loop_start.push_back(static_cast<std::int32_t>(out.loops.size()));
    out.polygon_region.push_back(region(q));
    for (const std::int32_t c : polygons.of(q)) {
      if (index[c] == kNone) {
        index[c] = static_cast<std::int32_t>(out.vertices.size());
        out.vertices.push_back(position[c]);
        out.source_vertex.push_back(polygons.vertex[c]);
        out.report.distance_max =
            std::max(out.report.distance_max, (position[c] - mesh.vertices()[polygons.vertex[c]]).norm());
      }
      out.loops.push_back(index[c]);
    }
    out.planarity.push_back(bend_of(polygons.of(q), position));
    const double a = vector_area(polygons.of(q), position).norm();
    area += a;
    bent += a * out.planarity.back();
    out.report.planarity_max = std::max(out.report.planarity_max, out.planarity.back());
  }
  out.report.planarity_mean = area > 0 ? bent / area : 0.0;
  out.report.polygons = out.polygon_count();
  out.report.corners = static_cast<std::int32_t>(out.loops.size());
  out.report.vertices = static_cast<std::int32_t>(out.vertices.size());
  return out;
}

}  // namespace

PolygonMesh polygonize(const Mesh& mesh, const Partition& partition, const MeshingOptions& options, Job& job) {
  check(mesh, partition, options);
  Job::Part whole(job, "meshing", 0.0, 1.0);
  Labels labels = label_pieces(mesh, partition.face_region);
  job.report(0.1);
  Cutter cutter(labels);
  make_discs(cutter, find_defects(labels), job);
  if (mesh.report().closed_components > 0) split_closed_components(cutter, kLeastClosed, job);
  job.report(0.4);
  std::vector<Plane> planes = planes_of(labels);
  Complex complex(labels, planes, chord_tolerance(mesh, planes, partition.region_count(), options));
  std::vector<std::int32_t> all(labels.pieces.size());
  std::iota(all.begin(), all.end(), 0);
  complex.refresh(all, boundary_starts(labels));
  complex.make_regular();
  job.report(0.6);
  const Polygons polygons = collect_polygons(complex, labels);
  const std::vector<double> radius = radii(polygons, mesh, options.reach * mesh.diagonal());
  std::vector<Vec3> position = place(polygons, mesh, planes, radius);
  flatten(polygons, mesh, planes, radius, options.flatten, position);
  job.report(0.9);
  PolygonMesh result = assemble(mesh, labels, polygons, position);
  count_splits(labels, partition.region_count(), result.report);
  judge_topology(result);
  return result;
}

}  // namespace isimp
