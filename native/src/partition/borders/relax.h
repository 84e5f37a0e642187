#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "borders/block_changes.h"
#include "borders/border_moves.h"
#include "borders/distances.h"
#include "isimp/core/job.h"
#include "isimp/core/prefetch.h"
#include "isimp/core/threads.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/regions.h"

namespace isimp {

/// The weight of borders for the least error. If it is about in proportion to the error (a share of the surface), it
/// smooths borders alike for few regions and many, and does not change exact shapes. The exponent is a little above 1,
/// since the gain of a face from a region that bends much is mostly noise. The weight stays well below the gain of a
/// face across a crease of 45 degrees.
inline BorderWeight border_weight(double error) {
  // tuned borders
  constexpr double kOfError = 1.64;     // weight over that power of the error
  constexpr double kPower = 1.35;       // power of the error
  constexpr double kMostWeight = 0.18;  // largest weight
  return {std::min(kOfError * std::pow(error, kPower), kMostWeight)};
}

/// As `border_weight`, for regions of other methods, whose error relaxing has to lower.
inline BorderWeight light_border_weight(double error) {
  // tuned unrecorded
  constexpr double kLightOfError = 0.6;      // weight over the error
  constexpr double kMostLightWeight = 0.12;  // largest weight
  return {std::min(kLightOfError * error, kMostLightWeight)};
}

/// The weight of a border as long as a region is wide, as a share of a region's area. It is in proportion to the error,
/// so that exact shapes do not change; from kMostError on, where regions are far from planar, it is constant.
/// \param smooth  PartitionOptions::smooth
inline double border_price(double error, double smooth) {
  // tuned shapes
  constexpr double kNu = 0.6;         // weight, over the error, of a border as long as its region is wide
  constexpr double kMostError = 0.1;  // largest error that counts
  return kNu * smooth * std::min(error, kMostError);
}

/// The weight of borders for regions of good shape, at any resolution of the scan.
/// \param nodes  faces, or patches, that the regions are made of
inline BorderWeight border_weight(double error, double smooth, std::int64_t nodes, std::int64_t regions) {
  constexpr double kEdge = 1.52;  // unit: length of an edge of an equilateral triangle of area 1
  const BorderWeight least = border_weight(error);
  if (!(smooth > 0) || regions < 1) return least;
  const double width = std::sqrt(static_cast<double>(nodes) / static_cast<double>(regions));
  return {std::max(least.edge, kEdge * border_price(error, smooth) * width), true};
}

/// Boundary relaxation: moves single faces between neighbouring regions as long as that lowers the energy
/// error + weight * mean face area * number of edges between regions.
///
/// With S the sum of area * normal, the error is 2 (A - sum |S|), so that the change by a move costs O(1). Without the
/// boundary term ragged borders are rewarded. A region never falls apart: a face leaves only if its neighbours of the
/// same region stay joined around a vertex they share, which a walk around that vertex shows. Sweeps visit the faces
/// near the last changes.
///
/// Long queues are swept in blocks of the Morton order, which threads share. A block reads nothing outside itself
/// except the sums of the regions as they were at the start; so no block sees the moves of others, and no region falls
/// apart by moves in several blocks. Faces that need data beyond the block come last, one after another. Blocks are cut
/// without regard to the number of threads, and so the result is the same for any.
/// Source: the energy moves of Valette, Chassery, Prost 2008, with the L2,1 error.
template <class Labels>
class Relaxation {
 public:
  /// \param sums    (R) is kept up to date with every move
  /// \param weight  of an edge between regions; unless it is wide, faces smaller than the mean take a proportionate
  ///                share of it
  /// \param face_weight  Surface::relative_weight; counts where borders are wide
  Relaxation(const FaceGraph& graph, Labels labels, std::vector<RegionSum>& sums, BorderWeight weight,
             const Threads& threads = Threads(1), RelativeWeight face_weight = {})
      : moves_{graph,
               labels,
               static_cast<float>(weight.edge),
               weight.is_wide,
               1.0F / static_cast<float>(graph.size()),
               face_weight},
        sums_(sums),
        threads_(threads),
        state_(graph.faces.size(), 0) {
    refit();
  }

