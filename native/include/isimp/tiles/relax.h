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

/// The faces of a tile, by graph index, and behind them its halo: all faces of other tiles that share a vertex with
/// them.
struct TileFaces {
  std::span<const FaceRecord> face;                        ///< (n) areas in scene units squared
  std::span<const std::array<std::int32_t, 3>> neighbour;  ///< (n) across corner k -> k + 1; kNone where none is known
  std::int32_t owned = 0;                                  ///< how many are the tile's own; the rest is halo
};

/// All tiles together, and how far relaxing goes in a round.
struct RelaxOptions {
  double error = 0.0;        ///< of the present regions, as a share of the area
  double smooth = 0.5;       ///< as PartitionOptions::smooth
  double area = 0.0;         ///< of all tiles, scene units squared
  std::int64_t faces = 0;    ///< of all tiles
  std::int32_t regions = 1;  ///< how many are wanted
  std::int32_t sweeps = 8;   ///< over the faces near which something changed; fewer if nothing moves
};

/// A round of relaxing in one tile.
struct Relaxed {
  std::vector<std::int32_t> label;                         ///< (owned)
  std::vector<std::pair<std::int32_t, RegionSum>> change;  ///< regions that gave or took faces, rising; scene units
  std::int64_t moves = 0;
};

/// Moves faces between neighbouring regions as borders/relax.h does, with its weight of borders.
///
/// A tile sees its own moves at once and those of others after the round. A region can't fall apart where tiles work at
/// the same time if of the tiles round a vertex only the one of the highest rank moves faces there.
/// \param label   (n) region of each face; kNone takes no part
/// \param frozen  (n) 1 where a face stays in this round; the halo always does
/// \param sum     (R) of all regions, scene units squared
/// \throws InvalidInput  arrays of unequal lengths, an index or a label out of range
/// \throws Cancelled     nothing was changed
/// Cost: O(n) to look for borders; then what moves. Some 60 bytes a face.
Relaxed relax(const TileFaces& tile, std::span<const std::int32_t> label, std::span<const std::uint8_t> frozen,
              std::span<const RegionSum> sum, const RelaxOptions& options, Job& job);

/// The pairs of regions that meet in a tile or at its border, and how long the borders are: half of each edge from
/// either side, so that tiles add up.
struct Touching {
  std::vector<std::array<std::int32_t, 2>> pair;  ///< (E) the lower first, rising
  std::vector<double> length;                     ///< (E) scene units
};

/// \param length  (owned) of the edges of each face, scene units
/// Cost: O(owned), and O(B log B) for B edges on borders.
Touching touching(const TileFaces& tile, std::span<const std::int32_t> label,
                  std::span<const std::array<float, 3>> length);

}  // namespace isimp::tiles
