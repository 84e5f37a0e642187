#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "cells/cells.h"
#include "cells/patches.h"
#include "fit/numbers.h"
#include "isimp/core/forest.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr int kTries = 3;  ///< tries to find cells whose number is not larger than before

/// Patches that have the same axis and touch each other.
bool is_coaxial(const CurvedProxy& a, const CurvedProxy& b, double distance) {
  if (!a.full || !b.full || a.kind == CurvedKind::extrusion || b.kind == CurvedKind::extrusion) return false;
  // A sphere has any axis through its centre, so it takes that of the other.
  const bool is_free = a.kind == CurvedKind::sphere || b.kind == CurvedKind::sphere;
  if (!is_free && a.axis.cross(b.axis).norm() > kSquare) return false;
  const CurvedProxy &line = a.kind == CurvedKind::sphere ? b : a, &point = a.kind == CurvedKind::sphere ? a : b;
  return polar(line, point.point).rho < kAlike * distance;
}

class Chooser {
 public:
  Chooser(const Faces& faces, Scene& scene, double distance)
      : f_(faces), s_(scene), distance_(distance), cell_(static_cast<std::size_t>(faces.size()), kNone) {}

  void run(Job& job) {
    const std::vector<bool> done = choose_pipes(f_, s_, distance_);
    for (const std::vector<std::size_t>& some : classes()) {
      job.poll();
      if (std::any_of(some.begin(), some.end(), [&](std::size_t k) { return done[k]; })) continue;
      for (const std::size_t k : some) s_.patches[k].together = static_cast<std::int32_t>(some[0]);
      for (const std::size_t k : some) limit_to_tangents(s_.patches[k]);
      if (some.size() > 1) share_axis(some);
      for (const std::size_t k : some) cuts_.try_emplace(k, s_.patches[k].proxy, s_.patches[k].faces);
      if (some.size() == 1) {
        choose_within(some);
        continue;
      }
      double before = 0;
      for (const std::size_t k : some) before += s_.patches[k].before;
      if (choose_within(some) <= kNearlyAsWell * kNearlyAsWell * before) continue;
      for (const std::size_t k : some) {
        choose_within({k});
        s_.patches[k].together = static_cast<std::int32_t>(k);
      }
    }
  }

 private:
  /// Chooses for some patches together.
  /// \return the sum of area times squared distance
  double choose_within(const std::vector<std::size_t>& some) {
    double cells = 0, share = 1, cost = 0;
    for (const std::size_t k : some) cells += s_.patches[k].cells;
    // Another body may cut cells in two: fewer are taken then.
    for (int k = 0; k < kTries; ++k) {
      cost = choose(some, share);
      double pieces = 0;
      for (const std::size_t i : some) pieces += pieces_of(s_.patches[i]);
      if (pieces <= kMoreCells * cells + kHalfCell) break;
      share *= cells / pieces;
    }
    for (const std::size_t k : some) {
      const RoundPatch& p = s_.patches[k];
      for (const double a : p.faces.area) cost += a * p.faces.rough * p.faces.rough;
    }
    return cost;
  }

