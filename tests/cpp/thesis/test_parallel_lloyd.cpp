// Parallel flooding on every back end that is here: against plain versions, and the same bits for any number of
// threads.

#include "isimp/parallel/backend.h"
#include "parallel_lloyd.h"
#include "partition_checks.h"
#include "rounds.h"
#include "seeding.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound_regions;

Partition run(const Surface& surface, const PartitionOptions& options) { return partition(surface, options, job()); }

std::vector<PartitionOptions> variants(PartitionOptions options) {
  std::vector<PartitionOptions> all;
  for (const Method method : {Method::naive, Method::queued})
    for (const Connect connect : {Connect::repair, Connect::flood}) {
      options.method = method;
      options.connect = connect;
      all.push_back(options);
    }
  return all;
}

/// A bumpy ring large enough that the queues go to threads.
const Mesh& large() {
  static const Mesh mesh =
      shapes::mesh(shapes::shuffled(shapes::noisy(shapes::torus(checks::size(240, 120), 120), 0.004, 3), 4));
  return mesh;
}

parallel::Proxies proxies_of(const Surface& surface, std::int32_t count, std::uint64_t seed) {
  const Components components = find_components(surface, count, 0, job());
  parallel::Proxies proxies;
  proxies.seed = random_seeds(surface, components, share_out(components), seed, job());
  for (const std::int32_t s : proxies.seed) {
    const FaceRecord& f = surface.graph().faces[s];
    for (const float x : {f.nx, f.ny, f.nz}) proxies.normal.push_back(x);
    for (const float x : {f.nx, f.ny, f.nz}) proxies.centre.push_back((x + 1) / 2);  // any places will do
  }
  return proxies;
}

float error_of(const FaceGraph& graph, const parallel::Proxies& proxies, std::int32_t face, std::int32_t r) {
  const float* n = &proxies.normal[3 * r];
  return std::max(0x1p-24F, NormalMetric::error(graph.faces[face], {n[0], n[1], n[2]}));
}

/// Queued flooding as in the thesis, where every step visits every face instead of a queue.
std::vector<std::int32_t> plain_queued(const FaceGraph& graph, const parallel::Proxies& proxies) {
  const std::int32_t n = graph.size();
  std::vector<std::int32_t> now(static_cast<std::size_t>(n) + 1, kNone), next;
  for (std::size_t r = 0; r < proxies.seed.size(); ++r) now[proxies.seed[r]] = static_cast<std::int32_t>(r);
  while (next != now) {
    if (!next.empty()) now = next;
    next = now;
    for (std::int32_t i = 0; i < n; ++i) {
      if (now[i] != kNone && proxies.seed[now[i]] == i) continue;
      std::set<std::pair<float, std::int32_t>> offers;
      for (const std::int32_t j : graph.neighbours[i])
        if (now[j] != kNone) offers.emplace(error_of(graph, proxies, i, now[j]), now[j]);
      if (offers.empty()) continue;
      if (now[i] == kNone || offers.begin()->first < error_of(graph, proxies, i, now[i]))
        next[i] = offers.begin()->second;
    }
  }
  now.pop_back();
  return now;
}

std::vector<std::int32_t> labels_of(const parallel::Flooder& flooder, const Mesh& mesh) {
  std::vector<std::int32_t> labels(static_cast<std::size_t>(mesh.face_count()));
  flooder.labels(labels);
  return labels;
}

TEST(Flooder, AQueueEqualsAVisitOfAllFaces) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(60, 30), 0.02, 5));
  const parallel::Proxies proxies = proxies_of(mesh, 40, 9);
  const std::vector<std::int32_t> plain = plain_queued(mesh.graph(), proxies);
  for (const std::string& name : parallel::backends()) {
    const auto flooder = load(mesh, name);
    EXPECT_GT(flooder->queued(proxies, 2, job()), 5);
    EXPECT_EQ(labels_of(*flooder, mesh), plain) << name;
    flooder->queued(proxies, 1, job());
    EXPECT_EQ(labels_of(*flooder, mesh), plain) << name << ", the second time";
  }
}

