#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/tiles/detail.h"
#include "isimp/tiles/merge.h"
#include "isimp/tiles/patches.h"
#include "isimp/tiles/relax.h"
#include "isimp/tiles/thin.h"
#include "isimp/tiles/weld.h"
#include "shapes.h"

namespace isimp {
namespace {

/// The side of the cube that a face is on.
std::vector<std::int32_t> sides(int n) {
  std::vector<std::int32_t> label(static_cast<std::size_t>(12 * n * n));
  for (std::size_t f = 0; f < label.size(); ++f) label[f] = static_cast<std::int32_t>(f) / (2 * n * n);
  return label;
}

Vec3 vector_area(const std::vector<Vec3>& p, const Triangle& t) {
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
}

tiles::JoinedGraph graph_of(const Mesh& mesh, std::int32_t size) {
  Job job;
  const tiles::Patches p = tiles::patches(mesh, size, 0.5, job);
  return {p.sum, p.pair, p.length};
}

TEST(TilePatches, CoverTheMeshAndTellWhatTheyShare) {
  Job job;
  const Mesh mesh = shapes::mesh(shapes::cube(12));
  const tiles::Patches p = tiles::patches(mesh, 50, 0.5, job);
  EXPECT_EQ(p.label.size(), 1728U);
  EXPECT_GE(p.sum.size(), 30U);
  double area = 0;
  std::int32_t faces = 0;
  for (const RegionSum& s : p.sum) {
    area += s.weight / 2;
    faces += s.faces;
  }
  EXPECT_NEAR(area, 6.0, 1e-5);
  EXPECT_EQ(faces, 1728);
  EXPECT_TRUE(std::is_sorted(p.pair.begin(), p.pair.end()));
  EXPECT_GE(*std::min_element(p.length.begin(), p.length.end()), 1.0 / 12 - 1e-6);
  EXPECT_THROW(tiles::patches(mesh, 0, 0.5, job), InvalidInput);
}

TEST(TileDetail, ExtentsOfPartsAddUpToTheSizeOfTheWhole) {
  Job job;
  const tiles::Extent e = tiles::measure(shapes::mesh(shapes::cube(12)), job);
  EXPECT_NEAR(e.area, 6.0, 1e-9);
  EXPECT_NEAR((e.centre - Vec3(0.5, 0.5, 0.5)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(e.spread, 0.25 + 2.0 / 12, 1e-9);  // a side's distance from the middle, and its own spread
  EXPECT_EQ(e.noise, 0.0);
}

TEST(TileDetail, ACubeHasSixRegionsAtAnyToleranceAndKeepsItsNeed) {
  Job job;
  const tiles::Patches p = tiles::detail_patches(shapes::mesh(shapes::cube(12)), 0.002, 0.0, job);
  EXPECT_EQ(p.sum.size(), 6U) << "flat sides are one patch each";
  const tiles::JoinedGraph graph{p.sum, p.pair, p.length};
  const tiles::JoinedComponents whole = tiles::find_components(graph, std::vector<std::uint8_t>(6, 0), 1, 0.001);
  for (const double tolerance : {0.0005, 0.008, 0.03})
    EXPECT_EQ(tiles::find_regions(graph, whole, tolerance, 0.0, true, {}, job).regions, 6) << tolerance;
  const tiles::FoundRegions coarse = tiles::find_regions(graph, whole, 100.0, 0.0, false, {}, job);
  EXPECT_EQ(coarse.regions, 4) << "it is closed";
  EXPECT_EQ(tiles::find_regions(graph, whole, 1.0, 0.0, false, coarse.cost, job).regions, 4);
  tiles::JoinedComponents out = whole;
  out.component.pop_back();
  EXPECT_THROW(tiles::find_regions(graph, out, 0.1, 0.0, true, {}, job), InvalidInput);
  EXPECT_THROW(tiles::detail_patches(shapes::mesh(shapes::cube(2)), 0.0, 0.0, job), InvalidInput);
  EXPECT_THROW(tiles::detail_patches(shapes::mesh(shapes::cube(2)), 0.1, -1.0, job), InvalidInput);
}

TEST(TileDetail, AChimneyIsKeptThoughTheGapAboveItIsTheWidest) {
  Job job;
  const RegionSum top{0, 0, 2, 2, 500}, front{0, -2, 0, 2, 500}, back{0, 2, 0, 2, 500}, left{-2, 0, 0, 2, 500},
      right{2, 0, 0, 2, 500};
  tiles::JoinedGraph graph{{top, front, left, back, right}, {{0, 1}, {0, 2}, {0, 3}, {0, 4}}, {1, 1, 1, 1}};
  const auto add = [&](float x, float y) {  // a small side that stands on the top
    graph.pair.push_back({0, static_cast<std::int32_t>(graph.sum.size())});
    graph.length.push_back(0.01F);
    graph.sum.push_back({x, y, 0, std::abs(x) + std::abs(y), 50});
  };
  for (const auto& [x, y] : {std::pair{1.0F, 0.0F}, {0.0F, 1.0F}, {-1.0F, 0.0F}, {0.0F, -1.0F}})
    add(0.004F * x, 0.004F * y);
  add(0.0006F, 0.0F);  // a dent
  const auto regions = [&](double tolerance) {
    const tiles::JoinedComponents whole = tiles::find_components(graph, std::vector<std::uint8_t>(10, 1), 1, 0.0);
    return tiles::find_regions(graph, whole, tolerance, 0.0, true, {}, job).regions;
  };
  EXPECT_EQ(regions(0.01), 9);
  EXPECT_EQ(regions(0.02), 5) << "below the limit it is no feature";
}

TEST(TileDetail, WhatIsLeftOutIsNotCounted) {
  Job job;
  const RegionSum sheet{0, 0, 1, 2, 50}, wall{1, 0, 0, 2, 50}, speck{0, 0, 1e-6, 2e-6, 3};
  const tiles::JoinedGraph graph{{sheet, wall, speck}, {{0, 1}}, {1}};
  const tiles::JoinedComponents parts = tiles::find_components(graph, std::vector<std::uint8_t>(3, 1), 1, 0.001);
  EXPECT_EQ(parts.left_out, 1);
  EXPECT_EQ(tiles::find_regions(graph, parts, 0.01, 0.0, true, {}, job).regions, 2);
  EXPECT_EQ(tiles::find_regions(graph, parts, 10.0, 0.0, true, {}, job).regions, 1);
}

TEST(TileComponents, OnlyTheJoinedGraphTellsWhatIsClosed) {
  const tiles::JoinedGraph graph =
      graph_of(shapes::mesh(shapes::both(shapes::cube(8), shapes::plane(8), {3, 0, 0})), 20);
  std::vector<std::uint8_t> open(graph.sum.size(), 0);
  const tiles::JoinedComponents closed = tiles::find_components(graph, open, 10, 0.0);
  EXPECT_EQ(closed.need, (std::vector<std::int32_t>{4, 4}));
  open.back() = 1;
  EXPECT_EQ(tiles::find_components(graph, open, 10, 0.0).need, (std::vector<std::int32_t>{4, 1}));
}

TEST(TileComponents, SpecksAreLeftOutByTheirShareOfTheArea) {
  const shapes::Arrays cube = shapes::cube(8);
  shapes::Arrays speck = shapes::cube(1);
  for (Vec3& p : speck.vertices) p *= 0.01;
  const tiles::JoinedGraph graph = graph_of(shapes::mesh(shapes::both(cube, speck, {3, 0, 0})), 20);
  const std::vector<std::uint8_t> open(graph.sum.size(), 0);
  const tiles::JoinedComponents found = tiles::find_components(graph, open, 10, 0.001);
  EXPECT_EQ(found.left_out, 1);
  EXPECT_EQ(found.need, (std::vector<std::int32_t>{4, 0}));
  EXPECT_NEAR(found.area_left_out, 1e-4, 1e-5);
  Job job;
  const auto label = tiles::merge(graph, found, 6, {}, job);
  EXPECT_EQ(*std::max_element(label.begin(), label.end()), 5);
  EXPECT_EQ(label.back(), kNone);
}

TEST(TileMerging, FindsTheSidesOfACube) {
  const Mesh mesh = shapes::mesh(shapes::cube(12));
  const tiles::JoinedGraph graph = graph_of(mesh, 20);
  const std::vector<std::uint8_t> open(graph.sum.size(), 0);
  Job job;
  const auto label = tiles::merge(graph, tiles::find_components(graph, open, 6, 0.001), 6, {0.5, 0.1, 6}, job);
  std::map<std::int32_t, RegionSum> sum;
  for (std::size_t u = 0; u < label.size(); ++u) sum[label[u]].add(graph.sum[u]);
  ASSERT_EQ(sum.size(), 6U);
  for (const auto& [region, s] : sum) EXPECT_NEAR(s.length(), 1.0, 1e-5) << region;
}

TEST(TileMerging, OfANodeWithManyNeighboursTakesLittleMemory) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer keeps what was freed";
#endif
  constexpr std::int32_t kLeaves = 4000;  // the square of it times 6 bytes are 96 MB
  tiles::JoinedGraph graph;
  for (std::int32_t u = 0; u <= kLeaves; ++u) {
    graph.sum.push_back({0, 0, 1, 2, 1});
    if (u > 0) graph.pair.push_back({0, u});
  }
  graph.length.resize(graph.pair.size(), 1.0);
  const std::vector<std::uint8_t> open(graph.sum.size(), 1);
  Job job;
  const auto peak_kb = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  const auto before = peak_kb();
  const auto label = tiles::merge(graph, tiles::find_components(graph, open, 1, 0.0), 1, {}, job);
  EXPECT_EQ(*std::max_element(label.begin(), label.end()), 0);
  EXPECT_LT(peak_kb() - before, 24 * 1024);
}

TEST(TileMerging, RefusesPairsThatAreNotThere) {
  const std::vector<std::uint8_t> open(1, 0);
  EXPECT_THROW(tiles::find_components({{RegionSum{}}, {{0, 1}}, {1.0}}, open, 1, 0.0), InvalidInput);
  EXPECT_THROW(tiles::find_components({{RegionSum{}}, {{0, 0}}, {}}, open, 1, 0.0), InvalidInput);
}

/// A mesh as one tile without a halo.
struct OneTile {
  explicit OneTile(const Mesh& mesh) : area(mesh.graph().area) {
    const FaceGraph& graph = mesh.graph();
    for (std::int32_t i = 0; i < graph.size(); ++i) {
      face.push_back(graph.faces[i]);
      face.back().area = static_cast<float>(face.back().area * area);
      neighbour.push_back(graph.neighbours[i]);
      for (std::int32_t& j : neighbour.back()) j = j == graph.size() ? kNone : j;
    }
  }
  [[nodiscard]] tiles::TileFaces faces() const { return {face, neighbour, static_cast<std::int32_t>(face.size())}; }
  [[nodiscard]] std::vector<RegionSum> sums(const std::vector<std::int32_t>& label, std::int32_t regions) const {
    std::vector<RegionSum> sum(static_cast<std::size_t>(regions));
    for (std::size_t i = 0; i < label.size(); ++i)
      if (label[i] != kNone) sum[label[i]].add(face[i]);
    return sum;
  }
  double area;
  std::vector<FaceRecord> face;
  std::vector<std::array<std::int32_t, 3>> neighbour;
};

double error_of(const std::vector<RegionSum>& sums) {
  double error = 0;
  for (const RegionSum& s : sums) error += s.error();
  return error;
}

class TileRelaxing : public testing::Test {
 protected:
  TileRelaxing() : mesh(shapes::mesh(shapes::cube(10))), tile(mesh) {
    // The sides, with their borders moved over by some faces: by the middle of the face and not by its normal.
    for (std::int32_t i = 0; i < mesh.face_count(); ++i) {
      const Triangle& t = mesh.triangles()[mesh.graph().mesh_face[i]];
      const Vec3 middle = (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3;
      label.push_back(middle.z() < 0.15 ? 0 : middle.z() > 0.8 ? 1 : middle.x() + middle.y() < 1 ? 2 : 3);
    }
    options = {.error = 0.1, .smooth = 0.5, .area = tile.area, .faces = mesh.face_count(), .regions = 4, .sweeps = 20};
  }
  Mesh mesh;
  OneTile tile;
  std::vector<std::int32_t> label;
  tiles::RelaxOptions options;
};

TEST_F(TileRelaxing, LowersTheErrorAndSaysWhatItChanged) {
  Job job;
  std::vector<RegionSum> sums = tile.sums(label, 4);
  const std::vector<std::uint8_t> frozen(label.size(), 0);
  const double before = error_of(sums);
  const tiles::Relaxed result = tiles::relax(tile.faces(), label, frozen, sums, options, job);
  EXPECT_GT(result.moves, 50);
  for (const auto& [region, change] : result.change) sums[region].add(change);
  EXPECT_LT(error_of(sums), 0.9 * before);
  const std::vector<RegionSum> anew = tile.sums(result.label, 4);
  for (std::size_t r = 0; r < 4; ++r) {
    EXPECT_NEAR(sums[r].x, anew[r].x, 1e-6);
    EXPECT_NEAR(sums[r].weight, anew[r].weight, 1e-6);
    EXPECT_EQ(sums[r].faces, anew[r].faces);
  }
}

TEST_F(TileRelaxing, LeavesWhatIsFrozenAndTheHalo) {
  Job job;
  const std::vector<RegionSum> sums = tile.sums(label, 4);
  std::vector<std::uint8_t> frozen(label.size(), 1);
  EXPECT_EQ(tiles::relax(tile.faces(), label, frozen, sums, options, job).moves, 0);
  std::fill(frozen.begin(), frozen.end(), 0);
  tiles::TileFaces half = tile.faces();
  half.owned /= 2;
  const tiles::Relaxed result = tiles::relax(half, label, frozen, sums, options, job);
  EXPECT_GT(result.moves, 0);
  EXPECT_EQ(result.label.size(), label.size() / 2);
}

TEST_F(TileRelaxing, RefusesArraysThatDoNotFit) {
  Job job;
  const std::vector<RegionSum> sums = tile.sums(label, 4);
  const std::vector<std::uint8_t> frozen(label.size(), 0), few(3, 0);
  EXPECT_THROW(tiles::relax(tile.faces(), label, few, sums, options, job), InvalidInput);
  EXPECT_THROW(tiles::relax(tile.faces(), label, frozen, std::span(sums).first(2), options, job), InvalidInput);
  tile.neighbour[5][0] = 100000;
  EXPECT_THROW(tiles::relax(tile.faces(), label, frozen, sums, options, job), InvalidInput);
}

TEST_F(TileRelaxing, TouchingRegionsShareTheLengthOfTheirBorder) {
  std::vector<std::array<float, 3>> length(label.size(), {1.0F, 1.0F, 1.0F});
  const tiles::Touching all = tiles::touching(tile.faces(), label, length);
  EXPECT_EQ(all.pair, (std::vector<std::array<std::int32_t, 2>>{{0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}));
  tiles::TileFaces half = tile.faces();
  half.owned /= 2;
  length.resize(static_cast<std::size_t>(half.owned));
  const tiles::Touching some = tiles::touching(half, label, length);
  EXPECT_LT(std::accumulate(some.length.begin(), some.length.end(), 0.0),
            std::accumulate(all.length.begin(), all.length.end(), 0.0));
}

TEST(Thinning, TakesOutAllThatLiesInsideSquares) {
  Job job;
  constexpr int kSquares = 12;
  const Mesh mesh = shapes::mesh(shapes::cube(kSquares));
  const tiles::Thinned thinned = tiles::thin(mesh, sides(kSquares), {}, job);
  EXPECT_LE(thinned.vertices.size(), 12U * kSquares - 4 + 6 * 8);  // the cube's edges, and a few that could not be
                                                                   // removed
  const Mesh checked(thinned.vertices, thinned.triangles, job);
  EXPECT_TRUE(checked.report().closed);
}

TEST(Thinning, KeepsNormalsMomentsAndOrientationOfNoisySurfaces) {
  Job job;
  constexpr int kSquares = 16;
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::cube(kSquares), 0.004, 3));
  const std::vector<std::int32_t> label = sides(kSquares);
  const tiles::Thinned thinned = tiles::thin(mesh, label, {}, job);
  EXPECT_LT(thinned.triangles.size(), label.size() / 2);
  std::vector<Vec3> before(6, Vec3::Zero()), after(6, Vec3::Zero());
  std::vector<SurfaceMoments> true_moments(6), kept(6);
  const std::vector<Vec3> p(mesh.vertices().begin(), mesh.vertices().end());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.triangles()[f];
    before[label[f]] += vector_area(p, t);
    SurfaceMoments m = moments_of(p[t[0]], p[t[1]], p[t[2]]);
    m.centre += mesh.origin();
    true_moments[label[f]].add(m);
  }
  for (std::size_t f = 0; f < thinned.triangles.size(); ++f) {
    const Vec3 n = vector_area(thinned.vertices, thinned.triangles[f]);
    after[thinned.label[f]] += n;
    kept[thinned.label[f]].add(thinned.moments[f]);
    EXPECT_GT(n.dot(before[thinned.label[f]]), 0) << "face " << f << " has turned over";
  }
  for (int r = 0; r < 6; ++r) {
    EXPECT_NEAR((before[r] - after[r]).norm(), 0, 1e-12);
    EXPECT_NEAR(kept[r].area, true_moments[r].area, 1e-12);
    EXPECT_NEAR((kept[r].centre - true_moments[r].centre).norm(), 0, 1e-12);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(kept[r].second[k], true_moments[r].second[k], 1e-12);
  }
}

TEST(Thinning, KeepsWhatStandsInsideARegion) {
  Job job;
  constexpr int kSquares = 40;
  shapes::Arrays ground = shapes::plane(kSquares);
  for (Vec3& p : ground.vertices)
    if (std::abs(p.x() - 0.5) < 0.21 && std::abs(p.y() - 0.5) < 0.21) p.z() += 0.3;
  const Mesh mesh = shapes::mesh(shapes::noisy(ground, 0.001, 2));
  const tiles::Thinned thinned = tiles::thin(mesh, std::vector<std::int32_t>(mesh.face_count(), 0), {}, job);
  EXPECT_LT(thinned.triangles.size(), static_cast<std::size_t>(mesh.face_count()) / 6);
  double before = 0, after = 0;
  const std::vector<Vec3> p(mesh.vertices().begin(), mesh.vertices().end());
  for (const Triangle& t : mesh.triangles()) before += vector_area(p, t).norm();
  for (const Triangle& t : thinned.triangles) after += vector_area(thinned.vertices, t).norm();
  EXPECT_GT(before, 1.4);
  EXPECT_NEAR(after, before, 0.03 * before) << "the walls of the block are thinned away";
}

TEST(Thinning, DropsFacesOfNoRegionAndKeepsRims) {
  Job job;
  const shapes::Arrays both = shapes::both(shapes::plane(8), shapes::plane(2), {3, 0, 0});
  const Mesh mesh = shapes::mesh(both);
  std::vector<std::int32_t> label(both.triangles.size(), 0);
  std::fill(label.begin() + 128, label.end(), kNone);
  const tiles::Thinned thinned = tiles::thin(mesh, label, {}, job);
  const Mesh checked(thinned.vertices, thinned.triangles, job);
  EXPECT_EQ(checked.report().border_edges, 32);
  EXPECT_EQ(checked.component_count(), 1);
  EXPECT_THROW(tiles::thin(mesh, std::span(label).first(3), {}, job), InvalidInput);
}

TEST(Thinning, OfAThinnedMeshAddsUpWhatItsFacesStandFor) {
  Job job;
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::plane(12), 0.003, 1));
  std::vector<std::int32_t> two(288);
  for (std::size_t f = 0; f < two.size(); ++f) two[f] = f < 144 ? 0 : 1;
  const tiles::Thinned once = tiles::thin(mesh, two, {}, job);
  const Mesh less(once.vertices, once.triangles, job);
  const std::vector<std::int32_t> one(once.triangles.size(), 0);
  const tiles::Thinned twice = tiles::thin(less, one, once.moments, job);
  EXPECT_LT(twice.triangles.size(), once.triangles.size());
  SurfaceMoments all, direct;
  for (const SurfaceMoments& m : twice.moments) all.add(m);
  for (const Triangle& t : mesh.triangles())
    direct.add(moments_of(mesh.vertices()[t[0]], mesh.vertices()[t[1]], mesh.vertices()[t[2]]));
  EXPECT_NEAR(all.area, direct.area, 1e-12);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(all.second[k], direct.second[k], 1e-12);
}

