// The delay until long calls see a cancel, and the steps of progress, counted in polls: no clock is used.
#include <optional>

#include "hierarchy/hierarchy.h"
#include "isimp/interact/interact.h"
#include "isimp/mesh/clean.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/simplify/partitioner.h"
#include "tests.h"

namespace isimp {
namespace {

/// A torus, its partition, and the input of both.
struct Input {
  explicit Input(int n) : arrays(shapes::torus(4 * n, n)), mesh(shapes::mesh(arrays)) {
    regions = partition(mesh, {.proxies = mesh.face_count() / 400}, job());
  }
  shapes::Arrays arrays;
  Mesh mesh;
  Partition regions;
};

struct Stage {
  std::string name;
  std::function<void(const Input&, Job&)> run;
};

void PrintTo(const Stage& stage, std::ostream* out) { *out << stage.name; }

PartitionOptions counted(Method method, std::int32_t proxies, std::int32_t threads = 1) {
  PartitionOptions options;
  options.proxies = proxies;
  options.iterations = 10;
  options.method = method;
  options.threads = threads;
  return options;
}

PartitionOptions found(std::optional<double> detail, std::optional<double> bound) {
  PartitionOptions options;
  options.detail = detail;
  options.bound = bound;
  options.threads = 1;
  return options;
}

PartitionOptions adaptive(PartitionOptions options) {
  options.adaptivity = 0.25;
  return options;
}

/// A partition next to a locked region, with some edges that cut the others.
void partition_constrained(const Input& in, Job& job) {
  Job own;
  Partition before = in.regions;
  before.region_locked.assign(before.region_seed.size(), 0);
  before.region_locked[0] = 1;
  const std::vector<VertexPair> edges = inner_edges(in.mesh, own).edges;
  const Constraints constraints{.cuts = {edges.begin(), edges.begin() + 30}, .before = &before};
  (void)Partitioner(in.mesh).run(counted(Method::hierarchy, 100), constraints, job);
}

std::vector<Stage> stages_over_faces() {
  const auto by = [](const std::string& name, const PartitionOptions& o) {
    return Stage{name, [o](const Input& in, Job& job) { partition(in.mesh, o, job); }};
  };
  return {
      {"mesh", [](const Input& in, Job& job) { Mesh(in.arrays.vertices, in.arrays.triangles, job); }},
      {"clean", [](const Input& in, Job& job) { clean(in.arrays.vertices, in.arrays.triangles, {}, job); }},
      {"hierarchy", [](const Input& in, Job& job) { build_hierarchy(in.mesh, 100, job); }},
      by("default", counted(Method::hierarchy, 100)),
      by("two_threads", counted(Method::hierarchy, 100, 2)),
      by("lloyd", counted(Method::lloyd, 100)),
      by("detail", found(0.05, std::nullopt)),
      by("bound", found(std::nullopt, 0.05)),
      by("adaptive", adaptive(counted(Method::hierarchy, 100))),
      by("adaptive_detail", adaptive(found(0.05, std::nullopt))),
      {"constrained", partition_constrained},
  };
}

Stage meshing() {  // polls by the region and not by the face
  return {"polygonize", [](const Input& in, Job& job) { polygonize(in.mesh, in.regions, {}, job); }};
}

class Polls : public testing::TestWithParam<Stage> {
 protected:
  static const Input& small() {
    static const Input input(84);
    return input;
  }
  static const Input& large() {
    static const Input input(126);
    return input;
  }
  static std::int64_t count(const Input& input) {
    Counting counting;
    GetParam().run(input, counting.job);
    return counting.polls;
  }
};

class PollsOfFaces : public Polls {};

// The slowest of these takes some 4 us a face on slow machines, so that 50 ms are 12,000 faces. The additional polls
// for more faces measure the loops over faces, and not the polls that every stage makes at its beginning.
TEST_P(PollsOfFaces, ComeAtLeastOnceInTwelveThousandFaces) {
  const std::int64_t more_polls = count(large()) - count(small());
  const std::int64_t more_faces = large().mesh.face_count() - small().mesh.face_count();
  EXPECT_GE(more_polls * 12'000, more_faces) << more_polls << " polls for " << more_faces << " faces";
}

// The point at which a call ends early, having found nothing more to do.
TEST_P(Polls, ShowProgressInSmallSteps) {
  Job job;
  std::atomic<double> last = 0.0, largest = 0.0;
  job.at_poll = [&] {
    const double now = job.progress();
    largest = std::max(largest.load(), now - last);
    last = now;
  };
  GetParam().run(large(), job);
  EXPECT_EQ(job.progress(), 1.0);
  EXPECT_LE(largest, 0.3 + 1e-9);
}

// Each pass over all faces takes long enough to show.
TEST(Progress, MovesWithEveryPassThatSearchesForDetails) {
  const Input input(84);
  for (const auto& [options, passes] :
       {std::pair(adaptive(counted(Method::hierarchy, 100)), 8 + 8), std::pair(found(0.05, std::nullopt), 8)}) {
    Job job;
    std::set<double> seen;
    const std::string stage = options.adaptivity > 0 ? "finding details" : "merging";
    job.at_poll = [&] {
      if (job.stage() == stage) seen.insert(job.progress());
    };
    partition(input.mesh, options, job);
    EXPECT_GE(static_cast<int>(seen.size()), passes) << stage;
  }
}

// After a cancel at any place, the only result is Cancelled.
TEST_P(Polls, EachOneCancels) {
  const std::int64_t all = count(small());
  for (std::int64_t stop = 1; stop <= all; stop += 1 + all / 20) {
    Counting counting(stop);
    EXPECT_THROW(GetParam().run(small(), counting.job), Cancelled) << "at poll " << stop << " of " << all;
  }
}

std::string name_of(const testing::TestParamInfo<Stage>& test) { return test.param.name; }

INSTANTIATE_TEST_SUITE_P(Of, PollsOfFaces, testing::ValuesIn(stages_over_faces()), name_of);
INSTANTIATE_TEST_SUITE_P(Of, Polls, testing::ValuesIn(stages_over_faces()), name_of);
INSTANTIATE_TEST_SUITE_P(OfMeshing, Polls, testing::Values(meshing()), name_of);

}  // namespace
}  // namespace isimp
