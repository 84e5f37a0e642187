#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "isimp/mesh/mesh.h"

/// REF: variational shape approximation written down plainly. The engine's own methods are measured against it.
namespace isimp::bench {

/// A surface for the plain method: the caller's face order, double precision, one array a quantity. It has none of the
/// engine's optimisations, on purpose: no Morton order, no packed records.
struct PlainSurface {
  std::vector<Vec3> normal;                             ///< (F) unit
  std::vector<double> area;                             ///< (F) as a share of the whole surface's area
  std::vector<std::array<std::int32_t, 3>> neighbours;  ///< (F) across corner k -> k + 1; kNone where none

  [[nodiscard]] std::int32_t face_count() const { return static_cast<std::int32_t>(area.size()); }
};

PlainSurface plain_surface(const Mesh& mesh);

struct ReferenceOptions {
  std::int32_t proxies = 64;
  std::int32_t rounds = 20;
  std::uint32_t seed = 1;
};

struct ReferenceResult {
  std::vector<std::int32_t> label;  ///< (F) in [0, proxies); kNone in a component that got no seed
  std::vector<double> history;      ///< sum of area * |n_face - n_region|^2 after each round, areas being shares
  std::vector<double> round_ms;     ///< processor time of each round
};

/// The faces that `reference` starts from: distinct, drawn by `seed`.
std::vector<std::int32_t> random_faces(std::int32_t faces, std::int32_t count, std::uint32_t seed);

/// Floods from random distinct seeds with one priority queue, fits, and floods again, for a fixed number of rounds.
///
/// The priority is the squared difference of the normals alone, without the face's area; so is the choice of the new
/// seeds. The last state is the result. Components without a seed stay without a region.
/// Source: Cohen-Steiner, Alliez, Desbrun 2004, section 3.
ReferenceResult reference(const PlainSurface& surface, const ReferenceOptions& options);

}  // namespace isimp::bench
