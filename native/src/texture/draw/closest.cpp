// Finds the closest point of the scan by cells.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "draw/view.h"

namespace isimp::detail {
namespace {

constexpr float kRounding = 1.0001F;                            // rounding
constexpr float kFar = std::numeric_limits<float>::infinity();  // mark

/// The closest point of a face to (x, y, 0) (Ericson, Real-Time Collision Detection, 5.1.5): its weights, and the
/// squared distance.
float closest_on(const FlatFace& f, float x, float y, float& b, float& c) {
  const float ux = f.x[1] - f.x[0], uy = f.y[1] - f.y[0], uz = f.z[1] - f.z[0];
  const float vx = f.x[2] - f.x[0], vy = f.y[2] - f.y[0], vz = f.z[2] - f.z[0];
  const float px = x - f.x[0], py = y - f.y[0], pz = -f.z[0];
  const float uu = ux * ux + uy * uy + uz * uz, uv = ux * vx + uy * vy + uz * vz, vv = vx * vx + vy * vy + vz * vz;
  const float d1 = ux * px + uy * py + uz * pz, d2 = vx * px + vy * py + vz * pz;
  const float d3 = d1 - uu, d4 = d2 - uv, d5 = d1 - uv, d6 = d2 - vv;
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  b = c = 0;
  if (d1 <= 0 && d2 <= 0) {
  } else if (d3 >= 0 && d4 <= d3) {
    b = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    b = d1 / (d1 - d3);
  } else if (d6 >= 0 && d5 <= d6) {
    c = 1;
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    c = d2 / (d2 - d6);
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    c = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    b = 1 - c;
  } else {
    const float sum = va + vb + vc;
    b = sum > 0 ? vb / sum : 0;
    c = sum > 0 ? vc / sum : 0;
  }
  const float qx = px - b * ux - c * vx, qy = py - b * uy - c * vy, qz = pz - b * uz - c * vz;
  return qx * qx + qy * qy + qz * qz;
}

Hit hit_on(const FlatFace& f, std::int32_t item, float x, float y) {
  float b = 0, c = 0;
  closest_on(f, x, y, b, c);
  return {f.face, b, c, item};
}

using Four = Eigen::Array4f;  // a processor computes all four at once

Four unit(const Four& t) { return t.min(1.0F).max(0.0F); }

/// The closest faces to the points of a quad among the faces tried.
struct Nearest {
  Four squared;  // -1 for unused points
  std::array<std::int32_t, 4> face, item;
};

/// Stores a face where it is closer: the distance from the plane above the face, from its three edges elsewhere. Among
/// equals the first face counts, for every polygon alike. Returns whether it is closer anywhere.
bool take(const FlatEdges& f, std::int32_t face, std::int32_t item, const Four& x, const Four& y, Nearest& best) {
  const float wx = f.vx - f.ux, wy = f.vy - f.uy, wz = f.vz - f.uz;
  const Four px = x - f.x, py = y - f.y;
  const float pz = -f.z;
  const Four d = px * f.ux + py * f.uy + pz * f.uz, e = px * f.vx + py * f.vy + pz * f.vz;
  const Four b = (d * f.vv - e * f.uv) * f.over_det, c = (e * f.uu - d * f.uv) * f.over_det;
  const Four nx = px - b * f.ux - c * f.vx, ny = py - b * f.uy - c * f.vy, nz = pz - b * f.uz - c * f.vz;
  const Four plane = nx * nx + ny * ny + nz * nz, inside = b.min(c).min(1 - b - c);
  const Four r = unit(d * f.over_uu), s = unit(e * f.over_vv), t = unit((e - d + (f.uu - f.uv)) * f.over_ww);
  const Four ax = px - r * f.ux, ay = py - r * f.uy, az = pz - r * f.uz;
  const Four bx = px - s * f.vx, by = py - s * f.vy, bz = pz - s * f.vz;
  const Four cx = px - f.ux - t * wx, cy = py - f.uy - t * wy, cz = pz - f.uz - t * wz;
  const Four rim = (ax * ax + ay * ay + az * az).min(bx * bx + by * by + bz * bz).min(cx * cx + cy * cy + cz * cz);
  bool any = false;
  for (int k = 0; k < 4; ++k) {
    const float squared = inside[k] >= 0 ? plane[k] : rim[k];
    if (squared > best.squared[k] || (squared == best.squared[k] && face >= best.face[k])) continue;
    best.squared[k] = squared;
    best.face[k] = face;
    best.item[k] = item;
    any = true;
  }
  return any;
}

}  // namespace

FlatEdges edges_of(const FlatFace& f) {
  FlatEdges e;
  e.x = f.x[0], e.y = f.y[0], e.z = f.z[0];
  e.ux = f.x[1] - f.x[0], e.uy = f.y[1] - f.y[0], e.uz = f.z[1] - f.z[0];
  e.vx = f.x[2] - f.x[0], e.vy = f.y[2] - f.y[0], e.vz = f.z[2] - f.z[0];
  const float wx = e.vx - e.ux, wy = e.vy - e.uy, wz = e.vz - e.uz;
  const auto over = [](float value) { return value > 0 ? 1 / value : 0.0F; };
  e.uu = e.ux * e.ux + e.uy * e.uy + e.uz * e.uz;
  e.vv = e.vx * e.vx + e.vy * e.vy + e.vz * e.vz;
  e.uv = e.ux * e.vx + e.uy * e.vy + e.uz * e.vz;
  e.over_uu = over(e.uu);
  e.over_vv = over(e.vv);
  e.over_ww = over(wx * wx + wy * wy + wz * wz);
  const float det = e.uu * e.vv - e.uv * e.uv;
  e.over_det = det > 0 ? 1 / det : std::numeric_limits<float>::quiet_NaN();
  return e;
}

std::array<Hit, 4> PolygonView::closest(const Quad& quad, std::array<std::int32_t, 2> guesses, Visited& visited) const {
  std::array<Hit, 4> hits;
  if (quad.wanted == 0 || upright_.empty()) return hits;
  Nearest best;
  Four x, y;
  for (int k = 0; k < 4; ++k) {
    x[k] = quad.x + quad.step * static_cast<float>(k % 2);
    y[k] = quad.y + quad.step * static_cast<float>(k >> 1);
    best.squared[k] = (quad.wanted >> k & 1) != 0 ? kFar : -1.0F;
    best.face[k] = best.item[k] = kNone;
  }
  if (guesses[0] == kNone && guesses[1] == kNone) guesses[0] = closest(quad.x, quad.y).index;
  visited.begin(upright_.size());
  for (const std::int32_t guess : guesses)
    if (guess != kNone && visited.first(guess)) take(edges_[guess], upright_[guess].face, guess, x, y, best);
  float least = best.squared.maxCoeff() * kRounding;
  const float reach = std::sqrt(least), right = quad.x + quad.step, above = quad.y + quad.step;
  const std::int32_t i1 = grid_.column(right + reach), j1 = grid_.row(above + reach);
  for (std::int32_t j = grid_.row(quad.y - reach); j <= j1; ++j)
    for (std::int32_t i = grid_.column(quad.x - reach); i <= i1; ++i) {
      const float off = grid_.off(i, j);
      if (grid_.away(i, j, quad.x, right, quad.y, above) + off * off > least) continue;
      const auto items = grid_.in(i, j);
      const auto boxes = grid_.boxes_in(i, j);
      for (std::size_t k = 0; k < items.size(); ++k) {
        const FlatBox& e = boxes[k];
        const std::int32_t item = items[k];
        const float over = std::max(std::max(0.0F, e.low_x - right), quad.x - e.high_x);
        const float up = std::max(std::max(0.0F, e.low_y - above), quad.y - e.high_y);
        if (over * over + up * up + e.off * e.off > least || !visited.first(item)) continue;
        if (take(edges_[item], upright_[item].face, item, x, y, best)) least = best.squared.maxCoeff() * kRounding;
      }
    }
  for (int k = 0; k < 4; ++k)
    if (best.item[k] != kNone) hits[k] = hit_on(upright_[best.item[k]], best.item[k], x[k], y[k]);
  return hits;
}

/// Cells are searched in rings around that of the point. Faces beyond the grid are in the cells at its rim, which are
/// no further away than these faces.
Hit PolygonView::closest(float x, float y) const {
  std::int32_t best = kNone;
  float least = kFar;
  const auto look_at = [&](std::int32_t item) {
    const FlatBox& e = boxes_[item];
    const float over = std::max({0.0F, e.low_x - x, x - e.high_x}), up = std::max({0.0F, e.low_y - y, y - e.high_y});
    if (over * over + up * up + e.off * e.off > least * kRounding) return;
    const FlatFace& f = upright_[item];
    float b = 0, c = 0;
    const float d = closest_on(f, x, y, b, c);
    if (d > least || (d == least && best != kNone && f.face >= upright_[best].face)) return;
    least = d;
    best = item;
  };
  const std::int32_t ci = grid_.column(x), cj = grid_.row(y);
  const std::int32_t rings = std::max({ci, cj, grid_.columns() - 1 - ci, grid_.rows() - 1 - cj});
  bool reached = true;  // whether any cell of the last ring was near enough
  const auto look_in = [&](std::int32_t i, std::int32_t j) {
    if (i < 0 || j < 0 || i >= grid_.columns() || j >= grid_.rows()) return;
    const float away = grid_.away(i, j, x, x, y, y), off = grid_.off(i, j);
    if (away > least * kRounding) return;
    reached = true;
    if (away + off * off > least * kRounding) return;
    for (const std::int32_t item : grid_.in(i, j)) look_at(item);
  };
  for (std::int32_t ring = 0; ring <= rings && reached; ++ring) {
    reached = false;
    for (std::int32_t i = ci - ring; i <= ci + ring; ++i) {
      look_in(i, cj - ring);
      if (ring > 0) look_in(i, cj + ring);
    }
    for (std::int32_t j = cj - ring + 1; j < cj + ring; ++j) {
      look_in(ci - ring, j);
      look_in(ci + ring, j);
    }
  }
  return best == kNone ? Hit() : hit_on(upright_[best], best, x, y);
}

}  // namespace isimp::detail
