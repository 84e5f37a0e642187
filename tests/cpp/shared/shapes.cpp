#include "tests.h"

namespace isimp::shapes {
namespace {

using Place = std::array<long long, 3>;  // in millionths

/// Adds a grid of n by n squares spanned by u and v from `origin`, sharing vertices with equal positions.
void add_grid(Arrays& a, std::map<Place, std::int32_t>& known, int n, const Vec3& origin, const Vec3& u,
              const Vec3& v) {
  const auto at = [&](int i, int j) {
    const Vec3 p = origin + u * (static_cast<double>(i) / n) + v * (static_cast<double>(j) / n);
    const Place key{std::llround(p.x() * 1e6), std::llround(p.y() * 1e6), std::llround(p.z() * 1e6)};
    const auto [it, fresh] = known.try_emplace(key, static_cast<std::int32_t>(a.vertices.size()));
    if (fresh) a.vertices.push_back(p);
    return it->second;
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      a.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      a.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

}  // namespace

Arrays cube(int n) {
  Arrays a;
  std::map<Place, std::int32_t> known;
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ(), o = Vec3::Zero();
  add_grid(a, known, n, o, y, x);
  add_grid(a, known, n, z, x, y);
  add_grid(a, known, n, o, x, z);
  add_grid(a, known, n, y, z, x);
  add_grid(a, known, n, o, z, y);
  add_grid(a, known, n, x, y, z);
  return a;
}

Arrays plane(int n) {
  Arrays a;
  std::map<Place, std::int32_t> known;
  add_grid(a, known, n, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
  return a;
}

Arrays sphere(int levels) {
  Arrays a;
  const double g = std::numbers::phi;
  for (const double s : {-1.0, 1.0})
    for (const double t : {-g, g}) {
      a.vertices.emplace_back(0, s, t);
      a.vertices.emplace_back(s, t, 0);
      a.vertices.emplace_back(t, 0, s);
    }
  for (Vec3& v : a.vertices) v.normalize();
  const double edge = 2.0 / std::sqrt(1 + g * g) + 1e-9;
  const auto n = static_cast<std::int32_t>(a.vertices.size());
  const auto near = [&](std::int32_t i, std::int32_t j) { return (a.vertices[i] - a.vertices[j]).norm() < edge; };
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = i + 1; j < n; ++j)
      for (std::int32_t k = j + 1; k < n; ++k) {
        if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
        const Vec3 normal = (a.vertices[j] - a.vertices[i]).cross(a.vertices[k] - a.vertices[i]);
        if (normal.dot(a.vertices[i]) > 0) {
          a.triangles.push_back({i, j, k});
        } else {
          a.triangles.push_back({i, k, j});
        }
      }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middle;
    const auto split = [&](std::int32_t i, std::int32_t j) {
      const auto [it, fresh] = middle.try_emplace(std::minmax(i, j), static_cast<std::int32_t>(a.vertices.size()));
      if (fresh) a.vertices.push_back((a.vertices[i] + a.vertices[j]).normalized());
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [i, j, k] : a.triangles) {
      const std::int32_t ij = split(i, j), jk = split(j, k), ki = split(k, i);
      finer.insert(finer.end(), {{i, ij, ki}, {j, jk, ij}, {k, ki, jk}, {ij, jk, ki}});
    }
    a.triangles = std::move(finer);
  }
  return a;
}

Arrays torus(int nu, int nv, double r) {
  Arrays a;
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const double u = 2 * std::numbers::pi * i / nu, v = 2 * std::numbers::pi * j / nv;
      const double d = 1 + r * std::cos(v);
      a.vertices.emplace_back(d * std::cos(u), d * std::sin(u), r * std::sin(v));
    }
  const auto at = [&](int i, int j) { return static_cast<std::int32_t>((i % nu) * nv + j % nv); };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      a.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      a.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return a;
}

Arrays perforated(int w, int h, double thickness, const std::function<bool(int x, int y)>& is_open) {
  Arrays a;
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y <= h; ++y)
      for (int x = 0; x <= w; ++x) a.vertices.emplace_back(x, y, thickness * z);
  const auto at = [&](int x, int y, int z) { return (z * (h + 1) + y) * (w + 1) + x; };
  const auto add = [&](int p, int q, int r, int s) {
    a.triangles.push_back({p, q, r});
    a.triangles.push_back({p, r, s});
  };
  const auto is_wall = [&](int x, int y) { return x < 0 || y < 0 || x >= w || y >= h || is_open(x, y); };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (is_open(x, y)) continue;
      add(at(x, y, 1), at(x + 1, y, 1), at(x + 1, y + 1, 1), at(x, y + 1, 1));
      add(at(x, y, 0), at(x, y + 1, 0), at(x + 1, y + 1, 0), at(x + 1, y, 0));
      if (is_wall(x, y - 1)) add(at(x, y, 0), at(x + 1, y, 0), at(x + 1, y, 1), at(x, y, 1));
      if (is_wall(x, y + 1)) add(at(x + 1, y + 1, 0), at(x, y + 1, 0), at(x, y + 1, 1), at(x + 1, y + 1, 1));
      if (is_wall(x - 1, y)) add(at(x, y + 1, 0), at(x, y, 0), at(x, y, 1), at(x, y + 1, 1));
      if (is_wall(x + 1, y)) add(at(x + 1, y, 0), at(x + 1, y + 1, 0), at(x + 1, y + 1, 1), at(x + 1, y, 1));
    }
  return a;
}

