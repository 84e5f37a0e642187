#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "draw/lean.h"
#include "draw/ownership.h"
#include "isimp/core/types.h"
#include "isimp/mesh/mesh.h"
#include "isimp/partition/partition.h"
#include "isimp/texture/unwrap.h"

namespace isimp::detail {

/// The faces of each region, and the regions adjacent to it.
struct Neighbourhood {
  /// Some faces of a region that lie together, and a ball around them.
  struct Block {
    std::int32_t begin, end;    // a range of `faces`
    std::int32_t first, count;  // a range of `vertices`: the vertices of the faces, each once
    Vec3 middle;
    double radius;
  };
  static constexpr std::int32_t kBlock = 32;  ///< work: faces of a block, at most
  std::vector<std::int32_t> start, faces;     ///< region r has faces[start[r]] to faces[start[r + 1]], in Morton order
  std::vector<std::int32_t> block_start;      ///< and its blocks block_start[r] to block_start[r + 1]
  std::vector<Block> blocks;
  std::vector<std::int32_t> vertices;
  std::vector<std::array<std::uint8_t, 3>> corners;  ///< for `faces`: index of each corner in its block's vertices
  std::vector<std::int32_t> near_start, near;        ///< the same for regions: r itself first, then the adjacent ones
};

/// \param known  (F) 0 for faces without an appearance, which are left out; empty: all are known. A region whose
///               neighbours have all lost their faces gets regions further away too.
Neighbourhood find_neighbourhood(const Mesh& mesh, const Partition& partition, std::span<const std::uint8_t> known);

/// A place on a face.
struct Hit {
  std::int32_t face = kNone;
  float b = 0, c = 0;
  std::int32_t index = kNone;  ///< index into the view's `faces()`
};

/// A face in the coordinates of a chart: texels right, up, and above the plane.
struct FlatFace {
  std::array<float, 3> x, y, z;
  float over;  ///< 1 / its doubled area in the plane
  std::int32_t face;
  bool own;  ///< belongs to the polygon's region
};

/// The same face in the form for the search for the closest one: a corner, two edges, and products of them.
struct FlatEdges {
  float x, y, z, ux, uy, uz, vx, vy, vz;
  float uu, uv, vv;
  float over_uu, over_vv, over_ww;  ///< w = v - u; 0 for edges of no length
  float over_det;                   ///< reciprocal of uu vv - uv^2; not a number for faces of no area
};
FlatEdges edges_of(const FlatFace& face);

/// Four points of the plane: (x, y), (x + step, y), (x, y + step), (x + step, y + step).
struct Quad {
  float x, y, step;
  unsigned wanted;  ///< bit k: whether point k is used
};

/// Texels of a row of a square: [begin, end).
struct Span {
  std::int32_t begin = 0, end = 0;
};

/// The bounds of a face: texels, and the least distance from the plane.
struct FlatBox {
  float low_x, high_x, low_y, high_y, off;
};

/// The faces in each cell of a grid; faces outside are in the cells at its rim.
class Bins {
 public:
  /// \param with_boxes  whether `boxes_in` is called
  void build(std::span<const FlatBox> faces, const TexelBox& box, float cell, bool with_boxes);
  [[nodiscard]] std::span<const std::int32_t> in(std::int32_t i, std::int32_t j) const;
  /// The bounds of those faces, one after another in memory.
  [[nodiscard]] std::span<const FlatBox> boxes_in(std::int32_t i, std::int32_t j) const {
    const std::size_t k = static_cast<std::size_t>(j) * columns_ + i;
    return std::span(box_).subspan(start_[k], start_[k + 1] - start_[k]);
  }
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] float cell() const { return cell_; }
  [[nodiscard]] std::int32_t column(float x) const;
  [[nodiscard]] std::int32_t row(float y) const;
  /// The least distance of the content of a cell from the plane.
  [[nodiscard]] float off(std::int32_t i, std::int32_t j) const {
    return off_[static_cast<std::size_t>(j) * columns_ + i];
  }
  /// Squared distance of a box from a cell.
  [[nodiscard]] float away(std::int32_t i, std::int32_t j, float x0, float x1, float y0, float y1) const {
    const float low_x = x0_ + static_cast<float>(i) * cell_, low_y = y0_ + static_cast<float>(j) * cell_;
    const float dx = std::max(std::max(0.0F, low_x - x1), x0 - low_x - cell_);
    const float dy = std::max(std::max(0.0F, low_y - y1), y0 - low_y - cell_);
    return dx * dx + dy * dy;
  }

 private:
  float x0_ = 0, y0_ = 0, cell_ = 1;
  std::int32_t columns_ = 1, rows_ = 1;
  std::vector<std::int32_t> start_, item_;
  std::vector<FlatBox> box_;
  std::vector<float> off_;
};

/// The faces that a search has tried: faces in several cells are tried once. One for each thread.
class Visited {
 public:
  void begin(std::size_t faces) {
    ++now_;
    if (last_.size() < faces) last_.resize(faces, 0);
  }
  /// Whether this is the first time since `begin`.
  bool first(std::int32_t item) {
    if (last_[item] == now_) return false;
    last_[item] = now_;
    return true;
  }

 private:
  std::vector<std::uint32_t> last_;
  std::uint32_t now_ = 0;
};

/// The faces that a polygon can show, seen along its normal and the directions that lean from it.
class PolygonView {
 public:
  static constexpr std::int32_t kSquare =
      128;  // work: texels: side of the squares that are drawn; samples fit into a cache

  PolygonView(const Mesh& mesh, const Neighbourhood& near) : mesh_(mesh), near_(near) {}

  /// \param frame  in the coordinates of the mesh
  void look(const ChartFrame& frame, const TexelBox& box, std::int32_t region, const Lean& lean);

  [[nodiscard]] const TexelBox& box() const { return box_; }
  [[nodiscard]] std::int32_t square_count() const { return squares_.columns() * squares_.rows(); }
  [[nodiscard]] TexelBox square(std::int32_t t) const;

  /// Draws the faces of a square with n x n samples a texel. `index` receives, for each sample, the visible one of
  /// `faces()`, or kNone; rows from the bottom.
  /// \param wanted  for each row of texels; nothing is drawn outside
  void draw(std::int32_t t, std::int32_t n, std::span<const Span> wanted, std::vector<std::int32_t>& index,
            std::vector<float>& depth) const;

  /// The faces as they are drawn.
  [[nodiscard]] std::span<const FlatFace> faces() const { return faces_; }
  /// The place of a face that is visible at a point.
  [[nodiscard]] Hit at(std::int32_t index, float x, float y) const;
  /// The closest place to a point of the plane; without a face if there are no faces.
  [[nodiscard]] Hit closest(float x, float y) const;
  /// The closest places to four points, about four times as fast.
  /// \param guesses  of `faces()` some that are near, so that the search ends soon; kNone: not known
  [[nodiscard]] std::array<Hit, 4> closest(const Quad& quad, std::array<std::int32_t, 2> guesses,
                                           Visited& visited) const;

 private:
  void collect(const ChartFrame& frame, std::int32_t region, const Lean& lean, bool facing);

  const Mesh& mesh_;
  const Neighbourhood& near_;
  TexelBox box_;
  std::vector<FlatFace> faces_, upright_;  // as they are drawn, and as they lie above the plane
  std::vector<FlatEdges> edges_;           // edges of the latter
  std::vector<FlatBox> boxes_, upright_boxes_;
  Bins squares_, grid_;
};

}  // namespace isimp::detail
