#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "borders/distances.h"
#include "isimp/core/prefetch.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"
#include "isimp/partition/surface.h"

namespace isimp {

/// Labels by graph index that lie in an array of n + 1 in the order of the graph.
struct GraphLabels {
  std::int32_t* label;
  [[nodiscard]] std::int32_t get(std::int32_t i) const { return label[i]; }
  void set(std::int32_t i, std::int32_t region) const { label[i] = region; }
  void prefetch(std::int32_t i) const { isimp::prefetch(&label[i]); }
};

/// The view of a region for a face that might join or leave it.
struct BorderProxy {
  float x = 0, y = 0, z = 0;  ///< unit normal
  float half_inverse = 0;     ///< 1 / (2 |S|)

  static BorderProxy of(const RegionSum& s) {
    const double length = s.length(), inverse = length > 0 ? 1.0 / length : 0.0;
    return {static_cast<float>(s.x * inverse), static_cast<float>(s.y * inverse), static_cast<float>(s.z * inverse),
            static_cast<float>(inverse / 2)};
  }
  [[nodiscard]] float dot(const FaceRecord& f) const { return f.nx * x + f.ny * y + f.nz * z; }
  /// The growth of |S| for each unit of area when a face of area w and normal n joins: (|S + w n| - |S|) / w.
  /// \param along  n . S / |S|; its negative for a face that leaves
  [[nodiscard]] float growth(float along, float area) const {
    constexpr float kSmall = 0.05F;  // rounding: w / 2 |S| up to which the second order of the series is enough
    const float half_ratio = area * half_inverse;
    if (half_ratio <= kSmall) return along + half_ratio * (1 - along * along);
    const float ratio = 2 * half_ratio;
    return (std::sqrt(std::max(0.0F, 1 + ratio * (2 * along + ratio))) - 1) / ratio;
  }
};

/// A range of faces whose labels may be read. The sentinel after the last face is always readable.
struct Reach {
  std::int32_t begin, end, sentinel;
  [[nodiscard]] bool holds(std::int32_t i) const {
    return static_cast<std::uint32_t>(i - begin) < static_cast<std::uint32_t>(end - begin) || i == sentinel;
  }
};

/// The weight of borders, relative to the error.
struct BorderWeight {
  double edge = 0;       ///< weight of an edge of the mean length between two regions, over the mean area of a face
  bool is_wide = false;  ///< by length, and counted over all faces that share a vertex: over edges alone, each zigzag
                         ///< that turns neither back nor aside is as short as the straight way
};

/// The worth of a border where the weights are w times their mean, relative to one of the same length elsewhere.
inline float worth_of(float w) { return 1 / std::sqrt(w); }

/// Judges whether a face on a border between regions should go to the other side, and whether it may.
template <class Labels>
struct BorderMoves {
  static constexpr std::int32_t kBeyond = -2;  ///< mark: instead of a region: the decision needs faces beyond the reach

  const FaceGraph& graph;
  Labels labels;
  float edge_weight = 0;                 ///< weight of an edge between regions, over the mean area of a face
  bool is_wide = false;                  ///< see BorderWeight
  float mean_area = 0;                   ///< mean area of a face
  RelativeWeight weight;                 ///< weights of the faces
  std::int32_t pinned = kNone;           ///< the one face that must not move
  const Distances* distances = nullptr;  ///< null: normals alone count

  /// The neighbouring region to which a move of the face lowers the energy most; kNone if there is none or it may not
  /// leave its own. `regions` has the proxy of each region.
  template <class Regions>
  std::int32_t target(std::int32_t face, Regions& regions, const Reach& reach) const {
    const auto& neighbours = graph.neighbours[face];
    for (const std::int32_t j : neighbours)
      if (!reach.holds(j)) return kBeyond;
    const std::int32_t own = labels.get(face);
    std::array<std::int32_t, 3> near;
    for (int k = 0; k < 3; ++k) near[k] = labels.get(neighbours[k]);
    const int same = (near[0] == own) + (near[1] == own) + (near[2] == own);
    if (same == 3 || same == 0 || own < 0 || face == pinned) return kNone;
    const FaceRecord& f = graph.faces[face];
    const BorderProxy& home = regions.proxy(own);
    const float leaving = home.growth(-home.dot(f), f.area);
    Ring ring;
    if (is_wide && !read_ring(face, reach, ring)) return kBeyond;
    const float edge = edge_weight * (is_wide              ? kOfEdge * length_at(face, f.area)
                                      : f.area < mean_area ? f.area
                                                           : mean_area);
    const float least = kLeastGain * (f.area + edge);
    Distances::Corners corners;
    double far = 0;
    if (distances != nullptr) {
      corners = distances->corners(face);
      far = distances->square(corners, own);
    }
    const auto gain_of = [&](std::int32_t other, int there) {
      const BorderProxy& proxy = regions.proxy(other);
      float gain = leaving + proxy.growth(proxy.dot(f), f.area);  // half of the fall of the error, as in all of this
      if (distances != nullptr)
        gain = distances->of_normals() * gain + static_cast<float>((far - distances->square(corners, other)) / 2);
      const float shorter = static_cast<float>(there - same) + kOfVertex * static_cast<float>(ring.gain(own, other));
      return f.area * gain + edge * shorter;
    };
    if (same == 2) {  // most faces; without a loop, as it can't be predicted which neighbour is the other one
      const std::int32_t other = near[0] ^ near[1] ^ near[2];
      const bool wanted = other >= 0 && gain_of(other, 1) > least && may_join(face, other);
      return wanted ? stays_joined(face, own, near, reach, other) : kNone;
    }
    float best = least;
    std::int32_t to = kNone;
    for (const std::int32_t other : near) {
      if (other == own || other < 0) continue;
      const float gain = gain_of(other, (near[0] == other) + (near[1] == other) + (near[2] == other));
      if (gain > best && may_join(face, other)) {
        best = gain;
        to = other;
      }
    }
    return to;
  }

