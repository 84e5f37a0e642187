#include "cells/grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "fit/numbers.h"
#include "isimp/core/check.h"
#include "isimp/core/tiny.h"
#include "isimp/core/to_integer.h"

namespace isimp::curved {
namespace {

constexpr int kBins = 120;      ///< work: number of bins of the profile
constexpr int kTurnSteps = 72;  ///< work: number of steps of a full turn in the search for gaps
// tuned round
constexpr double kCapRadius = 0.12;     ///< share of the largest radius: an end nearer to the axis may be a cap
constexpr double kStraightTurn = 1e-6;  ///< rounding: radians: the turn of a strip of an extrusion
constexpr double kLeastEdges = 2;       ///< edges of faces in the width of a segment: narrower ones have ragged borders
constexpr double kShort =
    1e-9;  ///< rounding: share of its distance from 0 along the profile: a shorter range is one place

using Row = std::array<double, kBins + 1>;

/// A quantile of some numbers.
double quantile(std::vector<double> x, double share) {
  ISIMP_ASSERT(!x.empty(), "there are some numbers");
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), x.begin() + at, x.end());
  return x[static_cast<std::size_t>(at)];
}

}  // namespace

/// Sums over the bins of a profile, and the costs of ranges of bins.
class Profile {
 public:
  Profile(const CurvedProxy& proxy, const PatchFaces& f) : proxy_(proxy) {
    low_ = quantile(f.along, 0.001);
    high_ = quantile(f.along, 0.999);
    if (proxy.closed) {
      low_ = 0;
      high_ = *std::max_element(f.along.begin(), f.along.end());
    }
    const double largest = quantile(f.rho, 0.9);
    std::array<double, 2> end_rho{kNever, kNever};
    for (std::size_t i = 0; i < f.area.size(); ++i) {
      const int bin = to_integer((f.along[i] - low_) / (high_ - low_) * kBins, 0, kBins - 1);
      const double a = f.area[i], r = f.rho[i], z = f.z[i];
      const std::array values = {a, a * f.out[i], a * f.up[i], a * r, a * z, a * r * r, a * r * z, a * z * z};
      for (std::size_t k = 0; k < values.size(); ++k) sum_[k][bin + 1] += values[k];
      if (bin == 0) end_rho[0] = std::min(end_rho[0], r);
      if (bin == kBins - 1) end_rho[1] = std::min(end_rho[1], r);
    }
    for (Row& row : sum_)
      for (int b = 0; b < kBins; ++b) row[b + 1] += row[b];
    for (std::size_t k = 0; k < 2; ++k) may_cap_[k] = proxy.full && !proxy.closed && end_rho[k] < kCapRadius * largest;
    const int rows = is_straight(proxy) ? 1 : kBins + 1;
    straight_.resize(static_cast<std::size_t>(rows));
    bent_ = cap_ = straight_;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j <= kBins; ++j) set(i, j);
  }

  /// The best rings for a number of segments. Faces at one place along the profile, such as four of an octahedron on a
  /// sphere, are one ring: others would have no length, and no plane.
  /// \param caps  whether ends at the axis are caps, which count as one cell
  [[nodiscard]] Grid best(std::int32_t segments, std::int32_t rings, bool caps) {
    if (!(high_ - low_ > kShort * std::max(std::abs(low_), std::abs(high_)))) rings = 1;
    const bool may = caps && rings > 2, low = may && may_cap_[0], high = may && may_cap_[1];
    const Table& table = table_of(segments, low, rings);
    const Row& before = table.least[rings - 1];
    Grid out;
    out.cost = kNever;
    out.rings = rings;
    out.low_cap = low;
    out.high_cap = high;
    int at = kBins;
    for (int i = rings - 1; i < kBins; ++i) {
      if (before[i] == kNever) continue;
      const double c = before[i] + (high ? cap_[i][kBins] : table.cost(*this, i, kBins));
      if (c >= out.cost) continue;
      out.cost = c;
      at = i;
    }
    out.knots.assign(static_cast<std::size_t>(rings) + 1, high_);
    for (int k = rings - 1; k >= 0; --k) {
      out.knots[k] = low_ + (high_ - low_) * at / kBins;
      if (k > 0) at = table.from[k][at];
    }
    out.segments = segments;
    out.cells = segments * (out.rings - out.low_cap - out.high_cap) + out.low_cap + out.high_cap;
    return out;
  }

  [[nodiscard]] bool may_cap() const { return may_cap_[0] || may_cap_[1]; }

 private:
  void set(int i, int j) {
    if (j <= i) {
      straight_[i][j] = bent_[i][j] = cap_[i][j] = kNever;
      return;
    }
    std::array<double, 8> s{};
    for (std::size_t k = 0; k < s.size(); ++k) s[k] = sum_[k][j] - sum_[k][i];
    const double w = std::max(s[0], kTiny), length = std::max(std::hypot(s[1], s[2]), kTiny);
    const double m0 = s[1] / length, m1 = s[2] / length, r = s[3] / w, z = s[4] / w;
    const double rr = s[5] / w - r * r, rz = s[6] / w - r * z, zz = s[7] / w - z * z;
    straight_[i][j] = w * std::max(0.0, m0 * m0 * rr + 2 * m0 * m1 * rz + m1 * m1 * zz);
    bent_[i][j] = w * m0 * m0 * (r * r + std::max(0.0, rr));
    cap_[i][j] = w * std::max(0.0, zz);
  }

  /// The least costs up to each bin by number of rings, for one number of segments.
  struct Table {
    std::int32_t segments = 0;
    bool low_cap = false;
    double chord = 0;
    std::vector<Row> least;
    std::vector<std::array<int, kBins + 1>> from;

    [[nodiscard]] double cost(const Profile& p, int i, int j) const {
      return p.straight_[i][j] + chord * p.bent_[i][j];
    }
  };

  /// The table with `rings` rows at the least. The last table with and without a cap is kept, and grows.
  const Table& table_of(std::int32_t segments, bool low_cap, std::int32_t rings) {
    Table& t = table_[low_cap ? 1 : 0];
    if (t.segments != segments) {
      const double d = proxy_.kind == CurvedKind::extrusion ? kStraightTurn : proxy_.span / segments;
      t = {segments, low_cap, std::max(0.0, of_chord(d)), {}, {}};
      t.least.emplace_back().fill(kNever);
      t.least[0][0] = 0;
      t.from.emplace_back();
    }
    for (auto k = static_cast<int>(t.least.size()); k < rings; ++k) {
      const Row& before = t.least[k - 1];
      Row least;
      least.fill(kNever);
      std::array<int, kBins + 1> from{};
      for (int j = k; j <= kBins; ++j)
        for (int i = k - 1; i < j; ++i) {
          if (before[i] == kNever) continue;
          const double c = before[i] + (k == 1 && low_cap ? cap_[i][j] : t.cost(*this, i, j));
          if (c < least[j]) {
            least[j] = c;
            from[j] = i;
          }
        }
      t.least.push_back(least);
      t.from.push_back(from);
    }
    return t;
  }

  const CurvedProxy& proxy_;
  double low_ = 0, high_ = 1;
  std::array<bool, 2> may_cap_{};
  std::array<Row, 8> sum_{};
  std::vector<Row> straight_, bent_, cap_;  // by first and last bin: of cells as wide as they may, and caps
  std::array<Table, 2> table_;
};

