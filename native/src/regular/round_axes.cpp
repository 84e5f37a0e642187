#include "round_axes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "isimp/core/check.h"

namespace isimp::regular {
namespace {

constexpr double kApart = 1e-7;  ///< rounding: share of the diagonal: distance of two axes that are one

bool is_bend(const CurvedProxy& p) { return p.kind == CurvedKind::revolution && p.closed && !p.full; }

bool is_one_axis(const CurvedProxy& a, const CurvedProxy& b, double apart) {
  return a.axis.cross(b.axis).norm() <= kSame && a.axis.cross(b.point - a.point).norm() <= apart;
}

/// Whether angles of a pipe begin at the axis of a bend, as where both have common edges.
bool is_pipe_of(const CurvedProxy& pipe, const CurvedProxy& bend) {
  return is_bend(bend) && pipe.kind == CurvedKind::cylinder && pipe.across.cross(bend.axis).norm() <= kSame;
}

/// The matrix M for which M x is v x x.
Eigen::Matrix3d crossing(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The least turn from one unit vector to another that is not its opposite.
/// Source: Eigen's Quaternion::FromTwoVectors, less its case of opposites, which alone takes a minute to compile.
Eigen::Matrix3d turn_between(const Vec3& from, const Vec3& to) {
  ISIMP_ASSERT(to.dot(from) > -1, "opposites have no least turn");
  const double s = std::sqrt((1 + to.dot(from)) * 2);
  Eigen::Quaterniond q;
  q.vec() = from.cross(to) * (1 / s);
  q.w() = s * 0.5;
  return q.toRotationMatrix();
}

Vec3 across(const Vec3& v, const Vec3& axis) { return v - v.dot(axis) * axis; }

}  // namespace

RoundAxes::RoundAxes(const Mesh& mesh, const Partition& partition, const std::vector<RegionPlane>& planes)
    : origin_(mesh.origin()) {
  if (partition.curved.empty() || partition.region_cell.empty() || partition.region_held.empty()) return;
  regions_ = planes;
  std::vector<RoundPart> parts(partition.curved.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].number = static_cast<std::int32_t>(p);
    parts[p].first = partition.curved[p];
    parts[p].first.point -= origin_;
    parts[p].radius = parts[p].first.radius;
  }
  add_cells(partition, parts);
  std::erase_if(parts, [](const RoundPart& p) { return p.area <= 0; });
  std::stable_sort(parts.begin(), parts.end(), [](const RoundPart& a, const RoundPart& b) {
    const auto rank = [](const RoundPart& p) {
      return std::pair(p.first.kind == CurvedKind::sphere || is_bend(p.first), -p.area);
    };
    return rank(a) < rank(b);
  });
  group_up(std::move(parts), kApart * mesh.diagonal());
  for (Group& g : groups_) measure(g);
}

void RoundAxes::add_cells(const Partition& partition, std::vector<RoundPart>& parts) const {
  for (std::int32_t r = 0; r < partition.region_count(); ++r) {
    const std::int32_t p = partition.region_cell[r].proxy;
    if (p == kNone || partition.region_held[r] != kPlaneRound || regions_[r].scan.area <= 0) continue;
    parts[p].area += regions_[r].scan.area;
    parts[p].cells.push_back({r, partition.region_normal[r], partition.offset_from(origin_, r)});
  }
}

void RoundAxes::group_up(std::vector<RoundPart> parts, double apart) {
  const auto belongs = [&](const RoundPart& a, const RoundPart& b) {
    return is_one_axis(a.first, b.first, apart) || is_pipe_of(a.first, b.first) || is_pipe_of(b.first, a.first);
  };
  while (!parts.empty()) {
    Group& g = groups_.emplace_back();
    g.parts.push_back(std::move(parts.front()));
    parts.erase(parts.begin());
    for (std::size_t k = 0; k < g.parts.size(); ++k) {
      const auto joins = [&](const RoundPart& p) { return belongs(g.parts[k], p); };
      const auto rest =
          std::stable_partition(parts.begin(), parts.end(), [&](const RoundPart& p) { return !joins(p); });
      g.parts.insert(g.parts.end(), rest, parts.end());
      parts.erase(rest, parts.end());
    }
    const bool has_bend =
        std::any_of(g.parts.begin(), g.parts.end(), [](const RoundPart& p) { return is_bend(p.first); });
    for (RoundPart& p : g.parts) {
      p.has_radius =
          !has_bend && p.first.full && (p.first.kind == CurvedKind::cylinder || p.first.kind == CurvedKind::sphere);
      p.is_on_axis = is_one_axis(g.parts[0].first, p.first, apart);
    }
  }
}

void RoundAxes::measure(Group& g) const {
  const CurvedProxy& lead = g.parts[0].first;
  RegionPlane& axis = g.axis;
  axis.faces = 0;
  for (const RoundPart& part : g.parts)
    for (const CellPlane& cell : part.cells) {
      const RegionPlane& r = regions_[cell.region];
      axis.scan.area += r.scan.area;
      axis.faces += r.faces;
      g.middle += r.scan.area * r.scan.centre;
      g.normals += r.scan.area * cell.normal * cell.normal.transpose();
    }
  g.middle /= axis.scan.area;
  g.normals /= axis.scan.area;
  if (lead.kind == CurvedKind::sphere) g.middle = lead.point;  // it turns within its surface
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();  // a turn by a vector w moves the cells by w^T turns w, mean square
  for (const RoundPart& part : g.parts)
    for (const CellPlane& cell : part.cells) {
      const RegionPlane& r = regions_[cell.region];
      const Vec3 lever = (r.scan.centre - g.middle).cross(cell.normal);
      const Eigen::Matrix3d n = crossing(cell.normal);
      turns += r.scan.area * (lever * lever.transpose() + n * r.scan.spread * n.transpose());
    }
  const Eigen::Matrix3d a = crossing(lead.axis);
  axis.scan.spread = a.transpose() * turns * a / axis.scan.area;
  axis.scan.centre = g.middle;
  axis.normal = axis.snapped = axis.scan.normal = lead.axis;
  g.line = lead.point;
}

void RoundAxes::turn(std::size_t group, const Vec3& axis) {
  Group& g = groups_[group];
  g.is_turned = true;
  g.axis.snapped = axis;
  if (axis != g.axis.normal) g.turn = turn_between(g.axis.normal, axis);
  g.line = g.middle + g.turn * (g.parts[0].first.point - g.middle);
}

void RoundAxes::place(std::int32_t number, const Vec3& point, const Vec3& axis, double radius) {
  for (std::size_t k = 0; k < size(); ++k)
    for (RoundPart& part : groups_[k].parts) {
      if (part.number != number) continue;
      if (part.has_radius) part.radius = radius;
      if (!part.is_on_axis) continue;
      Group& g = groups_[k];
      turn(k, axis.dot(g.axis.normal) < 0 ? Vec3(-axis) : axis);
      g.shift = across(point - g.line, axis);
      g.line += g.shift;
    }
}

void RoundAxes::share(std::span<const double> reach) {
  share_axes(reach);
  share_radii(reach);
}

void RoundAxes::share_axes(std::span<const double> reach) {
  std::vector<bool> done(size(), false);
  for (std::size_t lead = 0; lead < size(); ++lead) {
    if (done[lead] || !groups_[lead].is_turned) continue;
    const Vec3 axis = groups_[lead].axis.snapped, from = groups_[lead].line;
    const auto is_near = [&](std::size_t g, const Vec3& by) {
      const Vec3 back = groups_[g].turn.transpose() * by;
      return std::sqrt(back.dot(groups_[g].normals * back)) < reach[g];
    };
    Vec3 sum = Vec3::Zero();
    double area = 0;
    std::vector<std::size_t> some;
    for (std::size_t k = lead; k < size(); ++k) {
      const Group& g = groups_[k];
      if (done[k] || !g.is_turned || g.axis.snapped.cross(axis).norm() > kSame) continue;
      const Vec3 to = across(g.line - from, axis);
      if (!is_near(k, to) || !is_near(lead, to)) continue;
      some.push_back(k);
      done[k] = true;
      sum += g.axis.scan.area * to;
      area += g.axis.scan.area;
    }
    if (some.size() < 2) continue;
    const Vec3 line = from + sum / area;
    for (const std::size_t k : some) {
      groups_[k].shift = across(line - groups_[k].line, axis);
      groups_[k].line = line;
    }
  }
}

void RoundAxes::share_radii(std::span<const double> reach) {
  std::vector<std::pair<RoundPart*, double>> all;
  for (std::size_t k = 0; k < size(); ++k)
    for (RoundPart& p : groups_[k].parts)
      if (p.has_radius) all.emplace_back(&p, reach[k]);
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first->area > b.first->area; });
  while (!all.empty()) {
    const RoundPart* const lead = all.front().first;
    const double most = all.front().second;
    const auto rest = std::stable_partition(all.begin(), all.end(), [&](const auto& other) {
      return other.first == lead || (other.first->first.kind == lead->first.kind &&
                                     std::abs(other.first->radius - lead->radius) < std::min(other.second, most));
    });
    double sum = 0, area = 0;
    for (auto at = all.begin(); at != rest; ++at) {
      sum += at->first->area * at->first->radius;
      area += at->first->area;
    }
    if (rest - all.begin() > 1)
      for (auto at = all.begin(); at != rest; ++at) at->first->radius = sum / area;
    all.erase(all.begin(), rest);
  }
}

