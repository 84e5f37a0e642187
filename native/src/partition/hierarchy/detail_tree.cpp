#include "hierarchy/detail_tree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "borders/relax.h"
#include "density/normal_filter.h"
#include "hierarchy/features.h"
#include "hierarchy/hierarchy.h"
#include "hierarchy/region_graph.h"
#include "hierarchy/strays.h"
#include "isimp/partition/noise.h"

namespace isimp {
namespace {

constexpr int kTreeSweeps = 30;  // limit: sweeps of relaxation
// tuned found
constexpr double kBorder = 0.018;       // weight of an edge between regions, in mean face areas
constexpr double kNoisyBorder = 0.115;  // added to it where normals are all noise
// tuned houses
constexpr double kFaded = 0.25;             // share of its cost that the smoothing of borders may leave of a region
constexpr std::size_t kMostCosts = 20000;   // limit
constexpr std::int32_t kManyFaces = 50000;  // work: from here on many small patches merge at once
// tuned found
constexpr std::int32_t kFacesATreeProxy = 96;  // for patches of 6 faces
constexpr double kUsual = 0.7;     // quantile of the best prices of a level's patches; twice it is the level's price
constexpr double kFar = 1.0 / 16;  // share of the limit: up to levels of this price patches merge at once

std::vector<std::int32_t> components_of_faces(const Surface& surface) {
  std::vector<std::int32_t> component;
  const FaceGraph& graph = surface.graph();
  if (surface.component_count() == 1) return component;
  component.resize(static_cast<std::size_t>(graph.size()));
  for (std::int32_t i = 0; i < graph.size(); ++i) component[i] = surface.component()[graph.mesh_face[i]];
  return component;
}

/// The start of merging: faces, or small patches of them.
struct Start {
  ClusterGraph clusters;
  std::vector<std::int32_t> cluster;  ///< (n) of each face
};

Start start_from_faces(const FaceGraph& graph, std::span<const FaceRecord> smooth,
                       std::vector<std::int32_t> component) {
  Start start{.clusters = face_clusters(graph, smooth), .cluster = {}};
  start.clusters.component = std::move(component);
  start.cluster.resize(static_cast<std::size_t>(graph.size()));
  std::iota(start.cluster.begin(), start.cluster.end(), 0);
  return start;
}

/// The price below which most nodes find a partner, as a rise of the error.
double usual_price(const MergeGraph& graph) {
  std::vector<float> best;
  for (std::int32_t u = 0; u < graph.size(); ++u) {
    const NodeSum& a = graph.sum[u];
    float least = std::numeric_limits<float>::infinity();
    for (const std::int32_t v : graph.around(u)) {
      const NodeSum& b = graph.sum[v];
      least = std::min(least, lost_length(a, b, a.length + b.length));
    }
    if (least < std::numeric_limits<float>::infinity()) best.push_back(least);
  }
  if (best.empty()) return std::numeric_limits<double>::infinity();
  const auto at = best.begin() + static_cast<std::ptrdiff_t>(kUsual * static_cast<double>(best.size() - 1));
  std::nth_element(best.begin(), at, best.end());
  return 2.0 * *at;
}

/// Where single faces are far below the smallest visible detail, merging them one pair at a time is a waste: many pairs
/// merge at once, in the hierarchy of the smooth surface, until most merges cost a good part of the limit.
Start start_from_patches(const Surface& surface, std::span<const FaceRecord> smooth, double limit, std::int32_t threads,
                         Job& job) {
  const Hierarchy h = build_hierarchy(surface, surface.face_count() / kFacesATreeProxy, job,
                                      {.threads = threads, .faces = smooth, .most = limit});
  std::size_t level = 0;
  while (level + 1 < h.level.size() && usual_price(h.level[level + 1]) < kFar * limit) ++level;
  const MergeGraph& chosen = h.level[level];
  Start start{
      .clusters = {.sum = {}, .first = chosen.first, .neighbour = chosen.neighbour, .component = chosen.component},
      .cluster = h.patch};
  for (const NodeSum& s : chosen.sum) start.clusters.sum.push_back({s.x, s.y, s.z, 2.0 * s.length, 1});
  for (std::size_t i = 0; i < start.cluster.size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    for (std::size_t l = 0; l < level; ++l) start.cluster[i] = h.to_next[l][start.cluster[i]];
  }
  return start;
}

/// Replaces the region of each face by the region that it has become.
void relabel(Regions& regions, const std::vector<std::int32_t>& becomes, std::size_t count, const Threads& threads) {
  const auto n = static_cast<std::int32_t>(regions.label.size());
  threads.run(n, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end; ++i)
      if (regions.label[i] != kNone) regions.label[i] = becomes[regions.label[i]];
  });
  std::vector<RegionSum> sums(count);
  for (std::size_t r = 0; r < regions.sum.size(); ++r) sums[becomes[r]].add(regions.sum[r]);
  regions.sum = std::move(sums);
}

