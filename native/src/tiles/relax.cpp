#include "isimp/tiles/relax.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "borders/relax.h"
#include "isimp/core/errors.h"

namespace isimp::tiles {
namespace {

/// Labels of faces, some of which must not change.
struct FrozenLabels {
  std::int32_t* label;
  const std::uint8_t* frozen;
  std::int32_t owned;
  [[nodiscard]] std::int32_t get(std::int32_t i) const { return label[i]; }
  void set(std::int32_t i, std::int32_t region) const { label[i] = region; }
  [[nodiscard]] bool allows(std::int32_t i, std::int32_t /*region*/) const { return i < owned && frozen[i] == 0; }
};

void check(const TileFaces& tile, std::span<const std::int32_t> label, std::size_t regions) {
  const auto n = static_cast<std::int32_t>(tile.face.size());
  if (tile.neighbour.size() != tile.face.size() || label.size() != tile.face.size() || tile.owned < 0 || tile.owned > n)
    throw InvalidInput("faces, neighbours and labels of a tile must be of the same number");
  for (std::int32_t i = 0; i < n; ++i) {
    for (const std::int32_t j : tile.neighbour[i])
      if (j < kNone || j >= n)
        throw InvalidInput("face " + std::to_string(i) + " of the tile has neighbour " + std::to_string(j) +
                           ", but there are " + std::to_string(n) + " faces");
    if (label[i] < kNone || (label[i] >= 0 && static_cast<std::size_t>(label[i]) >= regions))
      throw InvalidInput("face " + std::to_string(i) + " of the tile is in region " + std::to_string(label[i]) +
                         ", but there are " + std::to_string(regions));
  }
}

/// Returns the tile as a mesh for borders/relax.h, which expects a mean area of 1 / n for n faces. Areas are scaled so
/// that the mean over all tiles has this value.
FaceGraph graph_of(const TileFaces& tile, double unit) {
  FaceGraph graph;
  const auto n = static_cast<std::int32_t>(tile.face.size());
  graph.faces.assign(tile.face.begin(), tile.face.end());
  graph.faces.emplace_back();
  for (FaceRecord& f : graph.faces) f.area = static_cast<float>(f.area * unit);
  graph.neighbours.assign(tile.neighbour.begin(), tile.neighbour.end());
  graph.neighbours.push_back({n, n, n});
  for (auto& around : graph.neighbours)
    for (std::int32_t& j : around) j = j == kNone ? n : j;
  graph.mesh_face.resize(static_cast<std::size_t>(n));  // only its size is used
  return graph;
}

/// The regions of a tile, with numbers of its own.
struct Local {
  std::vector<std::int32_t> name;   // region of each own number, rising
  std::vector<std::int32_t> label;  // (n + 1) own number of each face
};

Local localised(std::span<const std::int32_t> label, std::size_t regions) {
  Local local;
  std::vector<std::int32_t> number(regions, kNone);
  for (const std::int32_t r : label)
    if (r != kNone) number[r] = 0;
  for (std::size_t r = 0; r < regions; ++r)
    if (number[r] == 0) {
      number[r] = static_cast<std::int32_t>(local.name.size());
      local.name.push_back(static_cast<std::int32_t>(r));
    }
  local.label.reserve(label.size() + 1);
  for (const std::int32_t r : label) local.label.push_back(r == kNone ? kNone : number[r]);
  local.label.push_back(kNone);
  return local;
}

RegionSum scaled(const RegionSum& s, double by) { return {s.x * by, s.y * by, s.z * by, s.weight * by, s.faces}; }

}  // namespace

Relaxed relax(const TileFaces& tile, std::span<const std::int32_t> label, std::span<const std::uint8_t> frozen,
              std::span<const RegionSum> sum, const RelaxOptions& options, Job& job) {
  check(tile, label, sum.size());
  if (frozen.size() != tile.face.size()) throw InvalidInput("`frozen` must have one value for each face of the tile");
  if (!(options.area > 0) || options.faces < 1) throw InvalidInput("the tiles must have an area and faces");
  Relaxed result;
  const auto n = static_cast<double>(tile.face.size());
  const double unit = static_cast<double>(options.faces) / n / options.area;
  const FaceGraph graph = graph_of(tile, unit);
  Local local = localised(label, sum.size());
  std::vector<RegionSum> sums;
  sums.reserve(local.name.size());
  for (const std::int32_t r : local.name) sums.push_back(scaled(sum[r], unit));
  const std::vector<RegionSum> before = sums;
  const BorderWeight weight = border_weight(options.error, options.smooth, options.faces, options.regions);
  Relaxation<FrozenLabels> relaxation(graph, {local.label.data(), frozen.data(), tile.owned}, sums, weight);
  for (std::int32_t i = 0; i < tile.owned; ++i) {
    if ((i & 0xffff) == 0) job.poll();
    if (frozen[i] == 0 && local.label[i] != kNone) relaxation.push_if_border(i);
  }
  result.moves = relaxation.run(options.sweeps, job);
  result.label.reserve(static_cast<std::size_t>(tile.owned));
  for (std::int32_t i = 0; i < tile.owned; ++i)
    result.label.push_back(local.label[i] == kNone ? kNone : local.name[local.label[i]]);
  for (std::size_t r = 0; r < sums.size(); ++r) {
    const RegionSum &a = sums[r], &b = before[r];
    if (a.faces == b.faces && a.x == b.x && a.y == b.y && a.z == b.z) continue;
    const RegionSum change{a.x - b.x, a.y - b.y, a.z - b.z, a.weight - b.weight, a.faces - b.faces};
    result.change.emplace_back(local.name[r], scaled(change, 1 / unit));
  }
  return result;
}

Touching touching(const TileFaces& tile, std::span<const std::int32_t> label,
                  std::span<const std::array<float, 3>> length) {
  if (tile.neighbour.size() != label.size() || length.size() != static_cast<std::size_t>(tile.owned) ||
      label.size() < length.size())
    throw InvalidInput("neighbours, labels and lengths of a tile must be of the same number");
  struct Edge {
    std::array<std::int32_t, 2> pair;
    double length;
  };
  std::vector<Edge> edges;
  for (std::int32_t i = 0; i < tile.owned; ++i)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t j = tile.neighbour[i][k];
      if (j < 0 || static_cast<std::size_t>(j) >= label.size() || label[j] == label[i] || label[i] == kNone ||
          label[j] == kNone)
        continue;
      edges.push_back({{std::min(label[i], label[j]), std::max(label[i], label[j])}, 0.5 * length[i][k]});
    }
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.pair < b.pair; });
  Touching result;
  for (const Edge& edge : edges) {
    if (result.pair.empty() || result.pair.back() != edge.pair) {
      result.pair.push_back(edge.pair);
      result.length.push_back(0);
    }
    result.length.back() += edge.length;
  }
  return result;
}

}  // namespace isimp::tiles