namespace {

/// The share of a full turn that the normals of an extrusion cover.
double turn_of_normals(const PatchFaces& f) {
  std::array<bool, kTurnSteps> is_on{};
  for (std::size_t i = 0; i < f.area.size(); ++i)
    is_on[to_integer((std::atan2(f.up[i], f.out[i]) / kTurn + 0.5) * kTurnSteps, 0, kTurnSteps - 1)] = true;
  return static_cast<double>(std::count(is_on.begin(), is_on.end(), true)) / kTurnSteps;
}

/// The profile of an extrusion, a ring, with its first corner at a length along it.
void begin_at(CurvedProxy& proxy, double at) {
  const std::size_t n = corners(proxy);
  std::size_t edge = 0;
  Vec2 first = corner(proxy, 0);
  for (double left = at; edge < n; ++edge) {
    const Vec2 t = corner(proxy, (edge + 1) % n) - corner(proxy, edge);
    first = corner(proxy, edge) + std::min(1.0, left / std::max(t.norm(), kTiny)) * t;
    if (left < t.norm()) break;
    left -= t.norm();
  }
  std::vector<double> profile = {first.x(), first.y()};
  for (std::size_t k = 1; k <= n; ++k) {
    const Vec2 c = corner(proxy, (edge + k) % n);
    profile.insert(profile.end(), {c.x(), c.y()});
  }
  proxy.profile = std::move(profile);
}

}  // namespace