  /// Adds a face to the next sweep.
  void push(std::int32_t face) { lists_.push(face, state_[face]); }
  /// Whether the face has a neighbour of another region.
  [[nodiscard]] bool on_border(std::int32_t face) const {
    const std::int32_t own = moves_.labels.get(face), n = moves_.graph.size();
    bool border = false;  // visits all in any case: no processor predicts well which neighbour is the other one
    for (const std::int32_t j : moves_.graph.neighbours[face])
      border |= static_cast<int>(j != n) & static_cast<int>(moves_.labels.get(j) != own);
    return border;
  }
  /// Prefetches the data that on_border will read, except the labels.
  void fetch(std::int32_t face) const { prefetch(&moves_.graph.neighbours[face]); }
  void push_if_border(std::int32_t face) {
    if (on_border(face)) push(face);
  }
  /// Must follow every change of the sums from outside.
  void refit() {
    proxies_.resize(sums_.size());
    for (std::size_t r = 0; r < sums_.size(); ++r) proxies_[r] = BorderProxy::of(sums_[r]);
  }
  /// Every face ever pushed, once. If all border faces were pushed at the start, it always contains all of them.
  [[nodiscard]] const std::vector<std::int32_t>& pushed() const { return lists_.pushed; }
  /// The one face that must not move, or kNone.
  void pin(std::int32_t face) { moves_.pinned = face; }
  /// From now on distances count too; null: no longer. A region whose distances are unknown is summed up once a sweep
  /// comes there.
  /// \param distances  are kept up to date with every sweep
  void measure(Distances* distances) { moves_.distances = distances_ = distances; }
  /// As the weight of the constructor.
  void weigh(BorderWeight weight) {
    moves_.edge_weight = static_cast<float>(weight.edge);
    moves_.is_wide = weight.is_wide;
  }

  /// Sweeps until nothing moves, `sweeps` times at most; the queue is cleared then.
  /// \return number of moves
  std::int64_t run(int sweeps, Job& job) {
    std::int64_t moves = 0, last = 1;
    for (int k = 0; k < sweeps && last > 0 && !lists_.queue.empty();) {
      // A block can't sum up regions that it comes to.
      const bool many = lists_.queue.size() >= kMany && (distances_ == nullptr || distances_->knows_all());
      moves += last = many ? sweep_blocks(job) : sweep_all(job);
      k += many ? kSweepsOfBlock : 1;
    }
    for (const std::int32_t face : lists_.queue) state_[face] = kPushed;
    lists_.queue.clear();
    return moves;
  }

 private:
  static constexpr std::uint8_t kQueued = 1, kPushed = 2, kSummed = 4;  // mark: states of a face
  static constexpr std::int32_t kBlock = 1 << 15;                       // work: faces of a block
  static constexpr std::size_t kMany = 1 << 13;         // work: faces in the queue from which blocks are worth it
  static constexpr int kSweepsOfBlock = 2;              // work: sweeps before blocks exchange their changes
  static constexpr std::size_t kAhead = 16, kSoon = 6;  // work: faces to prefetch ahead

  /// Faces to visit, and all that were visited before.
  struct Lists {
    std::vector<std::int32_t> queue, current, pushed;
    std::vector<std::array<std::int32_t, 3>> moved;  // face, its region before and after, where distances count
    void push(std::int32_t face, std::uint8_t& state) {
      if ((state & kQueued) != 0) return;
      if (state == 0) pushed.push_back(face);
      state = kQueued | kPushed;
      queue.push_back(face);
    }
  };

  /// The regions for a single thread: moves show at once.
  struct AllRegions {
    std::vector<RegionSum>& sums;
    std::vector<BorderProxy>& proxies;
    [[nodiscard]] const BorderProxy& proxy(std::int32_t r) const { return proxies[r]; }
    void move(const FaceRecord& face, std::int32_t from, std::int32_t to) {
      sums[from].remove(face);
      sums[to].add(face);
      proxies[from] = BorderProxy::of(sums[from]);
      proxies[to] = BorderProxy::of(sums[to]);
    }
  };

  /// The regions as seen from one block: their state at the start, with the changes by moves within the block.
  struct BlockRegions {
    const std::vector<RegionSum>& sums;
    BlockChanges<RegionSum, BorderProxy> changes;
    [[nodiscard]] const BorderProxy& proxy(std::int32_t r) const { return changes.view(r); }
    void move(const FaceRecord& face, std::int32_t from, std::int32_t to) {
      auto [left, of_left] = changes.touch(from);
      left.remove(face);
      of_left = seen(from, left);
      auto [joined, of_joined] = changes.touch(to);
      joined.add(face);
      of_joined = seen(to, joined);
    }
    [[nodiscard]] BorderProxy seen(std::int32_t r, const RegionSum& change) const {
      RegionSum sum = sums[r];
      sum.add(change);
      return BorderProxy::of(sum);
    }
  };

  struct Block {
    Lists lists;
    std::vector<std::int32_t> beyond;  // faces to be visited from outside
    std::vector<std::pair<std::int32_t, RegionSum>> changes;
    std::int64_t moves = 0;
  };