TEST(Flooder, NaiveFloodingTakesTheBestOfTheNearest) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(3), 0.02, 5));
  const FaceGraph& graph = mesh.graph();
  const parallel::Proxies proxies = proxies_of(mesh, 60, 9);
  std::vector<float> centre;
  for (std::int32_t i = 0; i < mesh.face_count(); ++i)
    for (const float x : {graph.faces[i].nx, graph.faces[i].ny, graph.faces[i].nz}) centre.push_back((x + 1) / 2);
  std::vector<std::int32_t> plain(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t i = 0; i < mesh.face_count(); ++i) {
    std::vector<std::pair<float, std::int32_t>> by_distance;
    for (std::int32_t r = 0; r < 60; ++r) {
      float sum = 0;
      for (int k = 0; k < 3; ++k) {
        const float d = centre[3 * i + k] - proxies.centre[3 * r + k];
        sum += d * d;
      }
      by_distance.emplace_back(sum, r);
    }
    std::sort(by_distance.begin(), by_distance.end());
    plain[i] = by_distance[0].second;
    for (int k = 1; k < 5; ++k)
      if (const auto r = by_distance[k].second; error_of(graph, proxies, i, r) < error_of(graph, proxies, i, plain[i]))
        plain[i] = r;
  }
  for (std::int32_t r = 0; r < 60; ++r) plain[proxies.seed[r]] = r;
  for (const std::string& name : parallel::backends())
    for (const bool brute : {false, true}) {
      const auto flooder = load(mesh, name);
      flooder->place(centre, {});
      flooder->naive(proxies, 5, brute, 2, job());
      EXPECT_EQ(labels_of(*flooder, mesh), plain) << name;
    }
}

TEST(Flooder, RepairLeavesTheLargestPieceAndFillsTheRest) {
  // A strip of nine faces: four that face along x, three along y, two along x again, which is one region in two pieces.
  const std::vector<float> x{1, 0, 0, 1}, y{0, 1, 0, 1};
  std::vector<float> faces;
  std::vector<std::int32_t> neighbours;
  for (std::int32_t i = 0; i < 9; ++i) {
    const std::vector<float>& face = i >= 4 && i < 7 ? y : x;
    faces.insert(faces.end(), face.begin(), face.end());
    for (const std::int32_t j : {i > 0 ? i - 1 : 9, i + 1, 9}) neighbours.push_back(j);
  }
  const parallel::Proxies proxies{{0, 4}, {1, 0, 0, 0, 1, 0}, {0, 0, 0, 1, 0, 0}};
  for (const std::string& name : parallel::backends()) {
    const auto flooder = parallel::backend(name).load({faces, neighbours});
    flooder->place(std::vector<float>(27, 0.5F), {});
    flooder->naive(proxies, 2, false, 1, job());
    std::vector<std::int32_t> labels(9);
    flooder->labels(labels);
    EXPECT_EQ(labels, (std::vector<std::int32_t>{0, 0, 0, 0, 1, 1, 1, 0, 0}));
    EXPECT_EQ(flooder->cut_to_pieces(1, job()), 2);
    flooder->labels(labels);
    EXPECT_EQ(labels, (std::vector<std::int32_t>{0, 0, 0, 0, 1, 1, 1, -1, -1}));
    EXPECT_EQ(flooder->fill(proxies, 1, job()), 2);
    flooder->labels(labels);
    EXPECT_EQ(labels, (std::vector<std::int32_t>{0, 0, 0, 0, 1, 1, 1, 1, 1}));
  }
}

TEST(Flooder, BadInputIsNamed) {
  const std::vector<float> faces{0, 0, 1, 1, 0, 0, 1, 1};
  const auto message = [](std::vector<float> f, std::vector<std::int32_t> n) {
    return message_of([&] { (void)parallel::backend("cpu").load({f, n}); });
  };
  EXPECT_EQ(message(faces, {1, 2, 2, 0, 2, 2}), "no error");
  EXPECT_EQ(message(faces, {1, 2, 2}), "flooding wants 4 numbers and 3 neighbours a face, but got 8 and 3");
  EXPECT_EQ(message(faces, {1, 2, 2, 3, 2, 2}), "face 1 has neighbour 3, but there are 2 faces");
  EXPECT_EQ(message({0, 0, 1, 1, 0, 2, 1, 1}, {1, 2, 2, 0, 2, 2}).substr(0, 25), "face 1 needs a unit norma");
}

