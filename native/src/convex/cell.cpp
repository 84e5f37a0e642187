#include "cell.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isimp::convex {
namespace {

/// Two vectors that make a right-handed frame with a normal.
std::array<Vec3, 2> frame(const Vec3& normal) {
  int least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vec3 u = normal.cross(Vec3::Unit(least)).normalized();
  return {u, normal.cross(u)};
}

/// Rises with the angle of (x, y), from 0 to 4; without a function whose bits depend on the machine.
double turn(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (sum == 0) return 0;
  const double share = x / sum;
  return y >= 0 ? 1 - share : 3 + share;
}

/// Puts the corners of a convex polygon in order, and leaves out repeated ones.
void put_in_order(Loop& loop, const Vec3& normal, double snap) {
  const auto [u, v] = frame(normal);
  const Vec3 middle = mean_of(loop);
  std::vector<std::pair<double, Vec3>> turned;
  for (const Vec3& p : loop) turned.emplace_back(turn((p - middle).dot(u), (p - middle).dot(v)), p);
  std::ranges::stable_sort(turned, {}, &std::pair<double, Vec3>::first);
  loop.clear();
  const auto repeats = [snap](const Vec3& p, const Vec3& q) { return (p - q).cwiseAbs().maxCoeff() <= 2 * snap; };
  for (const auto& [angle, p] : turned)
    if (loop.empty() || !repeats(loop.back(), p)) loop.push_back(p);
  while (loop.size() > 1 && repeats(loop.back(), loop.front())) loop.pop_back();
}

}  // namespace

Vec3 area_vector(std::span<const Vec3> loop) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 2; i < loop.size(); ++i) sum += (loop[i - 1] - loop[0]).cross(loop[i] - loop[0]);
  return sum / 2;
}

Vec3 mean_of(std::span<const Vec3> loop) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : loop) sum += p;
  return sum / static_cast<double>(loop.size());
}

Eigen::AlignedBox3d box_of(std::span<const Vec3> points) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

std::array<Loop, 2> divide(const Loop& loop, const Plane& plane, double snap) {
  std::array<Loop, 2> side;
  std::array<bool, 2> beyond{};
  const auto height = [&](const Vec3& p) {
    const double h = plane.height(p);
    return std::abs(h) <= snap ? 0.0 : h;
  };
  double before = height(loop.back());
  const Vec3* last = &loop.back();
  for (const Vec3& p : loop) {
    const double h = height(p);
    if (h * before < 0) {
      // From above to below in both polygons at an edge, so that both get the same bits.
      const Vec3 &a = h > 0 ? p : *last, &b = h > 0 ? *last : p;
      const double up = std::max(h, before), down = std::min(h, before);
      const Vec3 cut = a + (b - a) * (up / (up - down));
      side[0].push_back(cut);
      side[1].push_back(cut);
    }
    if (h >= 0) side[0].push_back(p);
    if (h <= 0) side[1].push_back(p);
    beyond[0] |= h > 0;
    beyond[1] |= h < 0;
    before = h;
    last = &p;
  }
  for (int k = 0; k < 2; ++k)
    if (!beyond[k] || side[k].size() < 3) side[k].clear();
  return side;
}

Loop overlap(const Loop& loop, const Loop& within, const Vec3& normal, double snap) {
  Loop rest = loop;
  for (std::size_t i = 0; i < within.size() && !rest.empty(); ++i) {
    const Vec3 &a = within[i], &b = within[i + 1 < within.size() ? i + 1 : 0];
    const Vec3 in = normal.cross(b - a);
    const double length = in.norm();
    if (length <= snap) continue;
    rest = std::move(divide(rest, {in / length, in.dot(a) / length}, snap)[0]);
  }
  return rest;
}

std::array<double, 2> Cell::heights(const Plane& plane) const {
  double low_height = std::numeric_limits<double>::infinity(), high_height = -low_height;
  for (const Vec3& p : corners) {
    const double h = plane.height(p);
    low_height = std::min(low_height, h);
    high_height = std::max(high_height, h);
  }
  return {low_height, high_height};
}

void Cell::measure() {
  corners.clear();
  for (const CellFace& face : faces)
    for (const Vec3& p : face.loop)
      if (std::ranges::find(corners, p) == corners.end()) corners.push_back(p);
  box = box_of(corners);
  center = corners.empty() ? Vec3(Vec3::Zero()) : mean_of(corners);
  volume = 0;
  for (const CellFace& face : faces)
    volume += area_vector(face.loop).dot(face.loop[0] - center) * (face.up ? 1 : -1) / 3;
  volume = std::max(volume, 0.0);
}

Cell box_cell(const Vec3& low, const Vec3& high, std::vector<Plane>& planes) {
  Cell cell;
  for (int k = 0; k < 3; ++k)
    for (const bool up : {false, true}) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      Loop loop(4, up ? high : low);
      for (int i = 0; i < 4; ++i) {
        loop[i][u] = i == 1 || i == 2 ? high[u] : low[u];
        loop[i][v] = i >= 2 ? high[v] : low[v];
      }
      cell.faces.push_back({static_cast<std::int32_t>(planes.size()), up, loop});
      planes.push_back({Vec3::Unit(k), loop[0][k]});
    }
  cell.measure();
  return cell;
}

DividedCell divide(const Cell& cell, const std::vector<Plane>& planes, std::int32_t plane, double snap) {
  DividedCell made;
  const Plane& by = planes[plane];
  for (const CellFace& face : cell.faces) {
    auto loops = divide(face.loop, by, snap);
    for (int k = 0; k < 2; ++k) {
      for (const Vec3& p : loops[k])
        if (std::abs(by.height(p)) <= 2 * snap) made.between.push_back(p);
      if (!loops[k].empty()) made.side[k].faces.push_back({face.plane, face.up, std::move(loops[k])});
    }
  }
  if (!made.between.empty()) put_in_order(made.between, by.normal, snap);
  if (made.between.size() < 3) made.between.clear();
  for (int k = 0; k < 2; ++k) {
    if (!made.between.empty()) made.side[k].faces.push_back({plane, k == 1, made.between});
    made.side[k].measure();
  }
  return made;
}

}  // namespace isimp::convex
