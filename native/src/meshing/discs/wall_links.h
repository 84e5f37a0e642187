// Walls with holes, and the cuts that may link their holes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "discs/discs.h"
#include "discs/vec2.h"

namespace isimp::meshing {

/// A place on a boundary loop of a wall where a cut may end.
struct LoopPlace {
  std::int32_t vertex;
  Vec2 at;  ///< in the frame of the wall
};

/// A wall: a flat chart with holes, in a frame of its two main directions, given by the longest edges of its boundary.
/// Cuts end at corners of the holes, and on the outline at its corners or along a main direction from a corner of a
/// hole.
class Wall {
 public:
  static constexpr std::size_t kMostCorners = 8;  ///< limit: corners of a hole at which cuts may end

  /// \return nullopt for a chart that is bent, or whose boundary has no main directions
  static std::optional<Wall> find(const Labels& labels, std::span<const std::int32_t> faces, const Shape& shape);

  [[nodiscard]] double size() const { return size_; }  ///< sqrt(area)
  [[nodiscard]] std::int32_t holes() const { return static_cast<std::int32_t>(corners_.size()); }
  [[nodiscard]] std::span<const LoopPlace> corners(std::int32_t hole) const { return corners_[hole]; }
  /// The bounding box of a hole: its low and its high corner.
  [[nodiscard]] const std::array<Vec2, 2>& box(std::int32_t hole) const { return box_[hole]; }
  /// The cost of a straight cut that meets no boundary: its length, more if it is slanted.
  [[nodiscard]] static double least_price(const LoopPlace& a, const LoopPlace& b);
  /// The cost of a straight cut; infinite if it meets a boundary.
  [[nodiscard]] double price(const LoopPlace& a, const LoopPlace& b) const;

  struct Way {
    double price = std::numeric_limits<double>::infinity();
    LoopPlace end{kNone, Vec2::Zero()};  ///< on the outline
  };
  /// The cheapest cut from a corner of a hole to the outline.
  [[nodiscard]] Way way_out(const LoopPlace& from) const;

 private:
  struct Edge {
    LoopPlace from, to;
    std::int32_t loop;
  };
  explicit Wall(const Labels& labels) : labels_(labels) {}
  [[nodiscard]] Vec2 flat(std::int32_t vertex) const;
  bool turn_to_main_directions(const Shape& shape);
  void collect(const Shape& shape);
  [[nodiscard]] std::vector<LoopPlace> corners_of(const std::vector<std::int32_t>& loop, double reach) const;
  [[nodiscard]] Way straight_out(const LoopPlace& from, const Vec2& direction) const;

  const Labels& labels_;
  Vec3 origin_ = Vec3::Zero(), along_ = Vec3::UnitX(), across_ = Vec3::UnitY();
  double size_ = 0;
  std::vector<Edge> edges_;  // edges of all loops
  std::int32_t outer_ = 0;
  std::vector<LoopPlace> outline_;               // its corners
  std::vector<std::vector<LoopPlace>> corners_;  // by hole
  std::vector<std::array<Vec2, 2>> box_;         // by hole
};

}  // namespace isimp::meshing
