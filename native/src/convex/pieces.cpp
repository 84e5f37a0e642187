#include "pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "isimp/core/check.h"
#include "isimp/core/forest.h"

namespace isimp::convex {
namespace {

constexpr int kGridBits = 20;             // rounding: steps in the diagonal: the range of the integers in hull_of
constexpr std::size_t kMostChances = 24;  // limit: planes that are tried in full for one cut
constexpr double kNothing = 1e-9;         // rounding: share of its volume that a convex piece lacks
// tuned colliders
constexpr double kFinished = 0.1;  // weight of the volume that needs no more cuts

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box, double by) {
  return {Vec3(box.min().array() - by), Vec3(box.max().array() + by)};
}

Plane plane_of(const ConvexPart& part, const Triangle& t) {
  const Vec3 &a = part.vertices[t[0]], &b = part.vertices[t[1]], &c = part.vertices[t[2]];
  const Vec3 normal = (b - a).cross(c - a).normalized();
  return {normal, normal.dot(a)};
}

std::vector<Plane> planes_of(const ConvexPart& part) {
  std::vector<Plane> planes;
  for (const Triangle& t : part.triangles) planes.push_back(plane_of(part, t));
  return planes;
}

}  // namespace

Pieces::Pieces(const Solid& solid, Cells&& cells, Job& job) : solid_(&solid), cells_(std::move(cells.inside)) {
  // Where much space is free, a deep point is soon found.
  std::ranges::stable_sort(cells.outside, std::ranges::greater{}, &Cell::volume);
  outside_ = std::make_shared<const std::vector<Cell>>(std::move(cells.outside));
  int exponent = 0;
  (void)std::frexp(solid.box.diagonal().norm(), &exponent);
  grid_ = std::ldexp(1.0, exponent - kGridBits);
  contacts_of_.resize(cells_.size());
  place_.assign(cells_.size(), kNone);
  find_contacts(job);
}

void Pieces::add_contact(Contact&& contact) {
  const auto i = static_cast<std::int32_t>(contacts_.size());
  contacts_of_[contact.below].push_back(i);
  contacts_of_[contact.above].push_back(i);
  contacts_.push_back(std::move(contact));
}

void Pieces::find_contacts(Job& job) {
  struct Side {
    std::int32_t cell, face;
  };
  std::vector<std::array<std::vector<Side>, 2>> sides(solid_->planes.size());
  for (std::int32_t c = 0; c < std::ssize(cells_); ++c)
    for (std::int32_t f = 0; f < std::ssize(cells_[c].faces); ++f)
      sides[cells_[c].faces[f].plane][cells_[c].faces[f].up ? 0 : 1].push_back({c, f});
  const double snap = solid_->lengths.snap;
  for (std::int32_t p = 0; p < std::ssize(sides); ++p) {
    job.report(static_cast<double>(p) / static_cast<double>(sides.size()));
    for (const Side& below : sides[p][0])
      for (const Side& above : sides[p][1]) {
        const Cell &a = cells_[below.cell], &b = cells_[above.cell];
        if (!grown(a.box, snap).intersects(b.box)) continue;
        Loop loop = overlap(a.faces[below.face].loop, b.faces[above.face].loop, solid_->planes[p].normal, snap);
        if (!loop.empty()) add_contact({below.cell, above.cell, p, std::move(loop)});
      }
  }
}

Vec3 Pieces::on_grid(const Vec3& p) const {
  return {std::round(p.x() / grid_) * grid_, std::round(p.y() / grid_) * grid_, std::round(p.z() / grid_) * grid_};
}

std::vector<Vec3> Pieces::corners(const Piece& piece) const {
  std::vector<Vec3> points;
  for (const std::int32_t c : piece.cells)
    points.insert(points.end(), cells_[c].corners.begin(), cells_[c].corners.end());
  return points;
}

ConvexPart Pieces::hull(const std::vector<std::int32_t>& cells) const {
  std::vector<Vec3> points;
  for (const std::int32_t c : cells)
    for (const Vec3& p : cells_[c].corners) points.push_back(on_grid(p));
  return hull_of(points, 2 * grid_, grid_);
}

