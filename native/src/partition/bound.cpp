#include "isimp/partition/bound.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "dissolve.h"
#include "isimp/partition/merge_tree.h"
#include "isimp/partition/relax.h"
#include "narrow.h"

namespace isimp {
namespace {

using detail::Corners;

constexpr std::int32_t kFacesAProxy = 96;  // so that patches are of 8 faces
constexpr double kLeastLength = 0.5;       // of a region's area: where normals cancel more there is no plane
constexpr int kSweeps = 30;
constexpr double kFirstWidth = 0.3;  // share of the width that nodes of the hierarchy may take up: merging finds better
constexpr int kRounds = 3;           // of merging, dissolving and relaxing

/// Cuts the hierarchy from above into nodes that fit.
class Cutting {
 public:
  Cutting(const Surface& surface, const Hierarchy& hierarchy, const Parts& parts, double width)
      : graph_(surface.graph()), corners_(surface), h_(hierarchy), parts_(parts), width_(width) {
    for (const auto& up : h_.to_next) {
      std::vector<std::int32_t> first(h_.level[children_.size() + 1].sum.size() + 1, 0), child(up.size());
      for (const std::int32_t u : up) ++first[u + 1];
      std::partial_sum(first.begin(), first.end(), first.begin());
      std::vector<std::int32_t> fill(first.begin(), first.end() - 1);
      for (std::size_t k = 0; k < up.size(); ++k) child[fill[up[k]]++] = static_cast<std::int32_t>(k);
      children_.push_back({std::move(first), std::move(child)});
    }
  }

  BoundedRegions run(Job& job) {
    result_.regions.label.assign(graph_.faces.size(), kNone);
    const MergeGraph& top = h_.level.back();
    std::vector<std::int32_t> nodes(parts_.parts.size(), 0);
    for (std::int32_t u = 0; u < top.size(); ++u) ++nodes[top.part_of(u)];
    for (std::int32_t u = 0; u < top.size(); ++u) {
      const std::int32_t part = top.part_of(u);
      if (!parts_.parts[part].kept) continue;
      job.poll();
      // Where there are fewer patches than the component needs, its faces are what is left to begin with.
      if (nodes[part] < parts_.parts[part].need) {
        for (const std::int32_t face : faces_under(h_.level.size() - 1, u)) take({face});
      } else {
        descend(h_.level.size() - 1, u, job);
      }
    }
    sum_regions(graph_, result_.regions, job);
    return std::move(result_);
  }

 private:
  struct Children {
    std::vector<std::int32_t> first, child;
  };

  void descend(std::size_t level, std::int32_t node, Job& job) {
    const std::vector<std::int32_t> faces = faces_under(level, node);
    if (faces.size() > 0xffff) job.poll();
    if (take(faces)) return;
    if (level == 0) {
      for (const std::int32_t face : faces) take({face});
      return;
    }
    const Children& below = children_[level - 1];
    for (std::int32_t k = below.first[node]; k < below.first[node + 1]; ++k) descend(level - 1, below.child[k], job);
  }

  [[nodiscard]] std::vector<std::int32_t> faces_under(std::size_t level, std::int32_t node) const {
    std::vector<std::int32_t> nodes{node}, below;
    for (; level > 0; --level) {
      const Children& c = children_[level - 1];
      below.clear();
      for (const std::int32_t u : nodes)
        below.insert(below.end(), c.child.begin() + c.first[u], c.child.begin() + c.first[u + 1]);
      nodes.swap(below);
    }
    std::vector<std::int32_t> faces;
    for (const std::int32_t p : nodes)
      faces.insert(faces.end(), h_.patch_face.begin() + h_.patch_first[p],
                   h_.patch_face.begin() + h_.patch_first[p + 1]);
    return faces;
  }

  /// Makes a region of faces if they fit; a single face always does.
  bool take(const std::vector<std::int32_t>& faces) {
    RegionSum sum;
    for (const std::int32_t face : faces) sum.add(graph_.faces[face]);
    Slab slab{.normal = sum.normal()};
    if (faces.size() > 1 && sum.length() < kLeastLength * sum.weight / 2) return false;
    const std::size_t stride = faces.size() > 64 ? 32 : 1;  // a look here and there tells most that do not fit
    for (std::size_t begin = 0; begin < stride; ++begin)
      for (std::size_t k = begin; k < faces.size(); k += stride) {
        corners_.add_to(slab, faces[k]);
        if (slab.width() > width_ && faces.size() > 1) return false;
      }
    for (const std::int32_t face : faces) result_.regions.label[face] = static_cast<std::int32_t>(result_.slab.size());
    result_.slab.push_back(slab);
    result_.regions.sum.emplace_back();
    return true;
  }

