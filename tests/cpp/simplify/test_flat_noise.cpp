#include "isimp/mesh/mesh.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

/// Flat ground with noise becomes one region with hundreds around it. Splitting it again from a neighbour takes time by
/// its size and gains nothing; it is tried a few times, not with each neighbour.
namespace isimp {
namespace {

Mesh ground(int n) {
  std::mt19937 random(1);
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) vertices.emplace_back(0.5 * i, 0.5 * j, 0.02 * (random() % 1024) / 1024);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j;
      triangles.push_back({a, a + n + 1, a + n + 2});
      triangles.push_back({a, a + n + 2, a + 1});
    }
  return {std::move(vertices), std::move(triangles), job()};
}

TEST(FlatNoise, TheGroundIsSplitAgainAFewTimesOnly) {
  const Mesh mesh = ground(60);
  PartitionOptions options;
  options.proxies = 300;
  options.metric = Metric::normals;  // relaxing by distances would be counted too
  options.threads = 1;
  Job job;
  double last = -1;
  int polls = 0;  // since the progress rose last: while regions are split again nothing is reported
  int most = 0;
  job.at_poll = [&] {
    if (std::string(job.stage()) != "relaxing" || job.progress() < 0.9) return;
    polls = job.progress() > last ? 1 : polls + 1;
    last = job.progress();
    most = std::max(most, polls);
  };
  const Partition part = partition(mesh, options, job);
  EXPECT_EQ(part.region_count(), 300);
  EXPECT_LT(most, 20);  // 55 where each neighbour is tried
}

}  // namespace
}  // namespace isimp
