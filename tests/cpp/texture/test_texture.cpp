#include "isimp/mesh/clean.h"
#include "isimp/simplify/partitioner.h"
#include "isimp/texture/bake.h"
#include "isimp/texture/corners.h"
#include "isimp/texture/unwrap.h"
#include "tests.h"

namespace isimp {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

/// A mesh with its polygons, one region for each value of `region`.
struct Made {
  Mesh mesh;
  Partition part;
  PolygonMesh poly;
};

Made made(const shapes::Arrays& arrays,
          const std::function<std::int32_t(const Vec3& middle, const Vec3& normal)>& region) {
  Mesh mesh = shapes::mesh(arrays);
  std::vector<std::int32_t> regions;
  for (const Triangle& t : mesh.triangles()) {
    const Vec3 a = mesh.vertices()[t[0]], b = mesh.vertices()[t[1]], c = mesh.vertices()[t[2]];
    regions.push_back(region((a + b + c) / 3, (b - a).cross(c - a).normalized()));
  }
  const Surface surface(mesh);
  Partition part = partition_from(surface, regions, job());
  PolygonMesh poly = polygonize(mesh, part, {}, job());
  return {std::move(mesh), std::move(part), std::move(poly)};
}

std::int32_t side_of(const Vec3& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::int32_t>(2 * axis + (normal[axis] > 0 ? 1 : 0));
}

Made cube(int n) {
  return made(shapes::cube(n), [](const Vec3&, const Vec3& normal) { return side_of(normal); });
}

constexpr std::array<Rgb, 6> kColours = {
    {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {0, 255, 255}, {255, 0, 255}}};

/// Each face in the colour of its side.
struct Painted {
  std::vector<float> uv;
  std::vector<std::int32_t> image;
  std::vector<std::uint8_t> colors;
  Appearance look;

