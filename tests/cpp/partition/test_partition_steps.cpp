// The steps of partitioning on graphs small enough to know the answer, and against a plain version of each.

#include <queue>
#include <tuple>

#include "borders/local.h"
#include "borders/relax.h"
#include "graphs.h"
#include "hierarchy/contraction.h"
#include "hierarchy/greedy.h"
#include "hierarchy/hierarchy.h"
#include "hierarchy/patch_relax.h"
#include "hierarchy/region_graph.h"
#include "isimp/simplify/partitioner.h"
#include "isimp/thesis/thesis.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using graphs::node;
using graphs::strip;

MergeGraph chain(std::int32_t n) {
  MergeGraph g;
  g.sum.resize(static_cast<std::size_t>(n));
  g.first.push_back(0);
  for (std::int32_t u = 0; u < n; ++u) {
    if (u > 0) g.neighbour.push_back(u - 1);
    if (u + 1 < n) g.neighbour.push_back(u + 1);
    g.first.push_back(static_cast<std::int32_t>(g.neighbour.size()));
  }
  return g;
}

TEST(MergeGreedily, JoinsParallelNodesFirst) {
  // x x y y in a row: each pair costs nothing, the middle costs 2 - sqrt(2) of their length.
  const std::vector<RegionSum> sums{node(1, 0), node(1, 0), node(0, 1), node(0, 1)};
  const std::vector<std::int32_t> need{1};
  EXPECT_EQ(merge_greedily(chain(4), sums, need, 2, job()), (std::vector<std::int32_t>{0, 0, 1, 1}));
  EXPECT_EQ(merge_greedily(chain(4), sums, need, 1, job()), (std::vector<std::int32_t>{0, 0, 0, 0}));
  EXPECT_EQ(merge_greedily(chain(4), sums, need, 4, job()), (std::vector<std::int32_t>{0, 1, 2, 3}));
}

TEST(MergeGreedily, LeavesEveryComponentItsNeed) {
  // Two components of two parallel nodes each; the second needs two clusters.
  MergeGraph g;
  g.sum.resize(4);
  g.first = {0, 1, 2, 3, 4};
  g.neighbour = {1, 0, 3, 2};
  g.component = {0, 0, 1, 1};
  const std::vector<RegionSum> sums{node(1, 0), node(0, 1), node(1, 0), node(1, 0)};
  const std::vector<std::int32_t> need{1, 2};
  EXPECT_EQ(merge_greedily(g, sums, need, 1, job()), (std::vector<std::int32_t>{0, 0, 1, 2}));
}

TEST(MergeGreedily, LeavesOutEmptyNodes) {
  const std::vector<RegionSum> sums{node(1, 0), RegionSum{}, node(1, 0)};
  const std::vector<std::int32_t> need{1};
  EXPECT_EQ(merge_greedily(chain(3), sums, need, 1, job()), (std::vector<std::int32_t>{0, kNone, 1}));
}

TEST(MergeRound, PairsUpMutuallyCheapestNodes) {
  MergeGraph g = chain(4);
  g.sum = {{1, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 0, 1}};
  std::vector<std::int32_t> map;
  const MergeGraph next = merge_round(g, {.satellites = true}, map, Threads(1), job());
  EXPECT_EQ(map, (std::vector<std::int32_t>{0, 0, 1, 1}));
  ASSERT_EQ(next.size(), 2);
  EXPECT_EQ(next.neighbour, (std::vector<std::int32_t>{1, 0}));
  EXPECT_EQ(next.sum[0].x, 2.0F);
  EXPECT_EQ(merge_round(g, {.satellites = true, .least = 4}, map, Threads(1), job()).size(), 4)
      << "a component of no more than `least` nodes is left alone";
}

