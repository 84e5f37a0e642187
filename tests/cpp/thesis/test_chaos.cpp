// Results that no order of threads, no rubbish in memory and no failed allocation may change: see chaos.h.

#include <cstdlib>

#include "chaos/chaos.h"
#include "partition_checks.h"
#include "rounds.h"
#include "tests.h"

namespace isimp {
namespace {

/// `ISIMP_CHAOS_SEEDS` tries more than a test may take.
std::uint64_t seeds(std::uint64_t usual) {
  const char* const given = std::getenv("ISIMP_CHAOS_SEEDS");
  return given == nullptr ? usual : std::strtoull(given, nullptr, 10);
}

std::vector<PartitionOptions> variants() {
  std::vector<PartitionOptions> all;
  for (const Method method : {Method::naive, Method::queued})
    for (const Connect connect : {Connect::repair, Connect::flood})
      all.push_back({.proxies = 25, .iterations = 3, .method = method, .connect = connect});
  all.push_back({.proxies = 40, .iterations = 2, .method = Method::naive, .search = Search::brute});
  return all;
}

/// Two components, one of them without a multiple of 256 faces, equal normals and faces without area.
const Mesh& mesh() {
  static const Mesh made = [] {
    shapes::Arrays ring = shapes::noisy(shapes::torus(26, 13), 0.02, 5);
    return shapes::mesh(shapes::both(ring, shapes::cube(4), {3, 0, 0}));
  }();
  return made;
}

std::unique_ptr<parallel::Flooder> load(const parallel::Kernels& kernels) {
  const FaceGraph& graph = mesh().graph();
  const auto faces = static_cast<std::size_t>(graph.size());
  return kernels.load({{&graph.faces.data()->nx, 4 * faces}, {graph.neighbours.data()->data(), 3 * faces}});
}

Partition run(const PartitionOptions& options, parallel::Flooder& flooder) {
  return in_rounds(mesh(), Hierarchy{}, &flooder, options, job());
}

TEST(Chaos, NoOrderOfThreadsChangesALabel) {
  for (const PartitionOptions& options : variants()) {
    const Partition plain = run(options, *load(parallel::backend("cpu")));
    for (std::uint64_t seed = 1; seed <= seeds(20); ++seed) {
      chaos::set({.seed = seed});
      const auto flooder = load(chaos::kernels());
      const Partition disturbed = run(options, *flooder);
      ASSERT_EQ(disturbed.face_region, plain.face_region) << "seed " << seed;
      ASSERT_EQ(disturbed.error, plain.error) << "seed " << seed;
      ASSERT_EQ(disturbed.region_seed, plain.region_seed) << "seed " << seed;
      ASSERT_GT(chaos::count().switches, 1000);
    }
  }
  EXPECT_EQ(chaos::count().live, 0);
  EXPECT_EQ(chaos::count().misused, 0);
}

/// The results of the steps of a flooder, one after another.
std::vector<std::vector<std::int32_t>> steps_of(parallel::Flooder& flooder) {
  std::vector<std::vector<std::int32_t>> all;
  const auto read = [&] {
    all.emplace_back(static_cast<std::size_t>(mesh().face_count()));
    flooder.labels(all.back());
  };
  parallel::Proxies proxies;
  const FaceGraph& graph = mesh().graph();
  for (std::int32_t f = 5; f < graph.size(); f += 90) {
    proxies.seed.push_back(f);
    const FaceRecord& face = graph.faces[f];
    proxies.normal.insert(proxies.normal.end(), {face.nx, face.ny, face.nz});
  }
  all.push_back({flooder.queued(proxies, 1, job())});
  read();
  all.push_back({flooder.cut_to_pieces(1, job())});
  read();
  all.push_back(flooder.nearest_faces(proxies, 1));
  all.push_back({flooder.fill(proxies, 1, job())});
  read();
  return all;
}

TEST(Chaos, EveryStepEqualsThePlainBackEnds) {
  const auto plain = steps_of(*load(parallel::backend("cpu")));
  EXPECT_GT(plain[2].front(), 20) << "faces that are cut off";
  for (std::uint64_t seed = 1; seed <= seeds(20); ++seed) {
    chaos::set({.seed = seed});
    ASSERT_EQ(steps_of(*load(chaos::kernels())), plain) << "seed " << seed;
  }
}

TEST(Chaos, NoOrderOfThreadsChangesASum) {
  std::vector<float> faces;
  std::vector<std::int32_t> labels;
  std::mt19937 random(3);
  for (int i = 0; i < 3001; ++i) {
    faces.insert(faces.end(), {0.6F, 0, 0.8F, static_cast<float>(random() % 1000) / 7.0F});
    labels.push_back(static_cast<std::int32_t>(random() % 9) - 1);
  }
  const auto plain = parallel::backend("cpu").fit(faces, labels, 8, 1);
  for (std::uint64_t seed = 1; seed <= seeds(20); ++seed) {
    chaos::set({.seed = seed});
    ASSERT_EQ(chaos::kernels().fit(faces, labels, 8, 1), plain) << "seed " << seed;
  }
}

TEST(Chaos, AFailedAllocationIsAnErrorAndLeavesTheFlooderUsable) {
  for (const PartitionOptions& options : variants()) {
    chaos::set({});
    const Partition plain = run(options, *load(chaos::kernels()));
    const std::int64_t needed = chaos::count().allocations;
    ASSERT_GT(needed, 8);
    for (std::int64_t failing = 0; failing < needed; ++failing) {
      chaos::set({.seed = static_cast<std::uint64_t>(failing), .failing = failing});
      std::unique_ptr<parallel::Flooder> flooder;
      try {
        flooder = load(chaos::kernels());
        EXPECT_EQ(run(options, *flooder).face_region, plain.face_region) << "asked again, with what was free dropped";
      } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("faces on back end 'chaos' ran out of memory: "), std::string::npos)
            << e.what();
      }
      if (flooder != nullptr) {
        EXPECT_EQ(run(options, *flooder).face_region, plain.face_region) << failing;
      }
      flooder.reset();
      EXPECT_EQ(chaos::count().live, 0) << failing;
      EXPECT_EQ(chaos::count().misused, 0) << failing;
    }
  }
}

}  // namespace
}  // namespace isimp
