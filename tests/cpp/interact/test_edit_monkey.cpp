#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "isimp/interact/statistics.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/soundness.h"
#include "isimp/regular/regularise.h"
#include "isimp/simplify/partitioner.h"
#include "polygon_judge.h"
#include "tests.h"

/// Edits of every kind at random, one after another, on partitions of every kind. bench/monkeys/monkey.py judges the
/// changes of each; this test sees the sums of regions, and runs with sanitizers and assertions too.
namespace isimp {
namespace {

struct Act {
  const Mesh& mesh;
  const Partition& before;
  std::int32_t face, other;         ///< faces of any two regions
  std::vector<std::int32_t> faces;  ///< the face and some around it
  Vec3 by;
  std::int32_t few;
  Job& job;
};

const std::map<std::string, std::function<Partition(const Act&)>>& edits() {
  static const std::map<std::string, std::function<Partition(const Act&)>> all{
      {"add", [](const Act& a) { return add_proxy(a.mesh, a.before, a.face, a.job); }},
      {"delete", [](const Act& a) { return delete_proxy(a.mesh, a.before, a.face, a.job); }},
      {"split", [](const Act& a) { return split_region(a.mesh, a.before, a.face, a.job); }},
      {"cut",
       [](const Act& a) {
         const Vec3 at = a.mesh.vertices()[a.mesh.triangles()[a.face][0]] + a.mesh.origin();
         return split_along(a.mesh, a.before, a.face, std::vector<Vec3>{at - a.by, at + a.by}, Vec3::Zero(), a.job);
       }},
      {"merge", [](const Act& a) { return merge_regions(a.mesh, a.before, a.face, a.other, a.job); }},
      {"paint", [](const Act& a) { return paint_faces(a.mesh, a.before, a.faces, kNone, a.job); }},
      {"paint onto", [](const Act& a) { return paint_faces(a.mesh, a.before, a.faces, a.other, a.job); }},
      {"erase", [](const Act& a) { return erase_faces(a.mesh, a.before, a.faces, a.job); }},
      {"grow", [](const Act& a) { return grow_region(a.mesh, a.before, a.face, a.few, a.job); }},
      {"shrink", [](const Act& a) { return shrink_region(a.mesh, a.before, a.face, a.few, a.job); }},
      {"lock", [](const Act& a) { return set_locked(a.mesh, a.before, std::vector{a.face}, kLocked); }},
      {"leave out", [](const Act& a) { return set_locked(a.mesh, a.before, std::vector{a.face}, kLeftOut); }},
      {"unlock", [](const Act& a) { return set_locked(a.mesh, a.before, a.faces, 0); }},
      {"worst", [](const Act& a) { return add_worst(a.mesh, a.before, a.few, a.job); }},
      {"least", [](const Act& a) { return delete_least(a.mesh, a.before, a.few, a.job); }},
      {"cheapest", [](const Act& a) { return merge_cheapest(a.mesh, a.before, a.few, a.job); }},
      {"improve", [](const Act& a) { return improve(a.mesh, a.before, a.job); }},
      {"even", [](const Act& a) { return even_borders(a.mesh, a.before, 0.5, a.job); }},
      {"regularise", [](const Act& a) { return regularise(a.mesh, a.before, {}, a.job); }},
  };
  return all;
}

/// A face and those around it, up to a number.
std::vector<std::int32_t> blot(const Mesh& mesh, std::int32_t face, std::size_t most) {
  std::vector<std::int32_t> faces{face};
  for (std::size_t k = 0; k < faces.size() && faces.size() < most; ++k)
    for (std::int32_t h = 3 * faces[k]; h < 3 * faces[k] + 3; ++h)
      if (const std::int32_t o = mesh.opposite(h); o != kNone && std::ranges::count(faces, o / 3) == 0)
        faces.push_back(o / 3);
  return faces;
}

/// Makes edits, each on the result of the one before or on the first partition. Counts the accepted ones.
void play(const Mesh& mesh, const Partition& first, std::uint32_t seed, std::map<std::string, int>& done) {
  std::mt19937 random(seed);
  const auto below = [&](std::int32_t n) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
  Partition now = first;
  for (int k = 0; k < 60; ++k) {
    if (below(8) == 0) now = first;
    const auto& [name, edit] = *std::next(edits().begin(), below(static_cast<std::int32_t>(edits().size())));
    const std::int32_t face = below(mesh.face_count()), other = below(mesh.face_count());
    const Vec3 by = mesh.diagonal() * Vec3(0.1 * (below(3) - 1), 0.1 * (below(3) - 1), 0.05);
    Partition after;
    try {
      after = edit({mesh, now, face, other, blot(mesh, face, 1 + random() % 12), by, 1 + below(3), job()});
      (void)all_statistics(mesh, after, job());
    } catch (const InvalidInput&) {
      continue;
    }
    ASSERT_EQ(broken_promise(Surface(mesh, after.guided), after), "") << name << " at " << face << ", seed " << seed;
    ++done[name];
    now = std::move(after);
  }
  const PolygonMesh polygons = polygonize(mesh, now, {}, job());
  if (polygons.report.without_area == 0 && !polygons.report.repair_capped) {
    EXPECT_EQ(judge::defects_against(polygons, mesh, now), "") << "seed " << seed;
  }
}

TEST(EditMonkey, AnyChainOfEditsLeavesASoundPartition) {
  const shapes::Arrays all[] = {shapes::noisy(shapes::sphere(checks::size(3, 2)), 0.02, 5),
                                shapes::noisy(shapes::torus(24, 12), 0.03, 1), shapes::plane(8),
                                shapes::both(shapes::cube(4), shapes::noisy(shapes::sphere(2), 0.1, 3), {2, 0, 0})};
  std::map<std::string, int> done;
  std::uint32_t seed = 0;
  for (const shapes::Arrays& arrays : all) {
    const Mesh mesh = shapes::mesh(arrays);
    const Partitioner partitioner(mesh);
    std::vector<VertexPair> edges;
    for (std::int32_t h = 0; h < 3 * mesh.face_count(); h += 7) edges.push_back({mesh.from(h), mesh.to(h)});
    std::vector<double> weights(static_cast<std::size_t>(mesh.face_count()), 1);
    for (std::size_t f = 0; f < weights.size(); f += 3) weights[f] = f % 2 == 0 ? 0 : 50;
    const PartitionOptions plain{.detail = 0.005};
    const std::pair<PartitionOptions, Constraints> ways[] = {
        {plain, {}},
        {{.detail = 0.02, .adaptivity = 0.25, .smooth = 0.5}, {}},
        {{.proxies = 20}, {}},
        {{.proxies = 20, .method = Method::lloyd}, {}},
        {{.bound = 0.01 * mesh.diagonal()}, {}},
        {plain, {.guides = {.weights = {}, .barriers = edges}}},
        {plain, {.guides = {}, .cuts = edges}},
        {plain, {.guides = {.weights = weights, .barriers = {}}}},
    };
    for (const auto& [options, constraints] : ways) {
      play(mesh, partitioner.run(options, constraints, job()), ++seed, done);
    }
  }
  EXPECT_EQ(done.size(), edits().size()) << "an edit was never done";
}

}  // namespace
}  // namespace isimp
