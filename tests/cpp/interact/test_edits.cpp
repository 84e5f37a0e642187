#include "isimp/interact/heuristics.h"
#include "isimp/interact/interact.h"
#include "isimp/interact/lock.h"
#include "isimp/interact/merge.h"
#include "isimp/interact/paint.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using checks::expect_sound;
using checks::faces_of;
using checks::run;
using shapes::middle;
using Faces = std::vector<std::int32_t>;

const Mesh& ball() {
  static const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.002, 1));
  return mesh;
}

/// Faces within some edges of a face.
Faces disc(const Mesh& mesh, std::int32_t face, int edges) {
  Faces faces{face};
  std::set<std::int32_t> seen{face};
  for (std::size_t k = 0, ring_end = 1; edges > 0 && k < faces.size(); ++k) {
    for (std::int32_t h = 3 * faces[k]; h < 3 * faces[k] + 3; ++h)
      if (mesh.opposite(h) != kNone && seen.insert(mesh.opposite(h) / 3).second) faces.push_back(mesh.opposite(h) / 3);
    if (k + 1 == ring_end) {
      ring_end = faces.size();
      --edges;
    }
  }
  return faces;
}

/// Regions as sets of faces, for any numbering.
std::set<Faces> sets_of(const Partition& p) {
  std::set<Faces> sets;
  for (std::int32_t r = 0; r < p.region_count(); ++r) sets.insert(faces_of(p, r));
  return sets;
}

/// The number of earlier regions that have not changed.
std::int32_t kept(const Partition& before, const Partition& after) {
  const std::set<Faces> old = sets_of(before);
  std::int32_t count = 0;
  for (const Faces& faces : sets_of(after)) count += old.contains(faces) ? 1 : 0;
  return count;
}

std::pair<std::int32_t, std::int32_t> some_neighbours(const Mesh& mesh, const Partition& p, std::int32_t from) {
  for (std::int32_t h = 3 * from; h < 3 * mesh.face_count(); ++h)
    if (mesh.opposite(h) != kNone && p.face_region[h / 3] != p.face_region[mesh.opposite(h) / 3])
      return {h / 3, mesh.opposite(h) / 3};
  return {kNone, kNone};
}

TEST(Merge, JoinsTwoNeighboursAndLeavesTheRest) {
  const Partition before = run(ball(), 40);
  for (std::int32_t from = 0; from < ball().face_count(); from += 499) {
    const auto [a, b] = some_neighbours(ball(), before, from);
    const Partition after = merge_regions(ball(), before, a, b, job());
    expect_sound(ball(), after, 39);
    EXPECT_EQ(kept(before, after), 38);
    EXPECT_EQ(after.face_region[a], after.face_region[b]);
    const std::int32_t own = before.face_region[a], gone = before.face_region[b];
    EXPECT_EQ(after.face_region[a], own - (gone < own ? 1 : 0));
  }
}

TEST(Merge, RefusesRegionsThatAreNoNeighbours) {
  const Mesh mesh = shapes::mesh(shapes::cube(4));
  const Partition six = run(mesh, 6);
  std::int32_t across = 0;  // on the side opposite to that of face 0
  while (six.region_normal[six.face_region[across]].dot(six.region_normal[six.face_region[0]]) > -0.5) ++across;
  EXPECT_EQ(message_of([&] { merge_regions(mesh, six, 0, across, job()); }),
            "the regions of faces 0 and " + std::to_string(across) + " share no edge: only neighbours can be merged");
  EXPECT_EQ(message_of([&] { merge_regions(mesh, six, 0, 1, job()); }),
            "faces 0 and 1 are in one region: there is nothing to merge");
}

TEST(Split, ChangesNoOtherRegionAndLowersTheError) {
  const Partition before = run(ball(), 40);
  for (std::int32_t face = 0; face < ball().face_count(); face += 499) {
    const Partition after = split_region(ball(), before, face, job());
    expect_sound(ball(), after, 41);
    EXPECT_EQ(kept(before, after), 39);
    EXPECT_EQ(after.face_region[face], before.face_region[face]);
    EXPECT_LT(after.error, before.error);
    for (const std::int32_t r : {before.face_region[face], 40})
      EXPECT_GT(after.region_sum[r].faces, before.region_sum[before.face_region[face]].faces / 5);
  }
}

