#include "polygons.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace isimp::meshing {
namespace {

using Cycle = std::vector<std::int32_t>;  // mesh vertices
using Edge = std::array<std::int32_t, 2>;

Edge edge(std::int32_t a, std::int32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Splits the one of `cycles` that has both ends and not as neighbours. \return whether there is one
bool split_at(std::vector<Cycle>& cycles, const Edge& diagonal) {
  for (std::size_t k = 0; k < cycles.size(); ++k) {
    const Cycle& c = cycles[k];
    auto i = std::find(c.begin(), c.end(), diagonal[0]), j = std::find(c.begin(), c.end(), diagonal[1]);
    if (i == c.end() || j == c.end()) continue;
    if (i > j) std::swap(i, j);
    if (j - i < 2 || (i == c.begin() && j == c.end() - 1)) return false;
    Cycle a(i, j + 1), b(j, c.end());
    b.insert(b.end(), c.begin(), i + 1);
    cycles[k] = std::move(a);
    cycles.push_back(std::move(b));
    return true;
  }
  return false;
}

void find_polygons_round_corners(Polygons& p, std::int32_t corners) {
  p.around_start.assign(corners + 1, 0);
  for (const std::int32_t c : p.corners) ++p.around_start[c + 1];
  std::partial_sum(p.around_start.begin(), p.around_start.end(), p.around_start.begin());
  std::vector<std::int32_t> fill(p.around_start.begin(), p.around_start.end() - 1);
  p.around.resize(p.corners.size());
  for (std::int32_t q = 0; q < p.count(); ++q)
    for (const std::int32_t c : p.of(q)) p.around[fill[c]++] = q;
}

}  // namespace

std::int32_t Corners::at(std::int32_t v) {
  std::int32_t& c = of_vertex[v];
  if (c == kNone) {
    c = count();
    vertex.push_back(v);
    pull.push_back(1);
    radius.push_back(0);
    position.emplace_back(Vec3::Zero());
  }
  return c;
}

Polygons collect_polygons(const Complex& complex, const Labels& labels, const Polygons& before, Diagonals& diagonals,
                          Corners& corners, std::vector<std::int32_t>& changed) {
  Polygons p;
  p.start.push_back(0);
  diagonals.resize(labels.pieces.size());
  std::vector<bool> fresh(labels.pieces.size(), true);
  std::fill_n(fresh.begin(), before.first_of.empty() ? 0 : before.first_of.size() - 1, false);
  for (const std::int32_t l : changed) fresh[l] = true;
  std::vector<Edge> added;
  std::vector<Cycle> cycles;
  const auto add = [&](std::int32_t l) {
    p.piece.push_back(l);
    p.start.push_back(static_cast<std::int32_t>(p.corners.size()));
  };
  for (std::int32_t l = 0; l < labels.piece_count(); ++l) {
    p.first_of.push_back(p.count());
    if (complex.chords(l).empty()) continue;  // no more
    if (!fresh[l] && diagonals[l].empty()) {
      const auto same = before.of(before.first_of[l]);
      p.corners.insert(p.corners.end(), same.begin(), same.end());
      add(l);
      continue;
    }
    cycles.assign(1, {});
    for (const std::int32_t h : complex.chords(l)) cycles[0].push_back(labels.mesh.from(h));
    const std::size_t had = diagonals[l].size();
    std::erase_if(diagonals[l], [&](const Edge& d) {
      const Edge e = edge(d[0], d[1]);
      if (complex.has_chord(d[0], d[1]) || std::find(added.begin(), added.end(), e) != added.end() ||
          !split_at(cycles, d))
        return true;
      added.push_back(e);
      return false;
    });
    if (diagonals[l].size() < had) changed.push_back(l);
    for (const Cycle& c : cycles) {
      for (const std::int32_t v : c) p.corners.push_back(corners.at(v));
      add(l);
    }
  }
  p.first_of.push_back(p.count());
  find_polygons_round_corners(p, corners.count());
  return p;
}

Vec3 vector_area(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = position[polygon[0]];
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (position[polygon[i]] - origin).cross(position[polygon[i + 1]] - origin);
  return sum / 2;
}

double bend_of(std::span<const std::int32_t> polygon, std::span<const Vec3> position) {
  const Vec3 area = vector_area(polygon, position);
  const double length = area.norm();
  if (length == 0) return 0;
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t c : polygon) centre += position[c];
  centre /= static_cast<double>(polygon.size());
  double most = 0;
  for (const std::int32_t c : polygon) most = std::max(most, std::abs((position[c] - centre).dot(area)) / length);
  return most;
}

}  // namespace isimp::meshing
