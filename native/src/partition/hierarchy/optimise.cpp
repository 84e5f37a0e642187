#include "hierarchy/optimise.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

#include "borders/relax.h"
#include "hierarchy/greedy.h"
#include "hierarchy/patch_relax.h"
#include "hierarchy/region_graph.h"
#include "hierarchy/teleport.h"

namespace isimp {
namespace {

// tuned unrecorded
constexpr double kSurplus = 1.5;        // regions before the last merging, as a multiple of the wanted number
constexpr double kSmoothSurplus = 2.2;  // such a multiple if borders count too
constexpr int kTries = 4;               // limit: teleports without gain
// tuned nodes
constexpr std::int64_t kNodesOfRegion = 30;  // nodes for each region of a level that is relaxed before the patches are
// tuned unrecorded
constexpr std::int32_t kManyRegions = 200;  // least number of regions for it
constexpr int kPatchSweeps = 2;             // sweeps of a level of patches
constexpr int kFirstSweeps = 6;             // sweeps of faces before teleports
constexpr int kLastSweeps = 60;             // sweeps of faces at the end

/// The factor by which a region must exceed the usual before teleports are tried. On a scan of many regions they gain
/// little and cost much; a shape of a few sides must come out right, and there any wrong side exceeds the usual by far.
double least_ratio(std::int32_t regions) { return std::clamp(3.0 * regions, 10.0, 300.0); }

std::vector<std::int32_t> needs(const Components& components) {
  std::vector<std::int32_t> need;
  for (const Component& component : components.all) need.push_back(component.need);
  return need;
}

/// The sums of nodes in the form for greedy merging; empty where a component is left out.
std::vector<RegionSum> sums_of(const MergeGraph& graph, const Components& components) {
  std::vector<RegionSum> sums(static_cast<std::size_t>(graph.size()));
  for (std::int32_t u = 0; u < graph.size(); ++u) {
    if (!components.all[graph.component_of(u)].kept) continue;
    const NodeSum& s = graph.sum[u];
    sums[u].x = s.x;
    sums[u].y = s.y;
    sums[u].z = s.z;
    sums[u].faces = 1;
  }
  return sums;
}

/// Nodes in components that get regions.
std::int64_t nodes_kept(const MergeGraph& graph, const Components& components) {
  if (graph.component.empty()) return graph.size();
  return std::count_if(graph.component.begin(), graph.component.end(),
                       [&](std::int32_t c) { return components.all[c].kept; });
}

/// Labels of the patches, from greedy merging of the coarsest level that has enough nodes.
/// \param relax  is given each level between the two, and the labels of its nodes
template <class Relax>
std::vector<std::int32_t> cut(const Hierarchy& h, const Components& components, std::int32_t regions,
                              std::int32_t target, Relax relax, Job& job) {
  std::size_t level = h.level.size() - 1;
  while (level > 0 && nodes_kept(h.level[level], components) < nodes_for(regions)) --level;
  const MergeGraph& coarse = h.level[level];
  std::vector<std::int32_t> label = merge_greedily(coarse, sums_of(coarse, components), needs(components), target, job);
  while (level-- > 0) {
    std::vector<std::int32_t> finer(h.to_next[level].size());
    for (std::size_t u = 0; u < finer.size(); ++u) finer[u] = label[h.to_next[level][u]];
    label = std::move(finer);
    if (level > 0) relax(h.level[level], label);
  }
  return label;
}

/// The faces of a list that lie on borders, found by one thread.
std::vector<std::int32_t> find_borders(const Relaxation<GraphLabels>& relaxation, std::span<const std::int32_t> faces,
                                       Job& job) {
  constexpr std::size_t kAhead = 16;  // work: faces to prefetch ahead
  // One spare, written to before it is known to be wanted.
  const auto found = std::make_unique_for_overwrite<std::int32_t[]>(faces.size() + 1);
  std::size_t out = 0;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if ((k & 0x3fff) == 0x3fff) job.poll();
    if (k + kAhead < faces.size()) relaxation.fetch(faces[k + kAhead]);
    found[out] = faces[k];
    out += relaxation.on_border(faces[k]) ? 1 : 0;
  }
  return {found.get(), found.get() + out};
}

/// The steps from a hierarchy to regions, and their shared data.
class Optimiser {
 public:
  Optimiser(const Surface& surface, const Hierarchy& hierarchy, const Components& components, double smooth,
            const Threads& threads)
      : surface_(surface),
        graph_(surface.graph()),
        h_(hierarchy),
        components_(components),
        smooth_(smooth),
        threads_(threads) {}