  /// Processes lists.current.
  /// \return number of moves
  template <class Regions>
  std::int64_t sweep(Lists& lists, Regions& regions, const Reach& reach, std::vector<std::int32_t>& beyond, Job& job) {
    const FaceGraph& graph = moves_.graph;
    std::int64_t moves = 0;
    const std::size_t size = lists.current.size();
    for (std::size_t i = 0; i < size; ++i) {
      if ((i & 0x3fff) == 0) job.poll();
      if (i + kAhead < size) {
        const std::int32_t soon = lists.current[i + kAhead];
        prefetch(&graph.neighbours[soon]);
        prefetch(&graph.faces[soon]);
        if (distances_ != nullptr) distances_->fetch_triangle(soon);
      }
      if (distances_ != nullptr && i + kSoon < size) distances_->fetch_corners(lists.current[i + kSoon]);
      if constexpr (requires { moves_.labels.prefetch(0); }) {
        if (i + kSoon < size)
          for (const std::int32_t j : graph.neighbours[lists.current[i + kSoon]]) moves_.labels.prefetch(j);
      }
      const std::int32_t face = lists.current[i];
      const std::int32_t to = moves_.target(face, regions, reach);
      if (to == BorderMoves<Labels>::kBeyond) {  // stays queued, so that it is queued once
        beyond.push_back(face);
        continue;
      }
      state_[face] = kPushed;
      if (to == kNone) continue;
      const std::int32_t from = moves_.labels.get(face);
      regions.move(graph.faces[face], from, to);
      if (distances_ != nullptr) lists.moved.push_back({face, from, to});
      moves_.labels.set(face, to);
      ++moves;
      for (const std::int32_t j : graph.neighbours[face])
        if (j != graph.size()) lists.push(j, state_[j]);
    }
    return moves;
  }

  std::int64_t sweep_all(Job& job) {
    std::swap(lists_.queue, lists_.current);
    lists_.queue.clear();
    if (distances_ != nullptr && !distances_->knows_all()) sum_up_around(lists_.current);
    AllRegions regions{sums_, proxies_};
    const std::int32_t n = moves_.graph.size();
    std::vector<std::int32_t> none;  // all faces are within reach
    const std::int64_t moves = sweep(lists_, regions, {0, n, n}, none, job);
    if (distances_ != nullptr) follow();
    return moves;
  }

  /// Sums up the distances of the regions to which these faces may go, if that is still to be done.
  void sum_up_around(const std::vector<std::int32_t>& faces) {
    for (const std::int32_t face : faces) {
      sum_up_region(face);
      for (const std::int32_t j : moves_.graph.neighbours[face]) sum_up_region(j);
    }
  }
  void sum_up_region(std::int32_t face) {
    const std::int32_t region = moves_.labels.get(face), n = moves_.graph.size();
    if (region < 0 || distances_->knows(region)) return;
    std::vector<std::int32_t> faces{face};
    state_[face] |= kSummed;
    for (std::size_t k = 0; k < faces.size(); ++k) {
      distances_->add(faces[k], region);
      for (const std::int32_t j : moves_.graph.neighbours[faces[k]]) {
        if (j == n || (state_[j] & kSummed) != 0 || moves_.labels.get(j) != region) continue;
        state_[j] |= kSummed;
        faces.push_back(j);
      }
    }
    for (const std::int32_t f : faces) state_[f] &= static_cast<std::uint8_t>(~kSummed);
    distances_->start(region, sums_[region]);
  }

  /// Makes the distances follow the moves of a sweep.
  void follow() {
    std::vector<std::int32_t> changed;
    for (const auto& [face, from, to] : lists_.moved) {
      distances_->move(face, from, to);
      changed.push_back(from);
      changed.push_back(to);
    }
    lists_.moved.clear();
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    for (const std::int32_t region : changed) distances_->fit(region);
  }

  std::int64_t sweep_blocks(Job& job) {
    const std::int32_t n = moves_.graph.size();
    std::vector<Block> blocks(static_cast<std::size_t>(n / kBlock + 1));
    for (const std::int32_t face : lists_.queue) blocks[face / kBlock].lists.queue.push_back(face);
    lists_.queue.clear();
    const auto count = static_cast<std::int32_t>(blocks.size());
    threads_.share(count, [&](const auto& next) {
      BlockRegions regions{sums_, BlockChanges<RegionSum, BorderProxy>(proxies_)};
      for (std::int32_t b = next(); b < count; b = next()) {
        Block& block = blocks[b];
        const Reach reach{b * kBlock, std::min(n, (b + 1) * kBlock), n};
        for (int k = 0; k < kSweepsOfBlock; ++k) {
          std::swap(block.lists.queue, block.lists.current);
          block.lists.queue.clear();
          block.moves += sweep(block.lists, regions, reach, block.beyond, job);
        }
        block.changes = regions.changes.take();
      }
    });
    return join(blocks, job);
  }