TEST(ParallelLloyd, EveryThreadCountAndBackEndGivesTheSameBits) {
  for (const Method method : {Method::naive, Method::queued}) {
    PartitionOptions options{.proxies = 4000, .seed = 3, .iterations = 2, .method = method, .threads = 1};
    const Partition one = run(large(), options);
    expect_sound_regions(large(), one, 4000);
    for (const std::string& name : parallel::backends())
      for (const std::int32_t threads : {1, 2, 3, 8}) {
        options.threads = threads;
        options.backend = name;
        const Partition p = run(large(), options);
        EXPECT_EQ(p.face_region, one.face_region) << name << ", " << threads << " threads";
        EXPECT_EQ(p.history, one.history);
      }
  }
}

TEST(ParallelLloyd, TheGridEqualsBruteForce) {
  auto arrays = shapes::both(shapes::cube(8), shapes::noisy(shapes::sphere(3), 0.01, 1), {3, 0.5, 0});
  arrays = shapes::both(arrays, shapes::plane(9), {0, 7, 7});
  const Mesh mesh = shapes::mesh(arrays);
  for (const std::int32_t proxies : {1, 9, 60, 500})
    for (const std::int32_t nearest : {1, 4, 32}) {
      PartitionOptions options{.proxies = proxies, .iterations = 4, .method = Method::naive, .nearest = nearest};
      const Partition grid = run(mesh, options);
      expect_sound_regions(mesh, grid);
      options.search = Search::brute;
      const Partition brute = run(mesh, options);
      EXPECT_EQ(grid.face_region, brute.face_region) << proxies << ", " << nearest;
      EXPECT_EQ(grid.history, brute.history);
    }
}

TEST(ParallelLloyd, ACubeSplitsIntoItsSixSides) {
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  for (PartitionOptions options : variants({.proxies = 6, .seeding = Seeding::farthest})) {
    const Partition p = run(mesh, options);
    expect_sound_regions(mesh, p, 6);
    EXPECT_NEAR(p.error, 0.0, 1e-12);
  }
}

TEST(ParallelLloyd, HasExactlyTheRequestedRegions) {
  const Mesh sphere = shapes::mesh(shapes::shuffled(shapes::noisy(shapes::sphere(3), 0.01, 1), 2));
  for (const std::int32_t proxies : {4, 37, 300, 1280})
    for (const PartitionOptions& options : variants({.proxies = proxies, .seed = 7, .iterations = 6})) {
      const Partition p = run(sphere, options);
      expect_sound_regions(sphere, p, proxies);
      EXPECT_EQ(p.history.back(), p.error);
    }
}

TEST(ParallelLloyd, RepairLosesLessThanAnotherFlooding) {
  for (const Method method : {Method::naive, Method::queued}) {
    PartitionOptions options{.proxies = 300, .seed = 2, .iterations = 8, .method = method};
    const Partition repaired = run(large(), options);
    options.connect = Connect::flood;
    const Partition flooded = run(large(), options);
    EXPECT_EQ(std::vector(repaired.history.begin(), repaired.history.end() - 1),
              std::vector(flooded.history.begin(), flooded.history.end() - 1));
    EXPECT_LT(repaired.error, flooded.error);
  }
}

TEST(ParallelLloyd, IsNearTheSequentialError) {
  PartitionOptions options{.proxies = 300, .seed = 2, .method = Method::lloyd};
  const double lloyd = run(large(), options).error;
  options.method = Method::queued;
  EXPECT_LT(run(large(), options).error, 1.1 * lloyd);
}