  Regions run(Finish finish, Metric metric, Job& job) {
    const std::int32_t wanted = components_.regions();
    {
      Job::Stage stage(job, "merging", 0.0, 0.4);
      const double times = smooth_ > 0 ? kSmoothSurplus : kSurplus;
      const auto surplus = static_cast<std::int32_t>(std::min<double>(times * wanted, h_.patches()));
      // On the way down too: faces alone can't straighten a border whose zigzags are many faces wide. Few regions are
      // far from planar, and straight borders would cost them distance.
      const auto relax = [&](const MergeGraph& nodes, std::vector<std::int32_t>& label) {
        if (!(smooth_ > 0) || wanted < kManyRegions ||
            nodes.size() < kNodesOfRegion * static_cast<std::int64_t>(wanted))
          return;
        const std::int32_t count = 1 + *std::max_element(label.begin(), label.end());
        relax_patches(nodes, label, count, smooth_, kPatchSweeps, threads_, job);
      };
      patch_label_ = cut(h_, components_, wanted, std::max(surplus, wanted), relax, job);
      const std::int32_t regions = 1 + *std::max_element(patch_label_.begin(), patch_label_.end());
      relax_patches(h_.level.front(), patch_label_, regions, smooth_, kPatchSweeps, threads_, job);
      project(regions, job);
    }
    Job::Stage stage(job, "relaxing", 0.4, 1.0);
    Relaxation<GraphLabels> relaxation(graph_, {regions_.label.data()}, regions_.sum,
                                       border_weight(regions_.error(), smooth_, graph_.size(), wanted), threads_,
                                       surface_.relative_weight());
    for (const std::int32_t i : borders_among(relaxation, h_.patch_face, job)) relaxation.push(i);
    relaxation.run(kFirstSweeps, job);
    job.report(0.4);
    const MergeGraph pairs = merge_to(wanted - lacking(), relaxation, job);
    job.report(0.5);
    relaxation.run(kLastSweeps, job);
    job.report(0.9);
    const Job::Stage last(job, "relaxing", 0.9, 1.0);
    Teleport teleport(graph_, components_, regions_, std::move(component_), relaxation);
    const bool filled = teleport.fill_up(job);
    const double ratio = least_ratio(wanted);
    if (finish == Finish::teleports && (filled || teleport.worth_trying(pairs, ratio)))
      teleport.run(kTries, ratio, job);
    regions_.off_planes =
        relax_by(metric, surface_, GraphLabels{regions_.label.data()}, regions_.sum, relaxation, smooth_, wanted, job);
    return std::move(regions_);
  }

 private:
  /// Converts labels of patches to labels of faces.
  void project(std::int32_t regions, Job& job) {
    if (components_.all.size() > 1) {
      component_.resize(static_cast<std::size_t>(regions));
      for (std::int32_t p = 0; p < h_.patches(); ++p)
        if (patch_label_[p] != kNone) component_[patch_label_[p]] = h_.level.front().component[p];
    }
    regions_.label.resize(graph_.faces.size());
    threads_.run(graph_.size(), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      for (std::int32_t i = begin; i < end; ++i) {
        if ((i & 0xffff) == 0) job.poll();
        regions_.label[i] = patch_label_[h_.patch[i]];
      }
    });
    regions_.label[graph_.size()] = kNone;
    regions_.sum.resize(static_cast<std::size_t>(regions));
    for (std::int32_t p = 0; p < h_.patches(); ++p) {
      if ((p & 0xffff) == 0) job.poll();
      if (patch_label_[p] != kNone) regions_.sum[patch_label_[p]].add(h_.patch_sum[p]);
    }
  }

