#include "cells/cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/numbers.h"
#include "isimp/core/tiny.h"
#include "isimp/core/to_integer.h"

namespace isimp::curved {
namespace {

class Cutter {
 public:
  Cutter(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch)
      : f_(faces),
        p_(proxy),
        patch_(patch),
        grid_(proxy),
        on_(grid_.surface()),
        width_(grid_.width()),
        is_extrusion_(proxy.kind == CurvedKind::extrusion) {}

  /// \param mates  as of `cut`; null: corners stay where the grid has them
  Some labels(const Mates* mates) {
    for (std::size_t k = 0; k < patch_.face.size(); ++k) {
      ring_.push_back(grid_.ring(patch_.along[k]));
      segment_.push_back(grid_.segment(patch_.angle[k], patch_.along[k]));
    }
    if (mates != nullptr && p_.rings > 1) join_corners();
    if (mates != nullptr && (p_.full || is_bend())) join_rim(*mates);
    Some cell;
    cell.reserve(ring_.size());
    for (std::size_t k = 0; k < ring_.size(); ++k) cell.push_back(grid_.number(ring_[k], segment_[k]));
    return cell;
  }

  Cells run(const Mates& mates) {
    Cells cells;
    cells.of_face = labels(&mates);
    set_planes(cells);
    return cells;
  }

 private:
  /// The signed distance along the profile between two places; on a ring, along the shorter arc.
  [[nodiscard]] double beyond(double along, double from) const {
    const double d = along - from, round = p_.knots.back();
    return p_.closed ? d - round * std::round(d / round) : d;
  }

  /// The vertex nearest to a corner of the grid.
  struct Nearest {
    std::int32_t vertex = kNone;
    double distance = std::numeric_limits<double>::infinity(), angle = 0, along = 0;
  };

  /// Labels the faces near each inner corner of the grid by quadrants about one vertex, where four cells meet then.
  void join_corners() {
    const Mesh& mesh = f_.mesh();
    for (const double knot : p_.knots) corner_.push_back(on_.place(knot));
    nearest_.resize(p_.knots.size() * static_cast<std::size_t>(p_.segments + 1));
    std::vector<bool> met(mesh.vertices().size(), false);
    for (const std::int32_t i : patch_.face)
      for (const std::int32_t v : mesh.triangles()[f_.graph().mesh_face[i]]) {
        if (!met[v]) offer(v);
        met[v] = true;
      }
    for (std::size_t k = 0; k < patch_.face.size(); ++k) {
      const std::int32_t knot = nearest_knot(patch_.along[k]), side = nearest_side(patch_.angle[k]);
      const Nearest& n = nearest_[corner_of(knot, side)];
      if (n.vertex == kNone) continue;
      const auto [is_above, is_right] = quadrant(k, n);
      ring_[k] = is_above ? knot : (knot + p_.rings - 1) % p_.rings;
      segment_[k] = (side + (is_right ? 0 : p_.segments - 1)) % p_.segments;
    }
  }

  [[nodiscard]] std::size_t corner_of(std::int32_t knot, std::int32_t side) const {
    return static_cast<std::size_t>(knot) * static_cast<std::size_t>(p_.segments + 1) + static_cast<std::size_t>(side);
  }
  /// The knot of a corner of the grid that is nearest along the profile. On a ring the last is the first.
  [[nodiscard]] std::int32_t nearest_knot(double along) const {
    const std::int32_t before = grid_.part(along);
    const bool is_next = along - p_.knots[before] > p_.knots[before + 1] - along;
    return p_.closed ? (before + is_next) % p_.rings : before + is_next;
  }
  [[nodiscard]] std::int32_t nearest_side(double angle) const {
    const auto side = to_integer(grid_.place(angle) / width_ + 0.5, 0, p_.segments);
    return p_.full ? side % p_.segments : side;
  }
  /// Whether a face is beyond a vertex along the profile, and whether it is beyond it in angle.
  [[nodiscard]] std::array<bool, 2> quadrant(std::size_t k, const Nearest& n) const {
    return {beyond(patch_.along[k], n.along) > 0, turned(patch_.angle[k] - n.angle) > 0};
  }

