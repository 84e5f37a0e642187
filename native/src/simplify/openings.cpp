#include "isimp/simplify/openings.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "components.h"
#include "isimp/core/errors.h"
#include "isimp/core/forest.h"
#include "isimp/core/sorted.h"
#include "isimp/mesh/part_of.h"
#include "isimp/partition/noise.h"
#include "isimp/simplify/partitioner.h"

namespace isimp {
namespace {

// tuned real
constexpr double kOfRegion = 0.5;    // share of sqrt(area / regions)
constexpr double kMostEdges = 20;    // mean edges
constexpr double kFlat = 2.0;        // sqrt(area / regions): holes in walls
constexpr double kPinhole = 8;       // mean edges: the border of the faces at one vertex
constexpr double kLikely = 2.5;      // detail times number of regions: 9 of 10 scans are below
constexpr double kMostPatch = 2.0;   // mean regions; patches that cut a handle have up to 1.6
constexpr double kMostShare = 0.01;  // of the surface

/// As `opening_lengths`, for a scan with openings.
OpeningLengths lengths_of(double area, double edge, std::int32_t regions) {
  const double side = std::sqrt(area / regions);
  const auto rounded = [&](double length) { return edge * std::exp2(std::floor(2 * std::log2(length / edge)) / 2); };
  const double length = rounded(std::min(kOfRegion * side, kMostEdges * edge));
  return {.holes = std::max(length, rounded(std::min(side, kPinhole * edge))),
          .flat_holes = rounded(std::min(kFlat * side, kMostEdges * edge)),
          .handles = length};
}

/// Calls fn(mesh) with the components that a partition keeps.
template <class Function>
auto on_kept(const Mesh& mesh, const PartitionOptions& options, Job& job, Function fn) {
  const std::int32_t count = has_openings(mesh) ? left_out_count(mesh, options, job) : 0;
  const std::vector<std::uint8_t> left_out = smallest_components(mesh, count, job);
  if (left_out.empty()) return fn(mesh);
  std::vector<std::int32_t> kept;
  for (std::size_t f = 0; f < left_out.size(); ++f)
    if (left_out[f] == 0) kept.push_back(static_cast<std::int32_t>(f));
  return fn(part_of(mesh, kept, job));
}

/// Whether a mesh has openings that may be errors of scanning.
bool is_open_scan(const Mesh& mesh, Job& job) {
  return has_openings(mesh) && is_noisier(mesh, kScanNoise * mean_edge(mesh), job);
}

}  // namespace

std::int32_t left_out_count(const Mesh& mesh, const PartitionOptions& options, Job& job) {
  if (mesh.component_count() == 1 || options.leave_out <= 0) return 0;
  const std::int32_t proxies =
      options.triangles ? proxies_for(*options.triangles, mesh.face_count()) : options.proxies.value_or(1);
  return find_components(mesh, proxies, options.leave_out, job).left_out;
}

std::vector<std::uint8_t> smallest_components(const Mesh& mesh, std::int32_t count, Job& job) {
  if (count <= 0) return {};
  const std::vector<Component> all = find_components(mesh, 1, 0.0, job).all;
  std::vector<std::int32_t> order = numbers_below(static_cast<std::int32_t>(all.size()));
  std::ranges::stable_sort(order, {}, [&](std::int32_t c) { return all[c].area; });
  std::vector<std::uint8_t> is_small(all.size(), 0), marked;
  for (const std::int32_t c : std::span(order).first(std::min(order.size() - 1, static_cast<std::size_t>(count))))
    is_small[c] = 1;
  marked.reserve(mesh.component().size());
  for (const std::int32_t c : mesh.component()) marked.push_back(is_small[c]);
  return marked;
}

bool has_openings(const Mesh& mesh) {
  const MeshReport& report = mesh.report();
  return report.border_loops > 0 || report.euler != 2 * static_cast<std::int64_t>(report.components);
}

OpeningLengths opening_lengths(const Mesh& mesh, std::int32_t regions, Job& job,
                               const std::optional<PartitionOptions>& options) {
  if (regions < 1) throw InvalidInput("regions must be at least 1, got " + std::to_string(regions));
  const auto lengths = [&](const Mesh& kept) {
    return is_open_scan(kept, job) ? lengths_of(kept.graph().area, mean_edge(kept), regions) : OpeningLengths{};
  };
  return on_kept(mesh, options.value_or(PartitionOptions{.proxies = regions}), job, lengths);
}

namespace {

GuessedLengths guess_on_kept(const Mesh& mesh, const PartitionOptions& options, Job& job) {
  if (!is_open_scan(mesh, job)) return {.lengths = {}, .most = mesh.face_count(), .likely = true};
  const double area = mesh.graph().area, edge = mean_edge(mesh);
  GuessedLengths found{.lengths = lengths_of(area, edge, 1), .most = 1};
  // The first number past which they differ, between one that has them and one that has not.
  for (std::int32_t step = mesh.face_count(); step > 0; step /= 2)
    while (found.most <= mesh.face_count() - step && lengths_of(area, edge, found.most + step) == found.lengths)
      found.most += step;
  const double detail =
      options.tolerance ? *options.tolerance / surface_size(mesh) : options.detail.value_or(kDefaultDetail);
  found.likely = !options.proxies && !options.bound && detail * found.most >= kLikely;
  return found;
}

}  // namespace

GuessedLengths guess_opening_lengths(const Mesh& mesh, const PartitionOptions& options, Job& job) {
  return on_kept(mesh, options, job, [&](const Mesh& kept) { return guess_on_kept(kept, options, job); });
}

double opening_length(const Mesh& mesh, std::int32_t regions, Job& job,
                      const std::optional<PartitionOptions>& options) {
  return opening_lengths(mesh, regions, job, options).handles;
}

std::vector<double> weights_without_patches(const Mesh& mesh, std::span<const std::int32_t> source,
                                            std::vector<double> weights, std::int32_t regions) {
  if (std::find(source.begin(), source.end(), kNone) == source.end()) return weights;
  const auto count = static_cast<std::size_t>(mesh.face_count());
  if (!weights.empty() && weights.size() != count) return weights;
  detail::Forest patches(count);
  std::vector<double> area(count, 0.0);  // share of the surface, by root
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h) {
    const std::int32_t other = mesh.opposite(h);
    if (other != kNone && source[h / 3] == kNone && source[other / 3] == kNone) patches.join(h / 3, other / 3);
  }
  const FaceGraph& graph = mesh.graph();
  const double most = std::min(kMostShare, kMostPatch / regions);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (source[f] == kNone) area[patches.root(f)] += graph.faces[graph.graph_face[f]].area;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (source[f] != kNone || area[patches.root(f)] > most) continue;
    if (weights.empty()) weights.assign(count, 1.0);
    weights[f] = 0.0;
  }
  return weights;
}

}  // namespace isimp
