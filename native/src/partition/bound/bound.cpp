#include "bound/bound.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "borders/relax.h"
#include "bound/dissolve.h"
#include "bound/min_width_slab.h"
#include "hierarchy/dendrogram.h"

namespace isimp {
namespace {

using detail::Corners;

// tuned bound
constexpr std::int32_t kFacesABoundProxy = 96;  // gives patches of 6 faces
constexpr double kLeastLength = 0.5;            // share of a region's area: where normals cancel more there is no plane
constexpr int kBoundSweeps = 30;                // limit
constexpr double kFirstWidth = 0.4;  // share of the width that nodes of the hierarchy may take up: merging finds better
constexpr int kBoundRounds = 3;      // rounds of squeezing, merging, dissolving and relaxing

/// The nodes of a hierarchy with their faces in a row: the faces of a node are a stretch of it.
class Nodes {
 public:
  struct Node {
    std::int32_t begin = 0, end = 0;  ///< its faces, in `face`
    RegionSum sum;
  };

  Nodes(const FaceGraph& graph, const Hierarchy& h, Job& job) {
    job.poll();
    for (const auto& up : h.to_next) {
      std::vector<std::int32_t> first(h.level[children_.size() + 1].sum.size() + 1, 0), child(up.size());
      for (const std::int32_t u : up) ++first[u + 1];
      std::partial_sum(first.begin(), first.end(), first.begin());
      std::vector<std::int32_t> fill(first.begin(), first.end() - 1);
      for (std::size_t k = 0; k < up.size(); ++k) child[fill[up[k]]++] = static_cast<std::int32_t>(k);
      children_.push_back({std::move(first), std::move(child)});
    }
    std::vector<std::int32_t> order(h.level.back().sum.size()), below;
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t level = h.level.size() - 1; level > 0; --level) {
      below.clear();
      for (const std::int32_t u : order) {
        const std::span<const std::int32_t> children = this->children(level, u);
        below.insert(below.end(), children.begin(), children.end());
      }
      order.swap(below);
    }
    level_.resize(h.level.size());
    level_[0].resize(h.level[0].sum.size());
    faces_.reserve(h.patch_face.size());
    for (const std::int32_t p : order) {
      Node& patch = level_[0][p];
      patch.begin = static_cast<std::int32_t>(faces_.size());
      for (const std::int32_t face : h.faces_of(p)) {
        faces_.push_back(face);
        patch.sum.add(graph.faces[face]);
      }
      patch.end = static_cast<std::int32_t>(faces_.size());
    }
    for (std::size_t level = 1; level < level_.size(); ++level) join(level);
  }

  [[nodiscard]] const Node& at(std::size_t level, std::int32_t node) const { return level_[level][node]; }
  [[nodiscard]] std::span<const std::int32_t> faces(const Node& node) const {
    return std::span(faces_).subspan(node.begin, static_cast<std::size_t>(node.end - node.begin));
  }
  /// Children, on the level below, of a node of a level above the lowest.
  [[nodiscard]] std::span<const std::int32_t> children(std::size_t level, std::int32_t node) const {
    const Children& c = children_[level - 1];
    return std::span(c.child).subspan(c.first[node], static_cast<std::size_t>(c.first[node + 1] - c.first[node]));
  }

 private:
  struct Children {
    std::vector<std::int32_t> first, child;
  };

  void join(std::size_t level) {
    level_[level].resize(children_[level - 1].first.size() - 1);
    for (std::size_t u = 0; u < level_[level].size(); ++u) {
      const std::span<const std::int32_t> below = children(level, static_cast<std::int32_t>(u));
      Node& node = level_[level][u];
      node.begin = level_[level - 1][below.front()].begin;
      node.end = level_[level - 1][below.back()].end;
      for (const std::int32_t child : below) node.sum.add(level_[level - 1][child].sum);
    }
  }

  std::vector<Children> children_;  // [l] of level l + 1
  std::vector<std::vector<Node>> level_;
  std::vector<std::int32_t> faces_;
};

/// Cuts the hierarchy from above into nodes that fit.
class Cutting {
 public:
  Cutting(const Surface& surface, const Corners& corners, const Hierarchy& hierarchy, const Components& components,
          double width, Job& job)
      : graph_(surface.graph()),
        corners_(corners),
        h_(hierarchy),
        nodes_(graph_, hierarchy, job),
        components_(components),
        width_(width) {}

  BoundedRegions run(Job& job) {
    result_.regions.label.assign(graph_.faces.size(), kNone);
    const MergeGraph& top = h_.level.back();
    std::vector<std::int32_t> nodes(components_.all.size(), 0);
    for (std::int32_t u = 0; u < top.size(); ++u) ++nodes[top.component_of(u)];
    for (std::int32_t u = 0; u < top.size(); ++u) {
      const std::int32_t component = top.component_of(u);
      if (!components_.all[component].kept) continue;
      job.poll();
      // If there are fewer patches than the component needs, begin with its faces.
      if (nodes[component] < components_.all[component].need) {
        take_each(nodes_.faces(nodes_.at(h_.level.size() - 1, u)));
      } else {
        descend(h_.level.size() - 1, u, job);
      }
    }
    sum_regions(graph_, result_.regions, job);
    return std::move(result_);
  }

 private:
  void descend(std::size_t level, std::int32_t u, Job& job) {
    const Nodes::Node& node = nodes_.at(level, u);
    const std::span<const std::int32_t> faces = nodes_.faces(node);
    if (faces.size() > 0xffff) job.poll();
    if (take(faces, node.sum)) return;
    if (level == 0) {
      take_each(faces);
      return;
    }
    for (const std::int32_t child : nodes_.children(level, u)) descend(level - 1, child, job);
  }

