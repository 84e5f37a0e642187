#include "hierarchy/region_graph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "borders/border_moves.h"
#include "isimp/core/prefetch.h"
#include "isimp/core/to_integer.h"

namespace isimp {
namespace {

/// The place of a neighbour of a region in a graph.
std::int32_t entry(const MergeGraph& graph, std::int32_t region, std::int32_t neighbour) {
  const auto row = graph.around(region);
  return graph.first[region] +
         static_cast<std::int32_t>(std::lower_bound(row.begin(), row.end(), neighbour) - row.begin());
}

constexpr std::int64_t kMostLength = std::int64_t{1}
                                     << 60;  // rounding: and of sums: edges of regions without area are all
                                             // longer
constexpr std::size_t kFacesAhead = 8;       // work: faces to prefetch ahead
constexpr std::size_t kBorderOfPair = 16;    // work: border faces for each pair of regions, if there are few

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

/// A set of pairs of numbers below 2^31 that grows as it fills.
class PairSet {
 public:
  /// \param room  expected number of pairs
  explicit PairSet(std::size_t room) : slots_(std::bit_ceil(std::max<std::size_t>(2 * room, 1 << 10)), kEmpty) {}
  void insert(std::int32_t u, std::int32_t v) {
    const std::uint64_t key = static_cast<std::uint64_t>(u) << 32 | static_cast<std::uint32_t>(v);
    std::size_t at = place(key);
    while (slots_[at] != key) {
      if (slots_[at] == kEmpty) {
        slots_[at] = key;
        if (2 * ++size_ > slots_.size()) grow();
        return;
      }
      at = (at + 1) & (slots_.size() - 1);
    }
  }
  template <class Visit>
  void visit(Visit visit) const {
    for (const std::uint64_t key : slots_)
      if (key != kEmpty) visit(static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffU));
  }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};  // mark
  [[nodiscard]] std::size_t place(std::uint64_t key) const {
    return (key * 0x9e3779b97f4a7c15U >> 32) & (slots_.size() - 1);
  }
  void grow() {
    std::vector<std::uint64_t> old(2 * slots_.size(), kEmpty);
    old.swap(slots_);
    for (const std::uint64_t key : old) {
      if (key == kEmpty) continue;
      std::size_t at = place(key);
      while (slots_[at] != kEmpty) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = key;
    }
  }
  std::vector<std::uint64_t> slots_;
  std::size_t size_ = 0;
};

void insert_pairs(const FaceGraph& graph, const std::vector<std::int32_t>& label, std::span<const std::int32_t> faces,
                  PairSet& pairs) {
  std::pair<std::int32_t, std::int32_t> last(kNone, kNone);  // along a border the same pair occurs many times
  const std::size_t size = faces.size();
  for (std::size_t k = 0; k < size; ++k) {
    if (k + kFacesAhead < size) prefetch(&graph.neighbours[faces[k + kFacesAhead]]);
    const std::int32_t own = label[faces[k]];
    if (own == kNone) continue;
    for (const std::int32_t j : graph.neighbours[faces[k]]) {
      const std::int32_t other = label[j];
      if (other <= own || last == std::pair(own, other)) continue;  // the face beyond counts the others
      last = {own, other};
      pairs.insert(own, other);
    }
  }
}

/// Sorts by counting, first by the one number and then by the other, unless there are too few pairs for that.
void sort_pairs(Pairs& pairs) {
  std::int32_t most = 0;
  for (const auto& [u, unused] : pairs) most = std::max(most, u);  // each pair is there in both directions
  if (static_cast<std::size_t>(most) > 4 * pairs.size()) {
    std::sort(pairs.begin(), pairs.end());
    return;
  }
  std::vector<std::int32_t> first(static_cast<std::size_t>(most) + 2, 0);
  for (const auto& [u, unused] : pairs) ++first[u + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  Pairs by_second(pairs.size());
  std::vector<std::int32_t> next = first;
  for (const auto& pair : pairs) by_second[next[pair.second]++] = pair;
  for (const auto& pair : by_second) pairs[first[pair.first]++] = pair;
}

}  // namespace