void RoundAxes::release(std::size_t group) {
  Group& g = groups_[group];
  g.is_turned = false;
  g.turn.setIdentity();
  g.shift.setZero();
  g.line = g.parts[0].first.point;
  g.axis.snapped = g.axis.normal;
  for (RoundPart& p : g.parts) p.radius = p.first.radius;
}

CurvedProxy RoundAxes::moved(const Group& g, const RoundPart& part) const {
  CurvedProxy p = part.first;
  p.radius = part.radius;
  if (!g.is_turned) return p;
  p.point = g.middle + g.turn * (p.point - g.middle) + g.shift;
  p.axis = (g.turn * p.axis).normalized();
  if (part.is_on_axis) {
    p.axis = p.axis.dot(g.axis.snapped) < 0 ? Vec3(-g.axis.snapped) : g.axis.snapped;
    p.point -= across(p.point - g.line, p.axis);
  }
  p.across = across(g.turn * p.across, p.axis).normalized();
  return p;
}

template <class Visit>
void RoundAxes::for_each_cell(const Group& g, Visit visit) const {
  for (const RoundPart& part : g.parts) {
    if (!g.is_turned && part.radius == part.first.radius) continue;
    const CurvedProxy p = moved(g, part);
    const double grown = part.has_radius ? part.radius / part.first.radius : 1;
    for (const CellPlane& cell : part.cells) {
      const Vec3 normal = (g.turn * cell.normal).normalized();
      const double far = cell.offset - cell.normal.dot(part.first.point);
      visit(cell, CellPlane{cell.region, normal, normal.dot(p.point) + grown * far});
    }
  }
}