 private:
  /// Labels may restrict the moves of a face: `allows(face, region)`.
  [[nodiscard]] bool may_join([[maybe_unused]] std::int32_t face, [[maybe_unused]] std::int32_t region) const {
    if constexpr (requires { labels.allows(face, region); })
      return labels.allows(face, region);
    else
      return true;
  }

  // tuned shapes
  // A pair of faces that share just a vertex counts as half an edge, so that straight borders cost about the same in
  // all directions; there are some seven such pairs to an edge of a straight border.
  static constexpr float kOfVertex = 0.5F, kOfEdge = 1 / (1 + 7 * kOfVertex);

  /// The length of an edge of a face of this area for a wide border, in mean areas. Where weights make regions small, a
  /// border of the same length is worth less (worth_of).
  [[nodiscard]] float length_at(std::int32_t face, float area) const {
    const float w = weight.of(face);
    return w > 0 ? std::sqrt(area / w * mean_area) * worth_of(w) : 0;
  }

  /// Labels of the faces that share just a vertex with a face.
  struct Ring {
    static constexpr int kMostLabels = 24;  // limit
    std::array<std::int32_t, kMostLabels> label;
    int size = 0;
    /// The number of them in the one region minus the number in the other.
    [[nodiscard]] int gain(std::int32_t own, std::int32_t other) const {
      int sum = 0;
      for (int i = 0; i < size; ++i) sum += static_cast<int>(label[i] == other) - static_cast<int>(label[i] == own);
      return sum;
    }
  };

  /// Moves from one face at a vertex to the next, away from the one before.
  void go_on_round(std::int32_t& before, std::int32_t& at) const {
    const auto& next = graph.neighbours[at];
    const std::int32_t beyond = next[0] == before ? next[2] : next[1] == before ? next[0] : next[1];
    before = at;
    at = beyond;
  }

  /// \return false where they are beyond the reach
  bool read_ring(std::int32_t face, const Reach& reach, Ring& ring) const {
    const auto& around = graph.neighbours[face];
    for (int k = 0; k < 3; ++k) {  // around the vertex between edges k and k + 1
      const std::int32_t goal = around[(k + 1) % 3];
      std::int32_t before = face, at = around[k];
      for (int step = 0; step < Ring::kMostLabels / 3 && at != goal && at != graph.size(); ++step) {
        if (!reach.holds(at)) return false;
        if (before != face) ring.label[ring.size++] = labels.get(at);
        go_on_round(before, at);
      }
    }
    return true;
  }

  static constexpr float kLeastGain =
      1e-6F;                               // rounding: share of the face's area: less is rounding, and would oscillate
  static constexpr int kLongestWalk = 32;  // limit: steps at a vertex; beyond it the face just stays

  /// For a face with two neighbours in its own region: `to` if the region stays connected without it, else kNone.
  [[nodiscard]] std::int32_t stays_joined(std::int32_t face, std::int32_t own, const std::array<std::int32_t, 3>& near,
                                          const Reach& reach, std::int32_t to) const {
    const auto& around = graph.neighbours[face];
    // Edges k and k + 1 meet in a vertex; walk around it from the neighbour across one to the neighbour across the
    // other.
    const int first = near[0] != own ? 1 : near[1] != own ? 2 : 0;
    const std::int32_t goal = around[(first + 1) % 3];
    std::int32_t before = face, at = around[first];
    for (int step = 0; step < kLongestWalk; ++step) {
      if (at == goal) return to;
      if (!reach.holds(at)) return kBeyond;
      if (at == graph.size() || labels.get(at) != own) return kNone;
      go_on_round(before, at);
    }
    return kNone;
  }
};

}  // namespace isimp
