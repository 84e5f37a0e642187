// Openings of a scan: the lengths up to which they count as errors of scanning, and the weights of their patches.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/options.h"

namespace isimp {

/// The number of components that a partition with these options leaves out, which are the smallest ones.
/// Cost: O(F); nothing for a mesh of one component.
std::int32_t left_out_count(const Mesh& mesh, const PartitionOptions& options, Job& job);

/// (F) 1 for faces of so many components, the smallest ones; empty: none.
/// Cost: O(F + C log C).
std::vector<std::uint8_t> smallest_components(const Mesh& mesh, std::int32_t count, Job& job);

/// Whether a mesh has a hole or a handle.
bool has_openings(const Mesh& mesh);

/// The length up to which the loops of holes and handles count as errors of scanning; for CleanOptions::fill_holes and
/// cut_handles. Photogrammetry makes tunnels and pinholes that are too small for this number of regions, and each costs
/// polygons.
///
/// Half of sqrt(area / regions), but at most 20 times the mean edge, so that well sampled openings stay for any number
/// of regions. Rounded down to the mean edge times a power of sqrt(2), so that similar numbers of regions close the
/// same. 0 if the mesh has no opening, or so little noise that it was drawn and not scanned.
/// \param regions  at least 1
/// \param options  of the partition: components that it leaves out do not count. By default with `regions`. Its noise
///                 decides about the number of regions only: a tile of a city has noise 0 there, and errors of scanning
/// \return scene units
/// \throws InvalidInput  regions below 1
/// Cost: O(V + F).
double opening_length(const Mesh& mesh, std::int32_t regions, Job& job,
                      const std::optional<PartitionOptions>& options = {});

/// Scene units; both 0 where opening_length is.
struct OpeningLengths {
  double holes = 0;       ///< for CleanOptions::fill_holes
  double flat_holes = 0;  ///< for CleanOptions::fill_flat_holes
  double handles = 0;     ///< for CleanOptions::cut_handles: opening_length
  bool operator==(const OpeningLengths&) const = default;
};

/// The lengths of few regions, for a number that is not known yet.
struct GuessedLengths {
  OpeningLengths lengths;
  std::int32_t most = 0;  ///< numbers of regions up to this one have these lengths
  bool likely = false;    ///< whether the final number is most likely one of them
};

/// `opening_length` by kind. Holes of up to 8 mean edges, such as a missing vertex makes, are filled up to sqrt(area /
/// regions): filling changes less than cutting. Holes in walls are filled up to twice that, a square half as wide, and at
/// most 20 mean edges: as a modeller draws the wall behind a shelf.
/// \throws InvalidInput (regions below 1), Cancelled
/// Cost: O(V + F).
OpeningLengths opening_lengths(const Mesh& mesh, std::int32_t regions, Job& job,
                               const std::optional<PartitionOptions>& options = {});

/// The result of `opening_lengths` for one region, and the number of regions up to which it is the same: both lengths
/// have a bound in mean edges. So openings of a large scan can be closed before the number of regions is found.
/// \param options  of the partition
/// Cost: O(V + F).
GuessedLengths guess_opening_lengths(const Mesh& mesh, const PartitionOptions& options, Job& job);

/// Removes the weight of patches that closed an opening, so that no region is drawn for a surface that was not scanned.
/// Their faces join the adjacent regions.
///
/// A patch larger than two regions of mean size or a hundredth of the surface keeps its weight: it is the bottom of a
/// figure, for example, and not an error of scanning.
/// \param source   (F) as Mesh::source_face: kNone for faces of patches
/// \param weights  (F) of faces, or empty: 1 everywhere
/// \param regions  at least 1
/// \return (F) weights, with 0 for faces of small patches; `weights` if there is none, or their number is not F
/// Cost: O(F).
std::vector<double> weights_without_patches(const Mesh& mesh, std::span<const std::int32_t> source,
                                            std::vector<double> weights, std::int32_t regions);

}  // namespace isimp
