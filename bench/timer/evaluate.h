#pragma once

#include <cstdint>
#include <span>

#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "json.h"
#include "reference.h"

namespace isimp::bench {

/// The quality of a partition from any program: all are judged by this and not by their own figures.
struct Score {
  double error = 0.0;             ///< D: sum of area * |n_face - n_region|^2 as a share of the whole area
  std::int64_t border_edges = 0;  ///< edges between two regions
  double border_length = 0.0;     ///< their length, scene units
  std::int32_t regions = 0;       ///< that have a face
  std::int32_t fragments = 0;     ///< connected pieces beyond one a region
  std::int64_t unlabelled = 0;    ///< faces without a region
  double unlabelled_area = 0.0;   ///< their share of the whole area
  std::uint64_t fingerprint = 0;  ///< equal for equal labels
};

/// \param label  (F) region of each face of the mesh; negative where it has none
Score evaluate(const Mesh& mesh, const PlainSurface& surface, std::span<const std::int32_t> label);

Json to_json(const Score& score);

/// Equal for equal polygons, to the last bit of where they are.
std::uint64_t fingerprint(const PolygonMesh& polygons);

}  // namespace isimp::bench