PatchFaces::PatchFaces(const Faces& faces, const CurvedProxy& proxy, Some some) : face(std::move(some)) {
  const Locator surface(proxy);
  double square = 0;
  for (std::vector<double>* v : {&area, &angle, &rho, &z, &along, &out, &up}) v->reserve(face.size());
  for (const std::int32_t i : face) {
    const Vec3 x = faces.centre(i);
    const OnSurface on = surface.at(x);
    const Polar& p = on.polar;
    const Vec3& n = on.residual.normal;
    area.push_back(faces.area(i));
    angle.push_back(curved::angle(proxy, x));
    rho.push_back(p.rho);
    z.push_back(p.z);
    along.push_back(on.along);
    out.push_back(n.dot(p.out));
    up.push_back(n.dot(p.up));
    square += area.back() * on.residual.distance * on.residual.distance;
    whole += area.back();
  }
  rough = whole > 0 ? std::sqrt(square / whole) : 0;
  double length = 0;
  for (const std::int32_t i : face) {
    const Triangle& t = faces.mesh().triangles()[faces.graph().mesh_face[i]];
    length += (faces.mesh().vertices()[t[0]] - faces.mesh().vertices()[t[1]]).norm();
  }
  edge = face.empty() ? 0 : length / static_cast<double>(face.size());
}

void set_span(CurvedProxy& proxy, const PatchFaces& f) {
  if (proxy.kind == CurvedKind::extrusion) {
    proxy.full = proxy.closed;
    proxy.span = proxy.full ? kTurn : kTurn * turn_of_normals(f);
    return;
  }
  std::array<bool, kTurnSteps> is_on{};
  for (const double a : f.angle) is_on[to_integer(a / kTurn * kTurnSteps, 0, kTurnSteps - 1)] = true;
  int run = 0, longest = 0, end = 0;
  for (int k = 0; k < 2 * kTurnSteps; ++k) {
    run = is_on[k % kTurnSteps] ? 0 : run + 1;
    if (run > longest && run <= kTurnSteps) {
      longest = run;
      end = k + 1;
    }
  }
  // A coarse mesh has steps without a face all over.
  proxy.full = longest < (1 - kMost) * kTurnSteps;
  proxy.phase = 0;
  proxy.span = kTurn;
  if (proxy.full) return;
  const double begin = end % kTurnSteps * (kTurn / kTurnSteps), width = kTurn - longest * (kTurn / kTurnSteps);
  std::vector<double> on;
  for (const double a : f.angle) {
    const double t = std::fmod(a - begin + 2 * kTurn, kTurn);
    if (t < width + 0.12) on.push_back(t);
    if (t > kTurn - 0.12) on.push_back(t - kTurn);
  }
  const double low = quantile(on, 0.004), high = quantile(on, 0.996);
  proxy.phase = begin + low;
  proxy.span = std::max(high - low, 1e-6);
}

