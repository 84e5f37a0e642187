#include "hierarchy/hierarchy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>

namespace isimp {
namespace {

constexpr std::int32_t kBundle = 64;  // work: faces: one bit each
// tuned borders
constexpr std::int32_t kLargestPatch = 24;    // faces
constexpr std::int32_t kPatchesARegion = 10;  // for the largest size
// tuned unrecorded
constexpr float kCrease = 0.95F;               // cosine: neighbours that differ by more are never in one patch
constexpr std::int32_t kCoarsest = 64;         // nodes, where the rounds end
constexpr std::int32_t kLeastOfComponent = 8;  // nodes of a component, below which rounds leave it alone

// limit: rounds end where one merges at most this share of the nodes. A region that borders most others, such as the
// ground of a city, merges with one of them in each round, and each level has a graph.
constexpr double kFewMerges = 0.01;
constexpr std::int32_t kManyNodes = 1024;  // limit: fewer nodes are merged to the end

std::int32_t patch_size_for(std::int32_t faces, std::int32_t proxies) {
  const std::int64_t room = faces / (static_cast<std::int64_t>(kPatchesARegion) * proxies);
  std::int32_t size = kLargestPatch;
  while (size > 1 && size > room) size /= 2;
  return size;
}

/// Patches within one bundle, by sets of faces as bits of a word.
class Bundle {
 public:
  void read(const FaceGraph& graph, std::span<const FaceRecord> faces, std::int32_t begin, std::int32_t count) {
    for (std::int32_t i = 0; i < count; ++i) {
      const FaceRecord& f = faces[begin + i];
      std::uint64_t joined = 0;
      for (const std::int32_t j : graph.neighbours[begin + i]) {
        // By masks, as no processor predicts well which neighbours lie in the bundle; the face itself replaces the
        // others.
        const auto at = static_cast<std::uint32_t>(j - begin), own = static_cast<std::uint32_t>(i);
        const std::uint32_t outside = 0U - static_cast<std::uint32_t>(at >= static_cast<std::uint32_t>(count));
        const std::uint32_t inside = at ^ ((at ^ own) & outside);
        const FaceRecord& g = faces[begin + static_cast<std::int32_t>(inside)];
        joined |= static_cast<std::uint64_t>(f.nx * g.nx + f.ny * g.ny + f.nz * g.nz >= kCrease) << inside;
      }
      joined_[i] = joined;
    }
    left_ = ~std::uint64_t{0} >> (kBundle - count);
  }
  [[nodiscard]] bool empty() const { return left_ == 0; }
  /// The next patch, of no more faces than `most`: calls `visit` with the place of each of them in the bundle.
  template <class Visit>
  void take(std::int32_t most, Visit visit) {
    std::uint64_t border = left_ & (~left_ + 1);
    left_ &= ~border;
    for (; border != 0 && most > 0; --most) {
      const int i = std::countr_zero(border);
      border &= border - 1;
      const std::uint64_t fresh = joined_[i] & left_;
      left_ &= ~fresh;
      border |= fresh;
      visit(i);
    }
    left_ |= border;
  }

