#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <queue>
#include <span>
#include <vector>

#include "borders/relax.h"
#include "isimp/core/check.h"
#include "isimp/mesh/face_graph.h"
#include "isimp/partition/metric.h"

/// Changes to single regions with the cost of the changed faces. `Labels` as in relax.h.
namespace isimp {

/// mark: label of a face that was removed from its region and waits for another.
inline constexpr std::int32_t kOpen = -2;
/// mark: during a flood, kOffered - k is the label of an open face whose best offer is that of its region k.
inline constexpr std::int32_t kOffered = -4;

/// Gathers the faces of the region of a face (or of the part left out it lies in), and marks each as kOpen.
template <class Labels>
std::vector<std::int32_t> take_out(const FaceGraph& graph, Labels labels, std::int32_t face) {
  const std::int32_t own = labels.get(face);
  std::vector<std::int32_t> faces{face};
  labels.set(face, kOpen);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (const std::int32_t j : graph.neighbours[faces[i]])
      if (j != graph.size() && labels.get(j) == own) {
        labels.set(j, kOpen);
        faces.push_back(j);
      }
  return faces;
}

/// A queue for flooding a few regions: by error, then by arrival, so that where all errors are equal the regions meet
/// half-way. Errors below 2^-24 are rounding and count as equal.
class LocalQueue {
 public:
  struct Entry {
    float error;
    std::uint32_t arrival;
    std::int32_t face, region;
    bool operator>(const Entry& o) const { return error != o.error ? error > o.error : arrival > o.arrival; }
  };
  /// An error, at least 2^-24.
  static float level(float error) { return std::max(error, 0x1p-24F); }
  void push(float error, std::int32_t face, std::int32_t region) {
    entries_.push_back({level(error), arrivals_++, face, region});
    std::push_heap(entries_.begin(), entries_.end(), std::greater<>());
  }
  Entry pop() {
    std::pop_heap(entries_.begin(), entries_.end(), std::greater<>());
    const Entry least = entries_.back();
    entries_.pop_back();
    return least;
  }
  [[nodiscard]] bool empty() const { return entries_.empty(); }

 private:
  std::vector<Entry> entries_;
  std::uint32_t arrivals_ = 0;
};

/// Offers of open faces to regions, best first. An offer that cannot win is left out: its face has an earlier one that
/// is at least as good.
template <class Labels>
class Offers {
 public:
  Offers(const FaceGraph& graph, Labels labels) : graph_(graph), labels_(labels) {}

  /// Offers region k of `proxies` to a face, if the face is open.
  template <class Proxies>
  void add(std::int32_t face, std::int32_t k, const Proxies& proxies) {
    const std::int32_t label = labels_.get(face);
    if (label != kOpen && label > kOffered) return;
    const FaceRecord& f = graph_.faces[face];
    const float error = LocalQueue::level(NormalMetric::error(f, proxies[k]));
    if (label != kOpen && LocalQueue::level(NormalMetric::error(f, proxies[kOffered - label])) <= error) return;
    labels_.set(face, kOffered - k);
    queue_.push(error, face, k);
  }
  /// Calls settle(face, k) with the best offer of each face, which must label it and may add others.
  template <class Settle>
  void settle_all(Settle settle) {
    while (!queue_.empty()) {
      const LocalQueue::Entry next = queue_.pop();
      if (labels_.get(next.face) <= kOffered) settle(next.face, next.region);
    }
  }
  [[nodiscard]] bool empty() const { return queue_.empty(); }

 private:
  const FaceGraph& graph_;
  Labels labels_;
  LocalQueue queue_;
};

/// The face nearest to a proxy; ties to the first in the list. `skip` is not considered.
inline std::int32_t nearest_of(const FaceGraph& graph, std::span<const std::int32_t> faces,
                               const NormalMetric::Proxy& proxy, std::int32_t skip = kNone) {
  std::int32_t nearest = kNone;
  float least = std::numeric_limits<float>::infinity();
  for (const std::int32_t face : faces) {
    const float error = NormalMetric::error(graph.faces[face], proxy);
    if (error < least && face != skip) {
      least = error;
      nearest = face;
    }
  }
  return nearest;
}

/// The two halves of a former region.
struct Halves {
  std::array<std::int32_t, 2> region, seed;
  std::array<NormalMetric::Proxy, 2> proxy;
  std::array<RegionSum, 2> sum;
};

/// Moves two proxies to the clusters of the faces' normals: each face counts for the nearer one, connected or not. Two
/// seeds on the same side of a crease would otherwise never separate the two sides.
inline void part_normals(const FaceGraph& graph, std::span<const std::int32_t> faces,
                         std::array<NormalMetric::Proxy, 2>& proxy, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    std::array<RegionSum, 2> sum;
    for (const std::int32_t face : faces) {
      const FaceRecord& f = graph.faces[face];
      sum[NormalMetric::error(f, proxy[1]) < NormalMetric::error(f, proxy[0]) ? 1 : 0].add(f);
    }
    for (int k = 0; k < 2; ++k)
      if (sum[k].length() > 0) proxy[k] = NormalMetric::fit(sum[k]);
  }
}

// tuned unrecorded
inline constexpr int kSplitRounds = 3;  // rounds of fitting the halves of a split

