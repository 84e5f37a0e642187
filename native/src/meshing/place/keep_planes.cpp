#include "place/keep_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr int kGentle = 8;  ///< rounds that release one plane for each fault; later ones release all planes at it

class Keeper {
 public:
  Keeper(State& state, Findings& findings, const Job& job)
      : s_(state),
        findings_(findings),
        job_(job),
        home_(state.corners.position),
        planes_(state.planes),
        is_let_go_(state.regions, false) {
    for (std::int32_t l = 0; l < s_.labels.piece_count(); ++l) {
      faults_.push_back(findings_.faults(l));
      hold(planes_[l], s_.partition, region(l));
      if (is_kept(l)) asked_.push_back(l);
    }
    for (const Hit& h : findings_.hits()) met_.insert({h.a, h.b});
  }

  std::vector<std::int32_t> run() {
    for (int round = 0; !asked_.empty(); ++round) {
      job_.poll();
      move();
      let_go(round >= kGentle);
    }
    std::vector<std::int32_t> regions;
    for (std::int32_t r = 0; r < s_.regions; ++r)
      if (is_let_go_[r]) regions.push_back(r);
    return regions;
  }

 private:
  [[nodiscard]] std::int32_t region(std::int32_t l) const { return s_.labels.pieces[l].region; }
  [[nodiscard]] bool is_kept(std::int32_t l) const {
    return s_.labels.pieces[l].face != kNone && planes_[l].held && planes_[l].snapped;
  }

  /// Places the corners of the pieces in asked_ and of their neighbours again.
  void move() {
    s_.add_neighbours(asked_);
    std::vector<std::int32_t> moving, changed;
    for (const std::int32_t l : asked_)
      s_.polygons.for_each_of(
          l, [&](std::int32_t q) { moving.insert(moving.end(), s_.polygons.of(q).begin(), s_.polygons.of(q).end()); });
    sort_unique(moving);
    for (const std::int32_t c : moving) {
      s_.move(c, home_[c]);
      for (const std::int32_t q : s_.polygons.at(c)) changed.push_back(s_.polygons.piece(q));
    }
    std::erase_if(moving, [&](std::int32_t c) {
      const auto around = s_.polygons.at(c);
      return std::none_of(around.begin(), around.end(), [&](std::int32_t q) { return is_kept(s_.polygons.piece(q)); });
    });
    s_.move_onto(planes_, moving);
    sort_unique(changed);
    findings_.judge(changed);
    asked_.clear();
  }

  /// Releases planes at new faults. Each new fault has a plane to release, as one of its corners was moved onto one.
  /// \param all  releases all planes at a fault, else the smallest
  void let_go(bool all) {
    for (std::int32_t l = 0; l < s_.labels.piece_count(); ++l)
      if (findings_.faults(l) & ~faults_[l]) let_go_round(corners_at_fault(l), {l}, all);
    for (const Hit& h : findings_.hits())
      if (!h.excused && !met_.contains({h.a, h.b})) let_go_round({h.corners.begin(), h.corners.end()}, {h.a, h.b}, all);
    for (std::int32_t l = 0; l < s_.labels.piece_count(); ++l) {
      if (!is_kept(l) || !is_let_go_[region(l)]) continue;
      asked_.push_back(l);
      planes_[l] = s_.planes[l];
    }
  }

  /// The ends of edges that cross, and the corner of each bent polygon that is furthest from its plane.
  [[nodiscard]] std::vector<std::int32_t> corners_at_fault(std::int32_t l) const {
    std::vector<std::int32_t> some;
    const auto& position = s_.corners.position;
    for (std::size_t i = 0; i < findings_.of(l).polygons.size(); ++i) {
      const PolygonVerdict& v = findings_.of(l).polygons[i];
      const auto loop = s_.polygons.of(s_.polygons.first_of(l) + static_cast<std::int32_t>(i));
      for (const std::int32_t e : v.crossing)
        if (e >= 0) some.insert(some.end(), {loop[e], loop[(e + 1) % loop.size()]});
      if (!(v.faults & kBent)) continue;
      Vec3 middle = Vec3::Zero();
      for (const std::int32_t c : loop) middle += position[c] / static_cast<double>(loop.size());
      const Vec3 normal = vector_area(loop, position);
      some.push_back(*std::max_element(loop.begin(), loop.end(), [&](std::int32_t a, std::int32_t b) {
        return std::abs(normal.dot(position[a] - middle)) < std::abs(normal.dot(position[b] - middle));
      }));
    }
    return some;
  }

  /// Releases planes at a fault.
  /// \param corners  the corners at fault; if no plane is kept at these, all corners of `pieces` are used
  void let_go_round(std::vector<std::int32_t> corners, std::initializer_list<std::int32_t> pieces, bool all) {
    std::vector<std::int32_t> kept = kept_round(corners);
    if (kept.empty() || all) {
      for (const std::int32_t l : pieces)
        s_.polygons.for_each_of(l, [&](std::int32_t q) {
          corners.insert(corners.end(), s_.polygons.of(q).begin(), s_.polygons.of(q).end());
        });
      kept = kept_round(corners);
    }
    if (kept.empty()) return;
    if (!all)
      kept = {*std::min_element(kept.begin(), kept.end(),
                                [&](std::int32_t a, std::int32_t b) { return planes_[a].area < planes_[b].area; })};
    for (const std::int32_t l : kept) is_let_go_[region(l)] = true;
  }

  /// The pieces at some corners whose planes are kept.
  [[nodiscard]] std::vector<std::int32_t> kept_round(const std::vector<std::int32_t>& corners) const {
    std::vector<std::int32_t> kept;
    for (const std::int32_t c : corners)
      for (const std::int32_t q : s_.polygons.at(c))
        if (is_kept(s_.polygons.piece(q))) kept.push_back(s_.polygons.piece(q));
    sort_unique(kept);
    return kept;
  }

  State& s_;
  Findings& findings_;
  const Job& job_;
  const std::vector<Vec3> home_;               // by corner: its place before
  std::vector<Plane> planes_;                  // by piece: the snapped plane if it is kept, else that of the state
  std::vector<bool> is_let_go_;                // by region
  std::vector<std::uint8_t> faults_;           // by piece: the faults at the start
  std::set<std::array<std::int32_t, 2>> met_;  // pairs of pieces that met
  std::vector<std::int32_t> asked_;            // pieces whose planes are new or were released
};

}  // namespace

std::vector<std::int32_t> keep_to_planes(State& state, Findings& findings, const Job& job) {
  return Keeper(state, findings, job).run();
}

}  // namespace isimp::meshing