TEST(Thinning, PolygonsOfAThinnedMeshAreThoseOfTheWholeOne) {
  Job job;
  constexpr int kSquares = 20;
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::cube(kSquares), 0.01, 5));
  const std::vector<std::int32_t> label = sides(kSquares);
  const PolygonMesh whole = polygonize(mesh, partition_from(mesh, label, job), {}, job);
  const tiles::Thinned thinned = tiles::thin(mesh, label, {}, job);
  const Mesh less(thinned.vertices, thinned.triangles, job);
  std::vector<SurfaceMoments> moments = thinned.moments;
  for (SurfaceMoments& m : moments) m.centre -= less.origin();
  const Partition part = partition_from(less, thinned.label, job);
  const PolygonMesh given = polygonize(less, part, {}, job, moments), fitted = polygonize(less, part, {}, job);
  ASSERT_EQ(given.vertices.size(), whole.vertices.size());
  ASSERT_EQ(fitted.vertices.size(), whole.vertices.size());
  const auto apart = [&](const PolygonMesh& poly) {
    double most = 0;
    for (const Vec3& p : poly.vertices) {
      double nearest = 1;
      for (const Vec3& q : whole.vertices) nearest = std::min(nearest, (p - q).norm());
      most = std::max(most, nearest);
    }
    return most;
  };
  EXPECT_LT(apart(given), 0.1 * apart(fitted)) << "the thinned faces alone have other planes";
  EXPECT_THROW(polygonize(less, part, {}, job, std::span(moments).first(2)), InvalidInput);
}

