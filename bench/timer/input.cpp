#include "input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <utility>

#include "isimp/core/errors.h"
#include "isimp/mesh/io.h"

namespace isimp::bench {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// A grid of nu by nv squares of two triangles, closed in both directions.
std::vector<Triangle> ring_triangles(std::int32_t nu, std::int32_t nv) {
  std::vector<Triangle> triangles;
  const auto at = [&](std::int32_t i, std::int32_t j) { return (i % nu) * nv + j % nv; };
  for (std::int32_t i = 0; i < nu; ++i)
    for (std::int32_t j = 0; j < nv; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return triangles;
}

/// \param stretch  number of squares around the ring divided by the number around the tube
Arrays torus(std::int64_t faces, double stretch) {
  const auto nv = std::max<std::int32_t>(3, std::lround(std::sqrt(static_cast<double>(faces) / 2 / stretch)));
  const auto nu = std::max<std::int32_t>(3, static_cast<std::int32_t>(faces / 2 / nv));
  Arrays a;
  a.triangles = ring_triangles(nu, nv);
  std::mt19937 random(1);
  const double noise = 0.02 * std::min(0.4 * kTurn / nv, kTurn / nu) / 4294967296.0;  // a small share of an edge
  for (std::int32_t i = 0; i < nu; ++i)
    for (std::int32_t j = 0; j < nv; ++j) {
      const double u = kTurn * i / nu, v = kTurn * j / nv;
      double r = 0.4 + noise * random();
      for (const double k : {2.0, 5.0, 11.0, 23.0}) r += 0.08 / k * std::sin(k * u + 3) * std::cos((k - 1) * v + k);
      const double ring = 1 + r * std::cos(v);
      a.vertices.emplace_back(ring * std::cos(u), ring * std::sin(u), r * std::sin(v));
    }
  return a;
}

Arrays plane(std::int64_t faces) {
  const auto n = std::max<std::int32_t>(1, std::lround(std::sqrt(static_cast<double>(faces) / 2)));
  Arrays a;
  const auto at = [&](std::int32_t i, std::int32_t j) { return i * (n + 1) + j; };
  for (std::int32_t i = 0; i <= n; ++i)
    for (std::int32_t j = 0; j <= n; ++j) a.vertices.emplace_back(i, j, 0);
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = 0; j < n; ++j) {
      a.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      a.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return a;
}

Arrays boxes(std::int64_t faces) {
  const auto count = std::max<std::int32_t>(1, static_cast<std::int32_t>(faces / 12));
  const auto row = static_cast<std::int32_t>(std::ceil(std::cbrt(count)));
  // Corner c lies at (c & 1, c >> 1 & 1, c >> 2).
  constexpr Triangle kBox[12] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  Arrays a;
  for (std::int32_t b = 0; b < count; ++b) {
    const Vec3 corner(2 * (b % row), 2 * (b / row % row), 2 * (b / row / row));
    for (const Triangle& t : kBox) a.triangles.push_back({8 * b + t[0], 8 * b + t[1], 8 * b + t[2]});
    for (int c = 0; c < 8; ++c) a.vertices.push_back(corner + Vec3(c & 1, c >> 1 & 1, c >> 2));
  }
  return a;
}

/// Squares of unit cells of which some are filled: each side of a filled one that no filled one lies at.
class Cells {
 public:
  /// \param filled  called for cells -1 ... n too
  Arrays surface(const Eigen::Vector3i& n, const std::function<bool(int, int, int)>& filled) {
    for (int x = 0; x < n[0]; ++x)
      for (int y = 0; y < n[1]; ++y)
        for (int z = 0; z < n[2]; ++z)
          for (int side = 0; filled(x, y, z) && side < 6; ++side) {
            Eigen::Vector3i beside(x, y, z);
            beside[side / 2] += side % 2 == 0 ? -1 : 1;
            if (!filled(beside[0], beside[1], beside[2])) add_side({x, y, z}, side);
          }
    return std::move(arrays_);
  }

 private:
  void add_side(const Eigen::Vector3i& cell, int side) {
    const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<std::int32_t, 4> corner{};
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector3i at = cell;
      at[axis] += side % 2;
      at[u] += k == 1 || k == 2 ? 1 : 0;
      at[v] += k >= 2 ? 1 : 0;
      const auto [place, fresh] =
          index_.try_emplace({at[0], at[1], at[2]}, static_cast<std::int32_t>(arrays_.vertices.size()));
      if (fresh) arrays_.vertices.push_back(at.cast<double>());
      corner[k] = place->second;
    }
    if (side % 2 == 0) std::swap(corner[1], corner[3]);
    arrays_.triangles.push_back({corner[0], corner[1], corner[2]});
    arrays_.triangles.push_back({corner[0], corner[2], corner[3]});
  }

  Arrays arrays_;
  std::map<std::array<int, 3>, std::int32_t> index_;
};

/// A plate of one cell's thickness with n x n square holes, three cells apart; 42 faces a hole.
Arrays plate(std::int64_t faces) {
  const auto n = std::max<int>(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(faces) / 42))));
  Arrays a = Cells().surface({3 * n, 3 * n, 1}, [n](int x, int y, int z) {
    return z == 0 && x >= 0 && y >= 0 && x < 3 * n && y < 3 * n && (x % 3 != 1 || y % 3 != 1);
  });
  for (Vec3& v : a.vertices) v.z() *= 0.2;
  return a;
}