  /// Makes a vertex the nearest to a corner, if it is, and four cells can meet in it.
  void offer(std::int32_t v) {
    const Vec3& x = f_.mesh().vertices()[v];
    const double angle = curved::angle(p_, x), at = grid_.place(angle) / width_;
    auto side = to_integer(at + 0.5, 0, p_.segments);
    if (!p_.full && (side <= 0 || side >= p_.segments)) return;
    if (std::abs(at - side) > kQuarter) return;
    if (p_.full) side %= p_.segments;
    const Polar polar = curved::polar(p_, x);
    const double to = turned(angle - p_.phase - side * width_) * polar.rho;
    const Vec2 here(polar.rho, polar.z);
    std::size_t best = p_.closed ? 0 : 1;
    for (std::size_t k = best + 1; k + 1 < corner_.size(); ++k)
      if ((here - corner_[k]).squaredNorm() < (here - corner_[best]).squaredNorm()) best = k;
    const double d = to * to + (here - corner_[best]).squaredNorm();
    Nearest& n = nearest_[corner_of(static_cast<std::int32_t>(best), side)];
    if (d >= n.distance || d > std::pow(kQuarter * width_ * polar.rho, 2)) return;
    if (const Nearest now{v, d, angle, on_.along(polar)}; is_crossing(now)) n = now;
  }

  /// Whether all faces at a vertex are in the patch, and each quadrant about it has one of them and a face beyond that.
  [[nodiscard]] bool is_crossing(const Nearest& n) const {
    const Mesh& mesh = f_.mesh();
    bool is_inside = true;
    std::array<bool, 4> has{};
    for_each_leaving(mesh, n.vertex, [&](std::int32_t h) {
      const std::size_t k = index_of(f_.graph().graph_face[Mesh::face(h)]);
      const std::int32_t outward = mesh.opposite(Mesh::next(h));
      is_inside = is_inside && mesh.opposite(h) != kNone && k < patch_.face.size();
      if (!is_inside || outward == kNone) return;
      const std::size_t next = index_of(f_.graph().graph_face[Mesh::face(outward)]);
      const auto q = quadrant(k, n);
      if (next < patch_.face.size() && quadrant(next, n) == q) has[2 * q[0] + q[1]] = true;
    });
    return is_inside && std::all_of(has.begin(), has.end(), [](bool b) { return b; });
  }

  /// The bend of a pipe: its rings continue the segments of the pipe.
  [[nodiscard]] bool is_bend() const { return p_.closed && !p_.full; }

  /// Joins the corners at the borders to other patches with the same segments, which does the same with its faces.
  void join_rim(const Mates& mates) {
    const Mesh& mesh = f_.mesh();
    const FaceGraph& graph = f_.graph();
    const std::int32_t sides = is_bend() ? p_.rings : p_.segments;
    nearest_.assign(2 * static_cast<std::size_t>(sides), {});
    for (const std::int32_t i : patch_.face) {
      const auto is_mate = [&](std::int32_t j) {
        return j != graph.size() && mates.patch[j] != mates.patch[i] && mates.are(i, j);
      };
      if (std::none_of(graph.neighbours[i].begin(), graph.neighbours[i].end(), is_mate)) continue;
      for (const std::int32_t v : mesh.triangles()[graph.mesh_face[i]])
        if (is_among(v, mates, i)) offer_at_rim(v);
    }
    for (std::size_t c = 0; c < nearest_.size(); ++c) {
      const Nearest& n = nearest_[c];
      if (n.vertex == kNone) continue;
      const auto side = static_cast<std::int32_t>(c) % sides, before = (side + sides - 1) % sides;
      const bool is_high = static_cast<std::int32_t>(c) >= sides;
      for_each_leaving(mesh, n.vertex, [&](std::int32_t h) {
        const std::size_t k = index_of(graph.graph_face[Mesh::face(h)]);
        if (k == patch_.face.size()) return;
        ring_[k] = is_high ? p_.rings - 1 : 0;
        segment_[k] = is_high ? p_.segments - 1 : 0;
        if (is_bend())
          ring_[k] = beyond(patch_.along[k], n.along) > 0 ? side : before;
        else
          segment_[k] = turned(patch_.angle[k] - n.angle) > 0 ? side : before;
      });
    }
  }

