// A surface's memory on a device: kept from call to call, and the errors when there is too little.

#include "isimp/parallel/backend.h"
#include "kept_flooder.h"
#include "partition_checks.h"
#include "rounds.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::ring;

std::vector<PartitionOptions> variants() {
  std::vector<PartitionOptions> all;
  for (const Method method : {Method::naive, Method::queued})
    for (const Connect connect : {Connect::repair, Connect::flood})
      all.push_back({.proxies = 80, .iterations = 4, .method = method, .connect = connect});
  return all;
}

Partition run(const PartitionOptions& options, parallel::Flooder& flooder) {
  return in_rounds(ring(), Hierarchy{}, &flooder, options, job());
}

std::unique_ptr<parallel::Flooder> load_within(const std::string& name, std::size_t most) {
  const FaceGraph& graph = ring().graph();
  const auto faces = static_cast<std::size_t>(graph.size());
  return parallel::backend(name).load(
      {{&graph.faces.data()->nx, 4 * faces}, {graph.neighbours.data()->data(), 3 * faces}}, most);
}

TEST(DeviceMemory, ASecondRunAllocatesNothing) {
  for (const std::string& name : parallel::backends()) {
    const auto flooder = load(ring(), name);
    for (const PartitionOptions& options : variants()) run(options, *flooder);
    const auto [bytes, allocations] = flooder->memory();
    EXPECT_GT(allocations, 5);
    for (const PartitionOptions& options : variants()) run(options, *flooder);
    EXPECT_EQ(flooder->memory().allocations, allocations) << name;
    EXPECT_EQ(flooder->memory().bytes, bytes) << name;
  }
}

TEST(DeviceMemory, IsWithinTheLimitOfTheHeader) {
  const std::size_t faces = ring().graph().faces.size();
  for (const std::string& name : parallel::backends())
    for (const PartitionOptions& options : variants()) {
      const auto flooder = load(ring(), name);
      run(options, *flooder);
      const std::size_t most = (name == "cpu" ? 40 : 68) + 16 + (options.method == Method::naive ? 16 : 0);
      EXPECT_LT(flooder->memory().bytes, most * faces + (1U << 16)) << name;
    }
}

TEST(DeviceMemory, TooLittleIsAnErrorWithTheAmountAndNeverAWrongResult) {
  for (const std::string& name : parallel::backends())
    for (const PartitionOptions& options : variants()) {
      const auto roomy = load(ring(), name);
      const Partition expected = run(options, *roomy);
      const std::size_t needed = roomy->memory().bytes;
      int failures = 0;
      for (std::size_t most = 0; most <= needed; most += needed / 40) {
        try {
          const auto flooder = load_within(name, most);
          EXPECT_EQ(run(options, *flooder).face_region, expected.face_region) << most;
        } catch (const Error& e) {
          ++failures;
          const std::string said = e.what();
          EXPECT_NE(said.find("ing 3600 faces on back end '" + name + "' ran out of memory: 0."), std::string::npos)
              << said;
        }
      }
      EXPECT_GT(failures, 10);
      EXPECT_EQ(run(options, *load_within(name, needed)).face_region, expected.face_region);
    }
}

TEST(DeviceMemory, AFlooderThatRanOutOfItWorksWithLess) {
  PartitionOptions much = variants().front(), little = much;
  much.proxies = 3000;
  for (const std::string& name : parallel::backends()) {
    const auto roomy = load(ring(), name);
    const Partition expected = run(little, *roomy);
    const auto flooder = load_within(name, roomy->memory().bytes);
    EXPECT_THROW(run(much, *flooder), Error) << name;
    EXPECT_EQ(run(little, *flooder).face_region, expected.face_region) << name;
    EXPECT_LE(flooder->memory().bytes, roomy->memory().bytes);
  }
}

TEST(DeviceMemory, TheCpuIsOfferedInPlaceOfADevice) {
  EXPECT_EQ(parallel::out_of_memory("cuda", "flooding", 1'000'000, 16'000'000, 68'400'000),
            "flooding 1000000 faces on back end 'cuda' ran out of memory: 16 MB more were wanted, with 68 MB held; "
            "back end 'cpu' can do the same in main memory, with the same result");
  EXPECT_EQ(parallel::out_of_memory("cpu", "filling", 12, 512, 0),
            "filling 12 faces on back end 'cpu' ran out of memory: 0.001 MB more were wanted, with 0.000 MB held");
  EXPECT_EQ(parallel::out_of_order("cuda", "fitting", 7, "an illegal address was met"),
            "fitting 7 faces on back end 'cuda' failed: an illegal address was met; back end 'cpu' can do the same in "
            "main memory, with the same result");
}

const parallel::Flooder* address(parallel::Flooder& flooder) { return &flooder; }

TEST(KeptFlooder, KeepsOneSurfaceInTheMemoryOfTheDevice) {
  const KeptFlooder kept;
  const Surface surface(ring());
  const PartitionOptions options = variants().front();
  std::int64_t allocations = 0;
  const parallel::Flooder* first = kept.with(surface, "cpu", [&](parallel::Flooder& flooder) {
    for (int k = 0; k < 2; ++k) run(options, flooder);  // the second time its queues begin as large as they became
    allocations = flooder.memory().allocations;
    return &flooder;
  });
  kept.with(surface, "cpu", [&](parallel::Flooder& flooder) {
    EXPECT_EQ(&flooder, first);
    run(options, flooder);
    EXPECT_EQ(flooder.memory().allocations, allocations);
    EXPECT_NE(kept.with(surface, "cpu", address), first) << "one at a time";
    return 0;
  });
  EXPECT_EQ(kept.with(surface, "cpu", address), first);
}

TEST(KeptFlooder, AnotherSurfaceTakesThePlaceOfTheFirst) {
  const KeptFlooder kept;
  const Mesh other = shapes::mesh(shapes::cube(4));
  const Surface guided(ring(), Guides{std::vector<double>(3600, 2.0), {}}, job());
  for (const Surface& surface : {Surface(ring()), Surface(other), guided, Surface(ring())}) {
    std::vector<std::int32_t> labels(static_cast<std::size_t>(surface.face_count()));
    const Partition fresh = partition(surface, variants().back(), job());
    const Partition result = kept.with(surface, "cpu", [&](parallel::Flooder& flooder) {
      return in_rounds(surface, Hierarchy{}, &flooder, variants().back(), job());
    });
    EXPECT_EQ(result.face_region, fresh.face_region);
    EXPECT_EQ(result.error, fresh.error);
  }
}

TEST(KeptFlooder, IsKeptWhenCancelledAndDroppedWhenSomethingFails) {
  const KeptFlooder kept;
  const Surface surface(ring());
  const auto allocations = [&] {
    return kept.with(surface, "cpu", [](parallel::Flooder& flooder) { return flooder.memory().allocations; });
  };
  const std::int64_t fresh = allocations();
  kept.with(surface, "cpu", [](parallel::Flooder& flooder) { return run(variants().front(), flooder); });
  const std::int64_t used = allocations();
  EXPECT_GT(used, fresh);
  const auto fail_with = [&](auto failure) {
    kept.with(surface, "cpu", [&](parallel::Flooder&) -> int { throw failure; });
  };
  EXPECT_THROW(fail_with(Cancelled()), Cancelled);
  EXPECT_EQ(allocations(), used);
  EXPECT_THROW(fail_with(Error("out of memory")), Error);
  EXPECT_EQ(allocations(), fresh);
}

}  // namespace
}  // namespace isimp
