#include "discs/wall_links.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>

#include "discs/polyline.h"

namespace isimp::meshing {
namespace {

// tuned walls
/// Vector area over area, below which a chart is no wall. The area is in projection for faces that look the same way,
/// since noise enlarges the area itself.
constexpr double kFlatWall = 0.9;
constexpr double kMain = 0.5;     ///< share of the boundary, by square length, that must follow the main directions
constexpr double kReach = 0.015;  ///< distance of a boundary from the edges between its corners, in sqrt(area)
constexpr double kOfHole = 0.15;  ///< the same distance at most, as a share of the smaller side of a hole
constexpr double kSlant = 6;      ///< extra cost per unit of the shorter of a cut's two extents
constexpr double kFoot = 0.03;    ///< cost of a corner within an edge of the outline, in sqrt(area)
constexpr double kSame = 0.03;    ///< sine of a slant that costs nothing: noise makes it

}  // namespace

std::optional<Wall> Wall::find(const Labels& labels, std::span<const std::int32_t> faces, const Shape& shape) {
  const FaceGraph& graph = labels.mesh.graph();
  const auto record = [&](std::int32_t f) -> const FaceRecord& { return graph.faces[graph.graph_face[f]]; };
  Vec3 sum = Vec3::Zero();
  double area = 0, projected = 0;
  for (const std::int32_t f : faces) {
    const FaceRecord& r = record(f);
    sum += r.area * Vec3(r.nx, r.ny, r.nz);
    area += r.area;
  }
  const Vec3 normal = sum.normalized();
  for (const std::int32_t f : faces) {
    const FaceRecord& r = record(f);
    const double cosine = normal.dot(Vec3(r.nx, r.ny, r.nz));
    projected += r.area * (cosine > kSameWay ? cosine : 1);
  }
  if (!(sum.norm() > kFlatWall * projected) || shape.loops.size() < 2) return {};
  Wall wall(labels);
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  wall.origin_ = labels.mesh.vertices()[labels.mesh.from(shape.loops[0][0])];
  wall.along_ = normal.cross(Vec3::Unit(axis)).normalized();
  wall.across_ = normal.cross(wall.along_);
  wall.size_ = std::sqrt(area * graph.area);
  wall.outer_ = shape.longest_loop(labels.mesh);
  if (!wall.turn_to_main_directions(shape)) return {};
  wall.collect(shape);
  const bool all = std::all_of(wall.corners_.begin(), wall.corners_.end(), [](const auto& c) { return c.size() > 1; });
  return all ? std::optional(std::move(wall)) : std::nullopt;
}

Vec2 Wall::flat(std::int32_t vertex) const {
  const Vec3 d = labels_.mesh.vertices()[vertex] - origin_;
  return {d.dot(along_), d.dot(across_)};
}

/// Right angles count as one direction.
bool Wall::turn_to_main_directions(const Shape& shape) {
  std::complex<double> sum = 0;
  double all = 0;
  for (const auto& loop : shape.loops) {
    const std::vector<LoopPlace> corners = corners_of(loop, kReach * size_);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 d = corners[(i + 1) % corners.size()].at - corners[i].at;
      const double square = d.squaredNorm();
      sum += std::polar(square, 4 * std::atan2(d.y(), d.x()));
      all += square;
    }
  }
  if (!(std::abs(sum) > kMain * all)) return false;
  const double turn = std::arg(sum) / 4;
  const Vec3 along = std::cos(turn) * along_ + std::sin(turn) * across_;
  across_ = std::cos(turn) * across_ - std::sin(turn) * along_;
  along_ = along;
  return true;
}

void Wall::collect(const Shape& shape) {
  const Mesh& mesh = labels_.mesh;
  for (std::size_t i = 0; i < shape.loops.size(); ++i) {
    const auto& loop = shape.loops[i];
    std::array<Vec2, 2> box{flat(mesh.from(loop[0])), flat(mesh.from(loop[0]))};
    for (const std::int32_t h : loop) {
      const LoopPlace from{mesh.from(h), flat(mesh.from(h))}, to{mesh.to(h), flat(mesh.to(h))};
      edges_.push_back({from, to, static_cast<std::int32_t>(i)});
      box = {box[0].cwiseMin(from.at), box[1].cwiseMax(from.at)};
    }
    if (static_cast<std::int32_t>(i) == outer_) {
      outline_ = corners_of(loop, kReach * size_);
      continue;
    }
    corners_.push_back(corners_of(loop, std::min(kReach * size_, kOfHole * (box[1] - box[0]).minCoeff())));
    box_.push_back(box);
    if (corners_.back().size() > kMostCorners) corners_.back().resize(kMostCorners);
  }
}

