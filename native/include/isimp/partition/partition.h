#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/parallel/flooder.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Where the first proxies are put.
enum class Seeding {
  random,        ///< distinct faces drawn by `seed`
  farthest,      ///< each the face whose normal and place are farthest from all before
  hierarchical,  ///< the faces nearest to the regions that Method::hierarchy gives
};

/// How the regions are found.
enum class Method {
  lloyd,      ///< the 2004 paper's and the thesis's own: flooding and fitting in turn, from seeds
  hierarchy,  ///< merging of a hierarchy of patches, then relaxation of the borders: the best and the fastest
  teleport,   ///< lloyd, then merge the cheapest pair and split the worst region until it no longer helps
  naive,      ///< as lloyd, each face looking at the nearest regions at once: the thesis's data-parallel flooding
  queued,     ///< as lloyd, from a queue all of whose faces are flooded at once: the thesis's queued flooding
  hybrid,     ///< on a decimated mesh, and carried back: the thesis's hybrid
};

/// How the pieces that parallel flooding leaves become connected regions, and which of its two ways Method::hybrid
/// goes.
enum class Connect {
  repair,  ///< the largest piece of each region grows over the others: parallel, and it loses less
  flood,   ///< one sequential round of lloyd, the thesis's own
};

struct PartitionOptions {
  /// How many regions; at most one of these four is given, else it is `detail` at kDefaultDetail.
  std::optional<std::int32_t> proxies = std::nullopt;  ///< exactly so many, in [1, F]
  std::optional<double> detail = std::nullopt;     ///< what shows at a tolerance of this share of the size, in (0, 1]
  std::optional<double> tolerance = std::nullopt;  ///< the same with the tolerance in scene units, above 0
  /// As few as there may be with each vertex this near to its region's plane, scene units, above 0; Method::hierarchy.
  std::optional<double> bound = std::nullopt;
  std::optional<double> noise = std::nullopt;  ///< deviation of the scan's noise, scene units; none: estimated
  bool snap = true;                            ///< where the shape clearly is made of so many planes, take that number
  double adaptivity = 0.0;                     ///< how much denser regions get where the surface is rough, in [0, 1]
  double leave_out = 0.001;  ///< components each below this share of the area are left out, in [0, 1); see Partitioner
  std::uint64_t seed = 1;    ///< number that starts the random seeding
  std::int32_t iterations = 20;  ///< upper bound on flood-and-fit rounds, at least 1
  Seeding seeding = Seeding::random;
  Method method = Method::hierarchy;
  std::int32_t threads = 0;     ///< 0: as many as there are cores; the result does not depend on it
  std::string backend = "cpu";  ///< where Method::naive and queued run: one of parallel::backends(); same labels on all
  std::int32_t nearest = 8;     ///< how many of the nearest regions a face looks at in Method::naive, in [1, 32]
  parallel::Search search = parallel::Search::grid;  ///< how Method::naive finds them; the result is the same
  Connect connect = Connect::repair;                 ///< what Method::naive, queued and hybrid end with
  double fraction = 0.125;  ///< of the faces that Method::hybrid keeps when it decimates, in (0, 1]
};

/// What PartitionOptions::detail is if neither it nor another way to choose the number is given.
inline constexpr double kDefaultDetail = 0.005;

/// A surface split into connected, near-planar regions.
struct Partition {
  std::vector<std::int32_t> face_region;  ///< (F) in [0, R); kNone where a speck was left out
  std::vector<std::int32_t> region_seed;  ///< (R) the region's face that is nearest to its proxy
  std::vector<Vec3> region_normal;        ///< (R) unit, area-weighted mean; zero for a region without area;
                                          ///< with a bound, where that does not keep it, the normal of one that does
  std::vector<RegionSum> region_sum;      ///< (R) what the faces add up to, so that edits cost only what they touch
  double error = 0.0;                     ///< sum of area * |n_face - n_region|^2 of the faces that have an area
                                          ///< (see make_face_graph), scene units squared
  std::vector<double> history;            ///< the error after each round; `error` is not above any of them, but for
                                          ///< Method::naive and queued: rounds of pieces, the last entry is `error`

  double tolerance = 0.0;     ///< t at which the number of regions was found, scene units; 0: the number was given
  double noise = 0.0;         ///< the deviation it was found with, given or estimated, scene units
  bool snapped = false;       ///< the shape has so many planes: a gap in the costs of merging that can't be chance
  double bound = 0.0;         ///< as asked for, scene units; 0: none
  double distance_max = 0.0;  ///< with a bound: the largest distance of a vertex from its region's plane, scene units
  std::vector<double> region_offset;  ///< (R) with a bound: that plane is where region_normal * x is this; else empty
  std::int32_t proxies_asked = 0;     ///< R is larger where components need more (see `proxies_needed`)
  std::int32_t proxies_needed = 0;    ///< the least that the kept components need together
  std::int32_t parts_left_out = 0;    ///< components without a region
  double area_left_out = 0.0;         ///< their share of the whole area

  std::shared_ptr<const GuidedGraph> guided;  ///< what it was made on, so that edits keep to it; null without guides

  std::vector<std::uint8_t>
      region_locked;  ///< (R) 1 where edits leave a region as it is; empty: none (interact/lock.h)

  [[nodiscard]] std::int32_t region_count() const { return static_cast<std::int32_t>(region_seed.size()); }
};

/// A partition with regions that are known: from elsewhere, or put together from several.
///
/// \param face_region  (F) any numbers of at least 0, or kNone for a face in no region; a region that is not connected
///                     becomes as many as it has pieces, numbered by first face
/// \throws InvalidInput  not F of them, one below kNone, or none of at least 0
/// Cost: O(F).
Partition partition_from(const Surface& surface, std::span<const std::int32_t> face_region, Job& job);

/// What `before` knows, said of a partition each of whose regions lies in one of its: planes that keep a bound, locks,
/// and how the number was found.
/// \throws InvalidInput  they are of different numbers of faces
Partition inherited(Partition part, const Partition& before);

}  // namespace isimp