  Painted(const Mesh& mesh, const std::function<Rgb(std::int32_t face)>& colour) {
    uv.assign(6 * mesh.face_count(), 0);
    image.assign(mesh.face_count(), kNone);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (int k = 0; k < 3; ++k) {
        const Rgb c = colour(f);
        colors.insert(colors.end(), {c[0], c[1], c[2], 255});
      }
    look = {uv, image, colors, {}, {}};
  }
};

Vec3 normal_of(const Mesh& mesh, std::int32_t f) {
  const Triangle& t = mesh.triangles()[f];
  const auto v = mesh.vertices();
  return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
}

std::vector<std::array<double, 2>> outline(const PolygonMesh& poly, const Atlas& atlas, std::int32_t q) {
  return {atlas.corner.begin() + poly.loop_start[q], atlas.corner.begin() + poly.loop_end(q)};
}

double area(const std::vector<std::array<double, 2>>& p) {
  double sum = 0;
  for (std::size_t i = 0, h = p.size() - 1; i < p.size(); h = i++) sum += p[h][0] * p[i][1] - p[i][0] * p[h][1];
  return sum / 2;
}

Rgb pixel(const Texture& t, std::int32_t x, std::int32_t row) {
  const std::uint8_t* p = t.color.data() + 4 * (static_cast<std::size_t>(row) * t.side + x);
  return {p[0], p[1], p[2]};
}

TEST(Unwrap, ChartsAreRigidAndNotMirrored) {
  const Made cube_made = cube(4);
  for (const double angle : {0.0, 40.0}) {
    const Atlas atlas = unwrap(cube_made.poly, {256, 1, angle, 0}, job());
    for (std::int32_t q = 0; q < cube_made.poly.polygon_count(); ++q) {
      const auto p = outline(cube_made.poly, atlas, q);
      EXPECT_NEAR(area(p), atlas.scale * atlas.scale, 1e-6 * area(p));
      for (std::size_t i = 0; i < p.size(); ++i) {
        const std::size_t j = (i + 1) % p.size();
        const std::int32_t begin = cube_made.poly.loop_start[q];
        const Vec3 a = cube_made.poly.vertices[cube_made.poly.loops[begin + i]];
        const Vec3 b = cube_made.poly.vertices[cube_made.poly.loops[begin + j]];
        EXPECT_NEAR(std::hypot(p[i][0] - p[j][0], p[i][1] - p[j][1]), atlas.scale * (a - b).norm(), 1e-9 * atlas.side);
        const ChartFrame& frame = atlas.frame[q];
        EXPECT_NEAR((frame.origin + p[i][0] * frame.u + p[i][1] * frame.v - a).norm(), 0, 1e-9);
      }
    }
  }
}

TEST(Unwrap, UnfoldsFlatEdgesOnly) {
  EXPECT_EQ(unwrap(cube(2).poly, {256, 1, 40, 0}, job()).chart_count, 6);
  const Made halves = made(shapes::plane(8), [](const Vec3& middle, const Vec3&) {
    return (middle.x() > 0.5 ? 1 : 0) + (middle.y() > 0.5 ? 2 : 0);
  });
  // A chart takes at most 35 % of the atlas's extent, so that four quarters of a square do not all join.
  const Atlas apart = unwrap(halves.poly, {256, 1, 0, 0}, job());
  EXPECT_EQ(apart.chart_count, 4);
}

TEST(Unwrap, UnfoldedPolygonsDoNotOverlap) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const Partition part = partition(mesh, {.proxies = 150}, job());
  const PolygonMesh poly = polygonize(mesh, part, {}, job());
  const Atlas atlas = unwrap(poly, {1024, 1, 40, 0}, job());
  EXPECT_LT(atlas.chart_count, poly.polygon_count() * 3 / 4);
  const BakeMap map = bake_map(mesh, part, poly, atlas, {}, job());
  std::map<std::int32_t, double> count;
  for (const std::int32_t q : map.polygon) ++count[q];
  for (std::int32_t q = 0; q < poly.polygon_count(); ++q) {
    const double texels = area(outline(poly, atlas, q));
    EXPECT_GT(texels, 0);
    EXPECT_NEAR(count[q], texels, 8 + 0.03 * texels) << "polygon " << q;
  }
}

TEST(Unwrap, FillsMoreThanHalfOfTheAtlas) {
  const Mesh mesh = shapes::mesh(shapes::sphere(4));
  const Partition part = partition(mesh, {.proxies = 1000}, job());
  const PolygonMesh poly = polygonize(mesh, part, {}, job());
  EXPECT_GE(unwrap(poly, {2048, 1, 40, 4}, job()).fill, 0.55);
}

TEST(Unwrap, TakesAsManyTilesAsTheDensityNeedsWhereNoNumberIsGiven) {
  const PolygonMesh poly = cube(1).poly;
  constexpr double kDensity = 10'000;  // 6e8 texels, which fill .55 of the tiles of 8192 x 8192
  EXPECT_EQ(unwrap(poly, {.density = kDensity, .tiles = 0}, job()).tiles, 17);
  EXPECT_EQ(unwrap(poly, {.side = 64, .density = kDensity, .tiles = 0}, job()).tiles, 1);
  for (const std::int32_t tiles : {1, 3})
    EXPECT_EQ(unwrap(poly, {.density = kDensity, .tiles = tiles}, job()).tiles, tiles);
}

TEST(Unwrap, NamesTheSizeThatManyChartsNeed) {
  const Mesh mesh = shapes::mesh(shapes::sphere(3));
  const PolygonMesh poly = polygonize(mesh, partition(mesh, {.proxies = 200}, job()), {}, job());
  const std::string message = message_of([&] { unwrap(poly, {16, 1, 0, 0}, job()); });
  EXPECT_NE(message.find("choose a size of at least"), std::string::npos) << message;
}

