#include <gtest/gtest.h>

#include <algorithm>

#include "isimp/core/errors.h"
#include "isimp/interact/interact.h"
#include "isimp/simplify/partitioner.h"
#include "isimp/texture/bake.h"
#include "isimp/texture/occlusion.h"
#include "isimp/texture/unwrap.h"
#include "shapes.h"

namespace isimp {
namespace {

/// A noisy sphere of 150 regions, each face in a colour of its own, before and after a region is added.
class Rebake : public testing::Test {
 protected:
  Rebake()
      : mesh(shapes::mesh(shapes::noisy(shapes::sphere(4), 0.01, 3))),
        before(partition(mesh, {.proxies = 150}, job)),
        after(add_proxy(mesh, before, 200, job)),
        old_poly(polygonize(mesh, before, {}, job)),
        poly(polygonize(mesh, after, {}, job)),
        uv(6 * mesh.face_count(), 0),
        image(mesh.face_count(), kNone) {
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        for (const int value : {f % 251, f % 13 * 19, f % 7 * 36, 255})
          colors.push_back(static_cast<std::uint8_t>(value));
    look = {uv, image, colors, {}, {}};
  }

  Texture baked(const Partition& part, const PolygonMesh& polygons, const Atlas& atlas,
                const EarlierBake* earlier = nullptr) {
    return bake(mesh, part, polygons, atlas, look, {}, job, {}, earlier);
  }

  Job job;
  Mesh mesh;
  Partition before, after;
  PolygonMesh old_poly, poly;
  std::vector<float> uv;
  std::vector<std::int32_t> image;
  std::vector<std::uint8_t> colors;
  Appearance look;
};

std::vector<std::array<double, 2>> outline(const PolygonMesh& poly, const Atlas& atlas, std::int32_t q) {
  return {atlas.corner.begin() + poly.loop_start[q], atlas.corner.begin() + poly.loop_end(q)};
}

TEST_F(Rebake, UnchangedPolygonsStay) {
  const Atlas old = unwrap(old_poly, {512, 1, 40, 0}, job);
  const EarlierAtlas earlier{old_poly, old};
  const Atlas atlas = unwrap(poly, {512, 1, 40, 0}, job, &earlier);
  EXPECT_EQ(atlas.scale, old.scale);
  EXPECT_GT(atlas.kept, poly.polygon_count() / 3);
  EXPECT_LT(atlas.kept, poly.polygon_count());
  std::int32_t stayed = 0;
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
    const std::int32_t p = atlas.from[q];
    if (p == kNone) continue;
    ++stayed;
    auto here = outline(poly, atlas, q), there = outline(old_poly, old, p);
    std::sort(here.begin(), here.end());
    std::sort(there.begin(), there.end());
    EXPECT_EQ(here, there);
    EXPECT_EQ(atlas.frame[q], old.frame[p]);
    const std::int32_t begin = poly.loop_start[q];
    for (std::size_t i = 0; i < here.size(); ++i) {  // the picture is where the polygon is
      const Vec3 d = poly.vertices[poly.loops[begin + i]] - atlas.frame[q].origin;
      const auto& [x, y] = atlas.corner[begin + i];
      const double over = 1 / atlas.frame[q].u.squaredNorm();
      EXPECT_NEAR(d.dot(atlas.frame[q].u) * over, x, 2);
      EXPECT_NEAR(d.dot(atlas.frame[q].v) * over, y, 2);
    }
  }
  EXPECT_EQ(stayed, atlas.kept);
}

TEST_F(Rebake, NewChartsLieInTheFreeRoom) {
  const Atlas old = unwrap(old_poly, {512, 1, 40, 0}, job);
  const EarlierAtlas earlier{old_poly, old};
  const Atlas atlas = unwrap(poly, {512, 1, 40, 0}, job, &earlier);
  ASSERT_GT(atlas.kept, 0);
  // Were two charts nearer than the gutter, one would take texels that the other's polygons cover.
  const BakeMap map = bake_map(mesh, after, poly, atlas, {}, job);
  std::vector<double> count(poly.polygon_count(), 0);
  for (const std::int32_t q : map.polygon)
    if (q != kNone) ++count[q];
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
    double area = 0;
    const auto p = outline(poly, atlas, q);
    for (std::size_t i = 0, h = p.size() - 1; i < p.size(); h = i++)
      area += (p[h][0] * p[i][1] - p[i][0] * p[h][1]) / 2;
    EXPECT_NEAR(count[q], area, 10 + 0.06 * area) << "polygon " << q;
    for (const auto& corner : p)
      for (const double x : corner) {
        EXPECT_GE(x, atlas.gutter / 2 - 1e-9);
        EXPECT_LE(x, atlas.side - atlas.gutter / 2 + 1e-9);
      }
  }
}