TEST(SplitAlong, CutsAFlatSideWhereTheLineIs) {
  const Mesh mesh = shapes::mesh(shapes::plane(10));
  const Partition one = run(mesh, 1);
  const std::vector<Vec3> line{{0.3, 0.4, 0}, {0.3, 0.6, 0}};  // extended to both sides of the square
  const Partition two = split_along(mesh, one, 199, line, Vec3::Zero(), job());
  expect_sound(mesh, two);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    EXPECT_EQ(two.face_region[f] == two.face_region[199], middle(mesh, f).x() > 0.3) << f;
  EXPECT_EQ(two.face_region[199], 0);
}

TEST(SplitAlong, FollowsABentLineSeenAlongADirection) {
  const Mesh mesh = shapes::mesh(shapes::plane(10));
  const Partition one = run(mesh, 1);
  const Vec3 sight(0.3, -0.2, -1);  // the line lies on a screen above the square
  std::vector<Vec3> line{{0.5, 0, 0}, {0.5, 0.5, 0}, {1, 0.5, 0}};
  for (Vec3& p : line) p -= 2 * sight;
  const Partition two = split_along(mesh, one, 0, line, sight, job());
  expect_sound(mesh, two);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3 at = middle(mesh, f);
    EXPECT_EQ(two.face_region[f] == 1, at.x() > 0.5 && at.y() < 0.5) << f;
  }
}

TEST(SplitAlong, MakesTwoConnectedPartsOfManyPieces) {
  const Mesh mesh = shapes::mesh(shapes::torus(60, 24));
  const Partition one = partition(mesh, {.proxies = 1, .leave_out = 0}, job());
  const auto [a, b] = some_neighbours(mesh, one, 0);
  Partition whole = one;  // a closed surface has four regions at least
  while (whole.region_count() > 1) {
    const auto pair = some_neighbours(mesh, whole, 0);
    whole = merge_regions(mesh, whole, pair.first, pair.second, job());
  }
  ASSERT_NE(a, b);
  const std::vector<Vec3> line{{-2, 0.6, 0}, {2, 0.6, 0}};  // through both arms of the ring
  const Partition two = split_along(mesh, whole, 0, line, {0, 0, 1}, job());
  expect_sound(mesh, two, 2);
}

TEST(SplitAlong, NamesTheFaultOfTheLine) {
  const Mesh mesh = shapes::mesh(shapes::plane(4));
  const Partition one = run(mesh, 1);
  const auto message = [&](std::vector<Vec3> line, Vec3 direction) {
    return message_of([&] { split_along(mesh, one, 3, line, direction, job()); });
  };
  const Vec3 none = Vec3::Zero();
  EXPECT_EQ(message({{0, 0, 0}}, none), "a line to cut along needs at least 2 points, got 1");
  EXPECT_EQ(message({{2, 0, 0}, {2, 1, 0}}, none),
            "the line does not cut the region of face 3: all of it lies on one side");
  EXPECT_EQ(message({{0.5, 0, 0}, {0.5, 0, 1}}, none),
            "the line to cut along is a point when seen along its direction");
  EXPECT_EQ(message({{0.5, 0, 0}, {0.5, NAN, 1}}, none), "point 1 of the line is not finite");
}

TEST(Paint, MakesTheFacesARegion) {
  const Partition before = run(ball(), 40);
  for (std::int32_t face = 0; face < ball().face_count(); face += 499) {
    Faces stroke = disc(ball(), face, 6);
    const Partition after = paint_faces(ball(), before, stroke, kNone, job());
    expect_sound(ball(), after);
    for (const std::int32_t f : stroke) EXPECT_EQ(after.face_region[f], after.face_region[face]);
    EXPECT_EQ(after.face_region[face], after.region_count() - 1);
    std::sort(stroke.begin(), stroke.end());
    EXPECT_GE(after.region_sum.back().faces, static_cast<std::int32_t>(stroke.size()));
  }
}

TEST(Paint, PassesPiecesThatAreCutOffToNeighboursAndTakesWholeRegions) {
  const Mesh mesh = shapes::mesh(shapes::plane(10));
  const Partition one = run(mesh, 1);
  Faces bar, rest;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const double x = middle(mesh, f).x();
    (x > 0.3 && x < 0.4 ? bar : rest).push_back(f);
  }
  // The bar cuts a side into three tenths and six tenths; the smaller part joins the bar, its only neighbour.
  const Partition two = paint_faces(mesh, one, bar, kNone, job());
  expect_sound(mesh, two);
  ASSERT_EQ(two.region_count(), 2);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) EXPECT_EQ(two.face_region[f] == 0, middle(mesh, f).x() > 0.4);
  const Partition again = paint_faces(mesh, two, faces_of(two, 0), bar.front(), job());
  expect_sound(mesh, again, 1);
}

