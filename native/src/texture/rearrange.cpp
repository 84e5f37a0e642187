#include "rearrange.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "isimp/core/to_integer.h"
#include "ownership.h"

namespace isimp::detail {
namespace {

constexpr std::int64_t kFarthest = std::int64_t{1} << 53;  // cell: further away doubles know no single cells
constexpr double kMoved = 1;  // texels by which corners may have moved in their chart since it was laid out
constexpr double kMost = 2;   // the same if the others do not fit otherwise
/// If they still do not fit, polygons above this share of a tile's height are packed again.
constexpr std::array<double, 3> kLow = {0.85, 0.7, 0.5};
constexpr double kReach = 3;       // texels by which they may have moved in space since the last time
constexpr double kTilted = 0.999;  // cosine of the angle by which a polygon may have turned: 2.5 degrees

std::span<const std::int32_t> loop_of(const PolygonMesh& polygons, std::int32_t q) {
  const std::int32_t begin = polygons.loop_start[q];
  return std::span(polygons.loops).subspan(begin, polygons.loop_end(q) - begin);
}

/// An earlier polygon, and which of its corners a polygon's first one is.
struct Match {
  std::int32_t polygon = kNone, turn = 0;
};

/// Finds the earlier polygon that a polygon has the place of.
class Matcher {
 public:
  Matcher(const PolygonMesh& polygons, const Layout& layout, const EarlierAtlas& earlier, double moved)
      : polygons_(polygons),
        layout_(layout),
        earlier_(earlier),
        moved_(moved),
        taken_(earlier.polygons.loop_start.size(), 0) {
    for (std::int32_t p = 0; p < earlier.polygons.polygon_count(); ++p)
      for (const std::int32_t v : loop_of(earlier.polygons, p)) {
        const Vec3& at = earlier.polygons.vertices[v];
        cells_[cell(at)].push_back(p);
      }
  }

  /// The first that fits; each is taken once.
  Match find(std::int32_t q) {
    const auto loop = loop_of(polygons_, q);
    if (loop.empty()) return {};
    const Vec3& first = polygons_.vertices[loop.front()];
    const auto [i, j, k] = cell(first);
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -1; c <= 1; ++c) {
          const auto found = cells_.find({i + a, j + b, k + c});
          if (found == cells_.end()) continue;
          for (const std::int32_t p : found->second) {
            if (taken_[p] != 0) continue;
            const std::int32_t turn = turn_of(q, p);
            if (turn == kNone) continue;
            taken_[p] = 1;
            return {p, turn};
          }
        }
    return {};
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  /// The cell of a point. Cells are so large that corners of one place lie in adjacent cells.
  [[nodiscard]] Cell cell(const Vec3& p) const {
    const double over = earlier_.atlas.scale / kReach;
    const auto at = [&](double x) { return to_integer(std::floor(x * over), -kFarthest, kFarthest); };
    return {at(p.x()), at(p.y()), at(p.z())};
  }

  /// The cyclic shift between the corners; kNone if they are others.
  [[nodiscard]] std::int32_t turn_of(std::int32_t q, std::int32_t p) const {
    const auto loop = loop_of(polygons_, q);
    const auto count = static_cast<std::int32_t>(loop.size());
    const auto outline = outline_of(earlier_.polygons, earlier_.atlas, p);
    const ChartFrame& frame = earlier_.atlas.frame[p];
    if (static_cast<std::int32_t>(outline.size()) != count || layout_.plane[q].n.dot(frame.n) < kTilted) return kNone;
    const double over = 1 / frame.u.squaredNorm();
    const auto old_loop = loop_of(earlier_.polygons, p);
    const auto fits = [&](std::int32_t i, std::int32_t turn) {
      const std::int32_t o = (i + turn) % count;
      const Vec3& at = polygons_.vertices[loop[i]];
      const Vec3 d = at - frame.origin;
      const double x = d.dot(frame.u) * over - outline[o][0], y = d.dot(frame.v) * over - outline[o][1];
      if (!(std::hypot(x, y) <= moved_)) return false;
      return (at - earlier_.polygons.vertices[old_loop[o]]).norm() * earlier_.atlas.scale <= kReach;
    };
    for (std::int32_t turn = 0; turn < count; ++turn) {
      std::int32_t i = 0;
      while (i < count && fits(i, turn)) ++i;
      if (i == count) return turn;
    }
    return kNone;
  }

