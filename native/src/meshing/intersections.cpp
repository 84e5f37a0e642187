#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "isimp/mesh/meet.h"
#include "judge.h"

namespace isimp::meshing {
namespace {

Vec3 stored(const Vec3& p) { return p.cast<float>().cast<double>(); }

Corners corners_of(const Mesh& mesh, std::int32_t face) {
  const Triangle& t = mesh.triangles()[face];
  return {stored(mesh.vertices()[t[0]]), stored(mesh.vertices()[t[1]]), stored(mesh.vertices()[t[2]])};
}

/// The box of a triangle whose coordinates are float32.
Box box_of(const Corners& t) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = static_cast<float>(std::min({t[0][k], t[1][k], t[2][k]}));
    box.high[k] = static_cast<float>(std::max({t[0][k], t[1][k], t[2][k]}));
  }
  return box;
}

/// A box and what is in it, a piece or a face of the scan.
struct Entry {
  Box box;
  std::int32_t index;
};

/// The middle of where the edges of two triangles pass through the other one; of the smaller's if none does.
Vec3 meeting_place(const Corners& f, const Corners& g) {
  Vec3 sum = Vec3::Zero();
  int found = 0;
  for (const auto* t : {&f, &g}) {
    const Corners& other = t == &f ? g : f;
    const Vec3 u = other[1] - other[0], v = other[2] - other[0], n = u.cross(v);
    for (int k = 0; k < 3; ++k) {
      const Vec3 &p = (*t)[k], &q = (*t)[(k + 1) % 3];
      const double from = (p - other[0]).dot(n), to = (q - other[0]).dot(n);
      if (from * to >= 0) continue;
      const Vec3 x = p + (q - p) * (from / (from - to)), d = x - other[0];
      const double s = d.cross(v).dot(n), t2 = u.cross(d).dot(n);
      if (s < 0 || t2 < 0 || s + t2 > n.squaredNorm()) continue;
      sum += x;
      ++found;
    }
  }
  if (found > 0) return sum / found;
  const auto area = [](const Corners& t) { return (t[1] - t[0]).cross(t[2] - t[0]).squaredNorm(); };
  const Corners& small = area(f) < area(g) ? f : g;
  return (small[0] + small[1] + small[2]) / 3;
}

/// A tree of boxes, to look for those that meet a given one: halved at the median of their middles, along the axis on
/// which these spread most, down to a few. Cost: O(n log n) to make; a search, about O(log n + boxes that it meets).
class BoxTree {
 public:
  explicit BoxTree(std::vector<Entry> all) : all_(std::move(all)) {
    if (!all_.empty()) make(0, static_cast<std::int32_t>(all_.size()));
  }

  /// Whether some box has a place in common with `a` and passes the test; stops at the first.
  template <class Test>
  [[nodiscard]] bool any(const Box& a, Test test) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      if (node.around.apart(a)) {
        n = static_cast<std::size_t>(node.after);
        continue;
      }
      for (std::int32_t i = node.begin; i < node.end; ++i)
        if (!all_[i].box.apart(a) && test(all_[i])) return true;
      ++n;
    }
    return false;
  }

 private:
  struct Node {
    Box around;
    std::int32_t begin, end;  ///< of what lies in a leaf; the same in others
    std::int32_t after;       ///< the node that follows where nothing below this one is asked for
  };
  static constexpr std::int32_t kLeaf = 8;

  /// Nodes stand before those below them.
  void make(std::int32_t begin, std::int32_t end) {
    Box around = all_[begin].box;
    std::array<float, 3> low{}, high{};  // of twice the middles
    for (int k = 0; k < 3; ++k) low[k] = high[k] = around.low[k] + around.high[k];
    for (std::int32_t i = begin + 1; i < end; ++i) {
      const Box& box = all_[i].box;
      around.include(box);
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], box.low[k] + box.high[k]);
        high[k] = std::max(high[k], box.low[k] + box.high[k]);
      }
    }
    const std::size_t node = nodes_.size();
    const bool is_leaf = end - begin <= kLeaf;
    nodes_.push_back({around, begin, is_leaf ? end : begin, 0});
    if (!is_leaf) {
      int axis = 0;
      for (int k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
      const std::int32_t half = begin + (end - begin) / 2;
      std::nth_element(all_.begin() + begin, all_.begin() + half, all_.begin() + end,
                       [&](const Entry& x, const Entry& y) {
                         return x.box.low[axis] + x.box.high[axis] < y.box.low[axis] + y.box.high[axis];
                       });
      make(begin, half);
      make(half, end);
    }
    nodes_[node].after = static_cast<std::int32_t>(nodes_.size());
  }

  std::vector<Entry> all_;
  std::vector<Node> nodes_;
};

