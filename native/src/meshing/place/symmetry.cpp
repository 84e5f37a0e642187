#include "place/symmetry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "isimp/core/sorted.h"
#include "isimp/partition/mirror.h"
#include "judge/trials.h"
#include "place/moves.h"

namespace isimp::meshing {
namespace {

constexpr double kNear = 0.35;   // largest distance of a corner from another's image, in sqrt(area / charts)
constexpr double kExact = 1e-9;  // share of the diagonal: points that are nearer count as one place

/// The pairs of charts and of corners that are images of each other.
class Pairs {
 public:
  explicit Pairs(const State& state)
      : s_(state), mirror_(state.partition.symmetry->relative_to(state.mesh.origin())), chart_(chart_images(state)) {
    reach_ = kNear * state.scale().size;
    pair_corners();
  }

  [[nodiscard]] const Mirror& mirror() const { return mirror_; }
  /// The image of a corner, itself where it belongs on the plane; kNone where there is none.
  [[nodiscard]] std::int32_t of_corner(std::int32_t c) const { return corner_[c]; }
  /// Whether a corner lies exactly at its image.
  [[nodiscard]] bool is_exact(std::int32_t c) const {
    const auto& position = s_.corners.position;
    return corner_[c] != kNone &&
           (position[c] - mirror_.image(position[corner_[c]])).norm() <= kExact * s_.mesh.diagonal();
  }
  /// The images of the charts at a corner, rising; empty if one of them has no image.
  [[nodiscard]] std::vector<std::int32_t> images_round(std::int32_t c) const {
    std::vector<std::int32_t> images;
    for (const std::int32_t l : round(c)) {
      if (chart_[l] == kNone) return {};
      images.push_back(chart_[l]);
    }
    sort_unique(images);
    return images;
  }
  [[nodiscard]] std::vector<std::int32_t> round(std::int32_t c) const { return s_.polygons.charts_at({&c, 1}); }
  [[nodiscard]] double reach() const { return reach_; }

 private:
  void pair_corners() {
    std::map<std::vector<std::int32_t>, std::vector<std::int32_t>> by_round;
    for (std::int32_t c = 0; c < s_.corners.count(); ++c)
      if (!s_.polygons.at(c).empty()) by_round[round(c)].push_back(c);
    corner_.assign(s_.corners.count(), kNone);
    const auto& position = s_.corners.position;
    for (const auto& [charts, some] : by_round) {
      const auto others = by_round.find(images_round(some.front()));
      if (others == by_round.end()) continue;
      for (const std::int32_t c : some) {
        const Vec3 image = mirror_.image(position[c]);
        double least = reach_;
        for (const std::int32_t other : others->second) {
          const double distance = (position[other] - image).norm();
          if (distance >= least) continue;
          least = distance;
          corner_[c] = other;
        }
      }
    }
    const std::vector<std::int32_t> wanted = corner_;
    for (std::size_t c = 0; c < corner_.size(); ++c)
      if (wanted[c] != kNone && wanted[wanted[c]] != static_cast<std::int32_t>(c)) corner_[c] = kNone;
  }

  const State& s_;
  const Mirror mirror_;  // relative to the mesh's origin
  std::vector<std::int32_t> chart_, corner_;
  double reach_ = 0;
};

class Mirroring {
 public:
  Mirroring(State& state, Defects& defects, Job& job) : s_(state), defects_(defects), job_(job) {}

  /// Drops corners along borders that the borders' images lack, then adds the images of corners that had to stay.
  void pair_more() {
    for (const bool drop : {true, false}) {
      const Pairs pairs(s_);
      std::vector<std::int32_t> vertices;
      std::vector<std::size_t> left;  // corners by chart, of which three stay
      left.reserve(s_.labels.charts.size());
      for (std::int32_t l = 0; l < s_.labels.chart_count(); ++l) left.push_back(s_.complex.chords(l).size());
      for (std::int32_t c = 0; c < s_.corners.count(); ++c) {
        if (pairs.of_corner(c) != kNone || s_.polygons.at(c).empty()) continue;
        const std::int32_t v = s_.corners.vertex[c];
        if (s_.complex.boundary_edges(v) != 2 || ends_diagonal(c)) continue;
        const std::vector<std::int32_t> images = pairs.images_round(c);
        if (images.empty()) continue;
        if (!drop) {
          const std::int32_t other = vertex_near(images, pairs.mirror().image(s_.corners.position[c]), pairs);
          if (other != kNone) vertices.push_back(other);
          continue;
        }
        const std::vector<std::int32_t> round = pairs.round(c);
        if (std::any_of(round.begin(), round.end(), [&](std::int32_t l) { return left[l] <= 3; })) continue;
        for (const std::int32_t l : round) --left[l];
        vertices.push_back(v);
      }
      sort_unique(vertices);
      for (const std::int32_t v : vertices) turn_corner(v);
      defects_.renew_hits();
    }
  }