/// The upper side of such a plate, which has a border.
Arrays sheet(std::int64_t faces) {
  const auto n = std::max<std::int32_t>(1, std::lround(std::sqrt(static_cast<double>(faces) / 16)));
  const Arrays whole = plane(18 * static_cast<std::int64_t>(n) * n);
  Arrays a{whole.vertices, {}};
  for (const Triangle& t : whole.triangles) {
    const Vec3 middle = (whole.vertices[t[0]] + whole.vertices[t[1]] + whole.vertices[t[2]]) / 3;
    if (static_cast<int>(middle.x()) % 3 != 1 || static_cast<int>(middle.y()) % 3 != 1) a.triangles.push_back(t);
  }
  return a;
}

/// A plate with n x n circular holes of 16 sides, a ring of squares around each; 160 faces a hole.
Arrays perforated(std::int64_t faces) {
  constexpr int kSides = 16, kFlat = kSides / 4;
  const auto n = std::max<int>(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(faces) / 160))));
  Arrays a;
  std::map<std::array<std::int64_t, 3>, std::int32_t> index;
  // Step i around a hole: from its edge to the middle (1) and the outline (2) of its cell.
  const auto at = [&](int x, int y, int i, int ring, int z) {
    const int side = i / kFlat % 4;
    const double along = 2.0 * (i % kFlat) / kFlat - 1, turn = kTurn * (i + kFlat / 2.0) / kSides;
    const std::array<std::array<double, 2>, 4> square{{{-along, 1}, {-1, -along}, {along, -1}, {1, along}}};
    const double out = ring / 2.0;
    const Vec3 p(3 * x + 1.5 * out * square[side][0] + (1 - out) * std::cos(turn),
                 3 * y + 1.5 * out * square[side][1] + (1 - out) * std::sin(turn), 0.5 * z);
    const auto [place, fresh] = index.try_emplace({std::llround(p[0] * 1e6), std::llround(p[1] * 1e6), z},
                                                  static_cast<std::int32_t>(a.vertices.size()));
    if (fresh) a.vertices.push_back(p);
    return place->second;
  };
  const auto add = [&](const std::array<std::int32_t, 4>& c) {
    a.triangles.push_back({c[0], c[1], c[2]});
    a.triangles.push_back({c[0], c[2], c[3]});
  };
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int i = 0; i < kSides; ++i) {
        for (int ring = 0; ring < 2; ++ring) {
          add({at(x, y, i, ring, 1), at(x, y, i, ring + 1, 1), at(x, y, i + 1, ring + 1, 1), at(x, y, i + 1, ring, 1)});
          add({at(x, y, i, ring, 0), at(x, y, i + 1, ring, 0), at(x, y, i + 1, ring + 1, 0), at(x, y, i, ring + 1, 0)});
        }
        add({at(x, y, i, 0, 1), at(x, y, i + 1, 0, 1), at(x, y, i + 1, 0, 0), at(x, y, i, 0, 0)});
        const std::array<bool, 4> is_end{y == n - 1, x == 0, y == 0, x == n - 1};
        if (is_end[i / kFlat])
          add({at(x, y, i, 2, 0), at(x, y, i + 1, 2, 0), at(x, y, i + 1, 2, 1), at(x, y, i, 2, 1)});
      }
  return a;
}

/// Menger's sponge: the level with about so many faces.
Arrays sponge(std::int64_t faces) {
  int n = 3;
  for (std::int64_t at = 144; at * 7 < faces; at *= 16) n *= 3;
  return Cells().surface({n, n, n}, [n](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return false;
    for (; x + y + z > 0; x /= 3, y /= 3, z /= 3)
      if ((x % 3 == 1) + (y % 3 == 1) + (z % 3 == 1) >= 2) return false;
    return true;
  });
}