  /// Whether all faces at a vertex are in patches that are cut together, and some are in another one than a given face.
  [[nodiscard]] bool is_among(std::int32_t v, const Mates& mates, std::int32_t mine) const {
    bool is = true, is_border = false;
    for_each_leaving(f_.mesh(), v, [&](std::int32_t h) {
      const std::int32_t i = f_.graph().graph_face[Mesh::face(h)];
      is = is && f_.mesh().opposite(h) != kNone && mates.are(mine, i);
      is_border = is_border || mates.patch[i] != mates.patch[mine];
    });
    return is && is_border;
  }

  void offer_at_rim(std::int32_t v) {
    const Vec3& x = f_.mesh().vertices()[v];
    const double angle = curved::angle(p_, x);
    const OnSurface on = on_.at(x);
    const double cells = is_bend() ? on.along / p_.knots.back() * p_.rings : grid_.place(angle) / width_;
    const std::int32_t sides = is_bend() ? p_.rings : p_.segments;
    const auto side = to_integer(cells + 0.5, 0, sides);
    const double off = std::abs(cells - side);
    const bool is_high =
        is_bend() ? grid_.place(angle) > p_.span / 2 : on.along > (p_.knots.front() + p_.knots.back()) / 2;
    Nearest& n = nearest_[static_cast<std::size_t>(side % sides) + static_cast<std::size_t>(is_high ? sides : 0)];
    if (off < n.distance && off < kQuarter) n = {v, off, angle, on.along};
  }

  /// The place of a face in the patch; its size if the face is not in it.
  [[nodiscard]] std::size_t index_of(std::int32_t face) const {
    const auto at = std::lower_bound(patch_.face.begin(), patch_.face.end(), face);
    return at == patch_.face.end() || *at != face ? patch_.face.size()
                                                  : static_cast<std::size_t>(at - patch_.face.begin());
  }

  /// The line of each part of the profile, in the plane in the middle of a segment: its normal and offset. With more than
  /// one part the lines meet at corners that they share.
  std::vector<std::pair<Vec2, double>> lines(double sinc) const {
    const std::size_t parts = p_.knots.size() - 1;
    std::vector<Vec2> normal(parts, Vec2::Zero()), middle(parts, Vec2::Zero()), corners;
    std::vector<double> area(parts, 0);
    std::vector<ProfileSample> samples;
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const std::int32_t part = is_extrusion_ ? segment_[k] : ring_[k];
      const Vec2 at(sinc * patch_.rho[k], patch_.z[k]);
      area[part] += patch_.area[k];
      middle[part] += patch_.area[k] * at;
      normal[part] += patch_.area[k] * Vec2(sinc * patch_.out[k], patch_.up[k]);
      if (!grid_.is_cap(part)) samples.push_back({patch_.area[k], at, static_cast<std::size_t>(part)});
    }
    std::vector<std::pair<Vec2, double>> all;
    for (std::size_t k = 0; k < parts; ++k) {
      normal[k] = grid_.is_cap(static_cast<std::int32_t>(k)) ? Vec2(0, normal[k].y() < 0 ? -1 : 1)
                                                             : Vec2(normal[k].normalized());
      all.emplace_back(normal[k], normal[k].dot(middle[k]) / std::max(area[k], kTiny));
    }
    // The edges of a pipe and of its bend meet exactly if both depend on the radius alone.
    if (p_.kind == CurvedKind::cylinder) all[0] = {normal[0], normal[0].x() * sinc * p_.radius};
    if (parts == 1 || is_extrusion_) return all;
    for (const double knot : p_.knots) corners.push_back(Vec2(sinc, 1).cwiseProduct(on_.place(knot)));
    if (p_.closed && !p_.full) {
      const Vec2 middle_of_tube = Vec2(sinc, 1).cwiseProduct(tube_of(p_).middle);
      const double half = kTurn / p_.rings / 2, more = std::tan(half) / half;
      for (Vec2& c : corners) c = middle_of_tube + more * (c - middle_of_tube);
    } else {
      corners = fitted_corners(std::move(corners), p_.closed, samples);
    }
    for (std::size_t k = 0; k < parts; ++k) {
      if (grid_.is_cap(static_cast<std::int32_t>(k))) continue;
      const Vec2 edge = corners[k + 1] - corners[k];
      Vec2 m = Vec2(edge.y(), -edge.x()).normalized();
      if (m.dot(normal[k]) < 0) m = -m;
      all[k] = {m, m.dot(corners[k])};
    }
    return all;
  }