std::vector<Piece> Pieces::connected(const std::vector<std::int32_t>& cells) const {
  for (std::int32_t i = 0; i < std::ssize(cells); ++i) place_[cells[i]] = i;
  detail::Forest forest(cells.size());
  for (const std::int32_t c : cells)
    for (const std::int32_t i : contacts_of_[c]) {
      const std::int32_t other = contacts_[i].below == c ? contacts_[i].above : contacts_[i].below;
      if (place_[other] != kNone) forest.join(place_[c], place_[other]);
    }
  std::vector<Piece> pieces;
  std::vector<std::int32_t> number(cells.size(), kNone);
  for (std::int32_t i = 0; i < std::ssize(cells); ++i) {
    std::int32_t& n = number[forest.root(i)];
    if (n == kNone) {
      n = static_cast<std::int32_t>(pieces.size());
      pieces.emplace_back();
    }
    pieces[n].cells.push_back(cells[i]);
    pieces[n].volume += cells_[cells[i]].volume;
  }
  for (const std::int32_t c : cells) place_[c] = kNone;
  for (Piece& piece : pieces) piece.hull = hull(piece.cells);
  return pieces;
}

std::vector<Piece> Pieces::whole() const {
  std::vector<std::int32_t> all(cells_.size());
  std::iota(all.begin(), all.end(), 0);
  return connected(all);
}

Piece Pieces::joined(const Piece& a, const Piece& b) const {
  Piece both{.cells = a.cells, .volume = a.volume + b.volume};
  both.cells.insert(both.cells.end(), b.cells.begin(), b.cells.end());
  std::vector<Vec3> points = a.hull.vertices;
  points.insert(points.end(), b.hull.vertices.begin(), b.hull.vertices.end());
  both.hull = hull_of(points, 2 * grid_, grid_);
  return both;
}

std::vector<std::array<std::int32_t, 2>> Pieces::touching(const std::vector<Piece>& pieces) const {
  for (std::int32_t p = 0; p < std::ssize(pieces); ++p)
    for (const std::int32_t c : pieces[p].cells) {
      ISIMP_ASSERT(place_[c] == kNone, "a cell is of one piece");
      place_[c] = p;
    }
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const Contact& contact : contacts_) {
    if (contact.below == kNone) continue;  // it was divided
    const std::int32_t a = place_[contact.below], b = place_[contact.above];
    if (a != kNone && b != kNone && a != b) pairs.push_back({std::min(a, b), std::max(a, b)});
  }
  std::ranges::fill(place_, kNone);
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

