// Gibson: Constrained elastic surface nets, 1998. Zheng, Fu, Au, Tai: Bilateral normal filtering for mesh denoising, 2011.

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "cleaning/grid.h"

namespace isimp::detail {
namespace {

// tuned grids
constexpr int kRounds = 200;    // the steps of a plane that is nearly parallel to an axis are tens of cells long
constexpr int kTurns = 3;       // of filtering normals and following them
constexpr int kPasses = 8;      // of the filter
constexpr int kMoves = 10;      // of the vertices toward the planes of their faces
constexpr double kRange = 0.3;  // difference of normals beyond which two faces do not mix

/// The faces of each vertex.
struct FacesAt {
  std::vector<std::int32_t> start, face;

  FacesAt(std::size_t count, std::span<const Triangle> triangles) : start(count + 1, 0) {
    for (const Triangle& t : triangles)
      for (const std::int32_t v : t) ++start[v + 1];
    for (std::size_t v = 0; v < count; ++v) start[v + 1] += start[v];
    face.resize(static_cast<std::size_t>(start.back()));
    std::vector<std::int32_t> next(start.begin(), start.end() - 1);
    for (std::size_t f = 0; f < triangles.size(); ++f)
      for (const std::int32_t v : triangles[f]) face[next[v]++] = static_cast<std::int32_t>(f);
  }
};

/// Moves vertices within half a cell of the places that they had at first.
class Smoother {
 public:
  Smoother(MeshArrays& arrays, const Topology& topology, const Grid& grid, const Threads& threads, Job& job)
      : vertices_(arrays.vertices),
        triangles_(arrays.triangles),
        topology_(topology),
        grid_(grid),
        threads_(threads),
        job_(job),
        at_(arrays.vertices.size(), arrays.triangles),
        home_(arrays.vertices),
        fixed_(arrays.vertices.size(), 0),
        faces_(arrays.triangles.size()) {
    for (const std::int32_t h : topology.border) fixed_[triangles_[h / 3][h % 3]] = 1;
  }

  void run() {
    for (int round = 0; round < kRounds; ++round) shrink();
    for (int turn = 0; turn < kTurns; ++turn) {
      const std::vector<Vec3> normals = filtered_normals();
      for (int move = 0; move < kMoves; ++move) follow(normals);
    }
  }

 private:
  struct Face {
    Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
    double area = 0;
  };

  /// Calls body(i) for i in [0, n) on all threads.
  template <class Body>
  void each(std::size_t n, const Body& body) const {
    threads_.blocks(static_cast<std::int32_t>(n), 4096, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
      for (std::int32_t i = begin; i < end; ++i) body(i);
    });
  }

  /// Moves each vertex that is not fixed by step_of(vertex), as far as the cell allows. Steps depend on `before_`.
  template <class Step>
  void move(const Step& step_of) {
    job_.poll();
    before_ = vertices_;
    const double half = grid_.cell / 2;
    each(vertices_.size(), [&](std::int32_t v) {
      if (fixed_[v] || at_.start[v] == at_.start[v + 1]) return;
      const Vec3 off = before_[v] + step_of(v) - home_[v];
      vertices_[v] = home_[v] + grid_.axes * (grid_.axes.transpose() * off).cwiseMax(-half).cwiseMin(half);
    });
  }

  void shrink() {
    move([&](std::int32_t v) -> Vec3 {
      Vec3 sum = Vec3::Zero();  // each neighbour once for each common face
      for (std::int32_t i = at_.start[v]; i < at_.start[v + 1]; ++i)
        for (const std::int32_t w : triangles_[at_.face[i]])
          if (w != v) sum += before_[w] - before_[v];
      return sum / (2 * (at_.start[v + 1] - at_.start[v]));
    });
  }

  void measure_faces() {
    each(triangles_.size(), [&](std::int32_t f) {
      const Vec3 &a = vertices_[triangles_[f][0]], &b = vertices_[triangles_[f][1]], &c = vertices_[triangles_[f][2]];
      const Vec3 twice = (b - a).cross(c - a);
      const double length = twice.norm();
      faces_[f] = {
          .normal = length > 0 ? Vec3(twice / length) : Vec3::Zero(), .middle = (a + b + c) / 3, .area = length / 2};
    });
  }

  std::vector<Vec3> filtered_normals() {
    measure_faces();
    std::vector<Vec3> now(triangles_.size()), next(triangles_.size());
    each(now.size(), [&](std::int32_t f) { now[f] = faces_[f].normal; });
    for (int pass = 0; pass < kPasses; ++pass) {
      job_.poll();
      each(now.size(), [&](std::int32_t f) {
        Vec3 sum = faces_[f].area * now[f];
        for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
          const std::int32_t o = topology_.opposite[h];
          if (o == kNone) continue;
          const Vec3& other = now[o / 3];
          sum += faces_[o / 3].area * std::exp((now[f] - other).squaredNorm() / (-2 * kRange * kRange)) * other;
        }
        const double length = sum.norm();
        next[f] = length > 0 ? Vec3(sum / length) : now[f];
      });
      now.swap(next);
    }
    return now;
  }

  /// Moves the vertices toward the planes through the middles of their faces with these normals.
  void follow(const std::vector<Vec3>& normals) {
    measure_faces();
    move([&](std::int32_t v) -> Vec3 {
      Vec3 sum = Vec3::Zero();
      double area = 0;
      for (std::int32_t i = at_.start[v]; i < at_.start[v + 1]; ++i) {
        const Face& face = faces_[at_.face[i]];
        const Vec3& normal = normals[at_.face[i]];
        sum += face.area * normal.dot(face.middle - before_[v]) * normal;
        area += face.area;
      }
      return area > 0 ? Vec3(sum / area) : Vec3::Zero();
    });
  }

  std::vector<Vec3>& vertices_;
  const std::vector<Triangle>& triangles_;
  const Topology& topology_;
  const Grid& grid_;
  const Threads& threads_;
  Job& job_;
  FacesAt at_;
  std::vector<Vec3> home_, before_;
  std::vector<char> fixed_;
  std::vector<Face> faces_;
};

}  // namespace

bool smooth_steps(MeshArrays& arrays, const Topology& topology, std::optional<double> cell, RepairLog& log,
                  const Threads& threads, Job& job) {
  if (cell == 0.0) return false;
  const Grid grid = cell ? Grid{.cell = *cell} : find_grid(arrays);
  if (!(grid.cell > 0)) return false;
  const std::vector<Vec3> home = arrays.vertices;
  Smoother(arrays, topology, grid, threads, job).run();
  arrays.cell = grid.cell;
  for (std::size_t v = 0; v < home.size(); ++v)
    if (home[v] != arrays.vertices[v])
      log.add(RepairKind::smoothed_vertices,
              arrays.source_vertex.empty() ? static_cast<std::int32_t>(v) : arrays.source_vertex[v]);
  return true;
}

}  // namespace isimp::detail