Arrays scaled(Arrays a, double by) {
  for (Vec3& v : a.vertices) v *= by;
  return a;
}

Arrays moved(Arrays a, const Vec3& by) {
  for (Vec3& v : a.vertices) v += by;
  return a;
}

Arrays both(const Arrays& a, const Arrays& b, const Vec3& offset) {
  Arrays sum = a;
  const auto shift = static_cast<std::int32_t>(a.vertices.size());
  for (const Vec3& v : b.vertices) sum.vertices.push_back(v + offset);
  for (const auto& [i, j, k] : b.triangles) sum.triangles.push_back({i + shift, j + shift, k + shift});
  return sum;
}

Arrays shuffled(const Arrays& a, std::uint32_t seed) {
  Arrays result = a;
  std::mt19937 random(seed);
  std::shuffle(result.triangles.begin(), result.triangles.end(), random);
  return result;
}

Arrays noisy(const Arrays& a, double sigma, std::uint32_t seed) {
  Arrays result = a;
  if (sigma == 0) return result;  // which the distribution does not accept
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  for (Vec3& v : result.vertices) v += Vec3(normal(random), normal(random), normal(random));
  return result;
}

Arrays smoothed(const Arrays& a, int rounds) {
  std::vector<std::set<std::int32_t>> beside(a.vertices.size());
  for (const auto& [i, j, k] : a.triangles) {
    beside[i].insert({j, k});
    beside[j].insert({k, i});
    beside[k].insert({i, j});
  }
  Arrays result = a;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec3> before = result.vertices;
    for (std::size_t v = 0; v < before.size(); ++v) {
      Vec3 sum = Vec3::Zero();
      for (const std::int32_t w : beside[v]) sum += before[w];
      result.vertices[v] += 0.5 * (sum / static_cast<double>(beside[v].size()) - before[v]);
    }
  }
  return result;
}

Mesh mesh(const Arrays& a) { return Mesh(a.vertices, a.triangles, job()); }

Vec3 middle(const Mesh& mesh, std::int32_t face) {
  const auto [a, b, c] = mesh.triangles()[face];
  return (mesh.vertices()[a] + mesh.vertices()[b] + mesh.vertices()[c]) / 3;
}

std::vector<std::int32_t> labels(const Mesh& mesh, const std::function<std::int32_t(const Vec3&)>& label) {
  std::vector<std::int32_t> all;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) all.push_back(label(middle(mesh, f)));
  return all;
}

}  // namespace isimp::shapes