  void take_each(std::span<const std::int32_t> faces) {
    for (const std::int32_t& face : faces) {
      RegionSum sum;
      sum.add(graph_.faces[face]);
      take({&face, 1}, sum);
    }
  }

  /// Makes a region of faces if they fit; a single face always fits.
  bool take(std::span<const std::int32_t> faces, const RegionSum& sum) {
    Slab slab{.normal = sum.normal()};
    if (faces.size() > 1 && sum.length() < kLeastLength * sum.weight / 2) return false;
    const std::size_t stride = faces.size() > 64 ? 32 : 1;  // a sample rules out most that do not fit
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
  const Corners& corners_;
  const Hierarchy& h_;
  Nodes nodes_;
  const Components& components_;
  double width_;
  BoundedRegions result_;
};

/// Merges neighbours where both together fit.
void merge_fitting(const Surface& surface, const Corners& corners, std::span<const std::int32_t> need, double width,
                   BoundedRegions& bounded, Job& job) {
  const FaceGraph& graph = surface.graph();
  ClusterGraph clusters = region_clusters(graph, bounded.regions, job);
  clusters.component = detail::components_of_regions(surface, bounded);
  std::vector<std::vector<std::int32_t>> points = corners.points_of(bounded, job);
  std::vector<std::int32_t> leaf(points.size());  // a leaf of each node
  std::iota(leaf.begin(), leaf.end(), 0);
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
    if (!detail::turn_to_fit(corners, points[u], points[v], width, joint, joint_core)) return false;
    core[u] = core[v] = {};
    core.push_back(std::move(joint_core));
    if (points[u].size() < points[v].size()) std::swap(u, v);
    std::vector<std::int32_t> all = std::move(points[u]), fewer = std::move(points[v]);
    all.insert(all.end(), fewer.begin(), fewer.end());
    points.push_back(std::move(all));
    leaf.push_back(leaf[u]);
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
  // The remaining nodes, in the order in which cut_after numbers them: by the first of their leaves.
  BoundedRegions result{.regions = std::move(bounded.regions), .slab = {}};
  result.slab.resize(static_cast<std::size_t>(tree.leaves) - tree.merges());
  result.regions.sum.assign(result.slab.size(), {});
  for (std::size_t node = 0; node < slab.size(); ++node) {
    if (above[node] != kNone) continue;
    result.slab[becomes[leaf[node]]] = slab[node];
    result.regions.sum[becomes[leaf[node]]] = sum[node];
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

/// Moves border faces as far as the bound allows. Afterwards slabs are as wide as possible.
void relax(const Surface& surface, const Corners& corners, double bound, BoundedRegions& bounded, Job& job) {
  Regions& regions = bounded.regions;
  for (Slab& slab : bounded.slab) {
    const double middle = slab.middle();
    slab.low = std::min(slab.low, middle - bound);
    slab.high = std::max(slab.high, middle + bound);
  }
  Relaxation<BoundedLabels> relaxation(surface.graph(), {{regions.label.data()}, &corners, &bounded.slab}, regions.sum,
                                       light_border_weight(regions.error()));
  for (std::int32_t i = 0; i < surface.graph().size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    relaxation.push_if_border(i);
  }
  relaxation.run(kBoundSweeps, job);
}

/// Makes the slabs as narrow as the regions' vertices allow; in the end across the mean normals where these fit.
void tighten(const Corners& corners, double width, bool is_end, BoundedRegions& bounded, Job& job) {
  const std::vector<std::vector<std::int32_t>> points = corners.points_of(bounded, job);
  for (std::size_t r = 0; r < points.size(); ++r) {
    if ((r & 0xff) == 0) job.poll();
    Slab mean{.normal = bounded.regions.sum[r].normal()}, stored{.normal = bounded.slab[r].normal};
    for (const std::int32_t v : points[r]) {
      mean.add(corners.vertex(v));
      stored.add(corners.vertex(v));
    }
    bounded.slab[r] = mean.width() <= (is_end ? width : stored.width()) ? mean : stored;
  }
}

}  // namespace

Hierarchy hierarchy_for_bound(const Surface& surface, Job& job, std::int32_t threads) {
  return build_hierarchy(surface, std::max(1, surface.face_count() / kFacesABoundProxy), job, {.threads = threads});
}

BoundedRegions bounded_regions(const Surface& surface, const Hierarchy& hierarchy, const Components& components,
                               double bound, Job& job) {
  const double width = 2 * bound;
  std::vector<std::int32_t> need;
  for (const Component& component : components.all) need.push_back(component.need);
  const Corners corners(surface, job);
  BoundedRegions bounded = Cutting(surface, corners, hierarchy, components, kFirstWidth * width, job).run(job);
  job.report(0.2);
  for (int round = 0; round < kBoundRounds; ++round) {
    BoundedRegions fewer = bounded;
    if (round > 0) {
      detail::squeeze(surface, corners, need, width, fewer, job);
      tighten(corners, width, false, fewer, job);
    }
    merge_fitting(surface, corners, need, width, fewer, job);
    detail::dissolve(surface, corners, need, width, fewer, job);
    if (round > 0 && fewer.regions.count() == bounded.regions.count()) break;
    relax(surface, corners, bound, fewer, job);
    tighten(corners, width, false, fewer, job);
    bounded = std::move(fewer);
    job.report(0.2 + 0.8 * (round + 1) / kBoundRounds);
  }
  tighten(corners, width, true, bounded, job);
  return bounded;
}

}  // namespace isimp