TEST(Paint, OntoARegionGrowsIt) {
  const Partition before = run(ball(), 40);
  const auto [a, b] = some_neighbours(ball(), before, 700);
  const Faces stroke = disc(ball(), b, 3);
  const Partition after = paint_faces(ball(), before, stroke, a, job());
  expect_sound(ball(), after, 40);
  for (const std::int32_t f : stroke) EXPECT_EQ(after.face_region[f], before.face_region[a]);
}

TEST(Paint, NamesAFaceThatIsNotConnected) {
  const Mesh mesh = shapes::mesh(shapes::plane(10));
  const Partition p = run(mesh, 4);
  std::int32_t far = 0;
  while (p.face_region[far] == p.face_region[199] || p.face_region[far] == p.face_region[0]) ++far;
  EXPECT_EQ(message_of([&] {
              paint_faces(mesh, p, Faces{0, 199}, kNone, job());
            }),
            "the faces to paint do not hang together: face 199 is joined by no edge to face 0");
  EXPECT_EQ(message_of([&] { paint_faces(mesh, p, faces_of(p, p.face_region[0]), 0, job()); }),
            "there is nothing to paint: no face was given that is not locked or of the region already");
  EXPECT_EQ(message_of([&] { paint_faces(mesh, p, Faces{}, kNone, job()); }),
            "there is nothing to paint: no face was given that is not locked or of the region already");
  EXPECT_EQ(message_of([&] { paint_faces(mesh, p, Faces{200}, kNone, job()); }), "face must be in [0, 200), got 200");
}

TEST(Erase, AddsFacesToTheNeighbours) {
  const Partition before = run(ball(), 40);
  const auto [a, b] = some_neighbours(ball(), before, 700);
  const Faces stroke = disc(ball(), a, 2);
  const Partition after = erase_faces(ball(), before, stroke, job());
  expect_sound(ball(), after, 40);
  for (const std::int32_t f : stroke) {
    EXPECT_NE(after.face_region[f], before.face_region[a]);
    if (before.face_region[f] != before.face_region[a]) {
      EXPECT_EQ(after.face_region[f], before.face_region[f]);
    }
  }
  const Partition gone = erase_faces(ball(), before, faces_of(before, before.face_region[a]), job());
  expect_sound(ball(), gone, 39);
  EXPECT_EQ(message_of([&] { erase_faces(ball(), run(ball(), 4), Faces{run(ball(), 4).region_seed[0]}, job()); }),
            "the faces to erase touch no other region that could take them");
}

TEST(Grow, AndShrinkMoveTheBorderByRings) {
  const Partition before = run(ball(), 40);
  for (std::int32_t face = 0; face < ball().face_count(); face += 499) {
    const std::int32_t r = before.face_region[face];
    const Partition more = grow_region(ball(), before, face, 1, job());
    expect_sound(ball(), more);
    EXPECT_GT(more.region_sum[r].faces, before.region_sum[r].faces);
    const Partition less = shrink_region(ball(), before, before.region_seed[r], 1, job());
    expect_sound(ball(), less);
    EXPECT_LT(less.region_sum[r].faces, before.region_sum[r].faces);
    EXPECT_EQ(less.region_count(), 40);
  }
  EXPECT_EQ(message_of([&] { shrink_region(ball(), before, 0, 100, job()); }),
            "the region of face 0 would vanish: delete it instead");
  EXPECT_EQ(message_of([&] { grow_region(ball(), before, 0, 0, job()); }), "rings must be at least 1, got 0");
}