 private:
  std::uint64_t joined_[kBundle];
  std::uint64_t left_ = 0;
};

/// The patches found by one thread; concatenated over all threads they are the whole.
struct Patches {
  std::vector<NodeSum> node;
  std::vector<RegionSum> sum;
  std::vector<std::int32_t> first;
  std::vector<std::uint8_t> open;  // whether a face of the patch is on a border
};

/// The patches of the bundles from `begin` to `end`, numbered from 0.
Patches patches_between(const FaceGraph& graph, std::span<const FaceRecord> faces, Hierarchy& h, std::int32_t begin,
                        std::int32_t end, Job& job) {
  const std::int32_t n = graph.size();
  Patches patches;
  Bundle bundle;
  std::int32_t out = begin * kBundle;
  for (std::int32_t t = begin; t < end; ++t) {
    if ((t & 0xff) == 0) job.poll();
    const std::int32_t base = t * kBundle;
    bundle.read(graph, faces, base, std::min(kBundle, n - base));
    while (!bundle.empty()) {
      const auto id = static_cast<std::int32_t>(patches.first.size());
      patches.first.push_back(out);
      NodeSum s;
      RegionSum sum;
      bool open = false;
      bundle.take(h.patch_size, [&](int i) {
        const FaceRecord& f = faces[base + i];
        const auto& around = graph.neighbours[base + i];
        s.x += f.area * f.nx;
        s.y += f.area * f.ny;
        s.z += f.area * f.nz;
        sum.add(f);
        open |= around[0] == n || around[1] == n || around[2] == n;
        h.patch_face[out++] = base + i;
        h.patch[base + i] = id;
      });
      s.length = std::sqrt(s.x * s.x + s.y * s.y + s.z * s.z);
      patches.node.push_back(s);
      patches.sum.push_back(sum);
      patches.open.push_back(open ? 1 : 0);
    }
  }
  return patches;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

Patches make_patches(const FaceGraph& graph, std::span<const FaceRecord> faces, Hierarchy& h, const Threads& threads,
                     Job& job) {
  const std::int32_t n = graph.size(), bundles = (n + kBundle - 1) / kBundle;
  h.patch.resize(static_cast<std::size_t>(n));
  h.patch_face.resize(static_cast<std::size_t>(n));
  const std::int32_t pieces = threads.pieces(n);
  std::vector<Patches> found(static_cast<std::size_t>(pieces));
  threads.run(bundles, pieces, [&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    found[k] = patches_between(graph, faces, h, begin, end, job);
  });
  Patches all = std::move(found[0]);
  for (std::int32_t k = 1; k < pieces; ++k) {
    const auto base = static_cast<std::int32_t>(all.node.size());
    append(all.node, found[k].node);
    append(all.sum, found[k].sum);
    append(all.first, found[k].first);
    append(all.open, found[k].open);
    const std::int32_t begin = found[k].first.front(), end = k + 1 < pieces ? found[k + 1].first.front() : n;
    for (std::int32_t i = begin; i < end; ++i) h.patch[i] += base;
  }
  h.patch_first = std::move(all.first);
  h.patch_first.push_back(n);
  h.patch_sum = std::move(all.sum);
  return all;
}

/// The neighbours of the patches from `begin` to `end`, row after row; `lengths` receives the length of each row.
std::vector<std::int32_t> rows_between(const FaceGraph& faces, const Hierarchy& h, std::int32_t begin, std::int32_t end,
                                       std::int32_t* lengths, Job& job) {
  const std::int32_t n = faces.size();
  const auto patches = static_cast<std::int32_t>(h.patch_first.size()) - 1;
  // Room for the worst case, which is not touched unless needed; one more is written before its use is known.
  const auto room = 3 * static_cast<std::size_t>(h.patch_first[end] - h.patch_first[begin]) + 1;
  const auto rows = std::make_unique_for_overwrite<std::int32_t[]>(room);
  std::vector<std::int32_t> seen(static_cast<std::size_t>(patches) + 1, -1);
  std::size_t out = 0;
  for (std::int32_t p = begin; p < end; ++p) {
    if ((p & 0x3ff) == 0) job.poll();
    const std::size_t start = out;
    seen[p] = p;
    seen[patches] = p;  // the outside
    for (std::int32_t k = h.patch_first[p]; k < h.patch_first[p + 1]; ++k)
      for (const std::int32_t j : faces.neighbours[h.patch_face[k]]) {
        const std::int32_t other = j == n ? patches : h.patch[j];
        rows[out] = other;
        out += seen[other] != p ? 1 : 0;
        seen[other] = p;
      }
    lengths[p] = static_cast<std::int32_t>(out - start);
  }
  return {rows.get(), rows.get() + out};
}

MergeGraph graph_of_patches(const Surface& surface, const Hierarchy& h, std::vector<NodeSum> sums,
                            const Threads& threads, Job& job) {
  const FaceGraph& faces = surface.graph();
  MergeGraph graph;
  graph.sum = std::move(sums);
  const std::int32_t patches = graph.size();
  graph.first.assign(static_cast<std::size_t>(patches) + 1, 0);
  const std::int32_t pieces = threads.pieces(patches);
  std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(pieces));
  threads.run(patches, pieces, [&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    rows[k] = rows_between(faces, h, begin, end, graph.first.data() + 1, job);
  });
  graph.neighbour = std::move(rows[0]);
  for (std::int32_t k = 1; k < pieces; ++k) append(graph.neighbour, rows[k]);
  std::partial_sum(graph.first.begin(), graph.first.end(), graph.first.begin());
  if (surface.component_count() > 1) {
    graph.component.resize(static_cast<std::size_t>(patches));
    for (std::int32_t p = 0; p < patches; ++p)
      graph.component[p] = surface.component()[faces.mesh_face[h.patch_face[h.patch_first[p]]]];
  }
  return graph;
}

/// Components from the sums of their patches.
std::vector<Component> components_of(const Surface& surface, const Hierarchy& h, const Patches& patches) {
  const MergeGraph& graph = h.level.front();
  std::vector<Component> components(static_cast<std::size_t>(surface.component_count()));
  for (Component& component : components) component.first = surface.face_count();
  for (std::int32_t p = 0; p < graph.size(); ++p) {
    Component& component = components[graph.component_of(p)];
    component.sum.add(h.patch_sum[p]);
    component.area += h.patch_sum[p].weight / 2;
    component.closed &= patches.open[p] == 0;
    component.first = std::min(component.first, h.patch_face[h.patch_first[p]]);
  }
  return components;
}

}  // namespace

bool Hierarchy::serves(const Surface& surface, std::int32_t proxies) const {
  return patch.size() == static_cast<std::size_t>(surface.face_count()) &&
         patch_size == patch_size_for(surface.face_count(), proxies);
}

Hierarchy build_hierarchy(const Surface& surface, std::int32_t proxies, Job& job, const HierarchyOptions& options) {
  const Threads threads(options.threads);
  const std::span<const FaceRecord> faces = options.faces;
  Job::Stage stage(job, "merging", 0.0, 1.0);
  Hierarchy h;
  h.patch_size = patch_size_for(surface.face_count(), proxies);
  Patches patches = make_patches(surface.graph(), faces.empty() ? surface.graph().faces : faces, h, threads, job);

  job.report(0.3);
  h.level.push_back(graph_of_patches(surface, h, std::move(patches.node), threads, job));
  h.components = components_of(surface, h, patches);

  job.report(0.6);
  while (h.level.back().size() > std::max<std::int64_t>(options.coarsest, kCoarsest)) {
    const MergeRules rules{.satellites = h.level.size() <= 2, .least = kLeastOfComponent, .most = options.most};
    std::vector<std::int32_t> map;
    MergeGraph next = merge_round(h.level.back(), rules, map, threads, job);
    // The gate lets at least a few pairs pass, unless every component is down to its least or all merges cost too much.
    const std::int32_t nodes = h.level.back().size(), merges = nodes - next.size();
    if (merges == 0 || (nodes > kManyNodes && merges <= kFewMerges * nodes)) break;
    h.to_next.push_back(std::move(map));
    h.level.push_back(std::move(next));
    job.report(1 - 0.4 * h.level.back().size() / h.level.front().size());
  }

  return h;
}

}  // namespace isimp