TEST(Bake, CubeOfSixColoursShowsNoOtherColour) {
  const Made c = cube(6);
  const Atlas atlas = unwrap(c.poly, {128, 1, 40, 0}, job());
  const Painted painted(c.mesh, [&](std::int32_t f) { return kColours[side_of(normal_of(c.mesh, f))]; });
  const Texture texture = bake(c.mesh, c.part, c.poly, atlas, painted.look, {}, job());
  const BakeMap map = bake_map(c.mesh, c.part, c.poly, atlas, {}, job());
  std::int64_t inside = 0;
  for (std::int32_t row = 0; row < atlas.side; ++row)
    for (std::int32_t x = 0; x < atlas.side; ++x) {
      const std::int32_t q = map.polygon[static_cast<std::size_t>(row) * atlas.side + x];
      if (q == kNone) continue;
      ++inside;
      EXPECT_EQ(pixel(texture, x, row), kColours[side_of(atlas.frame[q].n)]);
      const std::uint8_t* n = texture.normal.data() + 3 * (static_cast<std::size_t>(row) * atlas.side + x);
      EXPECT_GT(n[2], 128);
    }
  EXPECT_EQ(inside, texture.total().inside);
  EXPECT_EQ(texture.total().unknown, 0);
}

TEST(Bake, NoisyThinPlateKeepsItsSidesApart) {
  shapes::Arrays plate = shapes::cube(24);
  for (Vec3& p : plate.vertices) p = Vec3(4 * p.x(), 4 * p.y(), 0.02 * p.z());
  const Mesh smooth = shapes::mesh(plate);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.015);
  shapes::Arrays noisy = plate;
  for (Vec3& p : noisy.vertices) p.z() += noise(random);
  const Made m = [&] {
    std::vector<std::int32_t> sides;
    for (std::int32_t f = 0; f < smooth.face_count(); ++f) sides.push_back(side_of(normal_of(smooth, f)));
    std::size_t at = 0;
    return made(noisy, [&](const Vec3&, const Vec3&) { return sides[at++]; });
  }();
  const Atlas atlas = unwrap(m.poly, {512, 1, 40, 0}, job());
  const Painted painted(m.mesh, [&](std::int32_t f) { return kColours[side_of(normal_of(smooth, f))]; });
  const Texture texture = bake(m.mesh, m.part, m.poly, atlas, painted.look, {}, job());
  const BakeMap map = bake_map(m.mesh, m.part, m.poly, atlas, {}, job());
  std::int64_t wrong = 0, all = 0;
  for (std::int32_t row = 0; row < atlas.side; ++row)
    for (std::int32_t x = 0; x < atlas.side; ++x) {
      const std::int32_t q = map.polygon[static_cast<std::size_t>(row) * atlas.side + x];
      if (q == kNone) continue;
      const Rgb shown = pixel(texture, x, row);
      const double up = atlas.frame[q].n.z();
      if (std::abs(up) < 0.7) continue;
      ++all;
      wrong += shown == kColours[up > 0 ? 4 : 5];
    }
  EXPECT_GT(all, 50000);
  EXPECT_LE(wrong, all / 1000);
}

TEST(Bake, SameBitsForAnyNumberOfThreads) {
  const Mesh mesh = shapes::mesh(shapes::noisy(shapes::sphere(4), 0.01, 3));
  const Partition part = partition(mesh, {.proxies = 60}, job());
  const PolygonMesh poly = polygonize(mesh, part, {}, job());
  const Atlas atlas = unwrap(poly, {700, 1, 40, 0}, job());
  const Painted painted(mesh, [&](std::int32_t f) { return Rgb{static_cast<std::uint8_t>(f % 251), 40, 90}; });
  const Texture one = bake(mesh, part, poly, atlas, painted.look, {.threads = 1}, job());
  const Texture four = bake(mesh, part, poly, atlas, painted.look, {.threads = 4}, job());
  EXPECT_EQ(one.color, four.color);
  EXPECT_EQ(one.normal, four.normal);
}

