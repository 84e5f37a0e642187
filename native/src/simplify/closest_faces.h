#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "judge/boxes.h"

namespace isimp {

/// A face, and its distance.
struct ClosestFace {
  std::int32_t face = kNone;
  double distance = std::numeric_limits<double>::infinity();  ///< scene units
};

/// Some faces of a mesh, to search for the closest one to a place.
class ClosestFaces {
 public:
  /// Cost: O(n log n).
  ClosestFaces(const Mesh& mesh, std::span<const std::int32_t> faces);

  /// The closest face to a place; among equally close ones the lowest.
  /// \param place   relative to the mesh's origin
  /// \param facing  only faces whose normal is within some 75 degrees of this unit vector; zero: all
  /// \param guess   an estimate of its distance; a good one saves time, the result does not depend on it
  /// \param most    the largest distance of the search
  /// Cost: about O(log n).
  [[nodiscard]] ClosestFace find(const Vec3& place, const Vec3& facing, double guess,
                                 double most = std::numeric_limits<double>::infinity()) const;

  /// The unit normal of a face; zero where it has no area.
  [[nodiscard]] Vec3 normal(std::int32_t face) const;
  [[nodiscard]] std::array<Vec3, 3> corners(std::int32_t face) const;

 private:
  const Mesh& mesh_;
  double least_;  // a guess is at least this
  meshing::BoxTree tree_;
};

}  // namespace isimp
