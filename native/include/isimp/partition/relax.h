#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "isimp/core/job.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"

namespace isimp {

/// Labels by graph index that lie in an array of n + 1 in the order of the graph.
struct GraphLabels {
  std::int32_t* label;
  [[nodiscard]] std::int32_t get(std::int32_t i) const { return label[i]; }
  void set(std::int32_t i, std::int32_t region) const { label[i] = region; }
};

/// Labels by graph index that lie in an array of n in the order of the mesh.
struct MeshLabels {
  std::int32_t* region;
  const FaceGraph* graph;
  [[nodiscard]] std::int32_t get(std::int32_t i) const {
    return i == graph->size() ? kNone : region[graph->mesh_face[i]];
  }
  void set(std::int32_t i, std::int32_t r) const { region[graph->mesh_face[i]] = r; }
};

/// What an edge between two regions weighs in the energy, in mean face areas: heavier edges make borders shorter and
/// the error larger. In proportion to the error (a share of the surface) it smooths borders alike for few regions and
/// many, and leaves exact shapes alone; it stays well below what a face gains across a crease of 45 degrees.
inline double border_weight(double error) { return std::min(0.6 * error, 0.12); }

/// Whether the region of a face stays connected without it, as far as a walk round one vertex can tell: where the faces
/// of the same region beside it are joined elsewhere only, the answer is no, also for the last face of a region.
template <class Labels>
[[nodiscard]] bool may_leave(const FaceGraph& graph, const Labels& labels, std::int32_t face) {
  constexpr int kLongestWalk = 32;  // round a vertex; beyond it the face just stays
  const auto& around = graph.neighbours[face];
  const std::int32_t own = labels.get(face), n = graph.size();
  const bool in[3] = {labels.get(around[0]) == own, labels.get(around[1]) == own, labels.get(around[2]) == own};
  const int count = in[0] + in[1] + in[2];
  if (count != 2) return count == 1;
  // Edges k and k + 1 meet in a vertex; turn round it from the neighbour across the one to that across the other.
  const int first = in[0] && in[1] ? 0 : in[1] && in[2] ? 1 : 2;
  const std::int32_t goal = around[(first + 1) % 3];
  std::int32_t before = face, at = around[first];
  for (int step = 0; step < kLongestWalk; ++step) {
    if (at == goal) return true;
    if (at == n || labels.get(at) != own) return false;
    const auto& next = graph.neighbours[at];
    const int back = next[0] == before ? 0 : next[1] == before ? 1 : 2;
    before = std::exchange(at, next[(back + 2) % 3]);
  }
  return false;
}

/// Boundary relaxation: moves single faces between neighbouring regions as long as that lowers the energy
/// error + lambda * mean face area * number of edges between regions.
///
/// With S the sum of area * normal, the error is 2 (A - sum |S|), so that the change by a move costs O(1); the second
/// order of its series is enough. Without the boundary term ragged borders are rewarded. A region never falls apart:
/// a face leaves only if its neighbours of the same region stay joined round a vertex they share, which can be seen by
/// a walk round that vertex. Sweeps look at the faces near which something has changed.
/// Source: the energy moves of Valette, Chassery, Prost 2008, with the L2,1 error.
template <class Labels>
class Relaxation {
 public:
  /// \param sums    (R) is kept up to date with every move
  /// \param lambda  weight of an edge between regions; faces smaller than the mean take a proportionate share of it
  Relaxation(const FaceGraph& graph, Labels labels, std::vector<RegionSum>& sums, double lambda)
      : graph_(graph), labels_(labels), sums_(sums), state_(graph.faces.size(), 0) {
    mean_area_ = 1.0F / static_cast<float>(graph.size());
    lambda_ = static_cast<float>(lambda);
    refit();
  }

  /// Has the next sweep look at a face.
  void push(std::int32_t face) {
    std::uint8_t& state = state_[face];
    if ((state & kQueued) != 0) return;
    if (state == 0) pushed_.push_back(face);
    state = kQueued | kPushed;
    queue_.push_back(face);
  }
  /// Pushes the face if it has a neighbour of another region.
  void push_if_border(std::int32_t face) {
    const std::int32_t own = labels_.get(face);
    for (const std::int32_t j : graph_.neighbours[face])
      if (j != graph_.size() && labels_.get(j) != own) return push(face);
  }
  /// Must follow every change of the sums from outside.
  void refit() {
    proxies_.resize(sums_.size());
    for (std::size_t r = 0; r < sums_.size(); ++r) refit(static_cast<std::int32_t>(r));
  }
  void refit(std::int32_t region) {
    const RegionSum& s = sums_[region];
    const double length = s.length(), inverse = length > 0 ? 1.0 / length : 0.0;
    proxies_[region] = {static_cast<float>(s.x * inverse), static_cast<float>(s.y * inverse),
                        static_cast<float>(s.z * inverse), static_cast<float>(inverse / 2)};
  }
  /// Every face ever pushed, once. Had all border faces been pushed at the start, all are among them at any time.
  [[nodiscard]] const std::vector<std::int32_t>& pushed() const { return pushed_; }
  /// The one face that must not move, or kNone.
  void pin(std::int32_t face) { pinned_ = face; }