  [[nodiscard]] std::vector<std::vector<std::size_t>> classes() const {
    std::vector<std::int32_t> patch(s_.found.size(), kNone);
    for (std::size_t k = 0; k < s_.patches.size(); ++k) patch[s_.patches[k].found] = static_cast<std::int32_t>(k);
    std::set<std::pair<std::int32_t, std::int32_t>> beside;
    for (const RoundPatch& p : s_.patches)
      for (const std::int32_t i : p.faces.face)
        for (const std::int32_t j : f_.graph().neighbours[i]) {
          const std::int32_t other = j == f_.size() || s_.label[j] == kNone ? kNone : patch[s_.label[j]];
          if (other != kNone && patch[p.found] < other) beside.emplace(patch[p.found], other);
        }
    const auto have_one_axis = [&](std::int32_t i, std::int32_t j) {
      return is_coaxial(s_.patches[i].proxy, s_.patches[j].proxy, distance_);
    };
    detail::Forest forest(s_.patches.size());
    Some axis(s_.patches.size());  // by root: the patch whose axis all have; a sphere where there is no other
    std::iota(axis.begin(), axis.end(), 0);
    for (const auto& [a, b] : beside) {
      const std::int32_t one = axis[forest.root(a)], other = axis[forest.root(b)];
      // Pipes that meet a sphere need not have one axis.
      if (!have_one_axis(a, b) || !have_one_axis(one, other)) continue;
      forest.join(a, b);
      axis[forest.root(a)] = s_.patches[one].proxy.kind == CurvedKind::sphere ? other : one;
    }
    std::map<std::int32_t, std::vector<std::size_t>> sets;
    for (std::size_t k = 0; k < s_.patches.size(); ++k) sets[forest.root(static_cast<std::int32_t>(k))].push_back(k);
    std::vector<std::vector<std::size_t>> all;
    all.reserve(sets.size());
    for (auto& [root, some] : sets) all.push_back(std::move(some));
    return all;
  }

  /// Copies the axis of the largest patch that is no sphere, and the direction where its angles begin, to the others.
  void share_axis(const std::vector<std::size_t>& some) {
    const std::size_t first = *std::max_element(some.begin(), some.end(), [&](std::size_t a, std::size_t b) {
      const RoundPatch &p = s_.patches[a], &q = s_.patches[b];
      const bool p_sphere = p.proxy.kind == CurvedKind::sphere, q_sphere = q.proxy.kind == CurvedKind::sphere;
      if (p_sphere != q_sphere) return p_sphere;
      return s_.found[p.found].area < s_.found[q.found].area;
    });
    const CurvedProxy& of = s_.patches[first].proxy;
    for (const std::size_t k : some) {
      CurvedProxy& p = s_.patches[k].proxy;
      if (k == first) continue;
      const bool is_turned = p.kind != CurvedKind::sphere && p.axis.dot(of.axis) < 0;
      if (is_turned) p.slope = -p.slope;
      // The planes of the cells of two patches meet exactly only about one axis. A profile keeps its direction.
      p.axis = is_turned && !is_straight(p) ? Vec3(-of.axis) : of.axis;
      p.point = of.point + (p.point - of.point).dot(of.axis) * of.axis;
      p.across = (of.across - of.across.dot(p.axis) * p.axis).normalized();
      s_.patches[k].faces = PatchFaces(f_, p, std::move(s_.patches[k].faces.face));
    }
  }
  /// Whether a profile is no line, so that one ring does not show it.
  static bool is_bent(const CurvedProxy& p) {
    return p.full && (p.kind == CurvedKind::revolution || p.kind == CurvedKind::sphere);
  }

  /// The parts of the cells of a patch that are no specks.
  double pieces_of(const RoundPatch& p) {
    if (p.proxy.segments == 0) return 0;
    const Some cell = cells_of_faces(f_, p.proxy, p.faces);
    for (std::size_t k = 0; k < cell.size(); ++k) cell_[p.faces.face[k]] = cell[k];
    double count = 0;
    const double speck = kQuarter * p.faces.whole / (p.proxy.segments * p.proxy.rings);
    Some stack;
    for (const std::int32_t first : p.faces.face) {
      const std::int32_t mine = cell_[first];
      if (mine == kNone) continue;
      cell_[first] = kNone;
      stack.push_back(first);
      double area = 0;
      while (!stack.empty()) {
        const std::int32_t i = stack.back();
        stack.pop_back();
        area += f_.area(i);
        for (const std::int32_t j : f_.graph().neighbours[i]) {
          if (j == f_.size() || cell_[j] != mine) continue;
          cell_[j] = kNone;
          stack.push_back(j);
        }
      }
      count += area > speck;
    }
    return count;
  }