TEST(Lock, KeepsFacesThroughEveryEdit) {
  Partition p = run(ball(), 40);
  const Faces seeds{p.region_seed[3], p.region_seed[17]};
  p = set_locked(ball(), p, seeds, kLocked);
  const std::set<Faces> locked{faces_of(p, 3), faces_of(p, 17)};
  const auto expect_kept = [&](const Partition& after) {
    expect_sound(ball(), after);
    const std::set<Faces> now = sets_of(after);
    for (const Faces& faces : locked) EXPECT_TRUE(now.contains(faces));
    ASSERT_EQ(after.region_locked.size(), after.region_sum.size());
    EXPECT_EQ(std::accumulate(after.region_locked.begin(), after.region_locked.end(), 0), 2);
    for (const std::int32_t seed : seeds) EXPECT_EQ(after.region_locked[after.face_region[seed]], 1);
  };
  for (std::int32_t f = 0; f < ball().face_count(); f += 97) {
    if (p.region_locked[p.face_region[f]] != 0) {
      EXPECT_EQ(message_of([&] { add_proxy(ball(), p, f, job()); }),
                "the region of face " + std::to_string(f) + " is locked: unlock it first");
      continue;
    }
    expect_kept(add_proxy(ball(), p, f, job()));
    expect_kept(delete_proxy(ball(), p, f, job()));
    expect_kept(split_region(ball(), p, f, job()));
    expect_kept(grow_region(ball(), p, f, 3, job()));
    expect_kept(shrink_region(ball(), p, p.region_seed[p.face_region[f]], 1, job()));
    expect_kept(paint_faces(ball(), p, disc(ball(), f, 2), kNone, job()));
  }
  expect_kept(improve(ball(), p, job()));
  expect_kept(add_worst(ball(), p, 10, job()));
  expect_kept(delete_least(ball(), p, 10, job()));
  expect_kept(merge_cheapest(ball(), p, 10, job()));
  EXPECT_TRUE(set_locked(ball(), p, seeds, 0).region_locked.empty());
  const Partition grown = paint_faces(ball(), p, disc(ball(), seeds[0], 12), seeds[0], job());  // onto it is allowed
  EXPECT_EQ(grown.region_locked[grown.face_region[seeds[0]]], 1);
  EXPECT_GT(grown.region_sum[grown.face_region[seeds[0]]].faces, p.region_sum[3].faces);
}

TEST(Lock, OfALeftOutRegionKeepsItLeftOut) {
  const Partition p = run(ball(), 40);
  const Faces seed{p.region_seed[3]}, other{p.region_seed[7]};
  const Partition out = set_locked(ball(), p, seed, kLeftOut);
  EXPECT_TRUE(out.is_left_out(3));
  EXPECT_TRUE(set_locked(ball(), out, seed, kLocked).is_left_out(3));
  EXPECT_EQ(set_locked(ball(), set_locked(ball(), out, other, kLocked), seed, 0).region_locked[7], kLocked);
  EXPECT_EQ(message_of([&] { set_locked(ball(), p, {}, kLeftOut); }),
            "there is no face: name one of each region to leave out");
  EXPECT_EQ(message_of([&] { add_proxy(ball(), out, seed[0], job()); }),
            "the region of face " + std::to_string(seed[0]) + " is locked: unlock it first");
}

TEST(Heuristics, AddAtTheWorstAndDeleteTheLeast) {
  const Partition before = run(ball(), 40);
  const Partition more = add_worst(ball(), before, 5, job());
  expect_sound(ball(), more, 45);
  EXPECT_LT(more.error, before.error);
  for (const Partition& less : {delete_least(ball(), more, 5, job()), merge_cheapest(ball(), more, 5, job())}) {
    expect_sound(ball(), less, 40);
    EXPECT_LT(less.error, 1.05 * before.error);
  }
}

TEST(Heuristics, AddWhereASplitPaysNotWhereNoiseIsLarge) {
  // A rough ground of 400 times the area of a cube's side has the largest error, but no split lowers it. Two sides of
  // the cube are one region.
  const shapes::Arrays ground = shapes::scaled(shapes::noisy(shapes::plane(60), 0.002, 1), 20);
  const Mesh mesh = shapes::mesh(shapes::both(ground, shapes::cube(8), {5, 5, 3}));
  constexpr std::int32_t kOfGround = 7200, kOfSide = 128;
  std::vector<std::int32_t> label(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::int32_t f = kOfGround; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.triangles()[f];
    const auto& v = mesh.vertices();
    const Vec3 n = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
    label[f] = n.x() > 0.5 || n.y() > 0.5 ? 1 : n.x() < -0.5 ? 2 : n.y() < -0.5 ? 3 : n.z() > 0.5 ? 4 : 5;
  }
  const Partition before = partition_from(mesh, label, job());
  ASSERT_GT(before.region_sum[0].error(), before.region_sum[1].error());
  const Partition after = add_worst(mesh, before, 1, job());
  std::vector<std::int32_t> faces;
  for (const RegionSum& s : after.region_sum) faces.push_back(s.faces);
  std::ranges::sort(faces);
  EXPECT_EQ(faces, (std::vector<std::int32_t>{kOfSide, kOfSide, kOfSide, kOfSide, kOfSide, kOfSide, kOfGround}));
}

