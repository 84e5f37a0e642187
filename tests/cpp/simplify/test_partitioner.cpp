// The data kept from one partition to the next changes no result.

#include <thread>

#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

/// A sphere with noise, a quarter of the faces of `checks::bumpy`.
const Mesh& coarse() {
  static const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(checks::size(3, 2)), 0.003, 2));
  return mesh;
}

/// Options whose kept data another call may find and use in another order.
std::vector<PartitionOptions> orders() {
  return {{.proxies = 5},
          {.proxies = 40},
          {.proxies = checks::size(400, 200)},
          {.proxies = 20},
          {.detail = 0.02},
          {.detail = 0.005},
          {.detail = 0.02, .method = Method::lloyd},
          {.proxies = 30, .adaptivity = 0.5},
          {.detail = 0.01, .adaptivity = 0.5},
          {.proxies = 30},
          {.bound = 0.05},
          {.proxies = 30, .seeding = Seeding::hierarchical, .method = Method::lloyd},
          {.proxies = 25, .seeding = Seeding::hierarchical, .method = Method::naive},
          {.proxies = 12, .method = Method::queued},
          {.proxies = 12, .method = Method::hybrid},
          {.proxies = 15, .method = Method::hybrid},
          {.detail = 0.02, .method = Method::hybrid},
          {.proxies = 15, .method = Method::hybrid, .fraction = 0.5},
          {.proxies = 12, .method = Method::teleport},
          {.proxies = 40}};
}

void expect_same(const Partition& a, const Partition& b, const std::string& which) {
  EXPECT_EQ(a.face_region, b.face_region) << which;
  EXPECT_EQ(a.region_seed, b.region_seed) << which;
  EXPECT_EQ(a.error, b.error) << which;
  EXPECT_EQ(a.history, b.history) << which;
  EXPECT_EQ(a.proxies_asked, b.proxies_asked) << which;
  EXPECT_EQ(a.tolerance, b.tolerance) << which;
  EXPECT_EQ(a.noise, b.noise) << which;
}

TEST(Partitioner, EqualsAFreshOne) {
  const Partitioner kept(coarse());
  const Guides heavy{std::vector<double>(static_cast<std::size_t>(coarse().face_count()), 3.0), {{0, 1}}};
  Guides some = heavy;
  some.barriers.clear();
  for (std::size_t f = 0; f < some.weights.size(); f += 2) some.weights[f] = 0.5;
  int number = 0;
  for (const Guides& guides : {Guides{}, some, Guides{}})
    for (const PartitionOptions& options : orders()) {
      const Surface surface = guides.weights.empty() ? Surface(coarse()) : Surface(coarse(), guides, job());
      expect_same(kept.run(options, {.guides = guides}, job()), partition(surface, options, job()),
                  std::to_string(number++));
    }
}

TEST(Partitioner, MayRunOnSeveralThreads) {
  const Partitioner kept(coarse());
  const std::vector<PartitionOptions> all = orders();
  std::vector<Partition> found(all.size());
  std::vector<std::thread> threads;
  threads.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) threads.emplace_back([&, i] { found[i] = kept.run(all[i], {}, job()); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < all.size(); ++i) {
    expect_same(found[i], partition(coarse(), all[i], job()), std::to_string(i));
  }
}

TEST(Partitioner, AFailedOrCancelledCallLeavesTheKeptData) {
  const Partitioner kept(coarse());
  const Partition before = kept.run({.proxies = 20}, {}, job());
  EXPECT_EQ(message_of([&] { (void)kept.run({.proxies = 0}, {}, job()); }),
            "proxies must be in [1, " + std::to_string(coarse().face_count()) + "], got 0");
  Job cancelled;
  cancelled.cancel();
  for (const PartitionOptions& options : orders())
    EXPECT_THROW((void)kept.run(options, {}, cancelled), Cancelled) << options.proxies.value_or(0);
  expect_same(kept.run({.proxies = 20}, {}, job()), before, "after");
}

}  // namespace
}  // namespace isimp