TEST_F(Rebake, GivesTheBitsOfAWholeBake) {
  const Atlas old = unwrap(old_poly, {512, 1, 40, 0}, job);
  const Texture first = baked(before, old_poly, old);
  const EarlierAtlas earlier{old_poly, old};
  const Atlas atlas = unwrap(poly, {512, 1, 40, 0}, job, &earlier);
  const Texture whole = baked(after, poly, atlas);
  const EarlierBake known{before, old_poly, old, first.color, first.normal, {}, first.texels};
  const Texture again = baked(after, poly, atlas, &known);
  EXPECT_EQ(again.color, whole.color);
  EXPECT_EQ(again.normal, whole.normal);
  EXPECT_EQ(again.total().inside, whole.total().inside);
  EXPECT_EQ(again.total().searched, whole.total().searched);
  const auto copied = std::count_if(again.same.begin(), again.same.end(), [](std::int32_t p) { return p != kNone; });
  EXPECT_GT(copied, poly.polygon_count() / 4);
  EXPECT_LT(copied, poly.polygon_count());
  EXPECT_EQ(std::count(whole.same.begin(), whole.same.end(), kNone), poly.polygon_count());
}

/// A polygon can stay while adjacent faces change their region: its texels must follow.
TEST_F(Rebake, BakesAgainWhereOnlyRegionsChanged) {
  const Atlas atlas = unwrap(old_poly, {512, 1, 40, 0}, job);
  const Texture first = baked(before, old_poly, atlas);
  Partition moved = before;
  std::int32_t changed = kNone;
  for (std::int32_t f = 0; f < mesh.face_count() && changed == kNone; ++f)
    for (int k = 0; k < 3 && changed == kNone; ++k)
      if (const std::int32_t o = mesh.opposite(3 * f + k);
          o != kNone && before.face_region[f] != before.face_region[Mesh::face(o)]) {
        changed = before.face_region[f];
        moved.face_region[f] = before.face_region[Mesh::face(o)];
      }
  ASSERT_NE(changed, kNone);
  const EarlierBake known{before, old_poly, atlas, first.color, first.normal, {}, first.texels};
  const EarlierAtlas earlier{old_poly, atlas};
  const Atlas same = unwrap(old_poly, {512, 1, 40, 0}, job, &earlier);
  ASSERT_EQ(same.kept, old_poly.polygon_count());
  const Texture again = baked(moved, old_poly, same, &known);
  EXPECT_EQ(again.color, baked(moved, old_poly, same).color);
  for (std::int32_t q = 0; q < old_poly.polygon_count(); ++q) {
    if (old_poly.polygon_region[q] != changed) continue;
    EXPECT_EQ(again.same[q], kNone);
  }
}

TEST_F(Rebake, OcclusionIsCopiedToo) {
  const Atlas old = unwrap(old_poly, {128, 1, 40, 0}, job);
  const Texture first = baked(before, old_poly, old);
  const auto grey = occlusion(mesh, before, bake_map(mesh, before, old_poly, old, {}, job), {}, job);
  const EarlierAtlas earlier{old_poly, old};
  const Atlas atlas = unwrap(poly, {128, 1, 40, 0}, job, &earlier);
  const EarlierBake known{before, old_poly, old, first.color, first.normal, {}, first.texels};
  const Texture again = baked(after, poly, atlas, &known);
  const EarlierGrey kept{again.same, grey};
  const BakeMap part = bake_map(mesh, after, poly, atlas, {}, job, again.same);
  EXPECT_EQ(occlusion(mesh, after, part, {}, job, &kept),
            occlusion(mesh, after, bake_map(mesh, after, poly, atlas, {}, job), {}, job));
}

