#include "repair/junctions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "complex/angles.h"
#include "isimp/core/sorted.h"
#include "place/symmetry.h"

namespace isimp::meshing {
namespace {

constexpr int kPasses = 2;
constexpr std::size_t kMostLabels = 5;  ///< charts that may meet in a vertex
// How far the planes may miss the vertex: deviations of the scan from them, and of sqrt(area / charts).
constexpr double kPlanes = 3.2, kGap = 0.11;
constexpr double kRounding = 1e-9;                 ///< share of the diagonal: planes that are nearer than this meet
constexpr double kFixed = 0.0625;                  ///< share of the largest eigenvalue: below, planes fix no point
constexpr double kParallel = 1e-6, kMeets = 1e-6;  ///< the same of planes of cells; how far these may miss, of the size
constexpr double kStep = 0.3;                      ///< from the middle to the vertex, in sqrt(area / charts)
// The energy of polygons, in area / charts: the distortion of their faces, a price for an edge of no length that falls to
// 0 for one of kShort, for each full turn by which reflex corners open too far, and for each full turn that sharp corners
// lack. A join must lower it.
constexpr double kOfShort = 0.003, kOfReflex = 0.3, kOfSharp = 6;
constexpr double kShort = 0.4;  ///< sqrt(area / charts); at cells of round parts also the longest chord that is removed
constexpr double kOfImage = 0.1;      ///< energy that the image of a join may add
constexpr double kOfGiver = 1.0 / 3;  ///< share of its area that a chart may give
constexpr double kLoose = 3;          ///< times the gap: at the image of a join
constexpr double kLongest = 4;        ///< longest path between two junctions, in sqrt(area / charts)

/// The charts at a vertex, counter-clockwise.
using Round = std::vector<std::int32_t>;

/// Two junctions, and the boundary half-edges from one to the other.
struct Chord {
  std::int32_t u, v;
  std::vector<std::int32_t> path;
};

/// One of the ways to join: a transfer of faces from one chart to another, by which one end moves to the other.
struct Gift {
  double error = 0;
  std::int32_t giver, taker, keeps, moves;
  std::vector<std::int32_t> faces;
  Vec3 sum = Vec3::Zero();
};

class Joiner {
 public:
  /// \param joins  new joins are appended
  Joiner(State& state, std::vector<Join>& joins, Job& job) : s_(state), mesh_(state.mesh), joins_(joins), job_(job) {}

  bool run() {
    read();
    const std::size_t before = joins_.size();
    for (const Candidate& c : candidates()) {
      job_.poll();
      if (image_.empty())
        join(c.a, c.b);
      else
        join_both(c.a, c.b);
    }
    for (std::size_t i = before; i < joins_.size(); ++i)
      s_.hand_over(joins_[i].giver, joins_[i].taker, joins_[i].faces, joins_[i].charts);
    return joins_.size() > before;
  }

 private:
  struct Candidate {
    double length;
    std::int32_t a, b;
    auto operator<=>(const Candidate&) const = default;
  };

  /// Polygons and planes as they are, to be kept up to date while junctions are joined.
  void read() {
    const std::int32_t charts = s_.labels.chart_count();
    loops_.resize(charts);
    sums_.resize(charts);
    at_.resize(s_.corners.count());
    for (std::int32_t l = 0; l < charts; ++l) {
      if (s_.labels.charts[l].face == kNone) continue;
      sums_[l] = s_.planes[l].projected * s_.planes[l].normal;
      for (const std::int32_t h : s_.complex.chords(l)) {
        const std::int32_t c = s_.corner_at(mesh_.from(h));
        loops_[l].push_back(c);
        at_[c].push_back(l);
      }
    }
    const Scale scale = s_.scale();
    size_ = scale.size;
    gap_ = std::min(kPlanes * scale.deviation, kGap * size_) + kRounding * mesh_.diagonal();
    vertex_ = s_.corners.vertex;
    position_ = s_.corners.position;
    image_ = chart_images(s_);
    planes_ = s_.planes;
    if (!s_.partition.region_cell.empty())
      for (std::int32_t l = 0; l < charts; ++l)
        if (const std::int32_t r = s_.labels.charts[l].region;
            s_.labels.charts[l].face != kNone && s_.partition.region_held[r] == kPlaneRound)
          hold(planes_[l], s_.partition, r);
  }