/// The unit square with the picture on it, `times` in each direction, mirrored if that is negative.
Texture square(const Picture& picture, float times_u, float times_v, std::int32_t side) {
  const Made m = made(shapes::plane(4), [](const Vec3&, const Vec3&) { return 0; });
  std::vector<float> uv;
  for (const Triangle& t : m.mesh.triangles())
    for (const std::int32_t v : t) {
      uv.push_back(static_cast<float>(m.mesh.vertices()[v].x()) * times_u);
      uv.push_back(static_cast<float>(m.mesh.vertices()[v].y()) * times_v);
    }
  const std::vector<std::int32_t> image(m.mesh.face_count(), 0);
  const Appearance look{uv, image, {}, {}, {picture}};
  Atlas atlas = unwrap(m.poly, {side, 1, 40, 0}, job());
  // The square over the whole image, x to the right and y up, so that pixels are known.
  const double s = side;
  atlas.scale = s;
  atlas.frame[0] = {Vec3::Zero(), Vec3::UnitX() / s, Vec3::UnitY() / s, Vec3::UnitZ()};
  for (std::size_t i = 0; i < atlas.corner.size(); ++i) {
    const Vec3& p = m.poly.vertices[m.poly.loops[i]];
    atlas.corner[i] = {p.x() * s, p.y() * s};
  }
  return bake(m.mesh, m.part, m.poly, atlas, look, {.band = 0, .normals = false, .threads = 1}, job());
}

/// Black and white squares of 8 pixels, 16 x 16 of them, the lower left one black.
std::vector<std::uint8_t> checks() {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < 128; ++row)
    for (int x = 0; x < 128; ++x) {
      const auto value = static_cast<std::uint8_t>((x / 8 + (127 - row) / 8) % 2 == 0 ? 0 : 255);
      pixels.insert(pixels.end(), {value, value, value, 255});
    }
  return pixels;
}

TEST(Bake, CheckerboardIsExactAwayFromItsEdges) {
  const std::vector<std::uint8_t> pixels = checks();
  for (const float times : {1.0F, -1.0F, 3.0F}) {
    const Texture texture = square({128, 128, pixels, {}}, times, 1, times == 3.0F ? 384 : 128);
    const std::int32_t n = texture.side;
    for (std::int32_t row = 0; row < n; ++row)
      for (std::int32_t x = 0; x < n; ++x) {
        const double u = (x + 0.5) / n * times, v = (n - row - 0.5) / n;
        const double cu = (u - std::floor(u)) * 16, cv = v * 16;
        if (std::abs(cu - std::round(cu)) < 0.2 || std::abs(cv - std::round(cv)) < 0.2) continue;
        const int want = (static_cast<int>(cu) + static_cast<int>(cv)) % 2 == 0 ? 0 : 255;
        ASSERT_EQ(pixel(texture, x, row)[0], want) << "times " << times << " at " << x << ", " << row;
      }
  }
}

TEST(Bake, SixteenBitImageIsTheSameAsEight) {
  const std::vector<std::uint8_t> pixels = checks();
  std::vector<std::uint16_t> words;
  for (const std::uint8_t value : pixels) words.push_back(static_cast<std::uint16_t>(value * 257));
  const Texture eight = square({128, 128, pixels, {}}, 1, 1, 96), sixteen = square({128, 128, {}, words}, 1, 1, 96);
  EXPECT_EQ(eight.color, sixteen.color);
}

TEST(Bake, ImageWithinItsEdgesDoesNotRepeat) {
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < 4; ++row)
    for (int x = 0; x < 4; ++x) pixels.insert(pixels.end(), {static_cast<std::uint8_t>(x == 0 ? 0 : 255), 0, 0, 255});
  const Texture texture = square({4, 4, pixels, {}}, 1, 1, 64);
  EXPECT_EQ(pixel(texture, 0, 20)[0], 0);
  EXPECT_EQ(pixel(texture, 63, 20)[0], 255);
}