TEST(Heuristics, SplitTheFirstOfEqualRegions) {
  const shapes::Arrays cube = shapes::cube(4);
  const Mesh mesh = shapes::mesh(shapes::both(cube, cube, {4, 0, 0}));
  const std::int32_t half = mesh.face_count() / 2;
  std::vector<std::int32_t> label(static_cast<std::size_t>(mesh.face_count()), 0);
  std::fill(label.begin() + half, label.end(), 1);
  const Partition after = add_worst(mesh, partition_from(mesh, label, job()), 1, job());
  ASSERT_EQ(after.region_count(), 3);
  EXPECT_EQ(after.region_sum[1].faces, half);
}

TEST(Heuristics, MergePairsWithoutCostFirst) {
  const Mesh mesh = shapes::mesh(shapes::cube(6));
  Partition p = run(mesh, 6);
  for (const std::int32_t face : {0, 100, 200}) p = split_region(mesh, p, face, job());
  ASSERT_EQ(p.region_count(), 9);
  EXPECT_NEAR(merge_cheapest(mesh, p, 3, job()).error, 0.0, 1e-9);
  EXPECT_NEAR(delete_least(mesh, p, 3, job()).error, 0.0, 1e-9);
  EXPECT_GT(merge_cheapest(mesh, p, 4, job()).error, 0.1);
  EXPECT_EQ(message_of([&] { merge_cheapest(mesh, p, 9, job()); }),
            "only 8 of 9 can be done: no region is left that could be merged");
  EXPECT_EQ(message_of([&] { add_worst(mesh, p, 0, job()); }), "times must be at least 1, got 0");
}

TEST(Heuristics, ImproveNeverMakesItWorse) {
  Partition p = partition(ball(), {.proxies = 40, .iterations = 1, .method = Method::lloyd}, job());
  const Partition better = improve(ball(), p, job());
  expect_sound(ball(), better, 40);
  EXPECT_LT(better.error, 0.9 * p.error);
  EXPECT_LE(improve(ball(), better, job()).error, better.error);
}

/// The number of edges of the mesh between regions.
std::int64_t border_edges(const Mesh& mesh, const Partition& p) {
  std::int64_t edges = 0;
  for (std::int32_t h = 0; h < 3 * mesh.face_count(); ++h)
    if (const std::int32_t o = mesh.opposite(h); o != kNone && o < h)
      edges += static_cast<int>(p.face_region[h / 3] != p.face_region[o / 3]);
  return edges;
}

TEST(EvenBorders, StraightensAToothedBorderOnAFlatSideAndLeavesCreases) {
  const Mesh mesh = shapes::mesh(shapes::cube(12));
  const Partition sides = run(mesh, 6);
  EXPECT_EQ(even_borders(mesh, sides, 1.0, job()).face_region, sides.face_region);
  Faces half;  // half of the top: its border oscillates by two squares
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3 at = middle(mesh, f);
    const int row = static_cast<int>(12 * at.y());
    if (at.z() > 1 - 1e-9 && 12 * at.x() < (row % 2 == 0 ? 5 : 7)) half.push_back(f);
  }
  const Partition toothed = paint_faces(mesh, sides, half, kNone, job());
  const Partition even = even_borders(mesh, toothed, 1.0, job());
  expect_sound(mesh, even, 7);
  EXPECT_EQ(border_edges(mesh, toothed) - border_edges(mesh, sides), 12 + 11 * 2);
  EXPECT_LE(border_edges(mesh, even) - border_edges(mesh, sides), 12 + 3);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    EXPECT_TRUE(middle(mesh, f).z() > 1 - 1e-9 || even.face_region[f] == sides.face_region[f]) << f;
  const Partition locked = set_locked(mesh, toothed, Faces{half[0]}, kLocked);
  EXPECT_EQ(even_borders(mesh, locked, 1.0, job()).face_region, toothed.face_region);
}

TEST(EvenBorders, ShortensThemMoreWithMoreStrength) {
  const Partition p = partition(ball(), {.proxies = 40, .iterations = 1, .method = Method::lloyd}, job());
  const Partition half = even_borders(ball(), p, 0.3, job()), even = even_borders(ball(), p, 1.0, job());
  expect_sound(ball(), even, 40);
  EXPECT_LT(border_edges(ball(), half), border_edges(ball(), p));
  EXPECT_LT(border_edges(ball(), even), border_edges(ball(), half));
  EXPECT_EQ(even_borders(ball(), even, 1.0, job()).region_count(), 40);
  EXPECT_EQ(message_of([&] { even_borders(ball(), p, 1.5, job()); }), "strength must be in [0, 1], got 1.500000");
}

}  // namespace
}  // namespace isimp