  /// Makes a corner no corner, or the other way round, if no polygon becomes defective.
  void turn_corner(std::int32_t vertex) {
    job_.poll();
    attempt(s_, defects_, {}, kNone, [&] {
      if (s_.complex.is_corner(vertex)) return s_.drop_corner(vertex);
      s_.add_corner(vertex);
      return true;
    });
  }

  /// Places pairs, one after the other: at the mean of the one and the other's image, else at one of both.
  void place() {
    const Pairs pairs(s_);
    for (std::int32_t c = 0; c < s_.corners.count(); ++c) {
      const std::int32_t other = pairs.of_corner(c);
      if (other < c || pairs.is_exact(c)) continue;  // none, or had its turn
      job_.poll();
      const Vec3 here = s_.corners.position[c], image = pairs.mirror().image(s_.corners.position[other]);
      for (const Vec3& wanted : {Vec3((here + image) / 2), here, image}) {
        const auto to = in_reach(c, other, wanted, pairs.mirror());
        if (!to) continue;
        const std::array<Move, 2> moves{Move{c, *to}, Move{other, pairs.mirror().image(*to)}};
        if (attempt_moves(s_, defects_, std::span(moves).first(other == c ? 1 : 2))) break;
      }
    }
    defects_.renew_hits();
  }

 private:
  /// The place near a given one that is within the reach of a corner, its image within the reach of the other corner. A
  /// corner that is its own image gets a place on the plane. Returns nullopt if there is none.
  [[nodiscard]] std::optional<Vec3> in_reach(std::int32_t c, std::int32_t other, Vec3 place,
                                             const Mirror& mirror) const {
    constexpr int kTurns = 12;
    const double reach = s_.options.reach * s_.mesh.diagonal() * (1 - 1e-9);
    const Vec3 &home = s_.mesh.vertices()[s_.corners.vertex[c]],
               there = mirror.image(s_.mesh.vertices()[s_.corners.vertex[other]]);
    for (int turn = 0; turn < kTurns; ++turn) {
      bool settled = true;
      for (const Vec3& vertex : {home, there}) {
        const double away = (place - vertex).norm();
        if (away <= reach) continue;
        place = vertex + (place - vertex) * (reach / away * (1 - 1e-9));
        settled = false;
      }
      if (other == c) place -= mirror.height(place) * mirror.normal;
      if (settled) return place;
    }
    return {};
  }

  [[nodiscard]] bool ends_diagonal(std::int32_t c) const {
    const std::int32_t v = s_.corners.vertex[c];
    for (const std::int32_t q : s_.polygons.at(c))
      for (const auto& [a, b] : s_.diagonals[s_.polygons.chart(q)])
        if (a == v || b == v) return true;
    return false;
  }

  /// The vertex inside the border between two charts, or of one and of the mesh, that is nearest to a place and no
  /// corner.
  [[nodiscard]] std::int32_t vertex_near(std::span<const std::int32_t> charts, const Vec3& place,
                                         const Pairs& pairs) const {
    double least = pairs.reach();
    std::int32_t nearest = kNone;
    for (const std::int32_t h : s_.complex.loop(charts.front())) {
      if (s_.labels.across(h) != (charts.size() > 1 ? charts.back() : kNone)) continue;
      const std::int32_t v = s_.mesh.from(h);
      const double distance = (s_.mesh.vertices()[v] - place).norm();
      if (distance >= least || s_.complex.is_corner(v) || s_.complex.boundary_edges(v) != 2) continue;
      least = distance;
      nearest = v;
    }
    return nearest;
  }

  State& s_;
  Defects& defects_;
  Job& job_;
};

}  // namespace

std::vector<std::int32_t> chart_images(const State& state) {
  if (!state.partition.symmetry) return {};
  std::vector<Patch> patches(state.labels.charts.size());
  for (std::size_t l = 0; l < patches.size(); ++l) {
    const Plane& p = state.planes[l];
    if (state.labels.charts[l].face != kNone) patches[l] = {p.centre, p.normal, p.area};
  }
  return mirror_images(patches, state.partition.symmetry->relative_to(state.mesh.origin()));
}

void mirror_corners(State& state, Defects& defects, Job& job) {
  if (!state.partition.symmetry) return;
  Mirroring(state, defects, job).pair_more();
  Mirroring(state, defects, job).place();
}

std::int32_t mirrored_corners(const State& state) {
  if (!state.partition.symmetry) return 0;
  const Pairs pairs(state);
  std::int32_t count = 0;
  for (std::int32_t c = 0; c < state.corners.count(); ++c) count += pairs.is_exact(c);
  return count;
}

}  // namespace isimp::meshing