TEST(MergeRound, MakesNoMergeAboveTheMost) {
  MergeGraph g = chain(5);
  g.sum = {{1, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {0, 0, 1, 1}};  // node 2 adds 1.17 to the error
  std::vector<std::int32_t> map;
  EXPECT_EQ(merge_round(g, {.satellites = true, .most = 2.0}, map, Threads(1), job()).size(), 2);
  EXPECT_EQ(merge_round(g, {.satellites = true, .most = 1.0}, map, Threads(1), job()).size(), 3);
  EXPECT_EQ(map, (std::vector<std::int32_t>{0, 0, 1, 2, 2}));
  EXPECT_EQ(merge_round(g, {.satellites = true}, map, Threads(1), job()).size(), 3) << "far above the usual price";
}

TEST(PatchRelaxation, MovesAStrayPatchHome) {
  MergeGraph g = chain(4);
  g.sum = {{1, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 0, 1}};
  std::vector<std::int32_t> label{0, 1, 1, 1};
  relax_patches(g, label, 2, 0.0, 5, Threads(1), job());
  EXPECT_EQ(label, (std::vector<std::int32_t>{0, 0, 1, 1}));
}

TEST(PatchRelaxation, MovesPatchesAcrossTheEdgesOfBlocks) {
  // 10,000 patches in a row, whose normal turns at 4100 and 8200 and halfway; borders that lie 50 before move there.
  MergeGraph g = chain(10000);
  std::vector<std::int32_t> label(10000);
  for (std::int32_t u = 0; u < 10000; ++u) {
    const bool x = u / 2050 % 2 == 0;
    g.sum[u] = x ? NodeSum{1, 0, 0, 1} : NodeSum{0, 1, 0, 1};
    label[u] = (u + 50) / 2050;
  }
  std::vector<std::int32_t> one = label;
  relax_patches(g, one, 5, 0.0, 200, Threads(1), job());
  for (std::int32_t u = 0; u < 10000; ++u) ASSERT_EQ(one[u], u / 2050) << "patch " << u;
  relax_patches(g, label, 5, 0.0, 200, Threads(3), job());
  EXPECT_EQ(label, one);
}

TEST(Relaxation, MovesTheBorderToTheCrease) {
  const FaceGraph g = strip({0, 0, 0, 90, 90, 90});
  Regions r{{0, 1, 1, 1, 1, 1, kNone}, std::vector<RegionSum>(2)};
  sum_regions(g, r, job());
  Relaxation<GraphLabels> relaxation(g, {r.label.data()}, r.sum, BorderWeight{});
  for (std::int32_t i = 0; i < 6; ++i) relaxation.push_if_border(i);
  EXPECT_EQ(relaxation.run(10, job()), 2);
  EXPECT_EQ(r.label, (std::vector<std::int32_t>{0, 0, 0, 1, 1, 1, kNone}));
  EXPECT_NEAR(r.error(), 0.0, 1e-7);
}

/// Regions that grow at the same pace from faces far apart.
Regions grown(const FaceGraph& graph, std::int32_t count, Job& job) {
  Regions r{std::vector<std::int32_t>(graph.faces.size(), kNone), std::vector<RegionSum>(count)};
  std::vector<std::int32_t> reached;
  for (std::int32_t k = 0; k < count; ++k) {
    reached.push_back(static_cast<std::int32_t>(static_cast<std::int64_t>(k) * graph.size() / count));
    r.label[reached.back()] = k;
  }
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (const std::int32_t j : graph.neighbours[reached[i]])
      if (j != graph.size() && r.label[j] == kNone) {
        r.label[j] = r.label[reached[i]];
        reached.push_back(j);
      }
  sum_regions(graph, r, job);
  return r;
}

/// Relaxes rough regions, and checks that no region is torn or emptied and that the sums are kept.
Regions relaxed(const Mesh& mesh, std::int32_t proxies, std::int32_t threads, BorderWeight weight = {}) {
  Regions r = grown(mesh.graph(), proxies, job());
  const double before = r.error();
  Relaxation<GraphLabels> relaxation(mesh.graph(), {r.label.data()}, r.sum, weight, Threads(threads));
  for (std::int32_t i = 0; i < mesh.face_count(); ++i) relaxation.push_if_border(i);
  EXPECT_GT(relaxation.run(50, job()), proxies);
  if (!weight.is_wide) {
    EXPECT_LT(r.error(), before);
  }
  Regions moved = r;
  sum_regions(mesh.graph(), r, job());
  for (std::int32_t k = 0; k < proxies; ++k) {
    EXPECT_GT(r.sum[k].faces, 0);
    EXPECT_EQ(r.sum[k].faces, moved.sum[k].faces);
    EXPECT_NEAR(r.sum[k].x, moved.sum[k].x, 1e-12);
    const GraphLabels labels{r.label.data()};
    const auto face = static_cast<std::int32_t>(std::find(r.label.begin(), r.label.end(), k) - r.label.begin());
    const auto faces = take_out(mesh.graph(), labels, face);
    EXPECT_EQ(static_cast<std::int32_t>(faces.size()), r.sum[k].faces) << "region " << k << " fell apart";
    for (const std::int32_t i : faces) labels.set(i, k);
  }
  return moved;
}

TEST(Relaxation, WideBordersAreTheSameOnAnyThreads) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(6), 0.004, 3));
  const BorderWeight weight = border_weight(0.05, 0.5, mesh.face_count(), 400);
  const Regions one = relaxed(mesh, 400, 1, weight), three = relaxed(mesh, 400, 3, weight);
  EXPECT_EQ(one.label, three.label);
}

