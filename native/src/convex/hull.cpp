#include "hull.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "cell.h"
#include "isimp/mesh/meet.h"

namespace isimp::convex {
namespace {

constexpr double kOutwards = 1e-6;  // rounding: weight of the distance from the middle among points that are as far out

struct HullFacet {
  Triangle corners;
  Triangle beside;  // the facet across the edge from corner k to the next one
  Vec3 normal;
  std::vector<std::int32_t> outside = {};  // points that no other facet has
  std::int32_t farthest = kNone;
  double distance = 0;  // distance of the farthest one, with kOutwards
  bool alive = true;
  std::int32_t seen_from = kNone;  // the last point that was looked from
};

class Growing {
 public:
  Growing(std::span<const Vec3> points, double tolerance, double grid)
      : points_(points), tolerance_(tolerance), grid_(grid) {}

  /// Makes a tetrahedron of extreme points; false if all points lie in a plane.
  bool begin() {
    if (points_.size() < 4) return false;
    middle_ = box_of(points_).center();
    // Each is a corner of the hull, since the maximum of a convex function is at a corner.
    std::array<std::int32_t, 4> corner{};
    corner[0] = farthest([&](const Vec3& p) { return (p - middle_).norm(); });
    const Vec3 a = points_[corner[0]];
    corner[1] = farthest([&](const Vec3& p) { return (p - a).norm(); });
    const Vec3 line = (points_[corner[1]] - a).normalized();
    corner[2] = farthest([&](const Vec3& p) { return (p - a).cross(line).norm() + kOutwards * (p - middle_).norm(); });
    const Vec3 across = line.cross(points_[corner[2]] - a).normalized();
    corner[3] =
        farthest([&](const Vec3& p) { return std::abs((p - a).dot(across)) + kOutwards * (p - middle_).norm(); });
    if (!(std::abs((points_[corner[3]] - a).dot(across)) > tolerance_)) return false;
    const int side = side_of(corner[0], corner[1], corner[2], corner[3]);
    if (side == 0) return false;
    if (side > 0) std::swap(corner[1], corner[2]);
    const auto [p, q, r, s] = corner;
    add({p, q, r}, {1, 2, 3});
    add({q, p, s}, {0, 3, 2});
    add({r, q, s}, {0, 1, 3});
    add({p, r, s}, {0, 2, 1});
    std::vector<std::int32_t> all(points_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
    share(all, 0);
    return true;
  }

  /// Adds the point that is farthest outside; false if none is outside by more than the tolerance.
  bool grow() {
    std::int32_t from = kNone;
    for (std::int32_t f = 0; f < count(); ++f)
      if (facets_[f].alive && facets_[f].farthest != kNone &&
          (from == kNone || facets_[f].distance > facets_[from].distance))
        from = f;
    if (from == kNone) return false;
    const std::int32_t p = facets_[from].farthest;
    if (!sees(from, p)) {  // the facet is so thin that its normal is wrong
      hand_on(from, p);
      return true;
    }
    std::vector<std::int32_t> seen{from}, left;
    facets_[from].seen_from = p;
    std::vector<std::array<std::int32_t, 3>> horizon;  // from, to, the facet beyond
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Triangle corners = facets_[seen[i]].corners, beside = facets_[seen[i]].beside;
      for (int k = 0; k < 3; ++k) {
        HullFacet& next = facets_[beside[k]];
        if (next.seen_from == p) continue;
        if (sees(beside[k], p)) {
          next.seen_from = p;
          seen.push_back(beside[k]);
        } else {
          horizon.push_back({corners[k], corners[(k + 1) % 3], beside[k]});
        }
      }
    }
    const std::int32_t first = count();
    // Facet i of the fan is between the facets whose edges end where its own begins and begin where it ends.
    std::vector<std::array<std::int32_t, 2>> begins;
    for (std::size_t i = 0; i < horizon.size(); ++i) begins.push_back({horizon[i][0], static_cast<std::int32_t>(i)});
    std::ranges::sort(begins);
    std::vector<std::int32_t> before(horizon.size()), after(horizon.size());
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const auto next = std::ranges::lower_bound(begins, std::array{horizon[i][1], std::int32_t{0}});
      after[i] = (*next)[1];
      before[(*next)[1]] = static_cast<std::int32_t>(i);
    }
    for (std::size_t i = 0; i < horizon.size(); ++i) {
      const auto [a, b, beyond] = horizon[i];
      add({a, b, p}, {beyond, first + after[i], first + before[i]});
      HullFacet& other = facets_[beyond];
      for (int k = 0; k < 3; ++k)
        if (other.corners[k] == b && other.corners[(k + 1) % 3] == a)
          other.beside[k] = first + static_cast<std::int32_t>(i);
    }
    for (const std::int32_t f : seen) {
      facets_[f].alive = false;
      left.insert(left.end(), facets_[f].outside.begin(), facets_[f].outside.end());
      facets_[f].outside = {};
    }
    share(left, first);
    return true;
  }

