#include "isimp/partition/detail_tree.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "isimp/partition/noise.h"
#include "isimp/partition/normal_filter.h"
#include "isimp/partition/relax.h"

namespace isimp {
namespace {

constexpr int kFilterPasses = 8;
constexpr int kRounds = 5;              // of relaxing and merging
constexpr int kSweeps = 30;             // of relaxation
constexpr double kBorder = 0.018;       // what an edge between regions weighs, in mean face areas
constexpr double kNoisyBorder = 0.115;  // what is added to it where normals are all noise
constexpr double kRounding = 1e-9;      // of the area: costs below this are none
constexpr std::size_t kMostCosts = 20000;

std::vector<std::int32_t> parts_of_faces(const Surface& surface) {
  std::vector<std::int32_t> part;
  const FaceGraph& graph = surface.graph();
  if (surface.component_count() == 1) return part;
  part.resize(static_cast<std::size_t>(graph.size()));
  for (std::int32_t i = 0; i < graph.size(); ++i) part[i] = surface.component()[graph.mesh_face[i]];
  return part;
}

/// Gives each face the region that its present one has become.
void relabel(Regions& regions, const std::vector<std::int32_t>& becomes, std::size_t count, const FaceGraph& graph,
             const Threads& threads, Job& job) {
  for (std::int32_t& label : regions.label)
    if (label != kNone) label = becomes[label];
  regions.sum.assign(count, {});
  sum_regions(graph, regions, job, threads);
}

}  // namespace

double finest_for(double detail) {
  double finest = kFinestDetail;
  while (finest > detail) finest /= 2;
  return finest;
}

DetailTree::DetailTree(const Surface& surface, const DetailSettings& settings, Job& job)
    : settings_(settings),
      area_(surface.graph().area),
      size_(surface_size(surface.mesh())),
      noise_(settings.noise ? *settings.noise : estimate_noise(surface.mesh(), job)),
      bend_(median_bend(surface.graph())),
      parts_(find_parts(surface, 1, settings.leave_out, job)) {
  for (const Part& part : parts_.parts) need_.push_back(part.need);
  {
    Job::Part stage(job, "merging", 0.0, 0.9);
    make_patches(surface, job);
  }
  Job::Part stage(job, "merging", 0.9, 1.0);
  ClusterGraph clusters = region_clusters(surface.graph(), patches_, job);
  clusters.part = part_;
  tree_ = merge_all(clusters, {.need = need_}, job);
  falling_ = tree_.cost;
  std::sort(falling_.begin(), falling_.end(), std::greater<>());
  falling_.resize(std::min(falling_.size(), kMostCosts));
  for (double& cost : falling_) cost *= area_;
}

void DetailTree::make_patches(const Surface& surface, Job& job) {
  const FaceGraph& graph = surface.graph();
  const std::vector<std::int32_t> part = parts_of_faces(surface);
  {
    ClusterGraph faces = face_clusters(graph, filtered_faces(graph, kFilterPasses, filter_range(bend_), job));
    faces.part = part;
    const double limit = merge_limit(settings_.finest * size_, noise_, kLeastNoise);
    const MergeTree fine = merge_all(faces, {limit / area_, need_}, job);
    patches_.label = cut_after(fine, fine.merges());
    patches_.sum.resize(static_cast<std::size_t>(fine.leaves) - fine.merges());
  }
  // Components that are left out have no patches.
  std::vector<std::int32_t> number(patches_.sum.size(), kNone);
  std::int32_t kept = 0;
  for (std::int32_t i = 0; i < graph.size(); ++i) {
    std::int32_t& label = patches_.label[i];
    const std::int32_t of = part.empty() ? 0 : part[i];
    if (number[label] == kNone && parts_.parts[of].kept) {
      number[label] = kept++;
      if (!part.empty()) part_.push_back(of);
    }
    label = number[label];
  }
  patches_.label.push_back(kNone);
  patches_.sum.assign(static_cast<std::size_t>(kept), {});
  sum_regions(graph, patches_, job);
}

Cut DetailTree::choose(double tolerance, bool snap) const {
  const auto left = static_cast<std::int32_t>(patches_.sum.size() - tree_.merges());
  return choose_cut(falling_, left, kRounding * area_, tolerance, noise_, snap);
}

std::int32_t DetailTree::merges(const Cut& cut) const {
  const auto above = [&](double cost) { return cost * area_ > cut.cost; };
  return static_cast<std::int32_t>(std::find_if(tree_.cost.begin(), tree_.cost.end(), above) - tree_.cost.begin());
}

Regions DetailTree::regions(const Surface& surface, const Cut& cut, const Threads& threads, Job& job) const {
  const FaceGraph& graph = surface.graph();
  Regions result = patches_;
  const auto made = static_cast<std::size_t>(merges(cut));
  relabel(result, cut_after(tree_, made), patches_.sum.size() - made, graph, threads, job);
  const double border = kBorder + kNoisyBorder * std::min(1.0, bend_ * bend_);
  for (int round = 0; round < kRounds; ++round) {
    Relaxation<GraphLabels> relaxation(graph, {result.label.data()}, result.sum, border);
    for (std::int32_t i = 0; i < graph.size(); ++i) relaxation.push_if_border(i);
    relaxation.run(kSweeps, job);
    ClusterGraph clusters = region_clusters(graph, result, job);
    if (!part_.empty()) {
      clusters.part.resize(result.sum.size());
      for (std::int32_t i = 0; i < graph.size(); ++i)
        if (result.label[i] != kNone) clusters.part[result.label[i]] = part_[patches_.label[i]];
    }
    const MergeTree more = merge_all(clusters, {cut.cost / area_, need_}, job);
    if (more.merges() == 0) break;
    relabel(result, cut_after(more, more.merges()), result.sum.size() - more.merges(), graph, threads, job);
  }
  return result;
}

}  // namespace isimp
