// Cuts polygons that are to be planar.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "complex/state.h"
#include "judge/defects.h"
#include "planar/draft.h"

namespace isimp::meshing::planar {

using Edge = std::array<std::int32_t, 2>;  ///< corners, the lower first

/// The edges of all polygons, by corner.
class Edges {
 public:
  explicit Edges(std::int32_t corners) : beyond_(corners) {}
  [[nodiscard]] bool has(const Edge& e) const;
  void add(const Edge& e) { beyond_[e[0]].push_back(e[1]); }
  void remove(const Edge& e);

 private:
  std::vector<std::vector<std::int32_t>> beyond_;  // by the lower corner; an edge of two polygons stands twice
};

/// The cuts of units that have corners off their planes: such corners are cut off by as few triangles as possible. The
/// rest stays one polygon, or a few. No cut joins two corners that an edge joins already.
class Cuts {
 public:
  /// \param defects  of the present polygons
  Cuts(State& state, const Defects& defects, Draft& draft);

  /// Cuts the waiting units of the draft, and rebuilds their polygons.
  /// \return their charts, in rising order
  /// Cost: O(n^3) for each unit of n corners.
  std::vector<std::int32_t> renew();
  /// The cuts of a unit at an earlier time.
  struct Was {
    std::int32_t unit;
    std::vector<Edge> cuts;
    bool uncut;
  };
  using Past = std::vector<Was>;
  /// The cuts of the waiting units.
  [[nodiscard]] Past past() const;
  /// Sets the cuts of units to earlier ones, with the corners where they were then. No unit waits any more.
  void restore(Past past);
  /// The number of polygons that cuts have added to a unit.
  [[nodiscard]] std::int32_t added(std::size_t u) const { return static_cast<std::int32_t>(cuts_[u].size()); }
  [[nodiscard]] bool is_whole(std::size_t u) const { return cuts_[u].empty() && !uncut_[u] && !draft_.units[u].left; }

 private:
  /// \return whether there is a way
  bool cut(std::int32_t u);
  /// Replaces the cuts of a unit.
  void set(std::int32_t u, std::vector<Edge> cuts);
  /// Rebuilds the polygons of the units of some charts.
  void rebuild(std::span<const std::int32_t> charts);

  State& s_;
  Draft& draft_;
  const double thickness_;  // scene units; a thinner triangle has no area
  Edges edges_;
  std::vector<std::vector<Edge>> cuts_;  // by unit: the edges across it, by corners
  std::vector<bool> uncut_;              // by unit: there is no way to cut it
};

}  // namespace isimp::meshing::planar
