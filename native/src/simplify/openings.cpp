#include "isimp/simplify/openings.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "density/noise.h"
#include "isimp/core/errors.h"

namespace isimp {
namespace {

constexpr double kOfRegion = 0.5;      // of sqrt(area / regions)
constexpr double kMostEdges = 20;      // mean edges
constexpr double kPinhole = 8;         // mean edges: the border of the faces round one vertex
constexpr double kLeastNoise = 0.005;  // of the mean edge: scans have .01 and more, CAD models .001 and less

}  // namespace

bool has_openings(const Mesh& mesh) {
  const MeshReport& report = mesh.report();
  return report.border_loops > 0 || report.euler != 2 * static_cast<std::int64_t>(report.components);
}

OpeningLengths opening_lengths(const Mesh& mesh, std::int32_t regions, Job& job) {
  if (regions < 1) throw InvalidInput("regions must be at least 1, got " + std::to_string(regions));
  if (!has_openings(mesh)) return {};
  const double edge = mean_edge(mesh);
  if (!is_noisier(mesh, kLeastNoise * edge, job)) return {};
  const double side = std::sqrt(mesh.graph().area / regions);
  const auto rounded = [&](double length) { return edge * std::exp2(std::floor(2 * std::log2(length / edge)) / 2); };
  const double length = rounded(std::min(kOfRegion * side, kMostEdges * edge));
  return {.holes = std::max(length, rounded(std::min(side, kPinhole * edge))), .handles = length};
}

double opening_length(const Mesh& mesh, std::int32_t regions, Job& job) {
  return opening_lengths(mesh, regions, job).handles;
}

}  // namespace isimp
