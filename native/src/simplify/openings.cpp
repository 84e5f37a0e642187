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
constexpr double kLeastNoise = 0.005;  // of the mean edge: scans have .01 and more, CAD models .001 and less

}  // namespace

bool has_openings(const Mesh& mesh) {
  const MeshReport& report = mesh.report();
  return report.border_loops > 0 || report.euler != 2 * static_cast<std::int64_t>(report.components);
}

double opening_length(const Mesh& mesh, std::int32_t regions, Job& job) {
  if (regions < 1) throw InvalidInput("regions must be at least 1, got " + std::to_string(regions));
  if (!has_openings(mesh)) return 0;
  const double edge = mean_edge(mesh);
  if (!(estimate_noise(mesh, job) > kLeastNoise * edge)) return 0;
  const double length = std::min(kOfRegion * std::sqrt(mesh.graph().area / regions), kMostEdges * edge);
  return edge * std::exp2(std::floor(2 * std::log2(length / edge)) / 2);
}

}  // namespace isimp
