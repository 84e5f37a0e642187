#include "cleaning/grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "isimp/core/to_integer.h"
#include "isimp/mesh/mesh.h"

namespace isimp::detail {
namespace {

constexpr double kSame = 1e-4;  // rounding: share of the extent: values at a smaller distance are equal
// tuned repairs
constexpr std::size_t kLeast = 8;     // values along an axis, with fewer there is no grid to be found
constexpr double kOffLattice = 0.02;  // share of half a cell
constexpr double kShare = 0.98;       // least share of the vertices at places of a grid of occupancy

/// The distinct values of an axis, rising; a value equal to a lower one is dropped. The values are only sorted into
/// intervals, as few values are distinct.
std::vector<double> distinct_values(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double first = *low, same = kSame * (*high - first);
  if (!(same > 0)) return {first};
  constexpr std::size_t kIntervals = 1.5 / kSame;  // unit
  const auto interval = [&](double v) { return to_integer((v - first) / same, std::size_t{0}, kIntervals - 1); };
  std::vector<std::size_t> start(kIntervals + 1, 0);
  for (const double v : values) ++start[interval(v) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<double> sorted(values.size());
  std::vector<std::size_t> fill(start.begin(), start.end() - 1);
  for (const double v : values) sorted[fill[interval(v)]++] = v;
  std::vector<double> distinct{first};
  for (std::size_t i = 0; i < kIntervals;) {
    double next = std::numeric_limits<double>::infinity();
    for (std::size_t k = start[i]; k < start[i + 1]; ++k)
      if (sorted[k] - distinct.back() > same) next = std::min(next, sorted[k]);
    if (std::isfinite(next))
      distinct.push_back(next);
    else
      ++i;
  }
  return distinct;
}

/// The distance that most of the different values of an axis are apart; 0 where few vertices share a value.
double common_step(const std::vector<double>& values) {
  const std::vector<double> distinct = distinct_values(values);
  if (distinct.size() < kLeast || distinct.size() * 2 > values.size()) return 0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < distinct.size(); ++i) steps.push_back(distinct[i] - distinct[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Whether less than kShare of `all` numbers fit, when `off` of them do not.
bool too_many(std::size_t off, std::size_t all) {
  return static_cast<double>(all - off) < kShare * static_cast<double>(all);
}

/// Whether the vertices are where marching cubes of occupied and empty cells has them, in the middles of the edges of a
/// grid: of their three places on a lattice of half a cell one is odd, and two are even.
bool is_of_grid(const std::vector<Vec3>& vertices, double half) {
  const Eigen::AlignedBox3d box = std::accumulate(vertices.begin(), vertices.end(), Eigen::AlignedBox3d(),
                                                  [](Eigen::AlignedBox3d b, const Vec3& v) { return b.extend(v); });
  // The rounding of the file is in one step, but hardly in the whole extent.
  const Vec3 counts = (box.sizes() / half).array().round(), step = box.sizes().cwiseQuotient(counts.cwiseMax(1.0));
  if ((step / half - Vec3::Ones()).cwiseAbs().maxCoeff() > kOffLattice) return false;
  // Which places are odd along an axis is not known: all eight ways are counted.
  std::array<std::array<std::size_t, 3>, 8> odd_along{};
  std::size_t off = 0;
  for (const Vec3& v : vertices) {
    const Vec3 place = (v - box.min()).cwiseQuotient(step), whole = place.array().round();
    if ((place - whole).cwiseAbs().maxCoeff() > kOffLattice) {
      if (too_many(++off, vertices.size())) return false;
      continue;
    }
    int odd = 0;
    for (int k = 0; k < 3; ++k) odd |= (to_integer(whole[k], 0, std::numeric_limits<int>::max()) & 1) << k;
    for (int way = 0; way < 8; ++way) {
      const int parity = odd ^ way;
      if (parity == 1 || parity == 2 || parity == 4) ++odd_along[way][parity / 2];
    }
  }
  // A mesh of blocks has its vertices at the corners of cells: then all would be odd along one axis.
  return std::any_of(odd_along.begin(), odd_along.end(), [&](const std::array<std::size_t, 3>& n) {
    const auto all = static_cast<double>(vertices.size());
    return static_cast<double>(n[0] + n[1] + n[2]) >= kShare * all &&
           static_cast<double>(std::min({n[0], n[1], n[2]})) > (1 - kShare) * all;
  });
}

/// The cell of the grid; 0 where the mesh is of none.
double find_cell(const std::vector<Vec3>& vertices) {
  double step = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(vertices.size());
    for (const Vec3& v : vertices) values.push_back(v[k]);
    const double own = common_step(values);
    if (!(own > 0)) return 0;
    step = std::min(step, own);
  }
  // Along a wall that lies in the grid the vertices are a cell apart, else half of one.
  for (const double half : {step, step / 2})
    if (is_of_grid(vertices, half)) return 2 * half;
  return 0;
}

/// The directions of a grid that a mesh was cut on and turned with, as columns; nothing where it was not. An edge of
/// such a mesh joins middles of edges of one cell, so it has one of four lengths, and the second of them along an axis.
std::optional<Eigen::Matrix3d> find_axes(const MeshArrays& arrays) {
  constexpr double kSameLength = 2e-3;  // rounding: share of a cell
  const std::array lengths{std::sqrt(0.5), 1.0, std::sqrt(1.5), std::sqrt(2.0)};
  const auto edge = [&](const Triangle& t, int k) -> Vec3 {
    return arrays.vertices[t[k < 2 ? k + 1 : 0]] - arrays.vertices[t[k]];
  };
  double shortest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : arrays.triangles)
    for (int k = 0; k < 3; ++k) shortest = std::min(shortest, edge(t, k).squaredNorm());
  const double cell = std::sqrt(shortest) / lengths[0];
  const std::size_t edges = 3 * arrays.triangles.size();
  std::size_t off = 0;
  std::array<Vec3, 3> sum{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  int known = 0;
  for (std::size_t i = 0; i < edges; ++i) {
    const Vec3 e = edge(arrays.triangles[i / 3], static_cast<int>(i % 3));
    const double length = e.norm() / cell;
    const auto is = [&](double l) { return std::abs(length - l) < kSameLength; };
    if (!std::any_of(lengths.begin(), lengths.end(), is)) {
      if (too_many(++off, edges)) return std::nullopt;
      continue;
    }
    if (!is(lengths[1])) continue;
    int axis = 0;  // the known one along which it is, else a new one at right angles to all
    while (axis < known && std::abs(e.dot(sum[axis])) < 0.5 * e.norm() * sum[axis].norm()) ++axis;
    if (axis == 3) return std::nullopt;
    if (axis == known) ++known;
    sum[axis] += e.dot(sum[axis]) < 0 ? Vec3(-e) : e;
  }
  if (known < 3) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = sum[0].normalized();
  axes.col(2) = axes.col(0).cross(sum[1]).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  if (std::abs(axes.col(2).dot(sum[2].normalized())) < 1 - kSameLength) return std::nullopt;
  return axes;
}

}  // namespace

Grid find_grid(const MeshArrays& arrays) {
  Grid grid{.cell = find_cell(arrays.vertices)};
  if (grid.cell > 0) return grid;
  const std::optional<Eigen::Matrix3d> axes = find_axes(arrays);
  if (!axes) return grid;
  std::vector<Vec3> along;
  along.reserve(arrays.vertices.size());
  for (const Vec3& v : arrays.vertices) along.emplace_back(axes->transpose() * v);
  return {.cell = find_cell(along), .axes = *axes};
}

}  // namespace isimp::detail
