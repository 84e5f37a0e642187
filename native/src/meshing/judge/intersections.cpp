// Finds polygons that meet others.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "isimp/core/prefetch.h"
#include "isimp/mesh/meet.h"
#include "judge/boxes.h"
#include "judge/judge.h"

namespace isimp::meshing {
namespace {

isimp::Corners corners_of(const Mesh& mesh, std::int32_t face) {
  const Triangle& t = mesh.triangles()[face];
  return {rounded_to_float(mesh.vertices()[t[0]]), rounded_to_float(mesh.vertices()[t[1]]),
          rounded_to_float(mesh.vertices()[t[2]])};
}

/// The box of a triangle whose coordinates are float32.
Box box_of(const isimp::Corners& t) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = static_cast<float>(std::min({t[0][k], t[1][k], t[2][k]}));
    box.high[k] = static_cast<float>(std::max({t[0][k], t[1][k], t[2][k]}));
  }
  return box;
}

/// Two facets that meet, by chart and index, the lower one first.
struct Meeting {
  std::int32_t chart, index, other_chart, other_index;
  auto operator<=>(const Meeting&) const = default;
};

Facing facing_of(const isimp::Corners& t) {
  // rounding: A side is a sum of six products of three differences each, rounded by less than this in all.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const Vec3 u = t[1] - t[0], v = t[2] - t[0];
  return {u.cross(v), kRounding * u.cwiseAbs().maxCoeff() * v.cwiseAbs().maxCoeff()};
}

/// A triangle with the data of a quick test whether another lies to one side of it.
struct Placed {
  const std::array<std::int32_t, 3>& corner;
  const isimp::Corners& at;
  const Facing& facing;
};

/// Whether all corners of g that f does not share surely lie to the same side of f's plane, so that the two meet only
/// in shared corners and edges. This test separates most triangles that are near each other.
bool beside(const Placed& f, const Placed& g) {
  int sides = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 d = g.at[k] - f.at[0];
    const double height = f.facing.normal.dot(d), unsure = f.facing.slack * d.cwiseAbs().maxCoeff();
    if (height > unsure) {
      sides |= 1;
    } else if (height < -unsure) {
      sides |= 2;
    } else if (std::find(f.corner.begin(), f.corner.end(), g.corner[k]) == f.corner.end()) {
      return false;
    }
  }
  return sides == 1 || sides == 2;
}

/// Whether all corners of g, except the ends of a side that both share, surely lie beyond one side of f, as seen along
/// the axis nearest to its normal. This test separates triangles in one plane.
bool beyond_side(const Placed& f, const Placed& g) {
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();  // rounding
  int axis = 0;
  f.facing.normal.cwiseAbs().maxCoeff(&axis);
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  const double turn = f.facing.normal[axis] > 0 ? -1 : 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = k < 2 ? k + 1 : 0;
    const Vec3 &a = f.at[k], &b = f.at[next];
    const double ux = b[x] - a[x], uy = b[y] - a[y], length = std::max(std::abs(ux), std::abs(uy));
    bool all = true;
    for (std::size_t m = 0; m < 3 && all; ++m) {
      if (g.corner[m] == f.corner[k] || g.corner[m] == f.corner[next]) continue;
      const double vx = g.at[m][x] - a[x], vy = g.at[m][y] - a[y];
      const double unsure = kRounding * length * std::max(std::abs(vx), std::abs(vy));
      all = turn * (ux * vy - uy * vx) > unsure;
    }
    if (all) return true;
  }
  return false;
}

/// Whether two triangles that have area meet elsewhere than in shared corners and edges.
bool meet(const Placed& f, const Placed& g) {
  return !beside(f, g) && !beside(g, f) && !beyond_side(f, g) && !beyond_side(g, f) &&
         meet_elsewhere(f.corner, f.at, g.corner, g.at);
}

Placed placed(const FacetSet& set, std::int32_t i) { return {set.facets[i].corner, set.solids[i], set.facings[i]}; }

/// Calls fn(facet of a, facet of b) for the pairs of facets of two charts, or of one, that meet, each pair once, until
/// it returns true.
/// \return whether it did
template <class Function>
bool any_meeting(const FacetSet& a, const FacetSet& b, Function fn) {
  std::vector<std::int32_t> near;
  for (const std::int32_t j : b.solid)
    if (!b.boxes[j].apart(a.around)) near.push_back(j);
  if (near.empty()) return false;
  for (const std::int32_t i : a.solid) {
    const Box& box = a.boxes[i];
    if (box.apart(b.around)) continue;
    for (const std::int32_t j : near) {
      if (box.apart(b.boxes[j]) || (&a == &b && (j <= i || a.facets[i].part == b.facets[j].part))) continue;
      if (meet(placed(a, i), placed(b, j)) && fn(i, j)) return true;
    }
  }
  return false;
}

constexpr std::int32_t kChartsATime = 16;  ///< work: charts that one thread searches at a time