/// A cluster for each region.
/// \param faces  among which all border faces are
ClusterGraph clusters_of(const FaceGraph& graph, const Regions& regions, std::vector<std::int32_t> component,
                         std::span<const std::int32_t> faces, const Threads& threads) {
  MergeGraph touching =
      graph_of_regions(graph, regions.label, regions.sum.size(), std::move(component), faces, threads);
  return {regions.sum, std::move(touching.first), std::move(touching.neighbour), std::move(touching.component)};
}

/// The weight of an edge between regions where normals of neighbours differ by this much.
BorderWeight border_weight_of(double bend) { return {kBorder + kNoisyBorder * std::min(1.0, bend * bend)}; }

/// Pushes border faces of changed regions, and the faces across from them.
/// \return the other border faces
std::vector<std::int32_t> push_beside(const FaceGraph& graph, const std::vector<std::int32_t>& label,
                                      std::span<const std::int32_t> faces, const std::vector<std::uint8_t>& changed,
                                      Relaxation<GraphLabels>& relaxation) {
  std::vector<std::int32_t> others;
  for (const std::int32_t i : faces) {
    const std::int32_t own = label[i];
    bool border = false, beside = changed[own] != 0;
    for (const std::int32_t j : graph.neighbours[i]) {
      if (label[j] == own || label[j] == kNone) continue;
      border = true;
      beside |= changed[label[j]] != 0;
    }
    if (border && beside) relaxation.push(i);
    if (border && !beside) others.push_back(i);
  }
  return others;
}

}  // namespace

double finest_for(double detail) {
  double finest = kFinestDetail;
  while (finest > detail) finest /= 2;
  return finest;
}

std::int32_t small_count(std::int32_t faces) {
  // tuned round
  constexpr std::int32_t kFaces = 20;         // faces of a small region
  constexpr std::int32_t kFewest = 120;       // least number of small regions
  constexpr std::int32_t kMostRegions = 450;  // largest number of small regions
  constexpr std::int32_t kMostFine = 700;     // largest number of small regions of scans of more faces than kFine
  constexpr std::int32_t kFine = 100000;      // faces of a scan that is fine
  return std::min(faces, std::clamp(faces / kFaces, kFewest, faces > kFine ? kMostFine : kMostRegions));
}

DetailTree::DetailTree(const Surface& surface, const DetailSettings& settings, Job& job, std::int32_t threads)
    : settings_(settings),
      area_(surface.graph().area),
      size_(surface_size(surface.mesh())),
      noise_(settings.noise ? *settings.noise : estimate_noise(surface.mesh(), Threads(threads), job)),
      bend_(median_bend(surface.graph())),
      components_(find_components(surface, 1, settings.leave_out, job)) {
  for (const Component& component : components_.all) need_.push_back(component.need);
  {
    Job::Stage stage(job, "merging", 0.0, 0.9);
    make_patches(surface, threads, job);
  }
  Job::Stage stage(job, "merging", 0.9, 1.0);
  const FaceGraph& graph = surface.graph();
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    const std::int32_t own = patches_.label[i];
    for (const std::int32_t j : graph.neighbours[i])
      if (j != graph.size() && patches_.label[j] != own) {
        borders_.push_back(i);
        break;
      }
  }
  tree_ = merge_all(clusters_of(graph, patches_, component_, borders_, Threads(threads)), {.need = need_}, job);
  relax_patches(graph, job);
  touching_ = graph_of_regions(graph, patches_.label, patches_.sum.size(), {}, borders_, Threads(threads));
  falling_ = tree_.cost;
  std::sort(falling_.begin(), falling_.end(), std::greater<>());
  falling_.resize(std::min(falling_.size(), kMostCosts));
  for (double& cost : falling_) cost *= area_;
}