/// Two facets that meet, by piece and index, the lower one first.
struct Meeting {
  std::int32_t piece, index, other_piece, other_index;
  auto operator<=>(const Meeting&) const = default;
};

Facing facing_of(const Corners& t) {
  // A side is a sum of six products of three differences each, rounded by less than this in all.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  const Vec3 u = t[1] - t[0], v = t[2] - t[0];
  return {u.cross(v), kRounding * u.cwiseAbs().maxCoeff() * v.cwiseAbs().maxCoeff()};
}

/// A triangle with what it takes to tell quickly that another lies to one side of it.
struct Placed {
  const std::array<std::int32_t, 3>& corner;
  const Corners& at;
  const Facing& facing;
};

/// Whether all corners of g that f does not share surely lie to the same side of f's plane, so that the two meet in no
/// more than they share. Most triangles that are near each other are told apart by this.
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

/// Whether two triangles that have area meet elsewhere than in what they share.
bool meet(const Placed& f, const Placed& g) {
  return !beside(f, g) && !beside(g, f) && meet_elsewhere(f.corner, f.at, g.corner, g.at);
}

Placed placed(const FacetSet& set, std::int32_t i) { return {set.facets[i].corner, set.solids[i], set.facings[i]}; }

/// Notes which facets of two pieces meet, or of one, each pair once. \param near  to be used
void find_meetings(const FacetSet& a, const FacetSet& b, std::vector<std::int32_t>& near, std::vector<Meeting>& met) {
  near.clear();
  for (const std::int32_t j : b.solid)
    if (!b.boxes[j].apart(a.around)) near.push_back(j);
  if (near.empty()) return;
  for (const std::int32_t i : a.solid) {
    const Box& box = a.boxes[i];
    if (box.apart(b.around)) continue;
    const Facet& f = a.facets[i];
    for (const std::int32_t j : near) {
      const Facet& g = b.facets[j];
      if (box.apart(b.boxes[j]) || (&a == &b && (j <= i || f.part == g.part))) continue;
      if (meet(placed(a, i), placed(b, j))) met.push_back({f.piece, i, g.piece, j});
    }
  }
}

constexpr std::int32_t kTogether = 64;  ///< pieces that are looked at on one thread ...
constexpr std::size_t kFewMoved = 8;    ///< ... and all are where no more have moved than this