  [[nodiscard]] ConvexPart result() const {
    ConvexPart made;
    std::vector<std::int32_t> name(points_.size(), kNone);
    for (const HullFacet& facet : facets_) {
      if (!facet.alive) continue;
      Triangle named{};
      for (int k = 0; k < 3; ++k) {
        std::int32_t& n = name[facet.corners[k]];
        if (n == kNone) {
          n = static_cast<std::int32_t>(made.vertices.size());
          made.vertices.push_back(points_[facet.corners[k]]);
        }
        named[k] = n;
      }
      made.triangles.push_back(named);
    }
    const Vec3 o = made.vertices.front();
    for (const auto& [a, b, c] : made.triangles)
      made.volume += (made.vertices[a] - o).cross(made.vertices[b] - o).dot(made.vertices[c] - o) / 6;
    return made;
  }

 private:
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(facets_.size()); }

  template <class Measure>
  [[nodiscard]] std::int32_t farthest(Measure measure) const {
    return static_cast<std::int32_t>(std::ranges::max_element(points_, {}, measure) - points_.begin());
  }

  void add(const Triangle& corners, const Triangle& beside) {
    const Vec3 &a = points_[corners[0]], &b = points_[corners[1]], &c = points_[corners[2]];
    facets_.push_back({.corners = corners, .beside = beside, .normal = (b - a).cross(c - a).normalized()});
  }

  [[nodiscard]] bool sees(std::int32_t f, std::int32_t p) const {
    const auto [a, b, c] = facets_[f].corners;
    return side_of(a, b, c, p) > 0;
  }

  [[nodiscard]] int side_of(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t p) const {
    if (grid_ == 0) return isimp::side_of({points_[a], points_[b], points_[c]}, points_[p]);
    using Steps = Eigen::Matrix<std::int64_t, 3, 1>;
    const auto steps = [&](std::int32_t i) {
      const Vec3 d = (points_[i] - points_[a]) / grid_;
      return Steps(static_cast<std::int64_t>(d.x()), static_cast<std::int64_t>(d.y()),
                   static_cast<std::int64_t>(d.z()));
    };
    const std::int64_t volume = steps(b).cross(steps(c)).dot(steps(p));
    return (volume > 0) - (volume < 0);
  }

  /// Assigns each point to the facet from `first` on that it is farthest outside of.
  void share(const std::vector<std::int32_t>& some, std::int32_t first) {
    for (const std::int32_t i : some) {
      std::int32_t best = kNone;
      double distance = tolerance_;
      for (std::int32_t f = first; f < count(); ++f) {
        const double d = height(f, i);
        if (!(d > distance)) continue;
        distance = d;
        best = f;
      }
      if (best != kNone) give(facets_[best], i, distance);
    }
  }

  /// Adds a point to a facet, which may become its farthest one.
  void give(HullFacet& facet, std::int32_t i, double distance) {
    facet.outside.push_back(i);
    // Many points of a side of a box are equally far; the one farthest out is a corner.
    const double rank = distance + kOutwards * (points_[i] - middle_).norm();
    if (facet.farthest != kNone && !(rank > facet.distance)) return;
    facet.farthest = i;
    facet.distance = rank;
  }

  /// Moves a point from a facet to another one that it is outside of.
  void hand_on(std::int32_t f, std::int32_t p) {
    const std::vector<std::int32_t> all = std::move(facets_[f].outside);
    facets_[f].outside.clear();
    facets_[f].farthest = kNone;
    for (const std::int32_t i : all)
      if (i != p) give(facets_[f], i, height(f, i));
    for (std::int32_t g = 0; g < count(); ++g) {
      if (g == f || !facets_[g].alive || !(height(g, p) > tolerance_) || !sees(g, p)) continue;
      give(facets_[g], p, height(g, p));
      return;
    }
  }

  [[nodiscard]] double height(std::int32_t f, std::int32_t p) const {
    return (points_[p] - points_[facets_[f].corners[0]]).dot(facets_[f].normal);
  }

  std::span<const Vec3> points_;
  double tolerance_, grid_;
  Vec3 middle_ = Vec3::Zero();
  std::vector<HullFacet> facets_;
};

}  // namespace

ConvexPart hull_of(std::span<const Vec3> points, double tolerance, double grid, std::int32_t most_vertices) {
  Growing hull(points, tolerance, grid);
  if (!hull.begin()) return {};
  // A point that is added may enclose earlier ones, so the hull never has more vertices than this counts.
  for (std::int32_t vertices = 4; vertices < most_vertices; ++vertices)
    if (!hull.grow()) break;
  return hull.result();
}

ConvexPart simple_hull_of(std::span<const Vec3> points, double tolerance, std::int32_t most_vertices) {
  ConvexPart part = hull_of(points, tolerance, 0, most_vertices);
  for (std::size_t v = part.vertices.size(); v-- > 0 && part.vertices.size() > 4;) {
    std::vector<Vec3> others = part.vertices;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(v));
    ConvexPart rest = hull_of(others, 0);
    const auto out = [&](const Triangle& t) {
      const Vec3 &a = rest.vertices[t[0]], &b = rest.vertices[t[1]], &c = rest.vertices[t[2]];
      return (b - a).cross(c - a).normalized().dot(part.vertices[v] - a) > tolerance;
    };
    if (rest.vertices.size() < 4 || std::ranges::any_of(rest.triangles, out)) continue;
    // Its vertices are in another order, but those before v were all needed, and those after it are seen again.
    v = std::min(v, rest.vertices.size());
    part = std::move(rest);
  }
  return part;
}

}  // namespace isimp::convex