TEST_F(Rebake, LaysOutAllAgainIfTheRestDoesNotFit) {
  const Atlas old = unwrap(old_poly, {512, 1, 40, 0}, job);
  const EarlierAtlas earlier{old_poly, old};
  EXPECT_EQ(unwrap(poly, {256, 1, 40, 0}, job, &earlier).kept, 0) << "another size";
  EXPECT_EQ(unwrap(poly, {512, 1, 40, 9}, job, &earlier).kept, 0) << "another gutter";
  // Half of the polygons at another scale have no room next to the other half.
  PolygonMesh larger = old_poly;
  for (std::size_t v = 0; v < larger.vertices.size(); ++v)
    if (larger.vertices[v].x() > 0) larger.vertices[v] *= 2;
  const Atlas anew = unwrap(larger, {512, 1, 40, 0}, job, &earlier);
  EXPECT_EQ(anew.kept, 0);
  EXPECT_LT(anew.scale, unwrap(larger, {512, 1, 40, 0}, job).scale) << "room is left for later";
}

TEST_F(Rebake, RefusesATextureOfAnotherMesh) {
  const Atlas atlas = unwrap(old_poly, {128, 1, 40, 0}, job);
  const Texture first = baked(before, old_poly, atlas);
  const EarlierBake without{before, old_poly, atlas, first.color, {}, {}, first.texels};
  EXPECT_THROW(baked(before, old_poly, atlas, &without), InvalidInput);
}

TEST(Tiles, ChartsOfSeveralTilesAreDenserAndKeepToTheirs) {
  Job job;
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const Partition part = partition(mesh, {.proxies = 60}, job);
  const PolygonMesh poly = polygonize(mesh, part, {}, job);
  const Atlas one = unwrap(poly, {256, 1, 40, 0}, job), three = unwrap(poly, {256, 1, 40, 0, 3}, job);
  EXPECT_EQ(one.tiles, 1);
  EXPECT_EQ(three.tiles, 3);
  EXPECT_GT(three.scale, 1.6 * one.scale);
  EXPECT_GT(three.fill, 0.5);
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q)
    for (const auto& [x, y] : outline(poly, three, q)) {
      EXPECT_GE(y, three.tile[q] * 256.0);
      EXPECT_LE(y, (three.tile[q] + 1) * 256.0);
      EXPECT_LE(x, 256.0);
    }
}

TEST(Tiles, MoreAreMadeWhereTheDensityNeedsThem) {
  Job job;
  const Mesh mesh = shapes::mesh(shapes::sphere(2));
  const PolygonMesh poly = polygonize(mesh, partition(mesh, {.proxies = 40}, job), {}, job);
  const Atlas few = unwrap(poly, {0, 1000, 40, 0, 0}, job), many = unwrap(poly, {0, 4000, 40, 0, 0}, job);
  EXPECT_EQ(few.tiles, 1);
  EXPECT_EQ(many.side, 8192);
  EXPECT_EQ(many.tiles, 6);            // 4 pi * 4000^2 texels at a fill of 0.55
  EXPECT_NEAR(many.scale, 4400, 500);  // the scale that fits
}

TEST(Tiles, GroupsShareNone) {
  Job job;
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const Partition part = partition(mesh, {.proxies = 60}, job);
  const PolygonMesh poly = polygonize(mesh, part, {}, job);
  std::vector<std::int32_t> group(poly.polygon_count());
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) group[q] = q % 2;
  const Atlas atlas = unwrap(poly, {256, 1, 40, 0, 2, group}, job);
  EXPECT_EQ(atlas.tile_group, (std::vector<std::int32_t>{0, 0, 1, 1}));
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) EXPECT_EQ(atlas.tile_group[atlas.tile[q]], group[q]);
  std::vector<std::int32_t> of_chart(atlas.chart_count, kNone);
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
    if (of_chart[atlas.chart[q]] == kNone) of_chart[atlas.chart[q]] = group[q];
    EXPECT_EQ(of_chart[atlas.chart[q]], group[q]);
  }
}

}  // namespace
}  // namespace isimp