double RoundAxes::before(std::size_t group) const {
  double sum = 0;
  for (const RoundPart& part : groups_[group].parts)
    for (const CellPlane& cell : part.cells)
      sum += regions_[cell.region].scan.area * squared_distance(regions_[cell.region], cell.normal, cell.offset);
  return sum;
}

double RoundAxes::added(std::size_t group) const {
  double sum = 0;
  for_each_cell(groups_[group], [&](const CellPlane& was, const CellPlane& is) {
    const RegionPlane& r = regions_[was.region];
    sum += r.scan.area * (squared_distance(r, is.normal, is.offset) - squared_distance(r, was.normal, was.offset));
  });
  return sum;
}

std::vector<CellPlane> RoundAxes::cells() const {
  std::vector<CellPlane> all;
  for (const Group& g : groups_) for_each_cell(g, [&](const CellPlane&, const CellPlane& is) { all.push_back(is); });
  return all;
}

void RoundAxes::store(std::vector<CurvedProxy>& parts, RegularAxes& found) const {
  std::vector<const RoundPart*> round;
  for (std::size_t k = 0; k < size(); ++k) {
    const Group& g = groups_[k];
    const auto is_mine = [&](const Group& other) {
      return &other != &g && g.is_turned && other.is_turned && other.line == g.line &&
             other.axis.snapped.cross(g.axis.snapped).norm() <= kSame;
    };
    found.coaxial += std::any_of(groups_.begin(), groups_.end(), is_mine);
    for (const RoundPart& p : g.parts) {
      if (p.has_radius) round.push_back(&p);
      if (!g.is_turned && p.radius == p.first.radius) continue;
      parts[p.number] = moved(g, p);
      parts[p.number].point += origin_;
    }
  }
  for (const RoundPart* p : round)
    found.equal_radii += std::any_of(round.begin(), round.end(), [&](const RoundPart* other) {
      return other != p && other->first.kind == p->first.kind && other->radius == p->radius;
    });
}

}  // namespace isimp::regular