  [[nodiscard]] std::vector<Candidate> candidates() const {
    std::vector<Candidate> some;
    for (const auto& loop : loops_)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t a = loop[i], b = loop[i + 1 < loop.size() ? i + 1 : 0];
        if (a > b || at_[a].size() < 3 || at_[b].size() < 3) continue;
        const double length = (position_[a] - position_[b]).norm();
        if (length < s_.options.join_junctions * size_) some.push_back({length, a, b});
      }
    std::sort(some.begin(), some.end());
    return some;
  }

  /// Nothing at a border of the mesh.
  [[nodiscard]] Round round_of(std::int32_t vertex) const {
    Round round;
    if (mesh_.opposite(mesh_.vertex_halfedge()[vertex]) == kNone) return round;
    for_each_leaving(mesh_, vertex, [&](std::int32_t h) {
      const std::int32_t l = s_.labels.label[h / 3];
      if (round.empty() || round.back() != l) round.push_back(l);
    });
    if (round.size() > 1 && round.front() == round.back()) round.pop_back();
    return round;
  }

  /// The path from u to v along which no other junction is, if there is one.
  [[nodiscard]] std::optional<Chord> trace(std::int32_t u, std::int32_t v) const {
    std::optional<Chord> found;
    for_each_leaving(mesh_, u, [&](std::int32_t first) {
      if (found || s_.labels.inner(first)) return;
      Chord chord{u, v, {}};
      double length = 0;
      for (std::int32_t h = first;; h = s_.labels.next_on_boundary(h)) {
        if (s_.labels.across(h) == kNone) return;
        chord.path.push_back(h);
        const std::int32_t to = mesh_.to(h);
        length += (mesh_.vertices()[to] - mesh_.vertices()[mesh_.from(h)]).norm();
        if (to == v) break;
        if (length > kLongest * size_ || s_.complex.boundary_edges(to) != 2) return;
      }
      found = std::move(chord);
    });
    return found;
  }

  /// Whether corners of some charts stay on the planes of cells exactly: two cells of one round part meet in a line, from
  /// which a join would move their corner far if they are nearly parallel. Four cells of two parts nearly meet in a point,
  /// which is good enough.
  [[nodiscard]] bool holds_cells(const Round& charts) const {
    int cells = 0;
    std::int32_t part = kNone;
    for (const std::int32_t l : charts) {
      if (!planes_[l].round) continue;
      const std::int32_t mine = s_.partition.region_cell[s_.labels.charts[l].region].proxy;
      if (cells > 0 && mine != part) return false;
      part = mine;
      ++cells;
    }
    return cells > 1;
  }

  /// Where the planes of some charts meet, near a point; nothing where they do not.
  [[nodiscard]] std::optional<Vec3> meeting_point(const Round& charts, const Vec3& near, double radius,
                                                  double gap) const {
    const bool holds = holds_cells(charts);
    std::vector<const Plane*> cells, others;
    for (const std::int32_t l : charts) (holds && planes_[l].round ? cells : others).push_back(&planes_[l]);
    Eigen::Matrix3d free = Eigen::Matrix3d::Identity();
    Vec3 d = Vec3::Zero();
    if (holds) d = step_onto(cells, kParallel, near, free);
    d += step_onto(others, kFixed, near + d, free);
    if (!(d.norm() <= radius)) return {};
    const auto misses = [&](const Plane* p, double most) {
      return std::abs(p->normal.dot(near + d - p->centre)) > most;
    };
    const bool is_met = std::none_of(cells.begin(), cells.end(), [&](auto p) { return misses(p, kMeets * size_); }) &&
                        std::none_of(others.begin(), others.end(), [&](auto p) { return misses(p, gap); });
    return is_met ? std::optional(Vec3(near + d)) : std::nullopt;
  }

  /// The data of a join of two junctions.
  struct Plan {
    std::int32_t a, b;
    Vec3 place;
    std::vector<Gift> gifts;
    Round all;
  };