  /// The faces of a list that lie on borders, in the same order.
  [[nodiscard]] std::vector<std::int32_t> borders_among(const Relaxation<GraphLabels>& relaxation,
                                                        std::span<const std::int32_t> faces, Job& job) const {
    const auto count = static_cast<std::int32_t>(faces.size());
    const std::int32_t pieces = threads_.pieces(count);
    std::vector<std::vector<std::int32_t>> found(static_cast<std::size_t>(pieces));
    threads_.run(count, pieces, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
      found[piece] = find_borders(relaxation, faces.subspan(begin, static_cast<std::size_t>(end - begin)), job);
    });
    for (std::int32_t k = 1; k < pieces; ++k) found[0].insert(found[0].end(), found[k].begin(), found[k].end());
    return std::move(found[0]);
  }

  /// Regions that components lack because they have too few patches; splitting adds them.
  [[nodiscard]] std::int32_t lacking() const {
    std::vector<std::int32_t> count(components_.all.size(), 0);
    for (std::int32_t r = 0; r < regions_.count(); ++r) ++count[component_.empty() ? 0 : component_[r]];
    std::int32_t sum = 0;
    for (std::size_t c = 0; c < count.size(); ++c) sum += std::max(0, components_.all[c].need - count[c]);
    return sum;
  }

  /// Merges regions to the given number.
  /// \return the graph of the remaining regions
  MergeGraph merge_to(std::int32_t target, Relaxation<GraphLabels>& relaxation, Job& job) {
    const std::vector<std::int32_t>& looked_at = relaxation.pushed();  // all border faces are among them
    MergeGraph touching =
        graph_of_regions(graph_, regions_.label, regions_.sum.size(), component_, looked_at, threads_);
    if (smooth_ > 0) {
      // Prices are half of the error that merging adds.
      const double price = border_price(regions_.error(), smooth_) / (2 * std::sqrt(std::max(1, target)));
      touching.border = border_lengths(surface_, regions_.label, looked_at, touching, threads_);
      for (double& border : touching.border) border *= price;
    }
    const std::vector<std::int32_t> merged = merge_greedily(touching, regions_.sum, needs(components_), target, job);
    threads_.run(graph_.size(), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      for (std::int32_t i = begin; i < end; ++i) {
        if ((i & 0xffff) == 0) job.poll();
        if (std::int32_t& r = regions_.label[i]; r != kNone) r = merged[r];
      }
    });
    std::vector<RegionSum> sums(static_cast<std::size_t>(1 + *std::max_element(merged.begin(), merged.end())));
    for (std::size_t r = 0; r < merged.size(); ++r) sums[merged[r]].add(regions_.sum[r]);
    regions_.sum = std::move(sums);
    if (!component_.empty()) {
      for (std::size_t r = 0; r < component_.size(); ++r)
        component_[merged[r]] = component_[r];  // merged[r] is never above r
      component_.resize(regions_.sum.size());
    }
    relaxation.refit();
    for (const std::int32_t i : borders_among(relaxation, looked_at, job)) relaxation.push(i);
    return contract(touching, merged, regions_.count(), threads_, job);
  }

  const Surface& surface_;
  const FaceGraph& graph_;
  const Hierarchy& h_;
  const Components& components_;
  const double smooth_;
  const Threads& threads_;
  std::vector<std::int32_t> patch_label_;
  Regions regions_;
  std::vector<std::int32_t> component_;  // component of each region; empty if there is one
};

}  // namespace

Regions optimise(const Surface& surface, const Hierarchy& hierarchy, const Components& components, double smooth,
                 const Threads& threads, Job& job, Finish finish, Metric metric) {
  return Optimiser(surface, hierarchy, components, smooth, threads).run(finish, metric, job);
}

}  // namespace isimp