  /// Sweeps until nothing moves, `sweeps` at most; what is still queued then is forgotten. \return moves made
  std::int64_t run(int sweeps, Job& job) {
    std::int64_t moves = 0, last = 1;
    for (int k = 0; k < sweeps && last > 0 && !queue_.empty(); ++k) moves += last = sweep(job);
    for (const std::int32_t face : queue_) state_[face] = kPushed;
    queue_.clear();
    return moves;
  }

 private:
  struct Proxy {
    float x, y, z;       // unit normal
    float half_inverse;  // 1 / (2 |S|)
    [[nodiscard]] float dot(const FaceRecord& f) const { return f.nx * x + f.ny * y + f.nz * z; }
  };

  std::int64_t sweep(Job& job) {
    std::swap(queue_, current_);
    queue_.clear();
    std::int64_t moves = 0;
    const std::size_t size = current_.size();
    for (std::size_t i = 0; i < size; ++i) {
      if ((i & 0x3fff) == 0) job.poll();
      if (i + kAhead < size) {
        const std::int32_t soon = current_[i + kAhead];
        __builtin_prefetch(&graph_.neighbours[soon]);
        __builtin_prefetch(&graph_.faces[soon]);
      }
      const std::int32_t face = current_[i];
      state_[face] = kPushed;
      const std::int32_t to = best_move(face);
      if (to == kNone || !may_leave(graph_, labels_, face)) continue;
      move(face, to);
      ++moves;
    }
    return moves;
  }

  /// The neighbouring region to which a move of the face lowers the energy most; kNone if there is none.
  std::int32_t best_move(std::int32_t face) const {
    const auto& neighbours = graph_.neighbours[face];
    const std::int32_t own = labels_.get(face);
    std::array<std::int32_t, 3> near;
    for (int k = 0; k < 3; ++k) near[k] = labels_.get(neighbours[k]);
    const int same = (near[0] == own) + (near[1] == own) + (near[2] == own);
    if (same == 3 || own < 0 || sums_[own].faces <= 1 || face == pinned_) return kNone;
    const FaceRecord& f = graph_.faces[face];
    // |S - wn| - |S| and |S + wn| - |S| to second order in w, divided by w.
    const float from = proxies_[own].dot(f);
    const float leaving = -from + f.area * (1 - from * from) * proxies_[own].half_inverse;
    const float edge = lambda_ * (f.area < mean_area_ ? f.area : mean_area_);
    float best = kLeastGain * (f.area + edge);
    std::int32_t to = kNone;
    for (const std::int32_t other : near) {
      if (other == own || other < 0) continue;
      const int there = (near[0] == other) + (near[1] == other) + (near[2] == other);
      const float into = proxies_[other].dot(f);
      const float joining = into + f.area * (1 - into * into) * proxies_[other].half_inverse;
      const float gain = f.area * (leaving + joining) + edge * static_cast<float>(there - same);
      if (gain > best) {
        best = gain;
        to = other;
      }
    }
    return to;
  }

  void move(std::int32_t face, std::int32_t to) {
    const std::int32_t own = labels_.get(face);
    sums_[own].remove(graph_.faces[face]);
    sums_[to].add(graph_.faces[face]);
    refit(own);
    refit(to);
    labels_.set(face, to);
    for (const std::int32_t j : graph_.neighbours[face])
      if (j != graph_.size()) push(j);
  }

  static constexpr std::uint8_t kQueued = 1, kPushed = 2;
  static constexpr float kLeastGain = 1e-6F;  // of the face's area: less is rounding, and would go to and fro
  static constexpr std::size_t kAhead = 8;    // faces, for the memory to be there in time

  const FaceGraph& graph_;
  Labels labels_;
  std::vector<RegionSum>& sums_;
  std::vector<Proxy> proxies_;
  std::vector<std::int32_t> queue_, current_;
  std::vector<std::uint8_t> state_;  // of each face: kPushed, kQueued
  std::vector<std::int32_t> pushed_;
  float mean_area_ = 0, lambda_ = 0;
  std::int32_t pinned_ = kNone;
};

}  // namespace isimp
