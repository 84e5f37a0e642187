#include "draw/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

constexpr float kTouch =
    2e-3F;  // rounding: samples by which a face is wider than it is, so that no gap shows between two
constexpr float kMostCells = 65536;  // work
// tuned texture
constexpr float kShifted = 0.2F;  // share of a polygon's margin; faces further away are not drawn on it
constexpr float kInCell = 2;      // work: faces in a cell, about

/// The least integer not below x, for x of at least 0; cheaper than std::ceil.
std::int32_t ceiling(float x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole + (static_cast<float>(whole) < x ? 1 : 0);
}

FlatBox extent(const FlatFace& f) {
  const auto [low_x, high_x] = std::minmax({f.x[0], f.x[1], f.x[2]});
  const auto [low_y, high_y] = std::minmax({f.y[0], f.y[1], f.y[2]});
  const auto [low_z, high_z] = std::minmax({f.z[0], f.z[1], f.z[2]});
  return {low_x, high_x, low_y, high_y, std::max({0.0F, low_z, -high_z})};
}

float double_area(const FlatFace& f) {
  return (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) - (f.y[1] - f.y[0]) * (f.x[2] - f.x[0]);
}

}  // namespace

void Bins::build(std::span<const FlatBox> faces, const TexelBox& box, float cell, bool with_boxes) {
  x0_ = static_cast<float>(box.x0);
  y0_ = static_cast<float>(box.y0);
  cell_ = cell;
  columns_ = std::max(1, static_cast<std::int32_t>(std::ceil(static_cast<float>(box.width()) / cell)));
  rows_ = std::max(1, static_cast<std::int32_t>(std::ceil(static_cast<float>(box.height()) / cell)));
  start_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  const auto for_cells = [&](const FlatBox& e, auto visit) {
    const std::int32_t i1 = column(e.high_x), j1 = row(e.high_y);
    for (std::int32_t j = row(e.low_y); j <= j1; ++j)
      for (std::int32_t i = column(e.low_x); i <= i1; ++i) visit(static_cast<std::size_t>(j) * columns_ + i);
  };
  off_.assign(start_.size() - 1, std::numeric_limits<float>::infinity());
  for (const FlatBox& face : faces)
    for_cells(face, [&](std::size_t k) {
      ++start_[k + 1];
      off_[k] = std::min(off_[k], face.off);
    });
  for (std::size_t k = 1; k < start_.size(); ++k) start_[k] += start_[k - 1];
  item_.resize(start_.back());
  box_.resize(with_boxes ? item_.size() : 0);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for_cells(faces[i], [&](std::size_t k) {
      if (with_boxes) box_[start_[k]] = faces[i];
      item_[start_[k]++] = static_cast<std::int32_t>(i);
    });
  std::copy_backward(start_.begin(), start_.end() - 1, start_.end());
  start_[0] = 0;
}

std::span<const std::int32_t> Bins::in(std::int32_t i, std::int32_t j) const {
  const std::size_t k = static_cast<std::size_t>(j) * columns_ + i;
  return std::span(item_).subspan(start_[k], start_[k + 1] - start_[k]);
}

std::int32_t Bins::column(float x) const { return to_integer((x - x0_) / cell_, 0, columns_ - 1); }

std::int32_t Bins::row(float y) const { return to_integer((y - y0_) / cell_, 0, rows_ - 1); }

void PolygonView::look(const ChartFrame& frame, const TexelBox& box, std::int32_t region, const Lean& lean) {
  box_ = box;
  collect(frame, region, lean, true);
  if (faces_.empty())
    collect(frame, region, lean, false);  // no face looks the polygon's way: others are better than
                                          // none
  edges_.clear();
  for (const FlatFace& f : upright_) edges_.push_back(edges_of(f));
  squares_.build(boxes_, box, static_cast<float>(kSquare), false);
  const float texels = static_cast<float>(box.width()) * static_cast<float>(box.height());
  const float cells = std::clamp(static_cast<float>(faces_.size()), 1.0F, kMostCells);
  grid_.build(upright_boxes_, box, std::max(4.0F, std::sqrt(kInCell * texels / cells)), true);
}