/// The squared distance of a triangle from a point, by its plane and its edges.
double squared_distance(const Mesh& mesh, std::int32_t f, const Vec3& p) {
  const auto corner = [&](int k) { return mesh.vertices()[mesh.triangles()[f][k % 3]]; };
  const Vec3 n = normal_of(mesh, f);
  bool inside = true;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3 a = corner(k), e = corner(k + 1) - a;
    inside = inside && n.dot(e.cross(p - a)) >= 0;
    least = std::min(least, (p - a - std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) * e).squaredNorm());
  }
  return inside ? std::pow(n.dot(p - corner(0)), 2) : least;
}

TEST(Bake, EdgesShowTheClosestPoint) {
  const Made s = made(shapes::noisy(shapes::sphere(4), 0.01, 3), [](const Vec3& middle, const Vec3&) {
    return (middle.x() > 0 ? 1 : 0) + (middle.y() > 0 ? 2 : 0) + (middle.z() > 0 ? 4 : 0);
  });
  const Atlas atlas = unwrap(s.poly, {64, 1, 40, 0}, job());
  const BakeMap map = bake_map(s.mesh, s.part, s.poly, atlas, {.band = 64}, job());  // 2 texels
  std::int32_t judged = 0;
  for (std::int32_t row = 0; row < atlas.side; ++row)
    for (std::int32_t x = 0; x < atlas.side; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(row) * atlas.side + x;
      const std::int32_t q = map.polygon[pixel];
      if (q == kNone) continue;
      const double y = atlas.side - 1 - row + 0.5;
      const auto p = outline(s.poly, atlas, q);
      double edge = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0, h = p.size() - 1; i < p.size(); h = i++) {
        const Eigen::Vector2d a(p[h][0], p[h][1]), b(p[i][0], p[i][1]), at(x + 0.5, y), e = b - a;
        edge = std::min(edge, (at - a - std::clamp((at - a).dot(e) / e.squaredNorm(), 0.0, 1.0) * e).norm());
      }
      if (edge > 0.95) continue;  // beyond, drawn faces weigh more
      const ChartFrame& frame = atlas.frame[q];
      const Vec3 place = frame.origin + (x + 0.5) * frame.u + y * frame.v - s.mesh.origin();
      double least = std::numeric_limits<double>::infinity();
      const std::int32_t own = s.poly.polygon_region[q];
      for (std::int32_t f = 0; f < s.mesh.face_count(); ++f) {  // faces of the region and of the three adjacent ones
        const std::int32_t apart = s.part.face_region[f] ^ own;
        if ((apart & (apart - 1)) != 0 || !(normal_of(s.mesh, f).dot(frame.n) > 0)) continue;
        least = std::min(least, squared_distance(s.mesh, f, place));
      }
      ASSERT_NE(map.face[pixel], kNone);
      EXPECT_NEAR(squared_distance(s.mesh, map.face[pixel], place), least, 1e-5);
      ++judged;
    }
  EXPECT_GT(judged, 200);
}

TEST(Bake, UnknownPlacesShowTheNearestColour) {
  const Made c = cube(6);
  const Atlas atlas = unwrap(c.poly, {128, 1, 40, 0}, job());
  const Painted painted(c.mesh, [&](std::int32_t f) { return kColours[side_of(normal_of(c.mesh, f))]; });
  std::vector<std::uint8_t> known(c.mesh.face_count(), 1);
  Appearance look = painted.look;
  std::int32_t hidden = 0;  // half of one side
  for (std::int32_t f = 0; f < c.mesh.face_count(); ++f) {
    const Vec3 middle = c.mesh.vertices()[c.mesh.triangles()[f][0]];
    if (side_of(normal_of(c.mesh, f)) == 5 && middle.x() < 0.5) known[f] = 0, ++hidden;
  }
  ASSERT_GT(hidden, 0);
  look.known = known;
  const Texture texture = bake(c.mesh, c.part, c.poly, atlas, look, {.band = 0}, job());
  EXPECT_GT(texture.total().searched, 0);
  EXPECT_EQ(texture.total().unknown, 0);
  const BakeMap map = bake_map(c.mesh, c.part, c.poly, atlas, {}, job());
  for (std::int32_t row = 0; row < atlas.side; ++row)
    for (std::int32_t x = 0; x < atlas.side; ++x) {
      const std::int32_t q = map.polygon[static_cast<std::size_t>(row) * atlas.side + x];
      if (q == kNone) continue;
      EXPECT_EQ(pixel(texture, x, row), kColours[side_of(atlas.frame[q].n)]);
    }
}