  /// \param loosely  whether the image of a join is planned: it may be a little worse
  [[nodiscard]] std::optional<Plan> plan(std::int32_t a, std::int32_t b, bool loosely) {
    if (at_[a].empty() || at_[b].empty()) return {};
    const std::int32_t u = vertex_[a], v = vertex_[b];
    const Round at_u = round_of(u), at_v = round_of(v);
    if (at_u.size() < 3 || at_v.size() < 3 || at_u.size() + at_v.size() - 2 > kMostLabels) return {};
    Round all = at_u;
    all.insert(all.end(), at_v.begin(), at_v.end());
    sort_unique(all);
    if (all.size() != at_u.size() + at_v.size() - 2 || all.front() == kNone) return {};
    const std::optional<Chord> chord = trace(u, v);
    if (!chord) return {};
    const double length = (position_[a] - position_[b]).norm();
    const bool any_cell = std::any_of(all.begin(), all.end(), [&](std::int32_t l) { return planes_[l].round; });
    if (any_cell && length > kShort * size_) return {};  // a long way would turn the edges of a ring
    const std::optional<Vec3> place = meeting_point(all, (position_[a] + position_[b]) / 2,
                                                    std::max(length, kStep * size_), loosely ? kLoose * gap_ : gap_);
    if (!place) return {};
    const std::optional<double> of_shape = energy_of_shape(a, b, *place, length);
    if (!of_shape) return {};
    const double most = (loosely ? kOfImage : 0) - *of_shape;
    if (most <= 0) return {};
    Plan p{a, b, *place, gifts_of(*chord, at_u, at_v, most * size_ * size_), std::move(all)};
    return p.gifts.empty() ? std::nullopt : std::optional(std::move(p));
  }

  bool carry_out(Plan& p) {
    for (Gift& gift : p.gifts) {
      if (!give(gift, p.all)) continue;
      replace(p.a, p.b, p.place, gift.keeps);
      joins_.push_back({gift.giver, gift.taker, gift.moves, std::move(gift.faces), std::move(p.all)});
      return true;
    }
    return false;
  }

  void join(std::int32_t a, std::int32_t b) {
    if (std::optional<Plan> p = plan(a, b, false)) carry_out(*p);
  }

  /// Joins two junctions and their images, or none of them. If the images are one junction already, or there are none,
  /// only the two junctions are joined.
  void join_both(std::int32_t a, std::int32_t b) {
    if (at_[a].empty() || at_[b].empty()) return;
    Round images = at_[a];
    images.insert(images.end(), at_[b].begin(), at_[b].end());
    sort_unique(images);
    bool mirrors = !images.empty();
    for (std::int32_t& l : images) mirrors = (l = image_[l]) != kNone && mirrors;
    if (!mirrors) return join(a, b);
    std::sort(images.begin(), images.end());
    const auto [c, d] = junctions_among(images);
    if (c == kNone) return;
    if (d == kNone || (std::min(a, b) == std::min(c, d) && std::max(a, b) == std::max(c, d))) {
      if (std::optional<Plan> p = plan(a, b, d == kNone)) carry_out(*p);
      return;
    }
    std::optional<Plan> here = plan(a, b, false), there = plan(c, d, true);
    if (here && there && carry_out(*here)) {
      there = plan(c, d, true);
      if (!there || !carry_out(*there)) joins_.back().alone = true;
    }
  }

  /// The junction at which exactly these charts meet, or two adjacent junctions that together have these charts.
  [[nodiscard]] std::array<std::int32_t, 2> junctions_among(const Round& charts) const {
    std::array<std::int32_t, 2> found{kNone, kNone};
    for (const std::int32_t l : charts) {
      const auto& loop = loops_[l];
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t c = loop[i], d = loop[i + 1 < loop.size() ? i + 1 : 0];
        if (at_[c] == charts) return {c, kNone};
        if (at_[c].size() < 3 || at_[d].size() < 3 || at_[c].size() + at_[d].size() != charts.size() + 2) continue;
        Round together = at_[c];
        together.insert(together.end(), at_[d].begin(), at_[d].end());
        sort_unique(together);
        if (together == charts) found = {c, d};
      }
    }
    return found;
  }

  /// The change of the energy, without that of the distortion, by one corner at a place instead of two; nothing if a
  /// polygon vanishes or faces away.
  [[nodiscard]] std::optional<double> energy_of_shape(std::int32_t a, std::int32_t b, const Vec3& place,
                                                      double length) {
    std::vector<std::int32_t> round = at_[a];
    round.insert(round.end(), at_[b].begin(), at_[b].end());
    sort_unique(round);
    Angles before, after;
    for (const std::int32_t l : round) before.add(angles_of(loops_[l], position_, s_.planes[l].normal));
    const Vec3 was = std::exchange(position_[a], place);
    bool good = true;
    for (const std::int32_t l : round) {
      const std::vector<std::int32_t> loop = without(loops_[l], a, b);
      good = good && loop.size() >= 3;
      if (good) after.add(angles_of(loop, position_, s_.planes[l].normal));
    }
    position_[a] = was;
    if (!good || after.faces_away) return {};
    const double reflex = (after.excess - before.excess) / 360, sharp = (after.lack - before.lack) / 360;
    return kOfReflex * reflex + kOfSharp * sharp - kOfShort * std::max(0.0, 1 - length / (kShort * size_));
  }

