// Partitions of shapes with flat sides are exact, for any order of their faces and any rotation.

#include <tuple>

#include "isimp/simplify/partitioner.h"
#include "partition_checks.h"
#include "tests.h"

namespace isimp {
namespace {

using shapes::Arrays;

/// The surface of a set of unit cells, each square side n by n squares, and the plane each face lies in.
struct Solid {
  Arrays arrays;
  std::vector<std::int32_t> side;  // by face: squares of one plane that hang together are one side
  std::int32_t sides = 0;
};

using Cell = std::array<int, 3>;

Solid solid(const std::set<Cell>& cells, int n) {
  Solid s;
  std::map<std::array<int, 3>, std::int32_t> vertex;
  std::vector<std::tuple<int, int, Cell>> plane;  // axis and direction, offset, cell of each face
  for (const Cell& c : cells)
    for (int axis = 0; axis < 3; ++axis)
      for (const int up : {0, 1}) {
        Cell beyond = c;
        beyond[axis] += up == 1 ? 1 : -1;
        if (cells.contains(beyond)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto at = [&](int i, int j) {
          std::array<int, 3> p{c[0] * n, c[1] * n, c[2] * n};
          p[axis] += up * n;
          p[u] += i;
          p[v] += j;
          const auto [it, fresh] = vertex.try_emplace(p, static_cast<std::int32_t>(s.arrays.vertices.size()));
          if (fresh) s.arrays.vertices.push_back(Vec3(p[0], p[1], p[2]) / n);
          return it->second;
        };
        for (int i = 0; i < n; ++i)
          for (int j = 0; j < n; ++j) {
            Triangle a{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, b{at(i, j), at(i + 1, j + 1), at(i, j + 1)};
            if (up == 0) {
              std::swap(a[1], a[2]);
              std::swap(b[1], b[2]);
            }
            s.arrays.triangles.insert(s.arrays.triangles.end(), {a, b});
            plane.insert(plane.end(), 2, {2 * axis + up, c[axis] + up, c});
          }
      }
  const Mesh mesh = shapes::mesh(s.arrays);
  s.side.assign(plane.size(), kNone);
  std::vector<std::int32_t> stack;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (s.side[f] != kNone) continue;
    s.side[f] = s.sides;
    stack.push_back(f);
    while (!stack.empty()) {
      const std::int32_t g = stack.back();
      stack.pop_back();
      for (std::int32_t h = 3 * g; h < 3 * g + 3; ++h) {
        const std::int32_t o = mesh.opposite(h) / 3;
        const bool same =
            std::get<0>(plane[o]) == std::get<0>(plane[g]) && std::get<1>(plane[o]) == std::get<1>(plane[g]);
        if (!same || s.side[o] != kNone) continue;
        s.side[o] = s.sides;
        stack.push_back(o);
      }
    }
    ++s.sides;
  }
  return s;
}

Solid cube() { return solid({{0, 0, 0}}, 20); }
Solid two_cubes() { return solid({{0, 0, 0}, {2, 0, 0}}, 10); }
Solid stairs() { return solid({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}, {1, 0, 1}, {0, 0, 2}}, 8); }
Solid washer() {
  return solid({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 2, 0}, {1, 2, 0}, {2, 2, 0}}, 6);
}

/// The faces in another order and the whole turned; `order` has the source of each face.
Arrays scrambled(const Arrays& a, std::uint32_t seed, std::vector<std::int32_t>& order) {
  std::mt19937 random(seed);
  order.resize(a.triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  std::shuffle(order.begin(), order.end(), random);
  Arrays b;
  for (const std::int32_t f : order) b.triangles.push_back(a.triangles[f]);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  const Eigen::Quaterniond turn = seed % 2 == 0
                                      ? Eigen::Quaterniond::Identity()
                                      : Eigen::Quaterniond(number(), number(), number(), number()).normalized();
  for (const Vec3& v : a.vertices) b.vertices.push_back(turn * v);
  return b;
}

/// The least of the sides' best intersection over union with a region, by faces.
double least_overlap(const Solid& s, const std::vector<std::int32_t>& order, const Partition& p) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> both;
  std::map<std::int32_t, int> side, region;
  for (std::size_t f = 0; f < order.size(); ++f) {
    ++both[{s.side[order[f]], p.face_region[f]}];
    ++side[s.side[order[f]]];
    ++region[p.face_region[f]];
  }
  std::map<std::int32_t, double> best;
  for (const auto& [key, count] : both) {
    const double overlap = static_cast<double>(count) / (side[key.first] + region[key.second] - count);
    best[key.first] = std::max(best[key.first], overlap);
  }
  double least = 1.0;
  for (const auto& [unused, overlap] : best) least = std::min(least, overlap);
  return least;
}

class Shapes : public testing::TestWithParam<std::uint32_t> {
 protected:
  static double overlap(const Solid& s, Method method, double noise = 0.0) {
    std::vector<std::int32_t> order;
    Arrays a = scrambled(s.arrays, GetParam(), order);
    if (noise > 0) a = shapes::noisy(a, noise, GetParam() + 100);
    const Mesh mesh = shapes::mesh(a);
    const Partition p = partition(mesh, {.proxies = s.sides, .seed = GetParam(), .method = method}, job());
    checks::expect_sound(mesh, p, s.sides);
    return least_overlap(s, order, p);
  }
};

TEST_P(Shapes, AreFoundExactlyByTheDefault) {
  EXPECT_EQ(overlap(cube(), Method::hierarchy), 1.0);
  EXPECT_EQ(overlap(two_cubes(), Method::hierarchy), 1.0);
  EXPECT_EQ(overlap(stairs(), Method::hierarchy), 1.0);
  EXPECT_EQ(overlap(washer(), Method::hierarchy), 1.0);
}

TEST_P(Shapes, AreFoundUnderNoise) {
  EXPECT_GT(overlap(cube(), Method::hierarchy, 0.01), 0.95);
  EXPECT_GT(overlap(stairs(), Method::hierarchy, 0.01), 0.95);
}

TEST_P(Shapes, ACubeIsFoundByTeleportsFromAnySeeds) { EXPECT_EQ(overlap(cube(), Method::teleport), 1.0); }

INSTANTIATE_TEST_SUITE_P(OrdersAndTurns, Shapes, testing::Range(0U, 20U));

TEST(Shape, SidesAreCountedRight) {
  EXPECT_EQ(cube().sides, 6);
  EXPECT_EQ(two_cubes().sides, 12);
  EXPECT_EQ(stairs().sides, 10);
  EXPECT_EQ(washer().sides, 10);
}

TEST(Shape, ASphereIsSharedOutEvenly) {
  const Mesh mesh = shapes::mesh(shapes::sphere(5));
  const Partition p = partition(mesh, {.proxies = 50}, job());
  checks::expect_sound(mesh, p);
  double least = 1e9, most = 0;
  for (const RegionSum& s : p.region_sum) {
    least = std::min(least, s.weight);
    most = std::max(most, s.weight);
  }
  EXPECT_LT(most, 4 * least);
}

}  // namespace
}  // namespace isimp