  /// \param share  of the number of cells that the partition has there
  /// \return the cost of the grids; infinite if there are none
  double choose(const std::vector<std::size_t>& some, double share) {
    std::map<std::int32_t, std::vector<Grid>> by_segments;
    double cells = 0, before = 0;
    bool are_walls = true;
    for (const std::size_t k : some) {
      const RoundPatch& p = s_.patches[k];
      cells += share * p.cells;
      before += p.before;
      are_walls = are_walls && p.proxy.full && !is_bent(p.proxy);
    }
    // The squared distance of a wall's strips from its surface falls with the fourth power of their number: on a rough
    // wall the last ones would bring less than a region had.
    const double price = are_walls ? before * share / cells : 0;
    for (const std::size_t k : some) {
      const RoundPatch& p = s_.patches[k];
      // Alone a patch keeps to its own number of cells; together they keep to the sum.
      const double mine = some.size() > 1 ? std::max(share * p.cells, cells / 2) : cells;
      for (Grid& grid : cuts_.at(k).within(mine, p.faces.rough))
        if (some.size() > 1 || grid.rings > 1 || !is_bent(p.proxy))
          by_segments[grid.segments].push_back(std::move(grid));
    }
    const std::vector<Grid>* best = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (auto& [n, all] : by_segments) {
      if (all.size() != some.size()) continue;
      if (some.size() > 1) all = within(n, some, cells);
      double cost = 0, count = 0;
      for (const Grid& g : all) {
        cost += g.cost + price * g.cells;
        count += g.cells;
      }
      if (best != nullptr && (cost >= least || count > kMoreCells * cells + kHalfCell)) continue;
      least = count > kMoreCells * cells + kHalfCell ? std::numeric_limits<double>::max() : cost;
      best = &all;
    }
    if (best == nullptr) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (std::size_t k = 0; k < some.size(); ++k) {
      RoundPatch& p = s_.patches[some[k]];
      sum += (*best)[k].cost;
      apply(p.proxy, (*best)[k]);
    }
    return sum;
  }

  /// Grids of patches with the same segments that together keep to a number of cells: rings are added one by one where
  /// they gain most for a cell.
  [[nodiscard]] std::vector<Grid> within(std::int32_t n, const std::vector<std::size_t>& some, double cells) {
    std::vector<Grid> all, next;
    double count = 0;
    const auto grid = [&](std::size_t k, std::int32_t rings) {
      return cuts_.at(some[k]).of(n, rings, s_.patches[some[k]].cells);
    };
    for (std::size_t k = 0; k < some.size(); ++k) {
      all.push_back(grid(k, 1));
      next.push_back(grid(k, 2));
      count += all.back().cells;
    }
    for (;;) {
      std::size_t best = some.size();
      double most = 0;
      for (std::size_t k = 0; k < some.size(); ++k) {
        if (next[k].rings == all[k].rings || count + next[k].cells - all[k].cells > kMoreCells * cells + kHalfCell)
          continue;
        const double gain = (all[k].cost - next[k].cost) / std::max(1, next[k].cells - all[k].cells);
        if (gain <= most) continue;
        most = gain;
        best = k;
      }
      if (best == some.size()) return all;
      count += next[best].cells - all[best].cells;
      all[best] = next[best];
      next[best] = grid(best, all[best].rings + 1);
    }
  }

  /// Where planes touch a patch at its ends, they have the first and the last half segment.
  static void limit_to_tangents(RoundPatch& p) {
    if (p.tangent[0] == kNone && p.tangent[1] == kNone) return;
    if (p.tangent[0] != kNone) {
      p.proxy.span -= p.first_angle - p.proxy.phase;
      p.proxy.phase = p.first_angle;
    }
    if (p.tangent[1] != kNone) p.proxy.span = p.last_angle - p.proxy.phase;
  }

  const Faces& f_;
  Scene& s_;
  double distance_;
  std::map<std::size_t, Cuts> cuts_;  // by patch
  Some cell_;                         // (n) by graph index: kNone but within pieces_of
};

}  // namespace

void choose_grids(const Faces& faces, Scene& scene, Job& job) { Chooser(faces, scene, scene.near.distance).run(job); }

}  // namespace isimp::curved
