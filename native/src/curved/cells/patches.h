#pragma once

#include <array>
#include <vector>

#include "cells/grid.h"
#include "find/find.h"
#include "isimp/curved/round.h"

namespace isimp::curved {

/// A curved patch before it is cut.
struct RoundPatch {
  CurvedProxy proxy;
  std::int32_t found = 0;  ///< its number among the surfaces
  PatchFaces faces;
  double cells = 0;   ///< regions that the partition has there
  double before = 0;  ///< sum of area times squared distance of its faces from the planes of these regions
  std::array<std::int32_t, 2> tangent{kNone,
                                      kNone};  ///< surfaces: planes that touch it where its segments begin and end
  double first_angle = 0, last_angle = 0;      ///< where they touch it
  std::int32_t together = 0;  ///< patches with the same number have the same segments: all are cut, or none
};

/// The surfaces found on a scan.
struct Scene {
  Points points;
  Nearness near;
  std::vector<Found> found;
  Some label;  ///< (n) by graph index: the surface of each face, kNone
  std::vector<RoundPatch> patches;
};

/// Finds the curved patches of a scan.
Scene find_patches(const Faces& faces, const Partition& part, std::span<const std::int32_t> small,
                   const RoundLengths& lengths, std::span<const std::uint8_t> stays, Job& job);

/// Chooses segments and rings of bends and of the straight pipes at their ends: the segments of these are the rings of the
/// bend. (pipes.cpp)
/// \return of each patch whether it was one
std::vector<bool> choose_pipes(const Faces& faces, Scene& scene, double distance);

/// Chooses segments and rings of all patches. Patches with a common axis and a common circle have the same segments.
void choose_grids(const Faces& faces, Scene& scene, Job& job);

}  // namespace isimp::curved