/// Triangles anywhere in a cube of 1, each of up to that size.
Arrays soup(std::int64_t faces) {
  Arrays a;
  std::mt19937 random(1);
  const auto any = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (std::int32_t f = 0; f < faces; ++f) {
    for (int k = 0; k < 3; ++k) {
      const double x = any(), y = any();
      a.vertices.emplace_back(x, y, any());
    }
    a.triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  return a;
}

Arrays made(const std::string& name) {
  std::istringstream words(name);
  std::string word, kind;
  std::int64_t faces = 0;
  std::getline(words, word, ':');
  std::getline(words, kind, ':');
  if (!(words >> faces) || faces < 12 || faces > 100'000'000)
    throw InvalidInput(name + ": wanted made:KIND:FACES with 12 to 100000000 faces");
  if (kind == "torus") return torus(faces, 2.5);
  if (kind == "slivers") return torus(faces, 1000);
  if (kind == "plane") return plane(faces);
  if (kind == "boxes") return boxes(faces);
  if (kind == "plate") return plate(faces);
  if (kind == "perforated") return perforated(faces);
  if (kind == "sheet") return sheet(faces);
  if (kind == "sponge") return sponge(faces);
  if (kind == "soup") return soup(faces);
  throw InvalidInput(name + ": there are torus, slivers, plane, boxes, plate, perforated, sheet, sponge and soup");
}

Arrays read(const std::string& path) {
  Job job;
  PolygonSoup soup = read_polygons(path, job);
  std::vector<Triangle> triangles = triangulate(soup, job).triangles;
  return {std::move(soup.vertices), std::move(triangles)};
}

/// The new place of an old vertex.
Vec3 smoothed_vertex(const Mesh& mesh, std::int32_t v) {
  const std::int32_t start = mesh.vertex_halfedge()[v];
  const Vec3 here = mesh.vertices()[v];
  if (start == kNone) return here;
  Vec3 sum = Vec3::Zero();
  int valence = 0;
  std::int32_t h = start, last = start;
  do {
    sum += mesh.vertices()[mesh.to(h)];
    ++valence;
    last = h;
    h = mesh.next_outgoing(h);
  } while (h != kNone && h != start);
  if (h == kNone)  // on a border: only the two neighbours along it count
    return 0.75 * here + 0.125 * (mesh.vertices()[mesh.to(start)] + mesh.vertices()[mesh.from(Mesh::prev(last))]);
  const double c = 0.375 + 0.25 * std::cos(kTurn / valence);
  const double weight = (0.625 - c * c) / valence;
  return (1 - valence * weight) * here + weight * sum;
}

}  // namespace

Arrays subdivided(const Arrays& arrays) {
  Job job;
  const Mesh mesh(arrays.vertices, arrays.triangles, job);
  Arrays fine;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) fine.vertices.push_back(smoothed_vertex(mesh, v));
  std::vector<std::int32_t> middle(mesh.opposite().size());
  const auto& at = mesh.vertices();
  for (std::int32_t h = 0; h < static_cast<std::int32_t>(middle.size()); ++h) {
    const std::int32_t other = mesh.opposite(h);
    if (other != kNone && other < h) {
      middle[h] = middle[other];
      continue;
    }
    middle[h] = static_cast<std::int32_t>(fine.vertices.size());
    const Vec3 ends = at[mesh.from(h)] + at[mesh.to(h)];
    if (other == kNone) {
      fine.vertices.push_back(0.5 * ends);
    } else {
      const Vec3 wings = at[mesh.from(Mesh::prev(h))] + at[mesh.from(Mesh::prev(other))];
      fine.vertices.push_back(0.375 * ends + 0.125 * wings);
    }
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.triangles()[f];
    const std::int32_t* m = &middle[3 * static_cast<std::size_t>(f)];
    fine.triangles.push_back({t[0], m[0], m[2]});
    fine.triangles.push_back({t[1], m[1], m[0]});
    fine.triangles.push_back({t[2], m[2], m[1]});
    fine.triangles.push_back({m[0], m[1], m[2]});
  }
  return fine;
}

Arrays load_input(const std::string& name, std::int32_t loop) {
  Arrays arrays = name.starts_with("made:") ? made(name) : read(name);
  for (std::int32_t i = 0; i < loop; ++i) arrays = subdivided(arrays);
  return arrays;
}

}  // namespace isimp::bench