Cuts::Cuts(const CurvedProxy& proxy, const PatchFaces& patch)
    : proxy_(&proxy),
      largest_(quantile(patch.rho, 0.9)),
      edge_(patch.edge),
      area_(patch.whole),
      profile_(std::make_unique<Profile>(proxy, patch)) {}
Cuts::Cuts(Cuts&&) noexcept = default;
Cuts::~Cuts() = default;

std::vector<Grid> Cuts::within(double cells, double rough) {
  std::vector<Grid> all;
  const CurvedProxy& proxy = *proxy_;
  if (proxy.kind == CurvedKind::extrusion) return strips_within(cells, rough);
  const std::int32_t least = proxy.full ? kLeastRound : 1;
  const auto most = to_integer(cells * kMoreCells + kHalfCell, least, kMostSegments);
  double limit = cells * kMoreCells + kHalfCell;
  if (limit < least - kHalfCell) return all;  // a few planes are enough
  limit = std::max(limit, static_cast<double>(least));
  for (std::int32_t n = least; n <= most; ++n) {
    const double width = proxy.span / n;
    const bool is_fine = largest_ * (1 - std::cos(width / 2)) < rough || largest_ * width < kLeastEdges * edge_;
    if (is_fine && !all.empty()) break;
    std::optional<Grid> best;
    for (const bool caps : {false, true}) {
      if (caps && !profile_->may_cap()) continue;
      std::int32_t rings =
          is_straight(proxy) ? 1 : std::clamp(to_integer(limit / n, 0, kMostRings) + 2 * caps, 1, kMostRings);
      Grid grid = profile_->best(n, rings, caps);
      while (grid.cells > limit && rings > 1) grid = profile_->best(n, --rings, caps);
      if (grid.cells <= limit && (!best || grid.cost < best->cost)) best = std::move(grid);
    }
    if (best) all.push_back(std::move(*best));
  }
  return all;
}

std::vector<Grid> Cuts::strips_within(double cells, double rough) {
  std::vector<Grid> all;
  const auto most = to_integer(cells * kMoreCells + kHalfCell, 1, kMostStrips);
  for (std::int32_t n = proxy_->full ? kLeastRound : 1; n <= most; ++n) {
    all.push_back(of(n, 1, cells));
    if (all.back().cost < rough * rough * area_) break;  // they are as near as the surface itself
  }
  return all;
}

Grid Cuts::of(std::int32_t segments, std::int32_t rings, double cells) {
  if (proxy_->kind == CurvedKind::extrusion) {
    Grid grid = profile_->best(1, segments, false);
    std::swap(grid.segments, grid.rings);
    return grid;
  }
  if (is_straight(*proxy_)) return profile_->best(segments, 1, false);
  const bool caps = profile_->may_cap();
  if (rings > 0) return profile_->best(segments, rings, caps);
  const auto k = to_integer(cells / segments + kHalfCell, 1, kMostRings);
  return profile_->best(segments, k + (caps ? 1 : 0), caps);
}

void begin_at_border(const Faces& faces, CurvedProxy& proxy, PatchFaces& patch, double strips) {
  if (proxy.kind != CurvedKind::extrusion || !proxy.closed) return;
  const Grid grid = Cuts(proxy, patch).of(to_integer(strips, 2, kMostStrips), 1, strips);
  begin_at(proxy, grid.knots[grid.knots.size() / 2]);
  patch = PatchFaces(faces, proxy, std::move(patch.face));
}

void apply(CurvedProxy& proxy, const Grid& grid) {
  proxy.segments = grid.segments;
  proxy.rings = grid.rings;
  proxy.knots = grid.knots;
  proxy.low_cap = grid.low_cap;
  proxy.high_cap = grid.high_cap;
  if (proxy.full) proxy.phase = -proxy.span / proxy.segments / 2;
}

}  // namespace isimp::curved