std::vector<std::pair<std::int32_t, std::int32_t>> neighbouring_regions(const FaceGraph& graph,
                                                                        const std::vector<std::int32_t>& label,
                                                                        std::span<const std::int32_t> faces,
                                                                        const Threads& threads) {
  const auto size = static_cast<std::int32_t>(faces.size());
  const std::int32_t pieces = threads.pieces(size);
  std::vector<PairSet> found(static_cast<std::size_t>(pieces), PairSet(faces.size() / kBorderOfPair / pieces));
  threads.run(size, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    insert_pairs(graph, label, faces.subspan(begin, static_cast<std::size_t>(end - begin)), found[piece]);
  });
  for (std::size_t k = 1; k < found.size(); ++k)
    found[k].visit([&](std::int32_t u, std::int32_t v) { found[0].insert(u, v); });
  Pairs result;
  found[0].visit([&](std::int32_t u, std::int32_t v) {
    result.emplace_back(u, v);
    result.emplace_back(v, u);
  });
  sort_pairs(result);
  return result;
}

MergeGraph graph_of_regions(const FaceGraph& graph, const std::vector<std::int32_t>& label, std::size_t regions,
                            std::vector<std::int32_t> component, std::span<const std::int32_t> faces,
                            const Threads& threads) {
  MergeGraph result;
  result.component = std::move(component);
  result.sum.resize(regions);
  result.first.assign(regions + 1, 0);
  for (const auto& [u, v] : neighbouring_regions(graph, label, faces, threads)) {
    ++result.first[u + 1];
    result.neighbour.push_back(v);
  }
  for (std::size_t u = 0; u < regions; ++u) result.first[u + 1] += result.first[u];
  return result;
}

std::vector<double> border_lengths(const Surface& surface, const std::vector<std::int32_t>& label,
                                   std::span<const std::int32_t> faces, const MergeGraph& touching,
                                   const Threads& threads) {
  constexpr double kUnit = 0x1p40;  // rounding: sums of integers do not depend on the number of threads
  const auto add_up = [](std::int64_t& sum, std::int64_t more) { sum = std::min(kMostLength, sum + more); };
  const FaceGraph& graph = surface.graph();
  const Mesh& mesh = surface.mesh();
  const RelativeWeight weight = surface.relative_weight();
  const double share = kUnit / std::sqrt(std::max(mesh.graph().area, std::numeric_limits<double>::min()));
  const auto size = static_cast<std::int32_t>(faces.size());
  const std::int32_t pieces = threads.pieces(size);
  std::vector<std::vector<std::int64_t>> sums(static_cast<std::size_t>(pieces));
  threads.run(size, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    std::vector<std::int64_t>& sum = sums[piece];
    sum.assign(touching.neighbour.size(), 0);
    for (std::int32_t i = begin; i < end; ++i) {
      if (const auto soon = static_cast<std::size_t>(i) + kFacesAhead; soon < faces.size())
        prefetch(&graph.mesh_face[faces[soon]]);
      const std::int32_t own = label[faces[i]];
      for (int k = 0; k < 3; ++k) {
        const std::int32_t other = label[graph.neighbours[faces[i]][k]];
        if (other <= own || own == kNone) continue;  // once for the two sides
        const Triangle& t = mesh.triangles()[graph.mesh_face[faces[i]]];
        const double length = (mesh.vertices()[t[(k + 1) % 3]] - mesh.vertices()[t[k]]).norm();
        if (const float w = weight.of(faces[i]); w > 0)
          add_up(sum[entry(touching, own, other)],
                 to_integer(std::rint(share * length * worth_of(w)), std::int64_t{0}, kMostLength));
      }
    }
  });
  std::vector<double> result(touching.neighbour.size());
  for (std::int32_t own = 0; own + 1 < static_cast<std::int32_t>(touching.first.size()); ++own)
    for (std::int32_t at = touching.first[own]; at < touching.first[own + 1]; ++at) {
      const std::int32_t other = touching.neighbour[at];
      if (other < own) continue;
      std::int64_t all = 0;
      for (const auto& sum : sums) add_up(all, sum.empty() ? 0 : sum[at]);
      result[at] = result[entry(touching, other, own)] = static_cast<double>(all) / kUnit;
    }
  return result;
}

}  // namespace isimp