  const PolygonMesh& polygons_;
  const Layout& layout_;
  const EarlierAtlas& earlier_;
  double moved_;
  std::map<Cell, std::vector<std::int32_t>> cells_;  // earlier polygons by the places of their corners
  std::vector<std::uint8_t> taken_;
};

/// Numbers the charts 0, 1, ... by their first polygons.
void renumber(Atlas& atlas) {
  std::map<std::int32_t, std::int32_t> number;
  for (std::int32_t& chart : atlas.chart)
    chart = number.try_emplace(chart, static_cast<std::int32_t>(number.size())).first->second;
  atlas.chart_count = static_cast<std::int32_t>(number.size());
}

/// Keeps polygons at their places in an earlier atlas, also if others of their chart leave it.
class Rearranger {
 public:
  /// \param moved  texels by which the corners of kept polygons may have moved
  Rearranger(const PolygonMesh& polygons, const AtlasOptions& options, const Layout& whole, const EarlierAtlas& earlier,
             double moved)
      : polygons_(polygons), options_(options), whole_(whole), earlier_(earlier) {
    find_kept(moved);
  }

  /// Empty if none is kept, or if the others do not fit between them.
  std::optional<Atlas> run(const Room& room, double unfold_angle, double low, Job& job) {
    keep_low(low);
    if (free_.size() == kept_.size()) return std::nullopt;
    if (free_.empty()) return joined(room, whole_, {earlier_.atlas.scale, {}, {}}, {});
    std::vector<std::int32_t> group;
    const PolygonMesh rest = subset(group);
    AtlasOptions options = options_;
    options.group = group;
    Layout layout = flatten(rest, options);
    layout.groups = whole_.groups;
    layout.tile_area = whole_.tile_area;
    if (unfold_angle > 0) unfold(rest, unfold_angle, layout, job);
    straighten(layout);
    const auto packing = pack_beside(layout, room, earlier_.atlas.scale, taken(), job);
    if (!packing) return std::nullopt;
    return joined(room, layout, *packing, free_);
  }

 private:
  void find_kept(double moved) {
    const Atlas& atlas = earlier_.atlas;
    Matcher matcher(polygons_, whole_, earlier_, moved);
    for (std::int32_t q = 0; q < polygons_.polygon_count(); ++q) {
      Match match = matcher.find(q);
      if (match.polygon != kNone && atlas.tile_group[atlas.tile[match.polygon]] != whole_.group[q]) match = {};
      kept_.push_back(match.polygon);
      turn_.push_back(match.turn);
    }
  }

  /// Frees polygons that reach above this share of the height that their tile uses.
  void keep_low(double low) {
    const Atlas& atlas = earlier_.atlas;
    std::vector<double> used(atlas.tiles, 0);
    const auto top = [&](std::int32_t p) {
      double most = 0;
      for (const auto& corner : outline_of(earlier_.polygons, atlas, p)) most = std::max(most, corner[1]);
      return most - double{1.0} * atlas.tile[p] * atlas.side;
    };
    for (const std::int32_t p : kept_)
      if (p != kNone) used[atlas.tile[p]] = std::max(used[atlas.tile[p]], top(p));
    free_.clear();
    for (std::size_t q = 0; q < kept_.size(); ++q) {
      std::int32_t& p = kept_[q];
      if (p != kNone && low < 1 && top(p) > low * used[atlas.tile[p]]) p = kNone;
      if (p == kNone) free_.push_back(static_cast<std::int32_t>(q));
    }
  }

  [[nodiscard]] PolygonMesh subset(std::vector<std::int32_t>& group) const {
    PolygonMesh rest;
    rest.vertices = polygons_.vertices;
    for (const std::int32_t q : free_) {
      rest.loop_start.push_back(static_cast<std::int32_t>(rest.loops.size()));
      rest.loops.insert(rest.loops.end(), polygons_.loops.begin() + whole_.start[q],
                        polygons_.loops.begin() + whole_.start[q + 1]);
      group.push_back(whole_.group[q]);
    }
    return rest;
  }

  [[nodiscard]] std::vector<Taken> taken() const {
    std::vector<Taken> all;
    for (const std::int32_t p : kept_) {
      if (p == kNone) continue;
      Taken& one = all.emplace_back();
      for (const auto& [x, y] : outline_of(earlier_.polygons, earlier_.atlas, p)) one.outline.emplace_back(x, y);
      one.tile = earlier_.atlas.tile[p];
    }
    return all;
  }