namespace {

/// From the mesh into a chart: texels right, up, and above the plane.
struct IntoChart {
  Vec3 origin, u, v, n;
  double scale;  // texels per scene unit

  explicit IntoChart(const ChartFrame& frame) : origin(frame.origin), scale(1 / frame.u.norm()) {
    u = frame.u * (scale * scale);
    v = frame.v * (scale * scale);
    n = frame.n * scale;
  }
  [[nodiscard]] std::array<float, 3> operator()(const Vec3& at) const {
    const Vec3 d = at - origin;
    return {static_cast<float>(d.dot(u)), static_cast<float>(d.dot(v)), static_cast<float>(d.dot(n))};
  }
  [[nodiscard]] bool beyond(const Neighbourhood::Block& block, const TexelBox& box, double margin) const {
    const Vec3 d = block.middle - origin;
    const double x = d.dot(u), y = d.dot(v), more = margin + block.radius * scale * (1 + 1e-9);
    return x + more < box.x0 || x - more > box.x1 || y + more < box.y0 || y - more > box.y1;
  }
};

}  // namespace

/// A direction leads from the plane to each corner: the corner is drawn where it leaves the plane. It is taken to be the
/// direction at the point below the corner, which is near.
void PolygonView::collect(const ChartFrame& frame, std::int32_t region, const Lean& lean, bool facing) {
  faces_.clear();
  upright_.clear();
  boxes_.clear();
  upright_boxes_.clear();
  const IntoChart into(frame);
  const float margin = std::max(16.0F, 0.25F * static_cast<float>(box_.width() + box_.height()));
  const float x0 = static_cast<float>(box_.x0) - margin, x1 = static_cast<float>(box_.x1) + margin;
  const float y0 = static_cast<float>(box_.y0) - margin, y1 = static_cast<float>(box_.y1) + margin;
  std::array<std::array<float, 5>, std::size_t{3} * Neighbourhood::kBlock> places;  // x, y, z, and x, y as drawn
  for (std::int32_t k = near_.near_start[region]; k < near_.near_start[region + 1]; ++k) {
    const std::int32_t r = near_.near[k];
    for (std::int32_t at = near_.block_start[r]; at < near_.block_start[r + 1]; ++at) {
      const Neighbourhood::Block& block = near_.blocks[at];
      if (facing && into.beyond(block, box_, margin)) continue;
      const bool straight = lean.straight() || into.beyond(block, box_, kShifted * margin);  // only the closest face
      for (std::int32_t i = 0; i < block.count; ++i) {
        const auto [x, y, z] = into(mesh_.vertices()[near_.vertices[block.first + i]]);
        const auto [right, up] = straight ? Slope{} : lean.at(x, y);
        places[i] = {x, y, z, x - right * z, y - up * z};
      }
      for (std::int32_t i = block.begin; i < block.end; ++i) {
        FlatFace flat;
        flat.face = near_.faces[i];
        flat.own = r == region;
        FlatFace drawn = flat;
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const auto& [x, y, z, shown_x, shown_y] = places[near_.corners[i][corner]];
          flat.x[corner] = x;
          flat.y[corner] = y;
          flat.z[corner] = drawn.z[corner] = z;
          drawn.x[corner] = shown_x;
          drawn.y[corner] = shown_y;
        }
        flat.over = 1 / double_area(flat);
        drawn.over = 1 / double_area(drawn);
        if (facing && !(flat.over > 0 && flat.over < std::numeric_limits<float>::infinity())) continue;
        const FlatBox e = extent(flat);
        if (facing && (e.high_x < x0 || e.high_y < y0 || e.low_x > x1 || e.low_y > y1)) continue;
        faces_.push_back(drawn);
        upright_.push_back(flat);
        boxes_.push_back(extent(drawn));
        upright_boxes_.push_back(e);
      }
    }
  }
}

TexelBox PolygonView::square(std::int32_t t) const {
  const std::int32_t x = box_.x0 + t % squares_.columns() * kSquare, y = box_.y0 + t / squares_.columns() * kSquare;
  return {x, y, std::min(box_.x1, x + kSquare), std::min(box_.y1, y + kSquare)};
}