  /// A loop with a for b.
  [[nodiscard]] static std::vector<std::int32_t> without(const std::vector<std::int32_t>& loop, std::int32_t a,
                                                         std::int32_t b) {
    std::vector<std::int32_t> result;
    for (const std::int32_t c : loop) {
      const std::int32_t d = c == b ? a : c;
      if (result.empty() || result.back() != d) result.push_back(d);
    }
    if (result.size() > 1 && result.front() == result.back()) result.pop_back();
    return result;
  }

  /// The ways to join, the one with the least increase of the error first. All ways if there is a mirror plane, so that
  /// both a join and its image can be made; else only the first.
  /// \param most  the largest increase of the error
  [[nodiscard]] std::vector<Gift> gifts_of(const Chord& chord, const Round& at_u, const Round& at_v,
                                           double most) const {
    const std::int32_t left = s_.labels.label[chord.path[0] / 3], right = s_.labels.across(chord.path[0]);
    std::vector<Gift> gifts;
    const auto consider = [&](const Round& at_end, std::int32_t keeps, std::int32_t moves) {
      if (at_end.size() != 3) return;
      const std::int32_t taker =
          *std::find_if(at_end.begin(), at_end.end(), [&](std::int32_t l) { return l != left && l != right; });
      for (const std::int32_t giver : {left, right}) {
        Gift gift{.giver = giver, .taker = taker, .keeps = keeps, .moves = moves, .faces = {}};
        if (fill(gift, chord) && gift.error <= most) gifts.push_back(std::move(gift));
      }
    };
    consider(at_u, chord.v, chord.u);
    consider(at_v, chord.u, chord.v);
    std::stable_sort(gifts.begin(), gifts.end(), [](const Gift& x, const Gift& y) { return x.error < y.error; });
    if (image_.empty() && gifts.size() > 1) gifts.erase(gifts.begin() + 1, gifts.end());
    return gifts;
  }

  /// Finds the faces to give and the increase of the error.
  /// \return whether they may be given
  bool fill(Gift& gift, const Chord& chord) const {
    const auto add_star = [&](std::int32_t w) {
      if (w == gift.keeps) return;
      for_each_leaving(mesh_, w, [&](std::int32_t h) {
        if (s_.labels.label[h / 3] == gift.giver) gift.faces.push_back(h / 3);
      });
    };
    for (const std::int32_t h : chord.path) add_star(mesh_.from(h));
    add_star(chord.v);
    sort_unique(gift.faces);
    double area = 0;
    for (const std::int32_t f : gift.faces) {
      const FaceRecord& r = mesh_.graph().faces[mesh_.graph().graph_face[f]];
      const double weight = mesh_.graph().area * r.area;
      area += weight;
      gift.sum += weight * Vec3(r.nx, r.ny, r.nz);
    }
    const Vec3 &giver = sums_[gift.giver], &taker = sums_[gift.taker];
    gift.error = 2 * (giver.norm() + taker.norm() - (giver - gift.sum).norm() - (taker + gift.sum).norm());
    return !gift.faces.empty() && area < kOfGiver * s_.planes[gift.giver].area &&
           may_give(s_, gift.giver, gift.taker, gift.faces);
  }

  /// Changes the labels, if all charts stay discs and no other junction changes.
  /// \param all  the charts that shall meet in the vertex that stays
  bool give(const Gift& gift, const Round& all) {
    std::vector<std::int32_t> near;
    for (const std::int32_t f : gift.faces)
      for (const std::int32_t w : mesh_.triangles()[f]) near.push_back(w);
    sort_unique(near);
    std::vector<Round> before;
    before.reserve(near.size());
    for (const std::int32_t w : near) before.push_back(round_of(w));
    if (std::any_of(before.begin(), before.end(), [](const Round& r) { return r.empty(); })) return false;
    s_.relabel(gift.faces, gift.taker);
    const std::int32_t face = s_.labels.charts[gift.giver].face;
    bool good = true;
    for (std::size_t i = 0; i < near.size() && good; ++i)
      good = is_kept(before[i], round_of(near[i]), near[i] == gift.keeps, near[i] == gift.moves, all);
    good = good && stay_discs(gift);
    if (good) {
      sums_[gift.giver] -= gift.sum;
      sums_[gift.taker] += gift.sum;
      return true;
    }
    s_.relabel(gift.faces, gift.giver);
    s_.name(gift.giver, face);
    return false;
  }

