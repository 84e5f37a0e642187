#include "judge/bounds.h"

#include <algorithm>
#include <cmath>

namespace isimp::meshing {

Bounds bounds_of(const MeshingOptions& options, std::int32_t regions, double tolerance, double diagonal) {
  const double fewer = std::max(1.0, static_cast<double>(options.flatness_from) / std::max(regions, 1));
  const double bend = options.flatness * std::pow(fewer, 4) * diagonal;
  return {.bend = bend > 0 ? std::max(bend, tolerance) : 0, .thickness = kThickness * diagonal};
}

Bounds bounds_of(const State& s) { return bounds_of(s.options, s.regions, s.partition.tolerance, s.mesh.diagonal()); }

}  // namespace isimp::meshing