  /// \param layout  of the polygons `put_in`, which `packing` places
  [[nodiscard]] Atlas joined(const Room& room, const Layout& layout, const Packing& packing,
                             const std::vector<std::int32_t>& put_in) const {
    Atlas atlas = empty_atlas(whole_, room, earlier_.atlas.scale);
    for (std::size_t i = 0; i < put_in.size(); ++i) {
      const auto q = static_cast<std::int32_t>(i);
      put(layout, packing, q, atlas, put_in[i], whole_.start[put_in[i]]);
      atlas.chart[put_in[i]] = earlier_.atlas.chart_count + layout.chart[q];
    }
    for (std::size_t q = 0; q < kept_.size(); ++q) {
      const std::int32_t p = kept_[q];
      if (p == kNone) continue;
      const auto outline = outline_of(earlier_.polygons, earlier_.atlas, p);
      std::rotate_copy(outline.begin(), outline.begin() + turn_[q], outline.end(),
                       atlas.corner.begin() + whole_.start[q]);
      atlas.from[q] = p;
      atlas.frame[q] = earlier_.atlas.frame[p];
      atlas.tile[q] = earlier_.atlas.tile[p];
      atlas.chart[q] = earlier_.atlas.chart[p];
    }
    renumber(atlas);
    atlas.kept = static_cast<std::int32_t>(kept_.size() - put_in.size());
    return atlas;
  }

  const PolygonMesh& polygons_;
  const AtlasOptions& options_;
  const Layout& whole_;
  const EarlierAtlas& earlier_;
  std::vector<std::int32_t> kept_;  // (Q) of the earlier polygons
  std::vector<std::int32_t> turn_;  // (Q) see Match
  std::vector<std::int32_t> free_;  // polygons to place
};

}  // namespace

Atlas empty_atlas(const Layout& layout, const Room& room, double scale) {
  Atlas atlas;
  atlas.side = room.side;
  atlas.tiles = room.tiles * layout.groups;
  atlas.scale = scale;
  atlas.gutter = 2 * room.grow;
  atlas.fill = layout.area * scale * scale / (static_cast<double>(room.side) * atlas.height());
  atlas.corner.resize(layout.flat.size());
  const std::size_t polygons = layout.plane.size();
  atlas.from.assign(polygons, kNone);
  atlas.chart.resize(polygons);
  atlas.tile.resize(polygons);
  atlas.frame.resize(polygons);
  for (std::int32_t t = 0; t < atlas.tiles; ++t) atlas.tile_group.push_back(t / room.tiles);
  return atlas;
}

void put(const Layout& layout, const Packing& packing, std::int32_t q, Atlas& atlas, std::int32_t to,
         std::int32_t begin) {
  const Rigid& chart = packing.place[layout.chart[q]];
  const Plane& plane = layout.plane[q];
  const auto texel = [&](const Vec2& p) -> Vec2 {
    return chart.turn * (packing.scale * layout.place[q](p)) + chart.shift;
  };
  for (std::int32_t i = layout.start[q]; i < layout.start[q + 1]; ++i) {
    const Vec2 at = texel(layout.flat[i]);
    atlas.corner[begin + i - layout.start[q]] = {at.x(), at.y()};
  }
  const Eigen::Matrix2d back = (chart.turn * layout.place[q].turn).transpose() / packing.scale;
  const Vec2 zero = texel(Vec2::Zero());
  ChartFrame& frame = atlas.frame[to];
  frame.u = plane.u * back(0, 0) + plane.v * back(1, 0);
  frame.v = plane.u * back(0, 1) + plane.v * back(1, 1);
  frame.n = plane.n;
  frame.origin = plane.centre - frame.u * zero.x() - frame.v * zero.y();
  atlas.tile[to] = packing.tile[layout.chart[q]];
}

bool has_room_of(const AtlasOptions& options, const Layout& whole, const Atlas& atlas, const Room& room) {
  return !(options.side > 0 && options.side != atlas.side) && 2 * room.grow == atlas.gutter &&
         room.tiles * whole.groups == atlas.tiles && whole.groups == 1 + atlas.tile_group.back();
}

std::optional<Atlas> rearrange(const PolygonMesh& polygons, const AtlasOptions& options, const Layout& whole,
                               const EarlierAtlas& earlier, const Room& room, Job& job) {
  if (!has_room_of(options, whole, earlier.atlas, room)) return std::nullopt;
  for (const double moved : {kMoved, kMost})
    for (const double angle : {options.unfold, 0.0})
      if (auto atlas = Rearranger(polygons, options, whole, earlier, moved).run(room, angle, 1, job)) return atlas;
  for (const double low : kLow)
    if (auto atlas = Rearranger(polygons, options, whole, earlier, kMost).run(room, options.unfold, low, job))
      return atlas;
  return std::nullopt;
}

}  // namespace isimp::detail