TEST(Bake, NothingKnownAtAllIsGreyAndNotBlack) {
  const Made c = cube(2);
  const Atlas atlas = unwrap(c.poly, {64, 1, 40, 0}, job());
  const Painted painted(c.mesh, [](std::int32_t) { return Rgb{0, 0, 0}; });
  const std::vector<std::uint8_t> known(c.mesh.face_count(), 0);
  Appearance look = painted.look;
  look.known = known;
  const Texture texture = bake(c.mesh, c.part, c.poly, atlas, look, {}, job());
  EXPECT_EQ(texture.total().unknown, texture.total().inside);
  EXPECT_EQ(pixel(texture, 10, 10), (Rgb{128, 128, 128}));
}

TEST(SourceCorners, TurnedAndHalvedFacesLieOnTheirSource) {
  // Two triangles, and a flat one between them whose longest edge has to be flipped.
  const std::vector<Vec3> v = {{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, 1, 0}};
  const std::vector<Triangle> t = {{0, 2, 4}, {2, 1, 4}, {0, 1, 2}, {1, 0, 3}};
  const Mesh mesh = clean(v, t, {}, job());
  ASSERT_EQ(mesh.report().repairs[9].what, "turned_edges");
  ASSERT_GT(mesh.report().repairs[9].count, 0);
  const SourceCorners found = source_corners(mesh, v, t, job());
  EXPECT_GT(found.turned, 0);
  EXPECT_EQ(found.lost, 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Triangle& s = t[found.face[f]];
      const double b = found.weight[f][2 * k], c = found.weight[f][2 * k + 1];
      const Vec3 p = (1 - b - c) * v[s[0]] + b * v[s[1]] + c * v[s[2]];
      EXPECT_NEAR((p - mesh.vertices()[mesh.triangles()[f][k]] - mesh.origin()).norm(), 0, 1e-6);
    }
}

TEST(SourceCorners, ReversedFacesKeepTheirCorners) {
  shapes::Arrays arrays = shapes::cube(3);
  for (std::size_t f = 0; f < arrays.triangles.size(); f += 5)
    std::swap(arrays.triangles[f][0], arrays.triangles[f][2]);
  const Mesh mesh = clean(arrays.vertices, arrays.triangles, {}, job());
  const SourceCorners found = source_corners(mesh, arrays.vertices, arrays.triangles, job());
  EXPECT_EQ(found.turned, 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Triangle& s = arrays.triangles[found.face[f]];
      const int at = found.weight[f][2 * k] == 1 ? 1 : found.weight[f][2 * k + 1] == 1 ? 2 : 0;
      EXPECT_EQ(arrays.vertices[s[at]], mesh.vertices()[mesh.triangles()[f][k]] + mesh.origin());
    }
}

TEST(SourceCorners, OtherArraysAreRefused) {
  const Mesh mesh = shapes::mesh(shapes::cube(3));
  const shapes::Arrays other = shapes::sphere(2);
  EXPECT_THROW(source_corners(mesh, other.vertices, other.triangles, job()), InvalidInput);
}

}  // namespace
}  // namespace isimp