void DetailTree::make_patches(const Surface& surface, std::int32_t thread_count, Job& job) {
  const FaceGraph& graph = surface.graph();
  const std::vector<std::int32_t> component = components_of_faces(surface);
  {
    const double limit = merge_limit(settings_.finest * size_, noise_, kLeastNoise) / area_;
    const Array<FaceRecord> smooth = [&] {
      const Job::Stage smoothing(job, "merging", 0.1, 0.7);
      return filtered_faces(graph, kFilterPasses, filter_range(bend_), Threads(thread_count), job);
    }();
    Start start = [&] {
      const Job::Stage half(job, "merging", 0.7, 0.9);
      return graph.size() < kManyFaces ? start_from_faces(graph, smooth, component)
                                       : start_from_patches(surface, smooth, limit, thread_count, job);
    }();
    const MergeTree fine = merge_all(std::move(start.clusters), {.cost = limit, .need = need_}, job);
    const std::vector<std::int32_t> patch = cut_after(fine, fine.merges());
    if (const std::int32_t most = small_count(graph.size()), count = fine.leaves; count > most)
      if (const auto fewer = static_cast<std::size_t>(count - most); fewer < fine.merges()) {
        const std::vector<std::int32_t> small = cut_after(fine, fewer);
        small_.resize(start.cluster.size());
        for (std::size_t i = 0; i < small_.size(); ++i) small_[i] = small[start.cluster[i]];
      }
    patches_.label.resize(start.cluster.size());
    for (std::size_t i = 0; i < start.cluster.size(); ++i) patches_.label[i] = patch[start.cluster[i]];
    patches_.sum.resize(static_cast<std::size_t>(fine.leaves) - fine.merges());
  }
  // Components that are left out have no patches.
  std::vector<std::int32_t> number(patches_.sum.size(), kNone);
  std::int32_t kept = 0;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    std::int32_t& label = patches_.label[i];
    const std::int32_t of = component.empty() ? 0 : component[i];
    if (number[label] == kNone && components_.all[of].kept) {
      number[label] = kept++;
      if (!component.empty()) component_.push_back(of);
    }
    label = number[label];
  }
  patches_.label.push_back(kNone);
  patches_.sum.assign(static_cast<std::size_t>(kept), {});
  sum_regions(graph, patches_, job);
}

/// Most of the work of relaxing a cut is the same for all cuts: it is done once. The tree is not updated, so that it is
/// the same at any resolution.
void DetailTree::relax_patches(const FaceGraph& graph, Job& job) {
  Relaxation<GraphLabels> relaxation(graph, {patches_.label.data()}, patches_.sum, border_weight_of(bend_));
  for (const std::int32_t i : borders_) relaxation.push(i);
  relaxation.run(kTreeSweeps, job);
  borders_.clear();
  for (const std::int32_t i : relaxation.pushed())
    if (relaxation.on_border(i)) borders_.push_back(i);
  std::sort(borders_.begin(), borders_.end());
}

Cut DetailTree::choose(double tolerance, bool snap) const {
  const auto left = static_cast<std::int32_t>(patches_.sum.size() - tree_.merges());
  return choose_cut(falling_, left, kNoCost * area_, tolerance, settings_.finest * size_, noise_, snap,
                    [&](double cost) {
                      return keeps_features(tree_, patches_.sum, merge_limit(tolerance, noise_) / area_, cost / area_);
                    });
}

