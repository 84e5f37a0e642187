// Partitions under constraints: barriers, cuts that end inside a region, locked regions, parts of a mesh.

#include "isimp/interact/lock.h"
#include "isimp/mesh/clean.h"
#include "isimp/mesh/part_of.h"
#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::bumpy;
using checks::edges_where;
using checks::faces_of;

Partition run(const Mesh& mesh, const PartitionOptions& options, const Constraints& constraints) {
  return Partitioner(mesh).run(options, constraints, job());
}

/// Four edges on top of a cube of 8 by 8 squares, from the middle of a side to the middle of the top.
std::vector<VertexPair> slit(const Mesh& cube) {
  return edges_where(
      cube, [](const Vec3& p) { return std::abs(p.z() - 1) < 1e-9 && std::abs(p.x() - 0.5) < 1e-9 && p.y() < 0.55; });
}

std::int64_t inside(const Mesh& mesh, const Partition& part, const std::vector<VertexPair>& edges) {
  return inside_regions(mesh, part, edges, job());
}

Partition with_locked(const Mesh& mesh, const PartitionOptions& options, int count) {
  const Partition part = partition(mesh, options, job());
  return set_locked(mesh, part, std::span(part.region_seed).first(count), kLocked);
}

std::vector<std::int32_t> upper_faces(const Mesh& mesh) {
  std::vector<std::int32_t> faces;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (mesh.vertices()[mesh.triangles()[f][0]].z() > 0.4) faces.push_back(f);
  return faces;
}

TEST(Edges, OfACubeAreEighteenAndTwelveOfThemSharp) {
  const Mesh mesh = shapes::mesh(shapes::cube());
  const InnerEdges all = inner_edges(mesh, job());
  ASSERT_EQ(all.edges.size(), 18U);  // 12, and a diagonal in each side
  EXPECT_TRUE(std::ranges::is_sorted(all.edges));
  for (std::size_t k = 0; k < all.edges.size(); ++k) {
    EXPECT_LT(all.edges[k][0], all.edges[k][1]);
    for (const std::int32_t face : {all.face[k], all.beside[k]})
      for (const std::int32_t v : all.edges[k]) EXPECT_EQ(std::ranges::count(mesh.triangles()[face], v), 1);
    EXPECT_NE(all.face[k], all.beside[k]);
  }
  EXPECT_EQ(sharp_edges(mesh, std::numbers::pi / 4, job()).size(), 12U);
  EXPECT_EQ(sharp_edges(mesh, 1.6, job()).size(), 0U);
  EXPECT_EQ(message_of([&] { (void)sharp_edges(mesh, -1, job()); }), "angle must be in [0, pi], got -1");
  EXPECT_EQ(message_of([&] { (void)sharp_edges(mesh, NAN, job()); }), "angle must be in [0, pi], got nan");
}

TEST(Edges, ThatWereMarkedAreFoundAgainInAPartOfTheMesh) {
  const Mesh& mesh = bumpy();
  const std::vector<std::int32_t> faces = upper_faces(mesh);
  const Mesh part = part_of(mesh, faces, job());
  ASSERT_EQ(part.face_count(), static_cast<std::int32_t>(faces.size()));
  const InnerEdges all = inner_edges(mesh, job());
  std::vector<VertexPair> marked{{-1, 3}, {0, 1 << 30}};  // no edges
  std::size_t wanted = 0;
  const std::set<std::int32_t> chosen(faces.begin(), faces.end());
  for (std::size_t k = 0; k < all.edges.size(); k += 3) {
    marked.push_back({all.edges[k][1], all.edges[k][0]});
    wanted += chosen.contains(all.face[k]) && chosen.contains(all.beside[k]) ? 1 : 0;
  }
  const std::vector<VertexPair> found = marked_edges(part, marked, job());
  EXPECT_EQ(found.size(), wanted);
  const std::set<VertexPair> given(marked.begin(), marked.end());
  for (const auto& [a, b] : found) {
    const std::int32_t u = part.source_vertex()[a], v = part.source_vertex()[b];
    EXPECT_TRUE(given.contains({std::max(u, v), std::min(u, v)}));
  }
}