std::vector<std::int32_t> Pieces::chances(const Piece& piece) const {
  const std::vector<Plane> lids = planes_of(piece.hull);
  std::vector<double> saved(solid_->planes.size(), 0);
  for (const std::int32_t c : piece.cells)
    for (const CellFace& face : cells_[c].faces) {
      double area = area_vector(face.loop).norm();
      for (const std::int32_t i : contacts_of_[c])
        if (contacts_[i].plane == face.plane && (contacts_[i].below == c) == face.up)
          area -= area_vector(contacts_[i].loop).norm();
      const Vec3 out = solid_->planes[face.plane].normal * (face.up ? 1 : -1);
      const Vec3 middle = mean_of(face.loop);
      double depth = std::numeric_limits<double>::infinity();
      for (const Plane& lid : lids) {
        const double toward = lid.normal.dot(out);
        if (toward > 0) depth = std::min(depth, std::max(-lid.height(middle), 0.0) / toward);
      }
      if (area > 0 && std::isfinite(depth)) saved[face.plane] += area * depth;
    }
  std::vector<Chance> found;
  for (std::int32_t p = 0; p < std::ssize(saved); ++p) {
    if (!(saved[p] > 0)) continue;
    double low = 0, high = 0;
    for (const Vec3& v : piece.hull.vertices) {
      const double h = solid_->planes[p].height(v);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    if (low < -solid_->lengths.same && high > solid_->lengths.same) found.push_back({p, saved[p]});
  }
  std::ranges::stable_sort(found, std::ranges::greater{}, &Chance::saved);
  std::vector<std::int32_t> planes;
  for (std::size_t i = 0; i < std::min(found.size(), kMostChances); ++i) planes.push_back(found[i].plane);
  return planes;
}

std::vector<Piece> Pieces::virtual_cut(const Piece& piece, std::int32_t plane) const {
  const Plane& by = solid_->planes[plane];
  const double snap = solid_->lengths.snap;
  const auto n = static_cast<std::int32_t>(piece.cells.size());
  // Cell i of the piece is node i above the plane and node n + i below.
  std::vector<double> volume(2 * piece.cells.size(), 0);
  std::vector<std::vector<Vec3>> points(2 * piece.cells.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const Cell& cell = cells_[piece.cells[i]];
    place_[piece.cells[i]] = i;
    const auto [low, high] = cell.heights(by);
    if (low < -snap && high > snap) {
      const DividedCell divided = divide(cell, solid_->planes, plane, snap);
      for (int k = 0; k < 2; ++k) {
        volume[k * n + i] = divided.side[k].volume;
        points[k * n + i] = divided.side[k].corners;
      }
    } else {
      const int k = high > snap ? 0 : 1;
      volume[k * n + i] = cell.volume;
      points[k * n + i] = cell.corners;
    }
  }
  detail::Forest forest(2 * piece.cells.size());
  for (const std::int32_t c : piece.cells)
    for (const std::int32_t contact : contacts_of_[c]) {
      if (contacts_[contact].below != c) continue;
      const std::int32_t i = place_[c], j = place_[contacts_[contact].above];
      if (j == kNone) continue;
      double low = 0, high = 0;
      for (const Vec3& p : contacts_[contact].loop) {
        low = std::min(low, by.height(p));
        high = std::max(high, by.height(p));
      }
      if (high > snap) forest.join(i, j);
      if (low < -snap) forest.join(n + i, n + j);
    }
  for (const std::int32_t c : piece.cells) place_[c] = kNone;
  std::vector<Piece> parts;
  std::vector<std::vector<Vec3>> all;
  std::vector<std::int32_t> number(volume.size(), kNone);
  for (std::int32_t i = 0; i < 2 * n; ++i) {
    if (points[i].empty()) continue;
    std::int32_t& k = number[forest.root(i)];
    if (k == kNone) {
      k = static_cast<std::int32_t>(parts.size());
      parts.emplace_back();
      all.emplace_back();
    }
    parts[k].volume += volume[i];
    for (const Vec3& p : points[i]) all[k].push_back(on_grid(p));
  }
  for (std::size_t k = 0; k < parts.size(); ++k) parts[k].hull = hull_of(all[k], 2 * grid_, grid_);
  return parts;
}

std::pair<Pieces, Piece> Pieces::alone(const Piece& piece) const {
  std::pair<Pieces, Piece> made{Pieces(), piece};
  auto& [some, same] = made;
  some.solid_ = solid_;
  some.outside_ = outside_;
  some.grid_ = grid_;
  some.place_.assign(piece.cells.size(), kNone);
  some.contacts_of_.resize(piece.cells.size());
  for (std::int32_t i = 0; i < std::ssize(piece.cells); ++i) {
    place_[piece.cells[i]] = same.cells[i] = i;
    some.cells_.push_back(cells_[piece.cells[i]]);
  }
  for (const std::int32_t c : piece.cells)
    for (const std::int32_t i : contacts_of_[c]) {
      const Contact& contact = contacts_[i];
      if (contact.below != c) continue;
      const std::int32_t above = place_[contact.above];
      if (above != kNone) some.add_contact({place_[c], above, contact.plane, contact.loop});
    }
  for (const std::int32_t c : piece.cells) place_[c] = kNone;
  return made;
}

std::vector<std::int32_t> Pieces::choices(const Piece& piece, Job& job) const {
  std::vector<std::pair<double, std::int32_t>> costs;
  for (const std::int32_t plane : chances(piece)) {
    job.poll();
    const std::vector<Piece> parts = virtual_cut(piece, plane);
    if (parts.size() < 2) continue;
    // Cuts through a hollow solid save nothing before the last one. So finished parts count a little.
    double cost = 0;
    for (const Piece& part : parts) {
      const double missing = std::max(part.missing(), 0.0);
      cost += missing;
      if (missing <= kNothing * part.volume) cost -= kFinished * part.volume;
    }
    costs.emplace_back(cost, plane);
  }
  std::ranges::stable_sort(costs, {}, &std::pair<double, std::int32_t>::first);
  std::vector<std::int32_t> planes;
  planes.reserve(costs.size());
  for (const auto& [cost, plane] : costs) planes.push_back(plane);
  return planes;
}

std::vector<Piece> Pieces::cut(const Piece& piece, std::int32_t plane) {
  std::vector<std::int32_t> cells = piece.cells;
  const auto first = static_cast<std::int32_t>(cells_.size());
  divide_cells(piece, plane);
  for (std::int32_t c = first; c < std::ssize(cells_); ++c) cells.push_back(c);
  place_.resize(cells_.size(), kNone);
  std::array<std::vector<std::int32_t>, 2> side;
  for (const std::int32_t c : cells) side[solid_->planes[plane].height(cells_[c].center) >= 0 ? 0 : 1].push_back(c);
  std::vector<Piece> parts = connected(side[0]);
  std::ranges::move(connected(side[1]), std::back_inserter(parts));
  return parts;
}

void Pieces::divide_cells(const Piece& piece, std::int32_t plane) {
  const Plane& by = solid_->planes[plane];
  const double snap = solid_->lengths.snap;
  std::vector<std::int32_t> lower(cells_.size());  // the half below; the half above keeps the number of its cell
  std::iota(lower.begin(), lower.end(), 0);
  std::vector<std::int32_t> old;
  std::vector<Contact> made;
  for (const std::int32_t c : piece.cells) {
    const auto [low, high] = cells_[c].heights(by);
    if (low >= -snap || high <= snap) continue;
    old.insert(old.end(), contacts_of_[c].begin(), contacts_of_[c].end());
    DividedCell divided = divide(cells_[c], solid_->planes, plane, snap);
    lower[c] = static_cast<std::int32_t>(cells_.size());
    cells_[c] = std::move(divided.side[0]);
    cells_.push_back(std::move(divided.side[1]));
    contacts_of_.emplace_back();
    if (!divided.between.empty()) made.push_back({lower[c], c, plane, std::move(divided.between)});
  }
  std::ranges::sort(old);
  old.erase(std::unique(old.begin(), old.end()), old.end());
  for (const std::int32_t i : old) {
    Contact contact = std::move(contacts_[i]);
    std::erase(contacts_of_[contact.below], i);
    std::erase(contacts_of_[contact.above], i);
    contacts_[i].below = contacts_[i].above = kNone;
    auto loops = divide(contact.loop, by, snap);
    if (!loops[0].empty()) made.push_back({contact.below, contact.above, contact.plane, std::move(loops[0])});
    if (!loops[1].empty())
      made.push_back({lower[contact.below], lower[contact.above], contact.plane, std::move(loops[1])});
  }
  for (Contact& contact : made) add_contact(std::move(contact));
}

bool Pieces::fills_space(const Piece& piece, Job& job) const {
  if (piece.missing() <= kNothing * piece.volume) return false;
  const std::vector<Plane> lids = planes_of(piece.hull);
  const double snap = solid_->lengths.snap, deep = solid_->lengths.deep;
  const Eigen::AlignedBox3d around = grown(box_of(piece.hull.vertices), -snap);
  std::vector<Plane> lid(1);
  for (const Cell& cell : *outside_) {
    if (!around.intersects(cell.box)) continue;
    job.poll();
    Cell rest = cell;
    for (std::size_t i = 0; i < lids.size() && !rest.faces.empty(); ++i) {
      const auto [lowest, highest] = rest.heights(lids[i]);
      if (highest <= snap) continue;
      if (lowest >= -snap) {
        rest.faces.clear();
        break;
      }
      lid[0] = lids[i];
      rest = std::move(divide(rest, lid, 0, snap).side[1]);
    }
    if (rest.faces.empty()) continue;
    if (solid_->is_far(rest.center, deep)) return true;
    for (const CellFace& face : rest.faces) {
      if (solid_->is_far(mean_of(face.loop), deep)) return true;
      for (const Vec3& p : face.loop)
        if (solid_->is_far(p, deep)) return true;
    }
  }
  return false;
}

}  // namespace isimp::convex