  /// Publishes the changes of the blocks, and processes the faces that needed data beyond them.
  std::int64_t join(const std::vector<Block>& blocks, Job& job) {
    std::int64_t moves = 0;
    std::vector<std::int32_t>& beyond = lists_.current;
    beyond.clear();
    for (const Block& block : blocks) {
      moves += block.moves;
      for (const auto& [region, change] : block.changes) sums_[region].add(change);
      lists_.queue.insert(lists_.queue.end(), block.lists.queue.begin(), block.lists.queue.end());
      lists_.moved.insert(lists_.moved.end(), block.lists.moved.begin(), block.lists.moved.end());
      lists_.pushed.insert(lists_.pushed.end(), block.lists.pushed.begin(), block.lists.pushed.end());
      beyond.insert(beyond.end(), block.beyond.begin(), block.beyond.end());
    }
    for (const Block& block : blocks)
      for (const auto& [region, unused] : block.changes) proxies_[region] = BorderProxy::of(sums_[region]);
    AllRegions regions{sums_, proxies_};
    const std::int32_t n = moves_.graph.size();
    std::vector<std::int32_t> none;
    moves += sweep(lists_, regions, {0, n, n}, none, job);
    if (distances_ != nullptr) follow();
    return moves;
  }

  BorderMoves<Labels> moves_;
  Distances* distances_ = nullptr;
  std::vector<RegionSum>& sums_;
  std::vector<BorderProxy> proxies_;
  Threads threads_;
  Lists lists_;
  std::vector<std::uint8_t> state_;  // state of each face
};

/// The error of regions by a metric in which distances count, as a share of the surface's area.
inline double error_by(const Distances& distances, std::span<const RegionSum> sums) {
  double error = distances.error();
  for (const RegionSum& sum : sums) error += distances.of_normals() * sum.error();
  return error;
}

/// Relaxes borders by a metric in which distances count, from regions that were relaxed by their normals alone.
///
/// Merging and relaxing by normals come before, since normals find creases and the number of regions, and are cheap.
/// Planes turn as faces move, so that faces move that were at rest: all borders are visited several times.
/// \param relaxation  of all these regions; all faces on borders have been pushed
/// \param smooth, count  as for `border_weight`, whose error is that by this metric
/// \return Regions::off_planes
template <class Labels>
double relax_by(Metric metric, const Surface& surface, Labels labels, std::vector<RegionSum>& sums,
                Relaxation<Labels>& relaxation, double smooth, std::int64_t count, Job& job) {
  // tuned distances
  constexpr int kFitRounds = 2, kFitSweeps = 60;  // of planes that are fitted again; the most of a round
  if (metric == Metric::normals) return 0.0;
  Distances distances(surface, metric, count);
  distances.sum_up(labels, sums, job);
  relaxation.weigh(border_weight(error_by(distances, sums), smooth, surface.graph().size(), count));
  relaxation.measure(&distances);
  for (int k = 0; k < kFitRounds; ++k) {
    const std::vector<std::int32_t> faces = relaxation.pushed();
    for (const std::int32_t face : faces) relaxation.push_if_border(face);
    if (relaxation.run(kFitSweeps, job) == 0) break;
  }
  relaxation.measure(nullptr);
  return distances.error();
}

/// Likewise; finds the borders itself.
inline void relax_by(Metric metric, const Surface& surface, Regions& regions, double smooth, const Threads& threads,
                     Job& job) {
  const GraphLabels labels{regions.label.data()};
  Relaxation<GraphLabels> relaxation(surface.graph(), labels, regions.sum, {}, threads, surface.relative_weight());
  for (std::int32_t i = 0; i < surface.graph().size(); ++i) relaxation.push_if_border(i);
  regions.off_planes = relax_by(metric, surface, labels, regions.sum, relaxation, smooth, regions.count(), job);
}

/// Relaxes all borders of some regions.
inline void relax_borders(const FaceGraph& graph, Regions& regions, BorderWeight weight, int sweeps,
                          const Threads& threads, Job& job, RelativeWeight face_weight = {}) {
  Relaxation<GraphLabels> relaxation(graph, {regions.label.data()}, regions.sum, weight, threads, face_weight);
  for (std::int32_t i = 0; i < graph.size(); ++i) relaxation.push_if_border(i);
  relaxation.run(sweeps, job);
}

}  // namespace isimp
