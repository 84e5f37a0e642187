#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"

namespace isimp::tiles {

/// The faces of a tile by graph index, followed by its halo: all faces of other tiles that share a vertex with them.
struct TileFaces {
  std::span<const FaceRecord> face;                        ///< (n) areas in scene units squared
  std::span<const std::array<std::int32_t, 3>> neighbour;  ///< (n) face across corner k -> k + 1; kNone: none known
  std::int32_t owned = 0;                                  ///< number of the tile's own faces; the others are halo
};

/// Values of all tiles together, and the limits of a round of relaxing.
struct RelaxOptions {
  double error = 0.0;        ///< error of the present regions, as a share of the area
  double smooth = 0.5;       ///< as PartitionOptions::smooth
  double area = 0.0;         ///< area of all tiles, scene units squared
  std::int64_t faces = 0;    ///< number of faces of all tiles
  std::int32_t regions = 1;  ///< number of regions to be made
  std::int32_t sweeps = 8;   ///< most passes over the faces near a change; fewer if nothing moves
};

/// The result of a round of relaxing in one tile.
struct Relaxed {
  std::vector<std::int32_t> label;                         ///< (owned) new region of each face
  std::vector<std::pair<std::int32_t, RegionSum>> change;  ///< regions that gave or took faces, rising; scene units
  std::int64_t moves = 0;
};

/// Moves faces between neighbouring regions, by the method and the weight of borders of borders/relax.h.
///
/// A tile sees its own moves at once, and moves of other tiles after the round. Tiles work at the same time. A region
/// can't fall apart if, at each vertex that tiles share, only the tile with the highest rank moves faces.
/// \param label   (n) region of each face; kNone: in no region, never moved
/// \param frozen  (n) 1 for a face that stays in this round; the halo always stays
/// \param sum     (R) sums of all regions, scene units squared
/// \throws InvalidInput  arrays of unequal lengths, an index or a label out of range
/// \throws Cancelled     nothing was changed
/// Cost: O(n) to find borders, then in proportion to the number of moves. About 60 bytes a face.
Relaxed relax(const TileFaces& tile, std::span<const std::int32_t> label, std::span<const std::uint8_t> frozen,
              std::span<const RegionSum> sum, const RelaxOptions& options, Job& job);

/// The pairs of regions that meet in a tile or at its border, and the lengths of their borders. Each side of an edge
/// counts half of its length, so that the lengths of tiles can be added.
struct Touching {
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) the lower one first, rising
  std::vector<double> length;                     ///< (E) scene units
};

/// \param length  (owned) lengths of the edges of each face, scene units
/// Cost: O(owned), and O(B log B) for B edges on borders.
Touching touching(const TileFaces& tile, std::span<const std::int32_t> label,
                  std::span<const std::array<float, 3>> length);

}  // namespace isimp::tiles