TEST(Relaxation, WeighsAFaceAsItIsAlsoIfItIsLargerThanItsRegion) {
  for (const float area : {0.001F, 0.1F, 0.5F, 1.0F, 2.0F, 40.0F})
    for (const float along : {-1.0F, -0.8F, 0.0F, 0.3F, 1.0F}) {
      RegionSum region;
      region.x = 1;
      const double across = std::sqrt(1 - along * along);
      RegionSum with = region;
      with.x += area * along;
      with.y += area * across;
      EXPECT_NEAR(BorderProxy::of(region).growth(along, area), (with.length() - region.length()) / area, 2e-3)
          << area << " " << along;
    }
}

TEST(Relaxation, NeverTearsARegionNorEmptiesOne) {
  relaxed(shapes::mesh(shapes::noisy(shapes::sphere(3), 0.05, 9)), 80, 1);
}

TEST(Relaxation, SweepsLongBordersInBlocksWithTheSameResultOnAnyNumberOfThreads) {
  // 82,000 faces in three blocks; some 20,000 of them lie on borders.
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(6), 0.002, 9));
  const Regions one = relaxed(mesh, 400, 1);
  for (const std::int32_t threads : {2, 5}) {
    const Regions more = relaxed(mesh, 400, threads);
    EXPECT_EQ(one.label, more.label);
    EXPECT_EQ(one.error(), more.error());
  }
}

/// Floods the open faces from the regions around them with a queue of all offers.
void flood_plainly(const FaceGraph& g, std::vector<std::int32_t>& label, const std::vector<std::int32_t>& faces,
                   const std::vector<NormalMetric::Proxy>& proxies) {
  LocalQueue queue;
  const auto offer = [&](std::int32_t i, std::int32_t r) {
    queue.push(NormalMetric::error(g.faces[i], proxies[r]), i, r);
  };
  for (const std::int32_t i : faces)
    for (const std::int32_t j : g.neighbours[i])
      if (label[j] >= 0) offer(i, label[j]);
  while (!queue.empty()) {
    const LocalQueue::Entry next = queue.pop();
    if (label[next.face] != kOpen) continue;
    label[next.face] = next.region;
    for (const std::int32_t j : g.neighbours[next.face])
      if (label[j] == kOpen) offer(j, next.region);
  }
}

TEST(LocalFlood, LeavesOutOnlyOffersThatCannotWin) {
  for (const double noise : {0.0, 0.01}) {  // many equal errors, and none
    const Mesh mesh = shapes::mesh(noise > 0 ? shapes::noisy(shapes::sphere(4), noise, 4) : shapes::cube(20));
    const FaceGraph& g = mesh.graph();
    const Partition p = partition(mesh, {.proxies = 12}, job());
    for (std::int32_t region = 0; region < p.region_count(); ++region) {
      std::vector<std::int32_t> label(g.faces.size(), kNone), faces, touched;
      for (std::int32_t i = 0; i < g.size(); ++i) {
        label[i] = p.face_region[g.mesh_face[i]];
        if (label[i] == region) faces.push_back(i);
      }
      for (const std::int32_t i : faces) label[i] = kOpen;
      std::vector<NormalMetric::Proxy> proxies;
      for (const RegionSum& sum : p.region_sum) proxies.push_back(NormalMetric::fit(sum));
      std::vector<std::int32_t> plain = label;
      flood_plainly(g, plain, faces, proxies);
      std::vector<RegionSum> sums = p.region_sum;
      ASSERT_TRUE(flood_from_around(g, GraphLabels{label.data()}, std::span<const std::int32_t>(faces), sums, touched));
      ASSERT_EQ(label, plain) << "region " << region;
    }
  }
}