/// Where the boundary bends, and where other charts meet at it.
std::vector<LoopPlace> Wall::corners_of(const std::vector<std::int32_t>& loop, double reach) const {
  const Mesh& mesh = labels_.mesh;
  const std::size_t n = loop.size();
  // From the vertex that is farthest from another one: that is a corner.
  std::size_t start = 0;
  double most = -1;
  for (std::size_t i = 0; i < n; ++i) {
    const double d = (flat(mesh.from(loop[i])) - flat(mesh.from(loop[0]))).squaredNorm();
    if (d > most * (1 + 1e-12)) {
      most = d;
      start = i;
    }
  }
  std::vector<Vec3> line;
  std::vector<std::size_t> junctions;
  for (std::size_t i = 0; i <= n; ++i) {
    const std::int32_t h = loop[(start + i) % n];
    line.push_back(mesh.vertices()[mesh.from(h)]);
    if (i < n && labels_.across(h) != labels_.across(loop[(start + i + n - 1) % n])) junctions.push_back(i);
  }
  std::vector<std::size_t> kept = simplify(line, reach);
  kept.insert(kept.begin(), 0);
  // A junction near a bend takes its place.
  const auto is_near = [&](std::size_t i, std::size_t k) { return (line[i] - line[k]).norm() <= 2 * reach; };
  std::erase_if(kept, [&](std::size_t k) {
    return std::any_of(junctions.begin(), junctions.end(), [&](std::size_t i) { return is_near(i, k); });
  });
  kept.insert(kept.end(), junctions.begin(), junctions.end());
  std::sort(kept.begin(), kept.end());
  std::vector<LoopPlace> corners;
  for (const std::size_t k : kept) {
    const std::int32_t v = mesh.from(loop[(start + k) % n]);
    corners.push_back({v, flat(v)});
  }
  return corners;
}

double Wall::least_price(const LoopPlace& a, const LoopPlace& b) {
  const Vec2 d = b.at - a.at;
  const double length = d.norm();
  return length + kSlant * std::max(0.0, d.cwiseAbs().minCoeff() - kSame * length);
}

double Wall::price(const LoopPlace& a, const LoopPlace& b) const {
  const Vec2 d = b.at - a.at;
  for (const Edge& e : edges_) {
    if (e.from.vertex == a.vertex || e.to.vertex == a.vertex || e.from.vertex == b.vertex || e.to.vertex == b.vertex)
      continue;
    const Vec2 side = e.to.at - e.from.at;
    if ((cross(d, e.from.at - a.at) > 0) != (cross(d, e.to.at - a.at) > 0) &&
        (cross(side, a.at - e.from.at) > 0) != (cross(side, b.at - e.from.at) > 0))
      return std::numeric_limits<double>::infinity();
  }
  return least_price(a, b);
}

Wall::Way Wall::way_out(const LoopPlace& from) const {
  Way best;
  for (const Vec2& direction : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)}) {
    const Way way = straight_out(from, direction);
    if (way.price < best.price) best = way;
  }
  for (const LoopPlace& corner : outline_) {
    const double least = least_price(from, corner);
    if (least < best.price && price(from, corner) < best.price) best = {least, corner};
  }
  return best;
}

/// The first vertex of the outline in a direction; none where a hole is before it.
Wall::Way Wall::straight_out(const LoopPlace& from, const Vec2& direction) const {
  double least = std::numeric_limits<double>::infinity();
  const Edge* hit = nullptr;
  for (const Edge& e : edges_) {
    if (e.from.vertex == from.vertex || e.to.vertex == from.vertex) continue;
    const double a = cross(direction, e.from.at - from.at), b = cross(direction, e.to.at - from.at);
    if ((a > 0) == (b > 0)) continue;
    const Vec2 place = e.from.at + a / (a - b) * (e.to.at - e.from.at);
    const double distance = direction.dot(place - from.at);
    if (distance <= 0 || distance >= least) continue;
    least = distance;
    hit = &e;
  }
  if (hit == nullptr || hit->loop != outer_) return {};
  const Vec2 place = from.at + least * direction;
  const LoopPlace& end = (hit->from.at - place).norm() <= (hit->to.at - place).norm() ? hit->from : hit->to;
  return {least + kFoot * size_, end};
}

}  // namespace isimp::meshing