TEST(ParallelLloyd, ComponentsKeepTheirRegionsAndSpecksAreLeftOut) {
  auto arrays = shapes::both(shapes::cube(6), shapes::cube(6), {1.02, 0, 0});  // so near that centres mix
  const Mesh mesh = shapes::mesh(shapes::both(arrays, shapes::scaled(shapes::cube(1), 0.006), {5, 0, 0}));
  for (const PartitionOptions& options : variants({.proxies = 14})) {
    const Partition p = run(mesh, options);
    expect_sound_regions(mesh, p, 14);
    EXPECT_EQ(p.parts_left_out, 1);
    EXPECT_EQ(p.face_region.back(), kNone);
    std::vector<std::set<std::int32_t>> regions(3);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) regions[mesh.component()[f]].insert(p.face_region[f]);
    EXPECT_EQ(regions[0].size() + regions[1].size(), 14U);
  }
}

TEST(ParallelLloyd, BarriersAndWeightsAreKept) {
  const Mesh mesh = shapes::mesh(shapes::plane(8));
  Guides guides;
  for (std::int32_t i = 0; i < mesh.vertex_count(); ++i)  // along x = 1/2, from border to border
    for (std::int32_t j = 0; j < mesh.vertex_count(); ++j)
      if (const Vec3 a = mesh.vertices()[i], b = mesh.vertices()[j];
          a.x() == 0.5 && b.x() == 0.5 && std::abs(b.y() - a.y() - 0.125) < 1e-9)
        guides.barriers.push_back({i, j});
  ASSERT_EQ(guides.barriers.size(), 8U);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) guides.weights.push_back(f % 3 == 0 ? 2.0 : 1.0);
  const Surface surface(mesh, guides, job());
  const double weighted = surface.graph().area;
  EXPECT_GT(weighted, mesh.report().area);
  for (const PartitionOptions& options : variants({.proxies = 6})) {
    const Partition p = partition(surface, options, job());
    expect_sound_regions(mesh, p);
    std::vector<std::set<bool>> sides(static_cast<std::size_t>(p.region_count()));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      sides[p.face_region[f]].insert(shapes::middle(mesh, f).x() < 0.5);
    for (const auto& side : sides) EXPECT_EQ(side.size(), 1U);
    EXPECT_EQ(p.guided, surface.guided());
  }
}

TEST(ParallelLloyd, AKeptFlooderGivesTheSame) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::torus(40, 20), 0.01, 3));
  const auto flooder = load(mesh, "cpu");
  for (const std::int32_t proxies : {30, 80, 30})
    for (const PartitionOptions& options : variants({.proxies = proxies})) {
      const Partition kept = in_rounds(mesh, Hierarchy{}, flooder.get(), options, job());
      const Partition fresh = run(mesh, options);
      EXPECT_EQ(kept.face_region, fresh.face_region);
      EXPECT_EQ(kept.history, fresh.history);
    }
}

TEST(ParallelLloyd, QueuedMakesTheSameRoundsOnAFlooderThatNaiveHasPlaced) {
  const Mesh mesh = shapes::mesh(shapes::plane(8));  // flat, so that it converges, and one round more shows
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto flooder = load(mesh, "cpu");
    (void)in_rounds(mesh, Hierarchy{}, flooder.get(), {.proxies = 20, .method = Method::naive}, job());
    const PartitionOptions queued{.proxies = 20, .seed = seed, .method = Method::queued};
    EXPECT_EQ(in_rounds(mesh, Hierarchy{}, flooder.get(), queued, job()).history, run(mesh, queued).history);
  }
}

TEST(ParallelLloyd, OptionsOutOfRangeAreNamedAndACancelStopsIt) {
  const Mesh mesh = shapes::mesh(shapes::cube(4));
  for (const std::int32_t nearest : {0, 33})
    EXPECT_EQ(message_of([&] { run(mesh, {.proxies = 6, .method = Method::naive, .nearest = nearest}); }),
              "nearest must be in [1, 32], got " + std::to_string(nearest));
  if (parallel::backends().size() == 1) {
    EXPECT_EQ(message_of([&] { run(mesh, {.proxies = 6, .method = Method::queued, .backend = "cuda"}); }).substr(0, 38),
              "back end 'cuda' is not available here:");
  }
  Job job;
  job.cancel();
  for (const PartitionOptions& options : variants({.proxies = 6}))
    EXPECT_THROW(partition(mesh, options, job), Cancelled);
}

}  // namespace
}  // namespace isimp