TEST(RegionGraph, ListsBothDirectionsOnce) {
  const FaceGraph g = strip({0, 0, 0, 0});
  const std::vector<std::int32_t> label{0, 1, 1, 2, kNone}, faces{0, 1, 2, 3};
  const std::vector<std::pair<std::int32_t, std::int32_t>> pairs{{0, 1}, {1, 0}, {1, 2}, {2, 1}};
  EXPECT_EQ(neighbouring_regions(g, label, faces), pairs);
  const std::vector<std::int32_t> sparse{7000, 5, 5, 900, kNone};
  const std::vector<std::pair<std::int32_t, std::int32_t>> few{{5, 900}, {5, 7000}, {900, 5}, {7000, 5}};
  EXPECT_EQ(neighbouring_regions(g, sparse, faces), few) << "numbers too far apart to count them";
}

TEST(Hierarchy, PatchesAreConnectedAndSmooth) {
  const Mesh mesh = shapes::mesh(shapes::cube(12));
  const Hierarchy h = build_hierarchy(mesh, 1, job());
  ASSERT_EQ(h.patch_first.back(), mesh.face_count());
  for (std::int32_t p = 0; p < h.patches(); ++p) {
    const FaceRecord& first = mesh.graph().faces[h.patch_face[h.patch_first[p]]];
    for (std::int32_t k = h.patch_first[p]; k < h.patch_first[p + 1]; ++k) {
      EXPECT_EQ(h.patch[h.patch_face[k]], p);
      EXPECT_EQ(mesh.graph().faces[h.patch_face[k]].nx, first.nx) << "a patch crosses an edge of the cube";
    }
  }
  for (std::size_t l = 0; l + 1 < h.level.size(); ++l) EXPECT_LT(h.level[l + 1].size(), h.level[l].size());
}

TEST(Hierarchy, ServesSmallerNumbers) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(5), 0.003, 2));
  const Hierarchy kept = build_hierarchy(mesh, 40, job());
  EXPECT_TRUE(kept.serves(mesh, 20));
  EXPECT_FALSE(kept.serves(mesh, 3000));
  EXPECT_FALSE(Hierarchy{}.serves(mesh, 20));
}

TEST(Threads, DoNotChangeTheResult) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::both(shapes::sphere(6), shapes::cube(20), {3, 0, 0}), 0.001, 2));
  std::vector<Method> methods{Method::hierarchy};
  if (Thesis::is_built()) methods.push_back(Method::lloyd);
  for (const Method method : methods) {
    const Partition one = partition(mesh, {.proxies = 90, .method = method, .threads = 1}, job());
    checks::expect_sound(mesh, one);
    for (const std::int32_t threads : {2, 3, 5}) {
      const Partition more = partition(mesh, {.proxies = 90, .method = method, .threads = threads}, job());
      EXPECT_EQ(one.face_region, more.face_region);
      EXPECT_EQ(one.region_seed, more.region_seed);
      EXPECT_EQ(one.error, more.error);
    }
  }
}

TEST(Hierarchy, FillsUpComponentsThatHaveTooFewPatches) {
  // Twelve small spheres of 20 faces, each mostly one patch, and a big one: four regions each all the same.
  auto arrays = shapes::sphere(4);
  const auto ball = shapes::scaled(shapes::sphere(0), 0.1);
  for (int k = 0; k < 12; ++k) arrays = shapes::both(arrays, ball, {3.0 + k, 0, 0});
  const Mesh mesh = shapes::mesh(arrays);
  const Partition p = partition(mesh, {.proxies = 60, .leave_out = 0}, job());
  checks::expect_sound(mesh, p, 60);
  std::vector<std::vector<bool>> seen(13, std::vector<bool>(60, false));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) seen[mesh.component()[f]][p.face_region[f]] = true;
  for (const auto& of : seen) EXPECT_GE(std::count(of.begin(), of.end(), true), 4);
}

}  // namespace
}  // namespace isimp
