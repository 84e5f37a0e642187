#include "isimp/simplify/partitioner.h"
#include "isimp/texture/bake.h"
#include "isimp/texture/unwrap.h"
#include "tests.h"

namespace isimp {
namespace {

/// A sphere in as many regions as there are directions, its polygons, and the places that they show without a band.
struct Ball {
  Mesh mesh = shapes::mesh(shapes::sphere(6));
  Partition part;
  PolygonMesh poly;
  Atlas atlas;
  BakeMap map;

  explicit Ball(const std::vector<Vec3>& directions) {
    std::vector<std::int32_t> regions;
    for (const Triangle& t : mesh.triangles()) {
      const Vec3 middle = mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]];
      const auto nearest = std::max_element(directions.begin(), directions.end(), [&](const Vec3& a, const Vec3& b) {
        return a.dot(middle) < b.dot(middle);
      });
      regions.push_back(static_cast<std::int32_t>(nearest - directions.begin()));
    }
    const Surface surface(mesh);
    part = partition_from(surface, regions, job());
    poly = polygonize(mesh, part, {}, job());
    atlas = unwrap(poly, {512, 1, 1, 0}, job());
    map = bake_map(mesh, part, poly, atlas, {.band = 0}, job());
  }

  /// The number of the texel (x, y), y upward.
  [[nodiscard]] std::size_t pixel_at(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(atlas.side - 1 - y) * atlas.side + x;
  }

  /// The place on the ball that a texel shows.
  [[nodiscard]] Vec3 shown(std::size_t pixel) const {
    const Triangle& t = mesh.triangles()[map.face[pixel]];
    const double b = map.barycentric[2 * pixel], c = map.barycentric[2 * pixel + 1];
    return (1 - b - c) * mesh.vertices()[t[0]] + b * mesh.vertices()[t[1]] + c * mesh.vertices()[t[2]];
  }

  /// The mean over all edges of the distance between the places that are shown 2 texels from their middles, in texels.
  [[nodiscard]] double mean_gap() const {
    std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Vec3>> sides;
    for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
      const std::int32_t begin = poly.loop_start[q], end = poly.loop_end(q);
      for (std::int32_t i = begin; i < end; ++i) {
        const std::int32_t next = i + 1 < end ? i + 1 : begin;
        const Eigen::Vector2d a(atlas.corner[i][0], atlas.corner[i][1]),
            b(atlas.corner[next][0], atlas.corner[next][1]);
        const Eigen::Vector2d along = (b - a).normalized(), inward(-along.y(), along.x());
        const Eigen::Vector2d inside = (a + b) / 2 + 2 * inward;
        const std::size_t pixel =
            pixel_at(static_cast<std::int32_t>(inside.x()), static_cast<std::int32_t>(inside.y()));
        EXPECT_EQ(map.polygon[pixel], q);
        sides[std::minmax({poly.loops[i], poly.loops[next]})].push_back(shown(pixel));
      }
    }
    double sum = 0;
    for (const auto& [edge, places] : sides) {
      EXPECT_EQ(places.size(), 2U);
      sum += (places.front() - places.back()).norm() * atlas.scale;
    }
    return sum / static_cast<double>(sides.size());
  }
};

std::vector<Vec3> axes() {
  return {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
}

/// The faces of a dodecahedron meet at 63 degrees. Along its polygons' normals the two sides of an edge would show places
/// 10 texels apart.
TEST(Lean, BothSidesOfABluntEdgeShowNearlyTheSamePlaces) {
  std::vector<Vec3> directions;
  const double golden = (1 + std::sqrt(5.0)) / 2;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-golden, golden}) {
      directions.push_back(Vec3(0, a, b).normalized());
      directions.push_back(Vec3(a, b, 0).normalized());
      directions.push_back(Vec3(b, 0, a).normalized());
    }
  const Ball ball(directions);
  ASSERT_EQ(ball.poly.polygon_count(), 12);
  EXPECT_LT(ball.mean_gap(), 5);  // 4 is the distance of the points themselves
}

/// Polygons of a cube meet at 90 degrees: each polygon shows the faces above it.
TEST(Lean, ASharpEdgeBendsNothing) {
  const Ball ball(axes());
  ASSERT_EQ(ball.poly.polygon_count(), 6);
  double most = 0;
  std::int32_t judged = 0;
  for (std::int32_t y = 0; y < ball.atlas.side; ++y)
    for (std::int32_t x = 0; x < ball.atlas.side; ++x) {
      const std::size_t pixel = ball.pixel_at(x, y);
      const std::int32_t q = ball.map.polygon[pixel];
      if (q == kNone || ball.map.face[pixel] == kNone) continue;
      const ChartFrame& frame = ball.atlas.frame[q];
      const Vec3 away = ball.shown(pixel) - (frame.origin + (x + 0.5) * frame.u + (y + 0.5) * frame.v);
      most = std::max(most, (away - away.dot(frame.n) * frame.n).norm() * ball.atlas.scale);
      ++judged;
    }
  EXPECT_GT(judged, 10000);
  EXPECT_LT(most, 0.01);
}

}  // namespace
}  // namespace isimp
