// The cells into which the polygons of a solid cut space.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "isimp/core/errors.h"
#include "isimp/core/threads.h"
#include "solid.h"

namespace isimp::convex {
namespace {

// tuned colliders
constexpr double kDoubtful = 0.25;     // turns off a whole number
constexpr double kMostDoubtful = 0.1;  // share of the volume

struct Fragment {
  std::int32_t facet = 0;
  Loop loop;
};

struct Node {
  Cell cell;
  std::vector<Fragment> fragments;
};

/// Whether a fragment only grazes its cell: it is as near to a face as noise, and not the other side of a plate there.
bool grazes(const Fragment& fragment, const Cell& cell, const Solid& solid) {
  const Facet& facet = solid.facets[fragment.facet];
  return std::ranges::any_of(cell.faces, [&](const CellFace& face) {
    if (face.plane == facet.plane) return true;
    const Plane& plane = solid.planes[face.plane];
    const bool known = face.plane < std::ssize(solid.both_ways);
    if (known && solid.both_ways[face.plane] == 0 && plane.normal.dot(facet.normal) < -kLikeNormal) return false;
    return std::ranges::all_of(fragment.loop,
                               [&](const Vec3& p) { return std::abs(plane.height(p)) <= solid.lengths.same; });
  });
}

/// The plane with the largest area of fragments in a cell; -1 if there are none.
std::int32_t largest_plane(const Node& node, const Solid& solid) {
  std::vector<std::pair<std::int32_t, double>> areas;
  for (const Fragment& fragment : node.fragments)
    areas.emplace_back(solid.facets[fragment.facet].plane, area_vector(fragment.loop).norm());
  std::ranges::stable_sort(areas, {}, &std::pair<std::int32_t, double>::first);
  std::int32_t best = kNone;
  double most = -1;
  for (std::size_t i = 0; i < areas.size();) {
    const std::int32_t plane = areas[i].first;
    double sum = 0;
    for (; i < areas.size() && areas[i].first == plane; ++i) sum += areas[i].second;
    if (!(sum > most)) continue;
    most = sum;
    best = plane;
  }
  return best;
}

std::string place(const Vec3& p) {
  std::string text;
  for (int k = 0; k < 3; ++k) text += (k > 0 ? ", " : "(") + std::to_string(p[k]);
  return text + ")";
}

/// Parts cells by how often the surface winds around them, and refuses a surface that leaves this open.
Cells sorted_out(std::vector<Cell>&& cells, const Solid& solid, const Vec3& origin, Job& job) {
  std::vector<double> winding(cells.size());
  const Threads threads(0);
  threads.blocks(static_cast<std::int32_t>(cells.size()), 64, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t c = begin; c < end; ++c) winding[c] = job.cancelled() ? 0 : solid.winding(cells[c].center);
  });
  job.poll();
  Cells made;
  double inside = 0, doubtful = 0;
  const Cell *worst = nullptr, *reversed = nullptr;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const double volume = cells[c].volume;
    if (winding[c] >= 0.5) inside += volume;
    if (winding[c] <= -0.5 && (reversed == nullptr || volume > reversed->volume)) reversed = &cells[c];
    if (winding[c] < kDoubtful || std::abs(winding[c] - std::round(winding[c])) < kDoubtful) continue;
    doubtful += volume;
    if (worst == nullptr || volume > worst->volume) worst = &cells[c];
  }
  if (inside == 0 && reversed != nullptr)
    throw InvalidInput("the surface faces inwards around " + place(reversed->center + origin) +
                       ": it bounds free space, not a solid. Flip its faces, or set a thickness for the walls of a "
                       "scanned room");
  if (worst != nullptr && doubtful > kMostDoubtful * inside)
    throw InvalidInput("the surface is open: it does not say whether " + place(worst->center + origin) +
                       " is inside. Close its holes first, or set a thickness");
  if (inside == 0)
    throw InvalidInput("the surface encloses no volume around " + place(solid.box.center() + origin) +
                       ". Set a thickness");
  for (std::size_t c = 0; c < cells.size(); ++c)
    (winding[c] >= 0.5 ? made.inside : made.outside).push_back(std::move(cells[c]));
  return made;
}

}  // namespace

Cells cells_of(Solid& solid, const Vec3& origin, Job& job) {
  const Vec3 pad = Vec3::Constant(2 * kTolerance * solid.box.diagonal().norm());
  std::vector<Node> open(1);
  open[0].cell = box_cell(solid.box.min() - pad, solid.box.max() + pad, solid.planes);
  const double whole = open[0].cell.volume;
  double done = 0;
  for (std::size_t f = 0; f < solid.facets.size(); ++f)
    open[0].fragments.push_back(
        {static_cast<std::int32_t>(f), Loop(solid.facets[f].corners.begin(), solid.facets[f].corners.end())});
  std::vector<Cell> cells;
  while (!open.empty()) {
    Node node = std::move(open.back());
    open.pop_back();
    std::erase_if(node.fragments, [&](const Fragment& fragment) { return grazes(fragment, node.cell, solid); });
    const std::int32_t plane = largest_plane(node, solid);
    if (plane == kNone) {
      done += node.cell.volume;
      job.report(std::min(done / whole, 1.0));
      cells.push_back(std::move(node.cell));
      continue;
    }
    std::erase_if(node.fragments, [&](const Fragment& f) { return solid.facets[f.facet].plane == plane; });
    const auto [low, high] = node.cell.heights(solid.planes[plane]);
    if (low >= -solid.lengths.snap || high <= solid.lengths.snap) {
      open.push_back(std::move(node));
      continue;
    }
    DividedCell divided = divide(node.cell, solid.planes, plane, solid.lengths.snap);
    std::array<Node, 2> child;
    for (const Fragment& fragment : node.fragments) {
      auto loops = divide(fragment.loop, solid.planes[plane], solid.lengths.snap);
      for (int k = 0; k < 2; ++k)
        if (!loops[k].empty()) child[k].fragments.push_back({fragment.facet, std::move(loops[k])});
    }
    for (int k = 0; k < 2; ++k) {
      child[k].cell = std::move(divided.side[k]);
      if (child[k].cell.volume > 0) open.push_back(std::move(child[k]));
    }
  }
  return sorted_out(std::move(cells), solid, origin, job);
}

}  // namespace isimp::convex
