// Cuts a flat wall along its two directions.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "discs/wall_links.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kOrderedHoles =
    8;  ///< limit: holes up to which all orders are tried; with more, a chain follows a row
constexpr std::size_t kMostLoops = 64;  ///< limit: with more, the choice of cuts takes too long
// tuned walls
constexpr double kThrough = 0.1;      ///< cost of the way across a hole, relative to a cut of that length
constexpr double kCostLeftOut = 0.3;  ///< cost of a hole that the chain leaves out, in sqrt(area)
constexpr double kApart =
    0.5;  ///< least distance of two cuts of one hole to the outline, as a share of its smaller side
constexpr double kOverlap = 0.5;  ///< least overlap of two holes of a row, as a share of the smaller one
constexpr double kOffCut = 3;     ///< extra cost of each step of a path, times its distance from the straight cut
constexpr int kChainTries = 4;    ///< limit: chains that are tried, each without the cuts that the mesh has no path for

/// A chain of cuts from the outline over holes back to it, as the two ends of each.
using Chain = std::vector<std::array<LoopPlace, 2>>;

/// The cheapest chain over some holes; holes that cost more than kCostLeftOut are left out.
class Chains {
 public:
  explicit Chains(const Wall& wall) : wall_(wall) {
    for (std::int32_t i = 0; i < wall.holes(); ++i) {
      auto& out = out_.emplace_back();
      for (const LoopPlace& p : wall.corners(i)) out.push_back(wall.way_out(p));
    }
  }

  /// Excludes a cut that can't be made.
  void forbid(const std::array<LoopPlace, 2>& cut) {
    forbidden_.insert({cut[0].vertex, cut[1].vertex});
    forbidden_.insert({cut[1].vertex, cut[0].vertex});
  }

  /// The chain in the cheapest order of all orders of subsets.
  [[nodiscard]] Chain over_all(std::span<const std::int32_t> holes) { return search(holes, false); }
  /// The chain in the given order.
  [[nodiscard]] Chain in_order(std::span<const std::int32_t> holes) { return search(holes, true); }

 private:
  struct WayThrough {
    double price = std::numeric_limits<double>::infinity();
    std::int32_t before = kNone;  ///< the state before, and the corner at which that hole is left
    std::int32_t left_at = kNone;
  };

  static constexpr std::size_t kCornersAHole = Wall::kMostCorners;  // unit

  /// A cut between two corners of holes.
  struct Link {
    double price = std::numeric_limits<double>::infinity();  ///< as long as it meets no boundary
    bool is_checked = true;                                  ///< whether it is known that it meets none
  };

  [[nodiscard]] bool is_forbidden(const LoopPlace& a, const LoopPlace& b) const {
    return forbidden_.contains({a.vertex, b.vertex});
  }

  /// Lists the corners of some holes, their ways out, and the cuts between them: in a chain in the given order only
  /// those between a hole and the next one.
  void list_links(std::span<const std::int32_t> holes, bool in_order) {
    const std::size_t places = holes.size() * kCornersAHole;
    places_.assign(places, nullptr);
    outs_.assign(places, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < holes.size(); ++i)
      for (std::size_t c = 0; c < wall_.corners(holes[i]).size(); ++c) {
        places_[i * kCornersAHole + c] = &wall_.corners(holes[i])[c];
        const Wall::Way& way = out_[holes[i]][c];
        if (!is_forbidden(*places_[i * kCornersAHole + c], way.end)) outs_[i * kCornersAHole + c] = way.price;
      }
    links_.assign(places * places, {});
    for (std::size_t a = 0; a < places; ++a)
      for (std::size_t b = 0; b < places; ++b) {
        const std::size_t i = a / kCornersAHole, j = b / kCornersAHole;
        if (!places_[a] || !places_[b] || i == j || (in_order && j != i + 1)) continue;
        if (!is_forbidden(*places_[a], *places_[b]))
          links_[a * places + b] = {Wall::least_price(*places_[a], *places_[b]), false};
      }
  }

  /// Whether a cut meets no boundary. If it does, its price becomes infinite.
  bool is_free(std::size_t a, std::size_t b) {
    Link& link = links_[a * places_.size() + b];
    if (!std::exchange(link.is_checked, true)) {
      const auto [from, to] = std::minmax(a, b);
      link.price = wall_.price(*places_[from], *places_[to]);
    }
    return std::isfinite(link.price);
  }

