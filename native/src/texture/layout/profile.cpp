#include "layout/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

constexpr std::int32_t kCells = 1024;  // work: columns of a tile, as profiles have them

/// Columns that no edge crosses, if any, are taken whole.
void close(Profile& profile) {
  profile.low_sum = 0;
  for (std::int32_t k = 0; k < profile.width(); ++k) {
    if (profile.low[k] > profile.high[k]) {
      profile.low[k] = 0;
      profile.high[k] = static_cast<Cell>(profile.height - 1);
    }
    profile.low_sum += profile.low[k];
  }
}

Profile half_turn(const Profile& p) {
  Profile turned = p;
  const std::int32_t m = p.width();
  for (std::int32_t k = 0; k < m; ++k) {
    turned.low[m - 1 - k] = static_cast<Cell>(p.height - 1 - p.high[k]);
    turned.high[m - 1 - k] = static_cast<Cell>(p.height - 1 - p.low[k]);
  }
  close(turned);
  return turned;
}

/// The four turns of a box of w by h, by quarters counter-clockwise.
Rigid quarter(std::int32_t turns, double w, double h) {
  Rigid r;
  switch (turns) {
    case 0:
      break;
    case 1:
      r.turn << 0, -1, 1, 0;
      r.shift = {h, 0};
      break;
    case 2:
      r.turn << -1, 0, 0, -1;
      r.shift = {w, h};
      break;
    default:
      r.turn << 0, 1, -1, 0;
      r.shift = {0, w};
  }
  return r;
}

/// An empty profile of `width` columns and `height` rows.
Profile empty_profile(std::int32_t width, std::int32_t height) {
  Profile profile;
  profile.height = height;
  profile.low.assign(width, std::numeric_limits<Cell>::max());
  profile.high.assign(width, -1);
  return profile;
}

/// Adds the extent of an edge in every column that it crosses, `grow` cells more on each side.
void add_edge(Vec2 a, Vec2 b, double grow, Profile& profile) {
  if (a.x() > b.x()) std::swap(a, b);
  const std::int32_t from = to_integer(a.x() - grow, 0, profile.width());
  const std::int32_t to = to_integer(std::floor(b.x() + grow), -1, profile.width() - 1);
  const double run = b.x() - a.x();
  for (std::int32_t k = from; k <= to; ++k) {
    const double s = run > 0 ? std::clamp((k - grow - a.x()) / run, 0.0, 1.0) : 0;
    const double t = run > 0 ? std::clamp((k + 1 + grow - a.x()) / run, 0.0, 1.0) : 1;
    const double ya = a.y() + s * (b.y() - a.y()), yb = a.y() + t * (b.y() - a.y());
    const std::int32_t low = to_integer(std::min(ya, yb) - grow, 0, profile.height - 1);
    const std::int32_t high = to_integer(std::max(ya, yb) + grow, 0, profile.height - 1);
    profile.low[k] = std::min(profile.low[k], static_cast<Cell>(low));
    profile.high[k] = std::max(profile.high[k], static_cast<Cell>(high));
  }
}

}  // namespace

Cells::Cells(const Layout& layout, const Room& room)
    : layout_(layout),
      count_(std::min(room.side, kCells)),
      size_(static_cast<double>(room.side) / count_),
      grow_(room.grow / size_),
      members_(layout.chart_count),
      extent_(layout.chart_count, Vec2::Zero()) {
  for (std::int32_t q = 0; q < layout.polygon_count(); ++q) {
    members_[layout.chart[q]].push_back(q);
    for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i)
      extent_[layout.chart[q]] = extent_[layout.chart[q]].cwiseMax(layout.corner(q, i));
  }
  order_.resize(layout.chart_count);
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [&](std::int32_t a, std::int32_t b) {
    return extent_[a].maxCoeff() > extent_[b].maxCoeff() * (1 + 1e-9);
  });
}

bool Cells::shape(std::int32_t chart, double scale, std::array<Profile, 4>& profile) const {
  const double s = scale / size_;  // cells per scene unit
  const Vec2 box = (s * extent_[chart]).array() + 2 * grow_;
  if (!(box.maxCoeff() <= count_)) return false;
  const std::int32_t width = to_integer(std::ceil(box.x()), 1, count_);
  const std::int32_t height = to_integer(std::ceil(box.y()), 1, count_);
  profile[0] = empty_profile(width, height);
  profile[1] = empty_profile(height, width);
  const Rigid turned = quarter(1, width, height);
  for (const std::int32_t q : members_[chart])
    for (std::int32_t i = layout_.start[q], h = layout_.start[q + 1] - 1; i < layout_.start[q + 1]; h = i++) {
      const Vec2 a = (s * layout_.corner(q, h)).array() + grow_, b = (s * layout_.corner(q, i)).array() + grow_;
      add_edge(a, b, grow_, profile[0]);
      add_edge(turned(a), turned(b), grow_, profile[1]);
    }
  close(profile[0]);
  close(profile[1]);
  profile[2] = half_turn(profile[0]);
  profile[3] = half_turn(profile[1]);
  return true;
}

Rigid Cells::place(const std::array<Profile, 4>& profile, std::int32_t turn, std::int32_t x, std::int32_t y,
                   std::int32_t tile) const {
  const Rigid r = quarter(turn, profile[0].width() * size_, profile[0].height * size_);
  const Vec2 margin(grow_ * size_, grow_ * size_);
  return {r.turn, r(margin) + size_ * Vec2(x, y + std::int64_t{tile} * count_)};
}

}  // namespace isimp::detail