/// Own faces come first and own the texels that they cover. Then the adjacent ones are drawn into the other texels.
void PolygonView::draw(std::int32_t t, std::int32_t n, std::span<const Span> wanted, std::vector<std::int32_t>& index,
                       std::vector<float>& depth) const {
  const TexelBox square = this->square(t);
  const std::int32_t w = square.width() * n, h = square.height() * n;
  index.assign(static_cast<std::size_t>(w) * h, kNone);
  depth.assign(static_cast<std::size_t>(w) * h, std::numeric_limits<float>::infinity());
  const auto s = static_cast<float>(n), x0 = static_cast<float>(square.x0), y0 = static_cast<float>(square.y0);
  bool own = true;
  for (const std::int32_t item : squares_.in(t % squares_.columns(), t / squares_.columns())) {
    const FlatFace& f = faces_[item];
    if (own && !f.own) {
      own = false;
      for (std::size_t k = 0; k < index.size(); ++k)
        if (index[k] != kNone) depth[k] = -1;
    }
    const float area = double_area(f) * s * s;
    if (!(area > 1e-9F)) continue;
    std::array<float, 3> x, y;
    for (int k = 0; k < 3; ++k) {
      x[k] = (f.x[k] - x0) * s - 0.5F;
      y[k] = (f.y[k] - y0) * s - 0.5F;
    }
    const auto [low, high] = std::minmax({y[0], y[1], y[2]});
    const auto j0 = to_integer(std::ceil(low - kTouch), 0, h);
    const auto j1 = to_integer(std::floor(high + kTouch), -1, h - 1);
    const float zx = ((f.z[1] - f.z[0]) * (y[2] - y[0]) - (f.z[2] - f.z[0]) * (y[1] - y[0])) / area;
    const float zy = ((f.z[2] - f.z[0]) * (x[1] - x[0]) - (f.z[1] - f.z[0]) * (x[2] - x[0])) / area;
    for (std::int32_t j = j0; j <= j1; ++j) {
      const auto level = static_cast<float>(j);
      const Span& span = wanted[j / n];
      float from = static_cast<float>(span.begin * n), to = static_cast<float>(span.end * n - 1);
      for (int k = 0, m = 2; k < 3; m = k++) {  // inside is left of each edge
        const float ex = x[k] - x[m], ey = y[k] - y[m];
        const float slack = kTouch * (std::abs(ex) + std::abs(ey));
        const float at = ex * (level - y[m]) + slack;  // ey * (x - x[m]) <= at
        if (ey > 0) {
          to = std::min(to, x[m] + at / ey);
        } else if (ey < 0) {
          from = std::max(from, x[m] + at / ey);
        } else if (at < 0) {
          to = -1;
        }
      }
      if (!(from <= to)) continue;
      const std::int32_t i0 = ceiling(from);
      const auto i1 = static_cast<std::int32_t>(to);
      const std::size_t row = static_cast<std::size_t>(j) * w;
      float z = f.z[0] + zx * (static_cast<float>(i0) - x[0]) + zy * (level - y[0]);
      for (std::int32_t i = i0; i <= i1; ++i, z += zx) {
        if (std::abs(z) >= depth[row + i]) continue;
        depth[row + i] = std::abs(z);
        index[row + i] = item;
      }
    }
  }
}

Hit PolygonView::at(std::int32_t index, float x, float y) const {
  const FlatFace& f = faces_[index];
  const float dx = x - f.x[0], dy = y - f.y[0];
  float b = (dx * (f.y[2] - f.y[0]) - dy * (f.x[2] - f.x[0])) * f.over;
  float c = ((f.x[1] - f.x[0]) * dy - (f.y[1] - f.y[0]) * dx) * f.over;
  b = std::clamp(b, 0.0F, 1.0F);
  c = std::clamp(c, 0.0F, 1.0F - b);
  return {f.face, b, c, index};
}

}  // namespace isimp::detail