  /// Source: Held, Karp 1962, over the corners of the holes.
  [[nodiscard]] Chain search(std::span<const std::int32_t> holes, bool in_order) {
    const std::size_t n = holes.size(), sets = in_order ? n + 1 : std::size_t{1} << n;
    list_links(holes, in_order);
    const auto with = [&](std::size_t set, std::size_t i) { return in_order ? set + 1 : set | std::size_t{1} << i; };
    const auto may_follow = [&](std::size_t set, std::size_t i) { return in_order ? set == i : !(set >> i & 1); };
    std::vector<WayThrough> states(sets * n * kCornersAHole);  // by set, hole and corner
    const double left_out = kCostLeftOut * wall_.size();
    for (std::size_t a = 0; a < n * kCornersAHole; ++a)
      states[with(in_order ? a / kCornersAHole : 0, a / kCornersAHole) * n * kCornersAHole + a].price =
          outs_[a] + left_out * static_cast<double>(n - 1);
    WayThrough last;
    for (std::size_t set = 1; set < sets; ++set)
      for (std::size_t c = 0; c < n * kCornersAHole; ++c) {
        const std::size_t at = set * n * kCornersAHole + c, i = c / kCornersAHole;
        if (!std::isfinite(states[at].price)) continue;
        const auto& [low, high] = wall_.box(holes[i]);
        const double apart = kApart * (high - low).minCoeff();
        for (std::size_t d = i * kCornersAHole; d < (i + 1) * kCornersAHole && places_[d]; ++d) {
          if (d == c) continue;
          const double through = (places_[c]->at - places_[d]->at).norm();
          const double so_far = states[at].price + kThrough * through;
          const auto set_to = [&](WayThrough& to, double price) {
            to = {price, static_cast<std::int32_t>(at), static_cast<std::int32_t>(d % kCornersAHole)};
          };
          const bool is_strip = states[at].before == kNone && through < apart;  // between the two cuts
          if (!is_strip && so_far + outs_[d] < last.price) set_to(last, so_far + outs_[d]);
          for (std::size_t j = 0; j < n; ++j) {
            if (!may_follow(set, j)) continue;
            for (std::size_t e = j * kCornersAHole; e < (j + 1) * kCornersAHole && places_[e]; ++e) {
              WayThrough& next = states[with(set, j) * n * kCornersAHole + e];
              // Boundaries are searched only for cuts that would be cheaper.
              const double price = so_far + links_[d * n * kCornersAHole + e].price - left_out;
              if (price < next.price && is_free(d, e)) set_to(next, price);
            }
          }
        }
      }
    return trace(holes, states, last);
  }

  [[nodiscard]] Chain trace(std::span<const std::int32_t> holes, const std::vector<WayThrough>& states,
                            WayThrough last) const {
    Chain chain;
    if (!std::isfinite(last.price)) return chain;
    LoopPlace to{kNone, Vec2::Zero()};
    while (true) {
      const std::size_t n = holes.size();
      const auto at = static_cast<std::size_t>(last.before);
      const std::int32_t hole = holes[at / kCornersAHole % n];
      const auto corners = wall_.corners(hole);
      const auto left_at = static_cast<std::size_t>(last.left_at);
      if (to.vertex == kNone) to = out_[hole][left_at].end;
      chain.push_back({corners[left_at], to});
      to = corners[at % kCornersAHole];
      last = states[at];
      if (last.before != kNone) continue;
      chain.push_back({out_[hole][at % kCornersAHole].end, to});
      return chain;
    }
  }

  const Wall& wall_;
  std::vector<std::vector<Wall::Way>> out_;                    // by hole and corner
  std::set<std::pair<std::int32_t, std::int32_t>> forbidden_;  // pairs of vertices
  // Of the holes of a search: a place is a corner of a hole, kCornersAHole a hole.
  std::vector<const LoopPlace*> places_;
  std::vector<double> outs_;  // by place: the price of the way out
  std::vector<Link> links_;   // by two places
};

