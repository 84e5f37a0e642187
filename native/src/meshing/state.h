#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "complex.h"
#include "discs.h"
#include "isimp/core/threads.h"
#include "isimp/meshing/polygonize.h"
#include "placement.h"
#include "polygons.h"

namespace isimp::meshing {

constexpr std::int32_t kLeastClosed = 4;  ///< no closed surface has fewer polygons
constexpr std::size_t kLarge = 64;        ///< chords of a piece beyond which what is at its ends is far apart

/// Two pieces made one, and what it takes to part them again.
struct Union {
  std::int32_t kept = kNone, gone = kNone;
  Piece kept_piece, gone_piece;
  std::vector<std::int32_t> faces;    ///< of the one that is gone
  std::vector<std::int32_t> corners;  ///< vertices of both that were
  std::vector<std::array<std::int32_t, 2>> kept_diagonals, gone_diagonals;
  Plane kept_plane, gone_plane;
  std::vector<std::int32_t> kept_loop, gone_loop;
};

/// How long the boundary of a piece is, and the part of it that each other piece is across of.
struct SharedBoundary {
  std::map<std::int32_t, double> with;    ///< pieces of its region
  std::map<std::int32_t, double> others;  ///< pieces of other regions
  double all = 0;
};

/// All that is known while a mesh is turned into polygons, from labels to positions, and how to bring it up to date
/// after a local change.
class State {
 public:
  /// \param job  polled by `update` too
  /// \param moments  as of Labels
  State(const Mesh& m, const Partition& p, const MeshingOptions& o, Job& job,
        std::span<const SurfaceMoments> moments = {});

  /// Where a piece would be split: in halves, or near a place. Threads may ask for several pieces at a time after the
  /// face marks of labels have been cleared.
  [[nodiscard]] Cut find_cut(std::int32_t piece, const Vec3* place);
  /// Splits a piece in two (and on, until all of it is discs).
  /// \return whether it could be
  bool split(std::int32_t piece, const Cut& cut, Job& job);
  /// Makes each face of a piece a piece of its own, all corners of which stay on the mesh.
  /// \return whether that is new
  bool shatter(std::int32_t piece);
  /// The pieces across the chords of one, in rising order.
  [[nodiscard]] std::vector<std::int32_t> neighbours(std::int32_t piece) const;
  /// Calls fn(piece) for each of them, once for each chord.
  template <class Function>
  void for_each_neighbour(std::int32_t piece, Function fn) const {
    for (const std::int32_t h : complex.chords(piece))
      if (const std::int32_t l = labels.across(h); l != kNone) fn(l);
  }
  /// Whether a piece borders so many holes that changes at its two ends do not affect each other.
  [[nodiscard]] bool is_large(std::int32_t piece) const {
    return cutter.perforated && complex.chords(piece).size() > kLarge;
  }
  /// Adds them to some pieces, in rising order then.
  void add_neighbours(std::vector<std::int32_t>& pieces) const;
  /// The region of a piece with these faces. The first piece of a region stays its piece while it has a face of it, so
  /// that every region keeps a polygon; other pieces are of the region that has most of their area. That may be another
  /// one than before: joining junctions and mending pinches hand faces over to a neighbour.
  [[nodiscard]] std::int32_t region_of(std::int32_t piece, std::span<const std::int32_t> faces) const;
  [[nodiscard]] SharedBoundary shared_boundary(std::int32_t piece) const;
  /// The boundary that two pieces would have together, as half-edges in order; empty where that would be no disc.
  /// Cost: O(their boundaries), of which the complex must be up to date.
  [[nodiscard]] std::vector<std::int32_t> loop_together(std::int32_t kept, std::int32_t gone);
  /// Makes two pieces one, which must be a disc.
  /// \return what was changed
  /// \param loop  what `loop_together` gave for them
  /// Cost: O(faces of the one that goes + their boundaries).
  Union unite(std::int32_t kept, std::int32_t gone, std::vector<std::int32_t> loop);
  void part_again(const Union& u);
  /// Tells that some faces have another label now, so that the next update need not look at all faces of these pieces.
  /// All pieces must still be discs, and that update must come before other changes.
  /// \param pieces  those whose boundaries, or what is across them, have changed
  /// Cost: O(faces).
  void hand_over(std::int32_t giver, std::int32_t taker, std::span<const std::int32_t> faces,
                 std::span<const std::int32_t> pieces);
  /// Brings polygons and positions up to date after splits, new corners, new diagonals or pulls.
  /// \param changed  pieces whose diagonals or pulls changed; the others are known
  /// \param before  where the corners were, for those to go back to; the others, and all if empty, are placed anew
  /// \return the pieces of which a polygon may have changed its place, in rising order
  std::vector<std::int32_t> update(std::vector<std::int32_t> changed, std::span<const Vec3> before = {});

  const Mesh& mesh;
  const Partition& partition;
  const MeshingOptions& options;
  const Threads threads;
  const std::int32_t regions;            ///< of the partition
  std::int32_t merged_without_area = 0;  ///< pieces that were given to a neighbour, as they had no area
  std::int64_t placed = 0;               ///< corners that were placed, each as often as it was
  Labels labels;
  Cutter cutter;
  std::vector<Plane> planes;  ///< by piece
  Complex complex;
  Diagonals diagonals;  ///< by piece
  Corners corners;
  Polygons polygons;

 private:
  /// Faces that went from one piece to another since the last update, as a plane.
  struct Handover {
    std::int32_t giver, taker;
    Plane part;
  };
  /// The boundary of a piece that has changed, from what it was; empty where it was none.
  [[nodiscard]] std::vector<std::int32_t> loop_again(std::int32_t piece) const;
  /// Applies the handovers to the planes.
  /// \return by touched piece, sorted and each once: whether all of it is known but its boundary
  std::vector<bool> settle_handovers();

  const Job& job_;
  std::vector<Handover> handovers_;
  std::vector<std::int32_t> handed_;    // pieces that were touched by these alone, each as often as it was
  std::vector<std::int32_t> united_;    // pieces that went into others since the last update
  std::map<std::int32_t, Disc> discs_;  // by piece: what was seen when it was split, until the next update
  /// By piece: its boundary, where all that is asked of its faces is known after a change.
  std::map<std::int32_t, std::vector<std::int32_t>> known_;
};

}  // namespace isimp::meshing
