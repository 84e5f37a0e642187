// The methods of the paper and the thesis by their interface: all of them where they are built, a clear error where not.

#include "isimp/simplify/partitioner.h"
#include "isimp/thesis/thesis.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::ring;

Partition thirty(const Mesh& mesh, PartitionOptions options) {
  options.proxies = 30;
  return Partitioner(mesh).run(options, {}, job());
}

TEST(Thesis, TheDefaultMethodNeedsNoneOfIt) { EXPECT_EQ(thirty(ring(), {}).region_count(), 30); }

TEST(Thesis, EveryMethodIsThereOrRefused) {
  for (const Method method : {Method::lloyd, Method::teleport, Method::naive, Method::queued, Method::hybrid}) {
    const PartitionOptions options{.method = method};
    if (Thesis::is_built()) {
      EXPECT_EQ(thirty(ring(), options).region_count(), 30);
    } else {
      EXPECT_EQ(message_of([&] { thirty(ring(), options); }),
                "method hierarchy is the only one in this build, which was made with ISIMP_THESIS=OFF");
    }
  }
}

TEST(Thesis, TeleportsLowerTheErrorOfTheFlooding) {
  if (!Thesis::is_built()) GTEST_SKIP() << "made with ISIMP_THESIS=OFF";
  EXPECT_LT(thirty(ring(), {.method = Method::teleport}).error, thirty(ring(), {.method = Method::lloyd}).error);
}

TEST(Thesis, ABackEndThatIsNotHereIsRefused) {
  const std::string message = message_of([] { thirty(ring(), {.backend = "abacus"}); });
  EXPECT_NE(message.find("abacus"), std::string::npos) << message;
  EXPECT_EQ(backends().front(), "cpu");
  EXPECT_TRUE(Thesis::is_built() || backends().size() == 1);
}

/// Data kept for one surface must not serve another one.
TEST(Thesis, ADecimatedMeshServesItsOwnSurface) {
  const Partitioner kept(ring());
  const PartitionOptions options{.proxies = 30, .method = Method::hybrid};
  if (!Thesis::is_built()) GTEST_SKIP() << "made with ISIMP_THESIS=OFF";
  Constraints heavy;
  for (std::int32_t f = 0; f < ring().face_count(); ++f) heavy.guides.weights.push_back(f % 7 == 0 ? 9.0 : 1.0);
  const auto plain = kept.run(options, {}, job()).face_region;
  const auto weighted = kept.run(options, heavy, job()).face_region;
  EXPECT_EQ(kept.run(options, {}, job()).face_region, plain);
  EXPECT_EQ(Partitioner(ring()).run(options, heavy, job()).face_region, weighted);
  EXPECT_NE(plain, weighted);
}

}  // namespace
}  // namespace isimp
