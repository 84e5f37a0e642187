#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/core/types.h"
#include "isimp/partition/curved.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/options.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// The result of `regularise` for the axes of round parts. Parts of one axis count as one axis.
struct RegularAxes {
  std::int32_t upright = 0, level = 0, parallel = 0, free = 0;  ///< number of axes by the kind of snap
  std::int32_t coaxial = 0;                                     ///< axes that were made one axis with another
  std::int32_t equal_radii = 0;  ///< cylinders and spheres with exactly the radius of another
  bool operator==(const RegularAxes&) const = default;
};

/// The result of `regularise` for the planes of a partition (regular/regularise.h). Lengths in scene units.
struct Regularity {
  std::int32_t directions = 0;  ///< number of directions of all regions' planes, opposite ones counted once
  std::int32_t planes = 0;      ///< number of different planes
  std::int32_t level = 0, upright = 0, slopes = 0, parallel = 0, free = 0;  ///< number of regions by the kind of snap
  std::int32_t by_hand = 0;                                                 ///< set by align_planes
  double length = 0;      ///< increase of a region's distance from its plane that a snap may cause, root mean square
  double rms_before = 0;  ///< distance of the scan from the regions' planes of best fit, root mean square
  double rms = 0;         ///< likewise from the snapped planes
  RegularAxes axes;
  bool operator==(const Regularity&) const = default;
};

/// Values of Partition::region_held.
constexpr std::uint8_t kPlaneSnapped = 1;  ///< mark: snapped by `regularise`
constexpr std::uint8_t kPlaneByHand = 2;   ///< mark: set by `align_planes`, which `regularise` keeps
constexpr std::uint8_t kPlaneFree = 3;  ///< mark: released by `align_planes`: not held, and `regularise` leaves it free
constexpr std::uint8_t kPlaneRound =
    4;  ///< mark: of a cell of a curved patch; it moves with the patch's axis and radius only

/// Values of Partition::region_locked.
constexpr std::uint8_t kLocked = 1;   ///< mark: edits do not change the region
constexpr std::uint8_t kLeftOut = 2;  ///< mark: locked, and no polygon is made of it
constexpr std::uint8_t kBoxed = 3;    ///< mark: left out, and a box replaces it and adjacent ones of this kind

/// A surface split into connected, near-planar regions.
struct Partition {
  std::vector<std::int32_t> face_region;  ///< (F) in [0, R); kNone where a speck was left out
  std::vector<std::int32_t> region_seed;  ///< (R) the region's face that is nearest to its proxy
  std::vector<Vec3> region_normal;        ///< (R) unit, area-weighted mean; zero for a region without area; with a
                                          ///< bound, a held plane or a cell of a round part, that of the plane
  std::vector<RegionSum> region_sum;      ///< (R) sums of the faces, so that edits cost only the changed regions
  double error = 0.0;                     ///< sum of weight * area * |n_face - n|^2, scene units squared; n is the
                                          ///< mean normal, with a bound that of the plane; no other plane counts
  std::vector<double> history;            ///< the error after each round; `error` is at most each of them, except for
                                          ///< Method::naive and queued: rounds of pieces, the last entry is `error`

  double smooth = 0.0;      ///< PartitionOptions::smooth it was made with; edits relax borders with the same weight
  double off_planes = 0.0;  ///< error of the distances by `metric` before edits, as a share of the area: for the
                            ///< weight of borders in edits
  Metric metric = Metric::normals;  ///< PartitionOptions::metric it was made with; edits relax borders by the same
  double tolerance = 0.0;     ///< tolerance of the search for the number of regions, scene units; 0: the number was
                              ///< given
  double noise = 0.0;         ///< deviation used in that search, given or estimated, scene units
  bool snapped = false;       ///< the number is the shape's own: a significant gap in the costs of merging
  double bound = 0.0;         ///< the given bound, scene units; 0: none
  double distance_max = 0.0;  ///< with a bound: the largest distance of a vertex from its region's plane, scene units
  std::vector<double> region_offset;  ///< (R) with a bound, or if planes are or were held: each region's plane is
                                      ///< region_normal * x = region_offset, x in the caller's coordinates; else empty
  std::int32_t proxies_asked = 0;     ///< R is larger where components need more (see `proxies_needed`)
  std::int32_t proxies_needed = 0;    ///< the least number for all kept components together
  std::int32_t parts_left_out = 0;    ///< components without a region
  double area_left_out = 0.0;         ///< their share of the whole area

  std::shared_ptr<const GuidedGraph> guided;  ///< the graph with the guides, so that edits use them too; null without
                                              ///< guides

  /// (R) kLocked, kLeftOut or kBoxed where edits do not change a region, else 0; empty: all 0 (interact/lock.h)
  std::vector<std::uint8_t> region_locked;

  /// (R) kPlaneSnapped, kPlaneByHand or kPlaneRound where polygons use the plane of region_normal and region_offset,
  /// kPlaneFree where they never do, else 0; empty: all 0
  std::vector<std::uint8_t> region_held;
  std::vector<CurvedProxy> curved;       ///< the curved patches; each has a region
  std::vector<CurvedCell> region_cell;   ///< (R) the cell of a patch that a region is, if it is one; empty: none is
  std::optional<Regularity> regularity;  ///< if regularised and not edited since

  [[nodiscard]] bool is_held(std::int32_t region) const {
    return !region_held.empty() && region_held[region] != 0 && region_held[region] != kPlaneFree;
  }
  /// Whether polygons keep to the plane only where it does no harm.
  [[nodiscard]] bool is_snapped(std::int32_t region) const {
    return is_held(region) && region_held[region] != kPlaneByHand;
  }
  /// The offset of a region's plane in coordinates relative to `origin`, as a mesh has them.
  [[nodiscard]] double offset_from(const Vec3& origin, std::int32_t region) const {
    return region_offset[region] - region_normal[region].dot(origin);
  }
  [[nodiscard]] bool is_left_out(std::int32_t region) const {
    return !region_locked.empty() && region_locked[region] >= kLeftOut;
  }
  /// The region of a face of which polygons are made; kNone if the face has no region or its region is left out.
  [[nodiscard]] std::int32_t kept_region(std::int32_t face) const {
    const std::int32_t region = face_region[face];
    return region == kNone || is_left_out(region) ? kNone : region;
  }
  [[nodiscard]] std::int32_t region_count() const { return static_cast<std::int32_t>(region_seed.size()); }
};

/// \throws InvalidInput  the partition is of another number of faces, or the plane of a region is not finite
void check_is_of(const Mesh& mesh, const Partition& partition);

/// A partition with known regions: from other programs, or combined from several.
///
/// \param face_region  (F) any numbers of at least 0, or kNone for a face in no region; each piece of a region that is
///                     not connected becomes a region, numbered by first face
/// \throws InvalidInput  not F of them, one below kNone, or none of at least 0
/// Cost: O(F).
Partition partition_from(const Surface& surface, std::span<const std::int32_t> face_region, Job& job);

/// Sets region_offset of each region that holds no plane: its plane is region_normal through the centre of its area.
/// Pre: there is no bound. Cost: O(F); nothing if region_offset is empty.
void place_free_planes(const Mesh& mesh, Partition& part);

/// Copies to a partition, each of whose regions lies in one region of `before`, the state of `before`: planes that keep
/// a bound, locks, and how the number was found.
/// \throws InvalidInput  they are of different numbers of faces
Partition inherited(Partition part, const Partition& before);

}  // namespace isimp