std::int32_t DetailTree::merges(const Cut& cut) const {
  const auto above = [&](double cost) { return cost * area_ > cut.cost; };
  return static_cast<std::int32_t>(std::find_if(tree_.cost.begin(), tree_.cost.end(), above) - tree_.cost.begin());
}

std::vector<std::int32_t> DetailTree::small_regions(const Surface& surface) const {
  const FaceGraph& graph = surface.graph();
  const auto more = std::max(0, patches_.count() - small_count(graph.size()));
  const std::vector<std::int32_t> cluster = cut_after(tree_, std::min(tree_.merges(), static_cast<std::size_t>(more)));
  std::vector<std::int32_t> by_face(static_cast<std::size_t>(graph.size()), kNone);
  for (std::int32_t i = 0; i < graph.size(); ++i)
    if (const std::int32_t patch = patches_.label[i]; patch != kNone)
      by_face[graph.mesh_face[i]] = small_.empty() ? cluster[patch] : small_[i];
  return by_face;
}

Regions DetailTree::regions(const Surface& surface, const Cut& cut, const Threads& threads, Job& job) const {
  const FaceGraph& graph = surface.graph();
  Regions result = patches_;
  std::vector<std::int32_t> component = component_;
  const auto become = [&](const std::vector<std::int32_t>& becomes, std::size_t count) {
    std::vector<std::int32_t> component_after(component.empty() ? 0 : count);
    for (std::size_t r = 0; r < component.size(); ++r) component_after[becomes[r]] = component[r];
    component = std::move(component_after);
    std::vector<std::uint8_t> of_several(count, 0), seen(count, 0);
    for (const std::int32_t r : becomes) of_several[r] |= std::exchange(seen[r], 1);
    relabel(result, becomes, count, threads);
    return of_several;
  };
  const std::int32_t count = this->count(cut);
  std::vector<std::int32_t> becomes = cut_after(tree_, static_cast<std::size_t>(merges(cut)));
  join_strays(touching_, patches_.sum, count, becomes);
  become(becomes, static_cast<std::size_t>(count));
  const BorderWeight border = border_weight_of(bend_);
  std::vector<std::int32_t> near = borders_;  // present and earlier borders
  std::vector<std::uint8_t> changed(result.sum.size(), 1);
  for (bool merges = true; merges;) {
    Relaxation<GraphLabels> relaxation(graph, {result.label.data()}, result.sum, border, threads);
    near = push_beside(graph, result.label, near, changed, relaxation);
    relaxation.run(kTreeSweeps, job);
    near.insert(near.end(), relaxation.pushed().begin(), relaxation.pushed().end());
    const MergeTree more =
        merge_all(clusters_of(graph, result, component, near, threads), {.cost = cut.cost / area_, .need = need_}, job);
    merges = more.merges() > 0;
    if (merges) changed = become(cut_after(more, more.merges()), result.sum.size() - more.merges());
  }
  return result;
}

void DetailTree::merge_again(const Surface& surface, const Cut& cut, Regions& regions, const Threads& threads,
                             Job& job) const {
  const FaceGraph& graph = surface.graph();
  std::vector<std::int32_t> all(static_cast<std::size_t>(graph.size())), component;
  std::iota(all.begin(), all.end(), 0);
  if (!component_.empty()) {
    component.resize(regions.sum.size());
    for (std::int32_t i = 0; i < graph.size(); ++i)
      if (regions.label[i] != kNone) component[regions.label[i]] = surface.component()[graph.mesh_face[i]];
  }
  const MergeTree more = merge_all(clusters_of(graph, regions, std::move(component), all, threads),
                                   {.cost = kFaded * cut.cost / area_, .need = need_}, job);
  if (more.merges() > 0) relabel(regions, cut_after(more, more.merges()), regions.sum.size() - more.merges(), threads);
}

}  // namespace isimp