  const FaceGraph& graph_;
  Corners corners_;
  const Hierarchy& h_;
  const Parts& parts_;
  double width_;
  std::vector<Children> children_;
  BoundedRegions result_;
};

/// Merges neighbours where both together fit.
void merge_fitting(const Surface& surface, std::span<const std::int32_t> need, double width, BoundedRegions& bounded,
                   Job& job) {
  const FaceGraph& graph = surface.graph();
  const Corners corners(surface);
  ClusterGraph clusters = region_clusters(graph, bounded.regions, job);
  clusters.part = detail::parts_of_regions(surface, bounded);
  std::vector<std::vector<std::int32_t>> faces = detail::faces_of(bounded);
  std::vector<RegionSum> sum = bounded.regions.sum;
  std::vector<Slab> slab = bounded.slab;
  std::vector<detail::Core> core(slab.size());
  const auto accept = [&](std::int32_t u, std::int32_t v) {
    job.poll();
    const RegionSum &a = sum[u], &b = sum[v];
    if (a.x * b.x + a.y * b.y + a.z * b.z < detail::kLeastCosine * a.length() * b.length()) return false;
    RegionSum both = a;
    both.add(b);
    if (both.length() < kLeastLength * both.weight / 2) return false;
    Slab joint{.normal = both.normal()};
    detail::Core joint_core = core[u];
    joint_core.insert(joint_core.end(), core[v].begin(), core[v].end());
    if (!detail::turn_to_fit(corners, faces[u], faces[v], width, joint, joint_core)) return false;
    core[u] = core[v] = {};
    core.push_back(std::move(joint_core));
    if (faces[u].size() < faces[v].size()) std::swap(u, v);
    std::vector<std::int32_t> all = std::move(faces[u]);
    all.insert(all.end(), faces[v].begin(), faces[v].end());
    faces[v].clear();
    faces.push_back(std::move(all));
    sum.push_back(both);
    slab.push_back(joint);
    return true;
  };
  const MergeTree tree = merge_all(clusters, {.need = need, .accept = accept}, job);
  job.poll();
  const std::vector<std::int32_t> becomes = cut_after(tree, tree.merges());
  std::vector<std::int32_t> above(slab.size(), kNone);
  for (std::size_t k = 0; k < tree.merges(); ++k)
    for (const std::int32_t node : tree.merged[k]) above[node] = 1;
  // The nodes that stand, in the order in which cut_after numbers them: by the first of their leaves.
  BoundedRegions result{.regions = std::move(bounded.regions), .slab = {}};
  result.slab.resize(static_cast<std::size_t>(tree.leaves) - tree.merges());
  result.regions.sum.assign(result.slab.size(), {});
  for (std::size_t node = 0; node < slab.size(); ++node) {
    if (above[node] != kNone) continue;
    const std::int32_t leaf = result.regions.label[faces[node].front()];
    result.slab[becomes[leaf]] = slab[node];
    result.regions.sum[becomes[leaf]] = sum[node];
  }
  for (std::int32_t& label : result.regions.label)
    if (label != kNone) label = becomes[label];
  bounded = std::move(result);
}

/// Labels that a face may take only where it stays between the region's planes.
struct BoundedLabels : GraphLabels {
  const Corners* corners;
  const std::vector<Slab>* slab;
  [[nodiscard]] bool allows(std::int32_t face, std::int32_t region) const {
    const Slab& s = (*slab)[region];
    return corners->width_with(s, face) <= s.width();
  }
};

/// Moves border faces as far as the bound lets them. Afterwards slabs are as wide as they may be.
void relax(const Surface& surface, double bound, BoundedRegions& bounded, Job& job) {
  const Corners corners(surface);
  Regions& regions = bounded.regions;
  for (Slab& slab : bounded.slab) {
    const double middle = slab.middle();
    slab.low = std::min(slab.low, middle - bound);
    slab.high = std::max(slab.high, middle + bound);
  }
  Relaxation<BoundedLabels> relaxation(surface.graph(), {{regions.label.data()}, &corners, &bounded.slab}, regions.sum,
                                       border_weight(regions.error()));
  for (std::int32_t i = 0; i < surface.graph().size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    relaxation.push_if_border(i);
  }
  relaxation.run(kSweeps, job);
}

/// Makes the slabs as narrow as the regions' vertices let them be; in the end across the mean normals where these fit.
void tighten(const Surface& surface, double width, bool is_end, BoundedRegions& bounded, Job& job) {
  const Corners corners(surface);
  const std::vector<std::int32_t>& label = bounded.regions.label;
  std::vector<Slab> mean(bounded.slab.size()), stored(bounded.slab.size());
  for (std::size_t r = 0; r < mean.size(); ++r) {
    mean[r].normal = bounded.regions.sum[r].normal();
    stored[r].normal = bounded.slab[r].normal;
  }
  for (std::int32_t i = 0; i < surface.graph().size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    if (label[i] == kNone) continue;
    corners.add_to(mean[label[i]], i);
    corners.add_to(stored[label[i]], i);
  }
  for (std::size_t r = 0; r < mean.size(); ++r)
    bounded.slab[r] = mean[r].width() <= (is_end ? width : stored[r].width()) ? mean[r] : stored[r];
}

}  // namespace

Hierarchy hierarchy_for_bound(const Surface& surface, Job& job, std::int32_t threads) {
  return build_hierarchy(surface, std::max(1, surface.face_count() / kFacesAProxy), job, threads);
}

BoundedRegions bounded_regions(const Surface& surface, const Hierarchy& hierarchy, const Parts& parts, double bound,
                               Job& job) {
  const double width = 2 * bound;
  std::vector<std::int32_t> need;
  for (const Part& part : parts.parts) need.push_back(part.need);
  BoundedRegions bounded = Cutting(surface, hierarchy, parts, kFirstWidth * width).run(job);
  job.report(0.2);
  for (int round = 0; round < kRounds; ++round) {
    const std::int32_t before = bounded.regions.count();
    merge_fitting(surface, need, width, bounded, job);
    detail::dissolve(surface, need, width, bounded, job);
    if (round > 0 && bounded.regions.count() == before) break;
    relax(surface, bound, bounded, job);
    tighten(surface, width, false, bounded, job);
    job.report(0.2 + 0.8 * (round + 1) / kRounds);
  }
  tighten(surface, width, true, bounded, job);
  return bounded;
}

}  // namespace isimp