  void set_planes(Cells& cells) const {
    const auto count = static_cast<std::size_t>(p_.rings) * static_cast<std::size_t>(p_.segments);
    cells.cell.resize(count);
    cells.normal.assign(count, Vec3::Zero());
    cells.offset.assign(count, 0.0);
    const auto all = lines(is_extrusion_ ? 1 : std::sin(width_ / 2) / (width_ / 2));
    const Vec3 beside = p_.axis.cross(p_.across), up = is_extrusion_ ? beside : p_.axis;
    for (std::size_t c = 0; c < count; ++c) {
      const auto r = static_cast<std::int32_t>(c) / p_.segments, s = static_cast<std::int32_t>(c) % p_.segments;
      const auto& [m, offset] = all[is_extrusion_ ? s : r];
      const double angle = is_extrusion_ ? 0 : p_.phase + (s + 0.5) * width_;
      cells.cell[c] = {kNone, r, s};
      cells.normal[c] = m.x() * (std::cos(angle) * p_.across + std::sin(angle) * beside) + m.y() * up;
      cells.offset[c] = cells.normal[c].dot(p_.point) + offset;
    }
  }

  const Faces& f_;
  const CurvedProxy& p_;
  const PatchFaces& patch_;
  CellGrid grid_;
  const Locator& on_;
  double width_;
  bool is_extrusion_;
  Some ring_, segment_;
  std::vector<Vec2> corner_;      // by knot: its place on the profile
  std::vector<Nearest> nearest_;  // by knot and side of a segment
};

}  // namespace

CellGrid::CellGrid(const CurvedProxy& proxy)
    : p_(&proxy), on_(proxy), width_(proxy.span / proxy.segments), is_extrusion_(proxy.kind == CurvedKind::extrusion) {}

std::int32_t CellGrid::part(double along) const {
  const auto at = std::upper_bound(p_->knots.begin(), p_->knots.end(), along) - p_->knots.begin() - 1;
  return std::clamp(static_cast<std::int32_t>(at), 0, static_cast<std::int32_t>(p_->knots.size()) - 2);
}

double CellGrid::place(double angle) const {
  const double t = rest_of_turns(angle - p_->phase + 2 * kTurn);
  if (p_->full) return t;
  return t > p_->span + (kTurn - p_->span) / 2 ? 0 : std::min(t, p_->span);
}

std::int32_t CellGrid::segment(double angle, double along) const {
  return is_extrusion_ ? part(along) : to_integer(place(angle) / width_, 0, p_->segments - 1);
}

std::int32_t CellGrid::at(const Vec3& x) const {
  const double along = on_.at(x).along;
  return number(ring(along), segment(angle(*p_, x), along));
}

Some cells_of_faces(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch) {
  return Cutter(faces, proxy, patch).labels(nullptr);
}

Cells cut(const Faces& faces, const CurvedProxy& proxy, const PatchFaces& patch, const Mates& mates) {
  return Cutter(faces, proxy, patch).run(mates);
}

}  // namespace isimp::curved
