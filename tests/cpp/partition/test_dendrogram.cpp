#include "hierarchy/dendrogram.h"
#include "hierarchy/strays.h"
#include "tests.h"

namespace isimp {
namespace {

ClusterGraph faces_of(const Mesh& mesh) { return face_clusters(mesh.graph(), mesh.graph().faces); }

/// The costs of always merging the cheapest pair, with a search of all pairs every time.
std::vector<double> plain_costs(const ClusterGraph& graph) {
  std::map<std::int32_t, RegionSum> alive;
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::int32_t u = 0; u < static_cast<std::int32_t>(graph.sum.size()); ++u) {
    alive[u] = graph.sum[u];
    for (std::int32_t k = graph.first[u]; k < graph.first[u + 1]; ++k) pairs.insert(std::minmax(u, graph.neighbour[k]));
  }
  std::vector<double> costs;
  while (!pairs.empty()) {
    const auto cost = [&](const auto& pair) { return merge_cost(alive[pair.first], alive[pair.second]); };
    const auto [u, v] =
        *std::min_element(pairs.begin(), pairs.end(), [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    costs.push_back(cost(std::pair(u, v)));
    alive[u].add(alive[v]);
    std::set<std::pair<std::int32_t, std::int32_t>> next;
    for (auto [a, b] : pairs) {
      if (a == v) a = u;
      if (b == v) b = u;
      if (a != b) next.insert(std::minmax(a, b));
    }
    pairs.swap(next);
  }
  return costs;
}

TEST(MergeTree, AlwaysMergesTheCheapestPair) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(14, 7), 0.03, 2));
  const MergeTree tree = merge_all(faces_of(mesh), {}, job());
  const std::vector<double> expected = plain_costs(faces_of(mesh));
  ASSERT_EQ(tree.cost.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(tree.cost[k], expected[k], 1e-9);
}

TEST(MergeTree, HasFiveMergesWithCostOnACube) {
  const Mesh mesh = shapes::mesh(shapes::shuffled(shapes::cube(9), 4));
  const MergeTree tree = merge_all(faces_of(mesh), {}, job());
  ASSERT_EQ(tree.merges(), mesh.face_count() - 1);
  EXPECT_EQ(std::count_if(tree.cost.begin(), tree.cost.end(), [](double c) { return c > 1e-9; }), 5);
  // Two sides of the cube, each a sixth of the area, at a right angle.
  EXPECT_NEAR(tree.cost[tree.merges() - 5], 2 * (2 - std::sqrt(2.0)) / 6, 1e-6);
  const std::vector<std::int32_t> side = cut_after(tree, tree.merges() - 5);
  for (std::int32_t i = 0; i < mesh.face_count(); ++i)
    for (std::int32_t j = 0; j < mesh.face_count(); ++j) {
      const FaceRecord &a = mesh.graph().faces[i], &b = mesh.graph().faces[j];
      EXPECT_EQ(side[i] == side[j], a.nx * b.nx + a.ny * b.ny + a.nz * b.nz > 0.5F);
    }
}

TEST(MergeTree, StopsAtTheCostAndKeepsTheNeededClusters) {
  const Mesh mesh = shapes::mesh(shapes::both(shapes::cube(3), shapes::sphere(2), Vec3(5, 0, 0)));
  ClusterGraph graph = faces_of(mesh);
  EXPECT_EQ(merge_all(graph, {-1, {}}, job()).merges(), 0);
  EXPECT_EQ(merge_all(graph, {}, job()).merges(), mesh.face_count() - 2);  // never across components
  for (std::int32_t i = 0; i < mesh.face_count(); ++i)
    graph.component.push_back(mesh.component()[mesh.graph().mesh_face[i]]);
  const std::vector<std::int32_t> need{4, 7};
  EXPECT_EQ(merge_all(graph, {.cost = 1e9, .need = need}, job()).merges(), mesh.face_count() - 11);
}

TEST(MergeTree, IsTheSameForRegionsOfOneFace) {
  const Mesh mesh = shapes::mesh(shapes::torus(10, 6));
  Regions regions;
  for (std::int32_t i = 0; i < mesh.face_count(); ++i) regions.label.push_back(i);
  regions.label.push_back(kNone);
  regions.sum.resize(mesh.face_count());
  sum_regions(mesh.graph(), regions, job());
  EXPECT_EQ(merge_all(region_clusters(mesh.graph(), regions, job()), {}, job()).merged,
            merge_all(faces_of(mesh), {}, job()).merged);
}

/// Patches in a row, all of area 1 and one normal but the last two.
MergeGraph row(std::int32_t n, std::vector<RegionSum>& sum) {
  MergeGraph graph;
  graph.sum.resize(static_cast<std::size_t>(n));
  graph.first.push_back(0);
  for (std::int32_t u = 0; u < n; ++u) {
    for (const std::int32_t v : {u - 1, u + 1})
      if (v >= 0 && v < n) graph.neighbour.push_back(v);
    graph.first.push_back(static_cast<std::int32_t>(graph.neighbour.size()));
    sum.push_back(u + 2 < n ? RegionSum{0, 0, 1, 2, 1} : RegionSum{1, 0, 0, 2, 1});
  }
  return graph;
}

TEST(Strays, JoinTheClustersAroundThem) {
  std::vector<RegionSum> sum;
  const MergeGraph graph = row(7, sum);
  std::vector<std::int32_t> cluster{0, 0, 1, 0, 1, 1, 2};  // patches 2 and 3 are loose
  EXPECT_EQ(join_strays(graph, sum, 3, cluster), 2);
  EXPECT_EQ(cluster, (std::vector<std::int32_t>{0, 0, 0, 0, 1, 1, 2}));
  EXPECT_EQ(join_strays(graph, sum, 3, cluster), 0);
}

TEST(Strays, ThatTouchOnlyStraysWait) {
  std::vector<RegionSum> sum;
  const MergeGraph graph = row(6, sum);
  std::vector<std::int32_t> cluster{1, 0, 1, 1, 0, 0};  // patch 0 touches patch 1 alone, which is a stray itself
  EXPECT_EQ(join_strays(graph, sum, 2, cluster), 2);
  EXPECT_EQ(cluster, (std::vector<std::int32_t>{1, 1, 1, 1, 0, 0}));
}

}  // namespace
}  // namespace isimp