TEST(Welding, TakesTheNearestPlaceOfAnEarlierTile) {
  Job job;
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {1.0004, 0, 0}, {0.0001, 0, 0}, {0.0002, 0, 0}, {2, 0, 0}};
  const std::vector<std::int32_t> tile = {0, 0, 1, 1, 1, 2};
  EXPECT_EQ(tiles::weld(points, tile, 1e-3, job), (std::vector<std::int32_t>{0, 1, 1, 0, 4, 5}));
  EXPECT_EQ(tiles::weld(points, tile, 1e-5, job), (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_THROW(tiles::weld(points, tile, 0, job), InvalidInput);
  EXPECT_THROW(tiles::weld(points, std::vector<std::int32_t>{1, 0, 0, 0, 0, 0}, 1, job), InvalidInput);
}

TEST(Welding, WorksInMapCoordinates) {
  Job job;
  const Vec3 far(5e5, 5e6, 100);
  const std::vector<Vec3> points = {far, far + Vec3(1e-4, 0, 0), far + Vec3(1, 0, 0)};
  EXPECT_EQ(tiles::weld(points, std::vector<std::int32_t>{0, 1, 1}, 1e-3, job), (std::vector<std::int32_t>{0, 0, 2}));
}

TEST(Welding, FindsPointsInsideEdgesInTheirOrder) {
  Job job;
  const std::vector<Vec3> ends = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 9}};
  const std::vector<Vec3> points = {{0.75, 0, 0}, {0.25, 1e-7, 0}, {1, 0, 0}, {0.5, 0.1, 0}, {0, 1, 6}};
  const auto found = tiles::points_on_edges(ends, points, 1e-6, job);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].point, 1);
  EXPECT_EQ(found[1].point, 0);
  EXPECT_EQ(found[2].edge, 1);
  EXPECT_EQ(found[2].point, 4);
  EXPECT_NEAR(found[2].along, 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace isimp
