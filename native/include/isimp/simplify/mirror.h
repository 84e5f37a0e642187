#pragma once

#include <cstdint>
#include <optional>

#include "isimp/core/job.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/mirror.h"
#include "isimp/partition/options.h"

namespace isimp {

/// The plane in which a surface mirrors: nine tenths of it, by area, lie within `allowed` of its mirror image.
///
/// Candidates are planes through the centroid: across the axes of inertia, X, Y, Z and some 150 directions for
/// Symmetry::found, across the one axis else. The best on a few samples are fitted to more. Each fit alternates two
/// steps: it finds the closest face to the image of each sample, then the plane that brings all images nearest to the
/// planes of these faces; far ones have little weight. Among planes that are about as good, the order is X, Y, Z,
/// others.
///
/// \param wanted   not Symmetry::none
/// \param allowed  scene units
/// \return nullopt where Symmetry::found has found none
/// \throws InvalidInput  the surface does not mirror across the wanted axis: the message gives the distance
/// Cost: O(F log F) to prepare, and some 200,000 searches for a closest face, about .3 s.
/// Source: iterated closest points (Chen, Medioni 1992), for reflections.
std::optional<Mirror> find_mirror(const Mesh& mesh, Symmetry wanted, double allowed, std::int32_t threads, Job& job);

/// The allowed distance of a surface from its mirror image for a partition: a few deviations of its noise, or a small
/// share of a region's size.
double mirror_allowance(const Mesh& mesh, const PartitionOptions& options, Job& job);

}  // namespace isimp