/// The holes of the fullest row, in order: holes that face each other along one of the main directions.
std::vector<std::int32_t> fullest_row(const Wall& wall) {
  std::vector<std::int32_t> best;
  for (const int axis : {0, 1})
    for (std::int32_t i = 0; i < wall.holes(); ++i) {
      std::vector<std::int32_t> row;
      for (std::int32_t j = 0; j < wall.holes(); ++j) {
        const auto &a = wall.box(i), &b = wall.box(j);
        const double both = std::min(a[1][1 - axis], b[1][1 - axis]) - std::max(a[0][1 - axis], b[0][1 - axis]);
        const double smaller = std::min(a[1][1 - axis] - a[0][1 - axis], b[1][1 - axis] - b[0][1 - axis]);
        if (both >= kOverlap * smaller) row.push_back(j);
      }
      std::stable_sort(row.begin(), row.end(),
                       [&](auto a, auto b) { return wall.box(a)[0][axis] < wall.box(b)[0][axis]; });
      if (row.size() > best.size()) best = std::move(row);
    }
  return best;
}

/// Paths of mesh edges for straight cuts, that touch no boundary and no other path.
class Paths {
 public:
  Paths(Cutter& cutter, std::int32_t chart, const Shape& shape)
      : cutter_(cutter), mesh_(cutter.labels.mesh), chart_(chart) {
    cutter_.vertex_marks.clear();
    for (const auto& loop : shape.loops)
      for (const std::int32_t h : loop) cutter_.vertex_marks.add(mesh_.from(h));
  }

  void clear() {
    cutter_.blocked.clear();
    cutter_.halfedge_marks.clear();
  }

  /// Marks the half-edges of a path.
  /// \return whether there is one
  bool add(std::int32_t from, std::int32_t to) {
    if (cutter_.blocked.has(from) || cutter_.blocked.has(to)) return false;
    Search& search = cutter_.vertices;
    const Vec3 &a = mesh_.vertices()[from], d = mesh_.vertices()[to] - a;
    const double length = d.norm();
    const auto off = [&](std::int32_t v) {
      const Vec3 p = mesh_.vertices()[v] - a;
      return (p - std::clamp(p.dot(d) / (length * length), 0.0, 1.0) * d).norm();
    };
    search.start();
    search.reach(from, 0, kNone);
    for (std::int32_t v = search.take(); v != kNone; v = search.take()) {
      if (v == to) break;
      for_each_leaving(mesh_, v, [&](std::int32_t h) {
        const std::int32_t w = mesh_.to(h);
        if (cutter_.labels.label[h / 3] != chart_ || !cutter_.labels.inner(h) || cutter_.blocked.has(w)) return;
        if (w != to && cutter_.vertex_marks.has(w)) return;
        const double edge = (mesh_.vertices()[w] - mesh_.vertices()[v]).norm();
        search.reach(w, search.distance[v] + edge + kOffCut * off(w), h);
      });
    }
    if (!search.reached.has(to)) return false;
    for (std::int32_t v = to;;) {
      cutter_.blocked.add(v);
      const std::int32_t h = search.via[v];
      if (h == kNone) return true;
      cutter_.halfedge_marks.add(h);
      cutter_.halfedge_marks.add(mesh_.opposite(h));
      v = mesh_.from(h);
    }
  }

 private:
  Cutter& cutter_;
  const Mesh& mesh_;
  const std::int32_t chart_;
};

}  // namespace

std::int32_t cut_wall(Cutter& cutter, std::int32_t chart, const Shape& shape, const Job& job) {
  if (cutter.perforated || shape.loops.size() > kMostLoops) return 0;
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(chart);
  const std::optional<Wall> wall = Wall::find(cutter.labels, faces, shape);
  if (!wall) return 0;
  const bool few = wall->holes() <= kOrderedHoles;
  const std::vector<std::int32_t> row = few ? numbers_below(wall->holes()) : fullest_row(*wall);
  if (!few && row.size() < 2) return 0;
  Chains chains(*wall);
  Paths paths(cutter, chart, shape);
  for (int go = 0; go < kChainTries; ++go) {
    job.poll();
    const Chain chain = few ? chains.over_all(row) : chains.in_order(row);
    if (chain.empty()) return 0;
    paths.clear();
    const auto failed = std::find_if(chain.begin(), chain.end(),
                                     [&](const auto& cut) { return !paths.add(cut[0].vertex, cut[1].vertex); });
    if (failed == chain.end()) return part_along_marks(cutter, faces);
    chains.forbid(*failed);
  }
  return 0;
}

}  // namespace isimp::meshing
