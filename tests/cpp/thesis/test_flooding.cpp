// Flooding and fitting on graphs small enough to know the answer, and against the plain method.

#include <queue>
#include <tuple>

#include "flooding.h"
#include "graphs.h"
#include "lloyd.h"
#include "seeding.h"
#include "tests.h"

namespace isimp {
namespace {

using graphs::strip;

std::vector<std::int32_t> flood(const FaceGraph& g, const std::vector<std::int32_t>& seeds) {
  std::vector<NormalMetric::Proxy> proxies;
  for (const std::int32_t s : seeds) proxies.push_back(NormalMetric::proxy_of(g.faces[s]));
  std::vector<std::int32_t> label;
  Flooding().run(g, proxies, seeds, label, job());
  return label;
}

TEST(Flooding, MeetsWhereTheErrorsAreEqual) {
  // Normals turn by 10 degrees a face from 0 to 90: seeds at the ends meet in the middle.
  const FaceGraph g = strip({0, 10, 20, 30, 40, 50, 60, 70, 80, 90});
  EXPECT_EQ(flood(g, {0, 9}), (std::vector<std::int32_t>{0, 0, 0, 0, 0, 1, 1, 1, 1, 1, kNone}));
}

TEST(Flooding, CrossesNoGapAndLeavesFacesThatNoSeedReaches) {
  FaceGraph g = strip({0, 0, 0, 90, 90, 90});
  g.neighbours[2][1] = g.neighbours[3][0] = 6;  // cut in two
  EXPECT_EQ(flood(g, {1}), (std::vector<std::int32_t>{0, 0, 0, kNone, kNone, kNone, kNone}));
}

TEST(Flooding, CrossesASteepFaceOnlyWhenNothingElseIsLeft) {
  // The face at 80 degrees parts two flat halves. Each seed takes its own half first.
  const FaceGraph g = strip({0, 1, 2, 80, 2, 1, 0});
  const auto label = flood(g, {0, 6});
  EXPECT_EQ(label[2], 0);
  EXPECT_EQ(label[4], 1);
}

TEST(Flooding, ListsCoverAllErrorsInOrder) {
  EXPECT_EQ(Flooding::list_of(0.0F), 0);
  std::int32_t before = 0;
  for (float e = 1e-9F; e < 4.0F; e *= 1.01F) {
    const std::int32_t list = Flooding::list_of(e);
    EXPECT_GE(list, before);
    EXPECT_LE(e, Flooding::upper_end(list));
    EXPECT_TRUE(list == 0 || e > Flooding::upper_end(list - 1));
    before = list;
  }
  EXPECT_LE(4.0F, Flooding::upper_end(Flooding::list_of(4.0F)));
}

/// Flooding and fitting as the 2004 paper writes it down.
double plain_error(const FaceGraph& g, std::vector<std::int32_t> seeds, int rounds) {
  std::vector<NormalMetric::Proxy> proxies;
  for (const std::int32_t s : seeds) proxies.push_back(NormalMetric::proxy_of(g.faces[s]));
  Regions state;
  double least = 1e300;
  for (int round = 0; round < rounds; ++round) {
    using Entry = std::tuple<float, std::int32_t, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    state.label.assign(g.faces.size(), kNone);
    state.sum.assign(seeds.size(), {});
    const auto settle = [&](std::int32_t face, std::int32_t r) {
      state.label[face] = r;
      for (const std::int32_t j : g.neighbours[face])
        if (j != g.size() && state.label[j] == kNone) queue.emplace(NormalMetric::error(g.faces[j], proxies[r]), j, r);
    };
    for (std::size_t r = 0; r < seeds.size(); ++r) state.label[seeds[r]] = static_cast<std::int32_t>(r);
    for (std::size_t r = 0; r < seeds.size(); ++r) settle(seeds[r], static_cast<std::int32_t>(r));
    while (!queue.empty()) {
      const auto [error, face, r] = queue.top();
      queue.pop();
      if (state.label[face] == kNone) settle(face, r);
    }
    sum_regions(g, state, job());
    least = std::min(least, state.error());
    seeds = nearest_faces(g, state, job());
    for (std::size_t r = 0; r < seeds.size(); ++r) proxies[r] = NormalMetric::fit(state.sum[r]);
  }
  return least;
}

TEST(Flooding, IsAsGoodAsThePlainVersion) {
  double fast = 0, plain = 0;
  for (std::uint32_t k = 1; k <= 8; ++k) {
    const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(60, 30), 0.004, k));
    const Components components = find_components(mesh, 60, 0, job());
    const auto seeds = random_seeds(mesh, components, share_out(components), k, job());
    std::vector<double> history;
    fast += lloyd(mesh.graph(), seeds, 20, history, job()).error();
    plain += plain_error(mesh.graph(), seeds, 20);
  }
  EXPECT_LT(std::abs(fast / plain - 1), 0.015);
}

TEST(Random, DrawsEvenlyAndTheSameEverywhere) {
  Random random(42);
  EXPECT_EQ(random.below(1000000), Random(42).below(1000000));
  std::vector<int> count(7, 0);
  for (int k = 0; k < 7000; ++k) ++count[random.below(7)];
  for (const int c : count) EXPECT_NEAR(c, 1000, 150);
}

}  // namespace
}  // namespace isimp