/// First by pieces whose boxes meet, as these are few.
std::vector<Meeting> find_meetings(std::span<const FacetSet* const> pieces, std::span<const Box> arounds,
                                   const std::vector<bool>& changed, const std::vector<bool>& known,
                                   const Threads& threads, const Job& job) {
  const auto count = static_cast<std::int32_t>(pieces.size());
  std::vector<Entry> moved;
  for (std::int32_t l = 0; l < count; ++l)
    if (changed[l] && !pieces[l]->solid.empty()) moved.push_back({arounds[l], l});
  const std::int32_t together = moved.size() < kFewMoved ? std::max(count, 1) : kTogether;
  std::vector<std::vector<Meeting>> met(count / together + 1);  // by block
  const BoxTree search(std::move(moved));
  threads.blocks(count, together, [&](std::int32_t block, std::int32_t begin, std::int32_t end) {
    job.poll();
    std::vector<std::int32_t> near;
    for (std::int32_t l = begin; l < end; ++l)
      (void)search.any(arounds[l], [&](const Entry& y) {
        const bool seen_from_there = changed[l] && y.index < l, is_known = known[l] && known[y.index];
        // Of a piece of one polygon, no two facets can.
        const bool is_alone = y.index == l && pieces[l]->facets.back().part == 0;
        if (!seen_from_there && !is_known && !is_alone)
          find_meetings(*pieces[std::min(l, y.index)], *pieces[std::max(l, y.index)], near, met[block]);
        return false;
      });
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
  for (const auto& [corner, piece, part] : facets) {
    solids.push_back({stored(position[corner[0]]), stored(position[corner[1]]), stored(position[corner[2]])});
    facings.push_back(facing_of(solids.back()));
    boxes.push_back(box_of(solids.back()));
    if (!has_area(solids.back())) continue;
    around.include(boxes.back());
    solid.push_back(static_cast<std::int32_t>(solids.size()) - 1);
  }
}

std::vector<Hit> find_hits(std::span<const FacetSet* const> pieces, std::span<const Box> arounds,
                           std::span<const Vec3> position, const std::vector<bool>& changed,
                           const std::vector<bool>& known, const Threads& threads, const Job& job) {
  std::vector<Hit> hits;
  const auto corners = [&](const Facet& f) {
    return Corners{position[f.corner[0]], position[f.corner[1]], position[f.corner[2]]};
  };
  // Facets come by part, so the lower one is of the lower polygon.
  for (const Meeting& m : find_meetings(pieces, arounds, changed, known, threads, job)) {
    const Facet &f = pieces[m.piece]->facets[m.index], &g = pieces[m.other_piece]->facets[m.other_index];
    hits.push_back({f.piece,
                    f.part,
                    g.piece,
                    g.part,
                    meeting_place(corners(f), corners(g)),
                    {f.corner[0], f.corner[1], f.corner[2], g.corner[0], g.corner[1], g.corner[2]}});
  }
  std::stable_sort(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() < y.key(); });
  hits.erase(std::unique(hits.begin(), hits.end(), [](const Hit& x, const Hit& y) { return x.key() == y.key(); }),
             hits.end());
  return hits;
}

Box box_around(const Mesh& mesh, std::span<const std::int32_t> faces) {
  constexpr std::size_t kAhead = 12;  // fetched before they are looked at
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + kAhead < faces.size())
      for (const std::int32_t v : mesh.triangles()[faces[i + kAhead]]) __builtin_prefetch(&mesh.vertices()[v]);
    for (const std::int32_t v : mesh.triangles()[faces[i]]) {
      low = low.cwiseMin(mesh.vertices()[v]);
      high = high.cwiseMax(mesh.vertices()[v]);
    }
  }
  if (faces.empty()) return Box::nowhere();
  Box box;
  box.low.head<3>() = low.cast<float>().array();  // rounding leaves the order as it is
  box.high.head<3>() = high.cast<float>().array();
  return box;
}

bool scan_intersects(const Mesh& mesh, const ScanPart& some, const ScanPart& others) {
  // What lies outside the other's box is of no interest.
  struct Face {
    std::int32_t face;
    Corners at;
  };
  std::vector<Face> faces;
  const auto boxes = [&](const ScanPart& from, const Box& near) {
    std::vector<Entry> result;
    for (const std::int32_t f : from.faces) {
      const Corners s = corners_of(mesh, f);
      const Box box = box_of(s);
      if (near.apart(box) || !has_area(s)) continue;
      result.push_back({box, static_cast<std::int32_t>(faces.size())});
      faces.push_back({f, s});
    }
    return result;
  };
  const std::vector<Entry> looking = boxes(some, others.around);
  const BoxTree search(boxes(others, some.around));
  return std::any_of(looking.begin(), looking.end(), [&](const Entry& x) {
    const Face& a = faces[x.index];
    const Facing facing = facing_of(a.at);
    const Placed here{mesh.triangles()[a.face], a.at, facing};
    return search.any(x.box, [&](const Entry& y) {
      const Face& b = faces[y.index];
      const Triangle& t = mesh.triangles()[b.face];
      if (a.face == b.face || beside(here, {t, b.at, facing})) return false;  // which asks for one side only
      return meet(here, {t, b.at, facing_of(b.at)});
    });
  });
}

}  // namespace isimp::meshing