  [[nodiscard]] static bool is_kept(const Round& before, const Round& after, bool keeps, bool moves, const Round& all) {
    Round sorted = after;
    sort_unique(sorted);
    if (sorted.size() != after.size()) return false;  // a chart would touch itself
    if (keeps) return sorted == all;
    if (after.size() <= 2) return moves || before.size() <= 2;
    return before == after;
  }

  /// Names the giver by a face that it keeps.
  /// \return whether both charts are discs still
  bool stay_discs(const Gift& gift) {
    const std::int32_t kept = face_beside(s_.labels, gift.faces, gift.giver);
    if (kept == kNone) return false;
    if (s_.labels.label[s_.labels.charts[gift.giver].face] != gift.giver) s_.name(gift.giver, kept);
    const std::vector<std::int32_t> loop = outline(gift.faces);
    // A disc without a disc along one path of its boundary is a disc, and so are two discs with one common path.
    // `is_kept` has already checked that no chart touches itself at a vertex.
    const auto runs = [&](std::int32_t label) {
      int count = 0;
      for (std::size_t i = 0; i < loop.size(); ++i)
        count += is_beside(loop[i], label) && !is_beside(loop[i > 0 ? i - 1 : loop.size() - 1], label);
      return count;
    };
    return runs(gift.giver) == 1 && runs(gift.taker) == 1;
  }

  /// Whether the face across a half-edge of the marked faces has a label and is none of them.
  [[nodiscard]] bool is_beside(std::int32_t h, std::int32_t label) const {
    const std::int32_t o = mesh_.opposite(h);
    return o != kNone && s_.labels.label[o / 3] == label && !s_.labels.face_marks.has(o / 3);
  }

  /// Marks some faces.
  /// \return their boundary half-edges in order; empty if they are no disc
  std::vector<std::int32_t> outline(const std::vector<std::int32_t>& faces) {
    auto &in = s_.labels.face_marks, &seen = s_.labels.vertex_marks;
    in.clear();
    seen.clear();
    for (const std::int32_t f : faces) in.add(f);
    std::int64_t vertices = 0, edges = 0, boundary = 0;  // edges twice
    std::int32_t start = kNone;
    const auto is_inner = [&](std::int32_t h) {
      const std::int32_t o = mesh_.opposite(h);
      return o != kNone && in.has(o / 3);
    };
    for (const std::int32_t f : faces)
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        vertices += seen.add(mesh_.from(h));
        ++edges;
        if (is_inner(h)) continue;
        ++edges;
        ++boundary;
        start = h;
      }
    std::vector<std::int32_t> loop;
    if (2 * (vertices + static_cast<std::int64_t>(faces.size())) - edges != 2) return loop;
    seen.clear();
    for (std::int32_t h = start; seen.add(mesh_.from(h));) {
      loop.push_back(h);
      h = Mesh::next(h);
      while (is_inner(h)) h = Mesh::next(mesh_.opposite(h));
    }
    if (static_cast<std::int64_t>(loop.size()) != boundary) loop.clear();
    return loop;
  }

  /// The polygons with one corner instead of two.
  void replace(std::int32_t a, std::int32_t b, const Vec3& place, std::int32_t keeps) {
    const std::int32_t gone = vertex_[a] == keeps ? vertex_[b] : vertex_[a];
    position_[a] = place;
    vertex_[a] = keeps;
    for (const std::int32_t l : at_[b]) loops_[l] = without(loops_[l], a, b);
    at_[a].insert(at_[a].end(), at_[b].begin(), at_[b].end());
    sort_unique(at_[a]);
    at_[b].clear();
    s_.drop_corner(gone);
    s_.add_corner(keeps);
  }

  State& s_;
  const Mesh& mesh_;
  std::vector<Join>& joins_;
  Job& job_;
  double size_ = 0;                                    // size of a region, scene units
  double gap_ = 0;                                     // distance by which planes may miss the vertex
  std::vector<std::vector<std::int32_t>> loops_, at_;  // corners by chart, charts by corner
  std::vector<std::int32_t> vertex_;                   // by corner: where the junction is
  std::vector<Vec3> position_;                         // by corner
  std::vector<Plane> planes_;                          // by chart: its plane, or that of its cell
  std::vector<Vec3> sums_;                             // by chart: vector area of its faces
  std::vector<std::int32_t> image_;                    // by chart: see chart_images
};

}  // namespace

std::vector<Join> join_junctions(State& state, Job& job) {
  std::vector<Join> joins;
  if (!(state.options.join_junctions > 0)) return joins;
  for (int pass = 0; pass < kPasses && Joiner(state, joins, job).run(); ++pass) state.update({});
  return joins;
}

}  // namespace isimp::meshing