TEST(Constraints, ACutThatEndsInsideASideOfACubeSplitsIt) {
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  const std::vector<VertexPair> edges = slit(mesh);
  ASSERT_EQ(edges.size(), 4U);
  for (const Method method :
       {Method::hierarchy, Method::lloyd, Method::teleport, Method::naive, Method::queued, Method::hybrid}) {
    const PartitionOptions options{.proxies = 6, .method = method};
    const Partition barred = run(mesh, options, {.guides = {{}, edges}});
    EXPECT_EQ(barred.region_count(), 6);
    EXPECT_EQ(inside(mesh, barred, edges), 4) << "nothing goes on from the end of a mere barrier";
    const Partition cut = run(mesh, options, {.cuts = edges});
    EXPECT_EQ(cut.region_count(), 7);
    EXPECT_EQ(inside(mesh, cut, edges), 0);
    checks::expect_sound_regions(mesh, cut);
  }
}

// The two halves of the top of a cube, by the border that continues from the end of the cut half-way between its sides.
TEST(Constraints, ACutContinuesHalfWayBetweenItsSides) {
  const Mesh mesh = shapes::mesh(shapes::cube(8));
  const Partition cut = run(mesh, {.proxies = 6}, {.cuts = slit(mesh)});
  std::set<std::int32_t> top;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (std::ranges::all_of(mesh.triangles()[f], [&](std::int32_t v) { return mesh.vertices()[v].z() > 1 - 1e-9; }))
      top.insert(cut.face_region[f]);
  ASSERT_EQ(top.size(), 2U);
  for (const std::int32_t region : top) EXPECT_NEAR(static_cast<double>(faces_of(cut, region).size()), 64, 16);
}

TEST(Constraints, NoRegionIsOnBothSidesOfACutHoweverTheyBranch) {
  const Mesh& mesh = bumpy();
  const std::vector<VertexPair> all = inner_edges(mesh, job()).edges;
  Partition part;
  for (const std::size_t step : {97, 13, 3, 1}) {
    std::vector<VertexPair> cuts;
    for (std::size_t k = 0; k < all.size(); k += step) cuts.push_back(all[k]);
    part = run(mesh, {.proxies = 5}, {.cuts = cuts});
    EXPECT_EQ(inside(mesh, part, cuts), 0) << "one edge of " << step;
    checks::expect_sound_regions(mesh, part);
  }
  EXPECT_EQ(part.region_count(), mesh.face_count());
}

TEST(Constraints, LockedRegionsStayToTheFace) {
  const Mesh& mesh = bumpy();
  const Partition before = with_locked(mesh, {.proxies = 30}, 2);
  for (const Method method :
       {Method::hierarchy, Method::lloyd, Method::teleport, Method::naive, Method::queued, Method::hybrid})
    for (const PartitionOptions& options :
         {PartitionOptions{.proxies = 45, .method = method}, PartitionOptions{.detail = 0.02, .method = method}}) {
      const Partition part = run(mesh, options, {.before = &before});
      checks::expect_sound_regions(mesh, part);
      ASSERT_EQ(part.region_locked.size(), part.region_seed.size());
      EXPECT_EQ(std::ranges::count(part.region_locked, 1), 2);
      for (const std::int32_t region : {0, 1}) {
        const std::int32_t now = part.face_region[before.region_seed[region]];
        EXPECT_EQ(faces_of(part, now), faces_of(before, region));
        EXPECT_EQ(part.region_locked[now], 1);
      }
      EXPECT_TRUE(!options.proxies || part.region_count() == 45) << part.region_count();
    }
}