/// All pairs of facets that meet, searched in pairs of charts whose boxes meet, as these are few.
std::vector<Meeting> find_meetings(std::span<const FacetSet* const> charts, const Arounds& arounds,
                                   const std::vector<bool>& changed, const std::vector<bool>& known,
                                   const Threads& threads, const Job& job) {
  std::vector<std::int32_t> moved;
  for (std::int32_t l = 0; l < static_cast<std::int32_t>(charts.size()); ++l)
    if (changed[l] && !charts[l]->solid.empty()) moved.push_back(l);
  std::vector<std::vector<Meeting>> met(moved.size() / kChartsATime + 1);  // by block
  threads.blocks(static_cast<std::int32_t>(moved.size()), kChartsATime,
                 [&](std::int32_t block, std::int32_t begin, std::int32_t end) {
                   for (std::int32_t i = begin; i < end; ++i) {
                     job.poll();
                     const std::int32_t l = moved[i];
                     const auto look = [&](std::int32_t y) {
                       const bool seen_from_there = changed[y] && y < l, is_known = known[l] && known[y];
                       // Two facets of one polygon are never tested, so a chart of one polygon has no pair.
                       const bool is_alone = y == l && charts[l]->facets.back().part == 0;
                       if (seen_from_there || is_known || is_alone) return;
                       const std::int32_t first = std::min(l, y), second = std::max(l, y);
                       any_meeting(*charts[first], *charts[second], [&](std::int32_t f, std::int32_t g) {
                         met[block].push_back({first, f, second, g});
                         return false;
                       });
                     };
                     arounds.free.for_each_near(charts[l]->around, look);
                     if (!charts[l]->given) arounds.given.for_each_near(charts[l]->around, look);
                   }
                 });
  std::vector<Meeting> all;
  for (const std::vector<Meeting>& some : met) all.insert(all.end(), some.begin(), some.end());
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

void FacetSet::locate(std::span<const Vec3> position) {
  solids.clear();
  facings.clear();
  boxes.clear();
  solid.clear();
  around = Box::nowhere();
  for (const auto& [corner, chart, part] : facets) {
    solids.push_back({rounded_to_float(position[corner[0]]), rounded_to_float(position[corner[1]]),
                      rounded_to_float(position[corner[2]])});
    facings.push_back(facing_of(solids.back()));
    boxes.push_back(box_of(solids.back()));
    if (!has_area(solids.back())) continue;
    around.include(boxes.back());
    solid.push_back(static_cast<std::int32_t>(solids.size()) - 1);
  }
}

void Arounds::set(std::int32_t chart, const FacetSet& facets) {
  free.set(chart, facets.given ? Box::nowhere() : facets.around);
  given.set(chart, facets.given ? facets.around : Box::nowhere());
}

void Arounds::settle() {
  free.settle();
  given.settle();
}

std::vector<Hit> find_hits(std::span<const FacetSet* const> charts, const Arounds& arounds,
                           const std::vector<bool>& changed, const std::vector<bool>& known, const Threads& threads,
                           const Job& job) {
  std::vector<Hit> hits;
  // Facets are in the order of parts, so the lower one is of the lower polygon.
  for (const Meeting& m : find_meetings(charts, arounds, changed, known, threads, job)) {
    const Facet &f = charts[m.chart]->facets[m.index], &g = charts[m.other_chart]->facets[m.other_index];
    hits.push_back({f.chart,
                    f.part,
                    g.chart,
                    g.part,
                    {f.corner[0], f.corner[1], f.corner[2], g.corner[0], g.corner[1], g.corner[2]}});
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() < y.key(); });
  hits.erase(std::unique(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() == y.key(); }),
             hits.end());
  return hits;
}

bool facets_meet(const FacetSet& a, const FacetSet& b) {
  return any_meeting(a, b, [](std::int32_t, std::int32_t) { return true; });
}

GivenHits find_given_hits(std::span<const FacetSet* const> charts, const Arounds& arounds, std::size_t most,
                          std::int64_t most_counted, const Job& job) {
  GivenHits result;
  std::vector<std::int32_t> met;
  for (std::int32_t l = 0; l < static_cast<std::int32_t>(charts.size()) && result.is_all; ++l) {
    if (!charts[l]->given || charts[l]->solid.empty()) continue;
    job.poll();
    met.clear();
    arounds.given.for_each_near(charts[l]->around, [&](std::int32_t y) {
      if (y > l && meet(placed(*charts[l], 0), placed(*charts[y], 0))) met.push_back(y);
    });
    std::sort(met.begin(), met.end());
    result.count += static_cast<std::int64_t>(met.size());
    result.is_all = result.count < most_counted;
    for (const std::int32_t y : met) {
      if (result.first.size() == most) break;
      result.first.push_back({l, 0, y, 0, {}, true});
    }
  }
  return result;
}

ScanPart::ScanPart(const Mesh& mesh, std::span<const std::int32_t> faces) {
  std::vector<NumberedBox> boxes;
  boxes.reserve(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + kAhead < faces.size())
      for (const std::int32_t v : mesh.triangles()[faces[i + kAhead]]) prefetch(&mesh.vertices()[v]);
    const isimp::Corners at = corners_of(mesh, faces[i]);
    if (has_area(at)) boxes.push_back({box_of(at), faces[i]});
  }
  tree = BoxTree(std::move(boxes));
}

bool scan_intersects(const Mesh& mesh, const ScanPart& some, const ScanPart& others) {
  std::int32_t last = kNone;  // many pairs in a row have the same first face
  isimp::Corners a;
  Facing facing;
  return some.tree.any_pair(others.tree, [&](const NumberedBox& x, const NumberedBox& y) {
    if (x.index == y.index) return false;
    if (x.index != last) {
      last = x.index;
      a = corners_of(mesh, last);
      facing = facing_of(a);
    }
    const isimp::Corners b = corners_of(mesh, y.index);
    const Triangle &s = mesh.triangles()[x.index], &t = mesh.triangles()[y.index];
    if (beside({s, a, facing}, {t, b, facing})) return false;  // needs the plane of one triangle only
    return meet({s, a, facing}, {t, b, facing_of(b)});
  });
}

}  // namespace isimp::meshing
