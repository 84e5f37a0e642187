#pragma once

#include <span>
#include <vector>

#include "cells/grid.h"

namespace isimp::curved {

/// A face of a profile that is cut into parts: its area, its place in the plane of the profile, and its part.
struct ProfileSample {
  double weight;
  Vec2 place;
  std::size_t part;
};

/// Moves the corners of a profile to where its straight parts are nearest to the samples by squared distance. Since
/// parts share their corners, planes through them meet there, also at small angles.
/// \param corners  one more than parts; of a closed profile the last is the first
/// \return the corners; a part without samples does not move by itself (fit_corners.cpp)
/// Cost: O(samples + parts^3).
std::vector<Vec2> fitted_corners(std::vector<Vec2> corners, bool closed, std::span<const ProfileSample> samples);

/// The cells of a patch.
struct Cells {
  Some of_face;                  ///< by PatchFaces: ring * segments + segment
  std::vector<CurvedCell> cell;  ///< by that number; `proxy` is not set
  std::vector<Vec3> normal;      ///< normal of the plane of each cell
  std::vector<double> offset;    ///< the plane is where normal * x is this
};

/// The patches of a scan, as far as others depend on how they are cut.
struct Mates {
  Some patch;     ///< (n) by graph index: the number of the patch, kNone in none
  Some together;  ///< by patch: the same number if they are cut together

  [[nodiscard]] bool are(std::int32_t i, std::int32_t j) const {
    return patch[i] != kNone && patch[j] != kNone && together[patch[i]] == together[patch[j]];
  }
};

/// The grid of a patch, which continues beyond the patch.
class CellGrid {
 public:
  /// \param proxy  with segments and rings; must outlive this
  explicit CellGrid(const CurvedProxy& proxy);

  [[nodiscard]] const Locator& surface() const { return on_; }
  [[nodiscard]] double width() const { return width_; }  ///< of a segment, radians
  [[nodiscard]] bool is_cap(std::int32_t ring) const {
    return (p_->low_cap && ring == 0) || (p_->high_cap && ring == p_->rings - 1);
  }
  /// The part of the profile at a place along it.
  [[nodiscard]] std::int32_t part(double along) const;
  /// An angle from the first segment on; one beyond the segments is moved to the nearer end.
  [[nodiscard]] double place(double angle) const;
  [[nodiscard]] std::int32_t ring(double along) const { return is_extrusion_ ? 0 : part(along); }
  [[nodiscard]] std::int32_t segment(double angle, double along) const;
  /// The number of a cell as in Cells::of_face.
  [[nodiscard]] std::int32_t number(std::int32_t ring, std::int32_t segment) const {
    return ring * p_->segments + (is_cap(ring) ? 0 : segment);
  }
  /// The cell at a place.
  [[nodiscard]] std::int32_t at(const Vec3& x) const;

 private:
  const CurvedProxy* p_;
  Locator on_;
  double width_;
  bool is_extrusion_;
};

/// The cell of each face, as Cells::of_face, where the corners of cells are not at vertices yet.
Some cells_of_faces(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch);

/// Cuts a patch into cells, so that four meet in one vertex of the scan: by symmetry their planes meet in one point, and
/// two junctions of three would fall together.
/// \param mates  patches that are cut together have their corners at common vertices
/// Cost: O(faces of the patch).
Cells cut(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch, const Mates& mates);

}  // namespace isimp::curved