TEST(Constraints, OnlyChosenFacesGetNewRegions) {
  const Mesh& mesh = bumpy();
  const Partition before = with_locked(mesh, {.proxies = 30}, 1);
  const std::vector<std::int32_t> faces = upper_faces(mesh);
  const Partition part = run(mesh, {.proxies = 25}, {.faces = faces, .before = &before});
  checks::expect_sound_regions(mesh, part);
  std::vector<bool> open(before.face_region.size(), false);
  for (const std::int32_t f : faces) open[f] = before.region_locked[before.face_region[f]] == 0;
  std::set<std::int32_t> fresh;
  std::set<std::pair<std::int32_t, std::int32_t>> kept;  // new and old numbers
  for (std::size_t f = 0; f < open.size(); ++f) {
    if (open[f])
      fresh.insert(part.face_region[f]);
    else
      kept.emplace(part.face_region[f], before.face_region[f]);
  }
  EXPECT_EQ(fresh.size(), 25U);
  std::set<std::int32_t> news;
  for (const auto& [now, was] : kept) {
    EXPECT_TRUE(news.insert(now).second) << "region " << now << " was more than one";
    EXPECT_FALSE(fresh.contains(now));
  }
  const Partition alone = run(mesh, {.proxies = 25}, {.faces = faces});
  EXPECT_EQ(alone.region_count(), 25);
  EXPECT_EQ(faces_of(alone, kNone).size(), mesh.face_count() - faces.size());
}

TEST(Constraints, WeightsAndBarriersHoldInAPartToo) {
  const Mesh& mesh = bumpy();
  const std::vector<std::int32_t> faces = upper_faces(mesh);
  const auto is_left = [&](std::int32_t f) { return mesh.vertices()[mesh.triangles()[f][0]].y() > 0; };
  const InnerEdges all = inner_edges(mesh, job());
  std::vector<VertexPair> barriers;  // between the left and the right
  for (std::size_t k = 0; k < all.edges.size(); ++k)
    if (is_left(all.face[k]) != is_left(all.beside[k])) barriers.push_back(all.edges[k]);
  std::vector<std::size_t> counts;
  for (const double weight : {1.0, 16.0}) {
    Constraints constraints{.guides = {{}, barriers}, .faces = faces};
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      constraints.guides.weights.push_back(is_left(f) ? weight : 1.0);
    const Partition part = run(mesh, {.proxies = 100}, constraints);
    EXPECT_EQ(inside(mesh, part, barriers), 0);
    std::set<std::int32_t> left;
    for (const std::int32_t f : faces)
      if (is_left(f)) left.insert(part.face_region[f]);
    counts.push_back(left.size());
  }
  EXPECT_GT(counts[1], counts[0] + 10);
}

TEST(Constraints, SpecksAreLeftOutNextToLockedRegionsAsWithoutThem) {
  const Mesh mesh = checks::cube_and_speck();
  const Partition base = partition(mesh, {.proxies = 6}, job());
  ASSERT_EQ(base.parts_left_out, 1);
  const Partition before = set_locked(mesh, base, std::span(base.region_seed).first(1), kLocked);
  const Partition part = run(mesh, {.proxies = 6}, {.before = &before});
  EXPECT_EQ(part.region_count(), 6);
  EXPECT_EQ(faces_of(part, kNone), faces_of(base, kNone));
  EXPECT_EQ(run(mesh, {.proxies = 12, .leave_out = 0}, {.before = &before}).region_count(), 12);
}

TEST(Constraints, ANumberDoesNotCountRegionsThatAreLeftOut) {
  const Mesh& mesh = bumpy();
  const Partition base = partition(mesh, {.proxies = 20}, job());
  const Partition before = set_locked(mesh, base, std::span(base.region_seed).first(2), kLeftOut);
  const Partition part = run(mesh, {.proxies = 30}, {.before = &before});
  EXPECT_EQ(part.region_count(), 32);
  EXPECT_EQ(std::ranges::count(part.region_locked, kLeftOut), 2);
}

/// Constraints of every kind together.
Constraints all_kinds(const Mesh& mesh, const Partition& before) {
  Constraints constraints{.before = &before};
  for (const Triangle& t : mesh.triangles())
    constraints.guides.weights.push_back(1 + std::abs(mesh.vertices()[t[0]].y()));
  constraints.guides.barriers = edges_where(mesh, [](const Vec3& p) { return p.z() > 0.9; });
  constraints.cuts = edges_where(mesh, [](const Vec3& p) { return p.z() < -0.9; });
  constraints.faces = upper_faces(mesh);
  return constraints;
}

void expect_same(const Partition& a, const Partition& b) {
  EXPECT_EQ(a.face_region, b.face_region);
  EXPECT_EQ(a.region_seed, b.region_seed);
  EXPECT_EQ(a.region_locked, b.region_locked);
  EXPECT_EQ(a.error, b.error);
}