/// First proxies and seeds for splitting a region: the two sides of its most unlike normals, or of its length if flat.
inline Halves two_sides(const FaceGraph& graph, std::span<const std::int32_t> faces, const RegionSum& sum) {
  ISIMP_ASSERT(faces.size() >= 2, "what is split has two faces");
  const auto farthest_from = [&](const NormalMetric::Proxy& proxy) {
    std::int32_t farthest = faces[0];
    float most = -1.0F;
    for (const std::int32_t face : faces) {
      const FaceRecord& f = graph.faces[face];
      const float error = f.area * NormalMetric::error(f, proxy);  // by area: slivers may have any normal
      if (error <= most) continue;
      most = error;
      farthest = face;
    }
    return std::pair(most, farthest);
  };
  Halves halves;
  halves.seed = {faces.front(), faces.back()};  // as gathered breadth first: far from each other
  halves.proxy = {NormalMetric::fit(sum), NormalMetric::fit(sum)};
  const auto [most, a] = farthest_from(halves.proxy[0]);
  if (most < 1e-9F * static_cast<float>(sum.weight)) return halves;
  const std::int32_t b = farthest_from(NormalMetric::proxy_of(graph.faces[a])).second;
  halves.proxy = {NormalMetric::proxy_of(graph.faces[a]), NormalMetric::proxy_of(graph.faces[b])};
  part_normals(graph, faces, halves.proxy, kSplitRounds);
  const std::int32_t first = nearest_of(graph, faces, halves.proxy[0]);
  halves.seed = {first, nearest_of(graph, faces, halves.proxy[1], first)};
  return halves;
}

/// Floods open faces from two seeds, `rounds` times with a new fit in between.
/// \param faces  connected, all kOpen, the seeds among them
/// \param keep   the second seed stays where it is
template <class Labels>
void flood_halves(const FaceGraph& graph, Labels labels, std::span<const std::int32_t> faces, Halves& halves,
                  int rounds, bool keep) {
  Offers<Labels> offers(graph, labels);
  for (int round = 0; round < rounds; ++round) {
    if (round > 0) {
      for (int k = 0; k < 2; ++k) halves.proxy[k] = NormalMetric::fit(halves.sum[k]);
      float least[2] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
      const std::int32_t kept = halves.seed[1];
      for (const std::int32_t face : faces) {
        const int k = labels.get(face) == halves.region[1] ? 1 : 0;
        const float error = NormalMetric::error(graph.faces[face], halves.proxy[k]);
        if (error >= least[k]) continue;
        least[k] = error;
        halves.seed[k] = face;
      }
      if (keep) halves.seed[1] = kept;
      for (const std::int32_t face : faces) labels.set(face, kOpen);
    }
    halves.sum = {};
    const auto settle = [&](std::int32_t face, int k) {
      labels.set(face, halves.region[k]);
      halves.sum[k].add(graph.faces[face]);
      for (const std::int32_t j : graph.neighbours[face]) offers.add(j, k, halves.proxy);
    };
    labels.set(halves.seed[1], halves.region[1]);  // so that the first seed's neighbours do not claim it
    settle(halves.seed[0], 0);
    settle(halves.seed[1], 1);
    offers.settle_all(settle);
  }
}

/// Splits a region in its labels: its open faces become part of their half.
/// \param faces  connected, all kOpen, at least two
/// \param sum    of the faces
/// \return the halves; the split lowers the error by split_gain(sum, halves)
template <class Labels>
Halves split_in_two(const FaceGraph& graph, Labels labels, std::span<const std::int32_t> faces, const RegionSum& sum,
                    std::array<std::int32_t, 2> region) {
  Halves halves = two_sides(graph, faces, sum);
  halves.region = region;
  flood_halves(graph, labels, faces, halves, kSplitRounds, false);
  return halves;
}

inline double split_gain(const RegionSum& sum, const Halves& halves) {
  return sum.error() - halves.sum[0].error() - halves.sum[1].error();
}

/// Floods open faces from the regions around them, whose sums grow; their proxies stay fixed meanwhile.
/// \param touched  the regions that grew are appended, each once
/// \return false if there is no region around: the faces then are still open
template <class Labels>
bool flood_from_around(const FaceGraph& graph, Labels labels, std::span<const std::int32_t> faces,
                       std::vector<RegionSum>& sums, std::vector<std::int32_t>& touched) {
  Offers<Labels> offers(graph, labels);
  std::vector<NormalMetric::Proxy> proxies;  // proxies of touched[k]
  const std::size_t first = touched.size();
  for (const std::int32_t face : faces)
    for (const std::int32_t j : graph.neighbours[face]) {
      const std::int32_t r = labels.get(j);
      if (r < 0) continue;
      const auto at = std::find(touched.begin() + static_cast<std::ptrdiff_t>(first), touched.end(), r);
      const auto k = static_cast<std::int32_t>(at - touched.begin()) - static_cast<std::int32_t>(first);
      if (at == touched.end()) {
        touched.push_back(r);
        proxies.push_back(NormalMetric::fit(sums[r]));
      }
      offers.add(face, k, proxies);
    }
  if (offers.empty()) return false;
  offers.settle_all([&](std::int32_t face, std::int32_t k) {
    const std::int32_t r = touched[first + static_cast<std::size_t>(k)];
    labels.set(face, r);
    sums[r].add(graph.faces[face]);
    for (const std::int32_t j : graph.neighbours[face]) offers.add(j, k, proxies);
  });
  return true;
}

}  // namespace isimp