TEST(ConstraintsThreads, TheResultDoesNotDependOnThem) {
  const Mesh& mesh = bumpy();
  const Partition before = with_locked(mesh, {.proxies = 30}, 3);
  Constraints constraints = all_kinds(mesh, before);
  for (const bool only_some : {true, false}) {
    if (!only_some) constraints.faces.reset();
    const Partition one = run(mesh, {.proxies = 40, .threads = 1}, constraints);
    for (const std::int32_t threads : {2, 3})
      expect_same(run(mesh, {.proxies = 40, .threads = threads}, constraints), one);
  }
}

TEST(Constraints, KeptDataOfAPartChangesNothing) {
  const Mesh& mesh = bumpy();
  const Partitioner kept(mesh);
  const Partition before = with_locked(mesh, {.proxies = 30}, 3);
  Constraints constraints = all_kinds(mesh, before);
  for (const bool only_some : {true, false, true}) {
    constraints.faces = only_some ? std::optional(upper_faces(mesh)) : std::nullopt;
    for (const std::int32_t proxies : {30, 50}) {
      const Partition fresh = run(mesh, {.proxies = proxies}, constraints);
      expect_same(kept.run({.proxies = proxies}, constraints, job()), fresh);
    }
  }
}

TEST(Constraints, APartIsCutOffOnce) {
  const Mesh& mesh = bumpy();
  const Partitioner kept(mesh);
  const auto polls = [&](const std::vector<std::int32_t>& faces) {
    Counting counting;
    (void)kept.run({.proxies = 30, .threads = 1}, {.faces = faces}, counting.job);
    return counting.polls.load();
  };
  const std::vector<std::int32_t> faces = upper_faces(mesh);
  const std::int64_t first = polls(faces), again = polls(faces);
  EXPECT_LT(again, first);
  (void)polls({faces.begin(), faces.begin() + 300});
  EXPECT_EQ(polls(faces), first) << "the last one is kept";
}

TEST(Constraints, BadOnesAreNamed) {
  const Mesh& mesh = bumpy();
  const std::int32_t count = mesh.face_count();
  const std::string all = std::to_string(count);
  const Mesh other = shapes::mesh(shapes::cube());
  const Partition before = with_locked(mesh, {.proxies = 4}, 4), some = with_locked(mesh, {.proxies = 4}, 1);
  const Partition foreign = partition(other, {.proxies = 6}, job());
  const auto said = [&](const Constraints& constraints, PartitionOptions options = {.proxies = 9}) {
    return message_of([&] { (void)run(mesh, options, constraints); });
  };
  using Faces = std::vector<std::int32_t>;
  EXPECT_EQ(said({.faces = Faces{3, 9999}}), "faces must be in [0, " + all + "), got 9999");
  EXPECT_EQ(said({.faces = Faces{3, -1}}), "faces must be in [0, " + all + "), got -1");
  EXPECT_EQ(said({.faces = Faces{}}), "no face is given");
  EXPECT_EQ(said({.before = &before}), "all faces that would be split are locked");
  EXPECT_EQ(said({.before = &foreign}),
            "the partition has 12 faces and the mesh has " + all + ": it was made for another mesh");
  EXPECT_EQ(said({.guides = {{1, 2}, {}}, .before = &some}),
            "there are 2 weights, but the mesh has " + all + " faces: give one for each");
  EXPECT_EQ(said({.cuts = {{0, 0}}, .before = &some}),
            "barrier 0 runs between vertices 0 and 0, but there is no such edge in the mesh");
  EXPECT_EQ(said({.before = &some}, {.proxies = 0}), "proxies must be in [1, " + all + "], got 0");
  EXPECT_EQ(message_of([&] { (void)part_of(mesh, Faces{count}, job()); }),
            "faces must be in [0, " + all + "), got " + all);
  EXPECT_EQ(message_of([&] { (void)inside(mesh, foreign, {}); }),
            "the partition has 12 faces and the mesh has " + all + ": it was made for another mesh");
}

}  // namespace
}  // namespace isimp
