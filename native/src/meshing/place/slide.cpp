#include "place/slide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "complex/angles.h"
#include "discs/no_length.h"
#include "isimp/core/symmetric.h"
#include "place/moves.h"

namespace isimp::meshing {
namespace {

// tuned shapes
constexpr int kSlideRounds = 2;             // passes over all corners
constexpr int kSlideDirections = 8;         // directions in which each is tried
constexpr std::array kSteps = {0.2, 0.08};  // largest move of a corner in a round, in sqrt(area / charts)
constexpr double kOffPlanes = 0.4;          // distance from its planes, in deviations of the scan from them
// tuned needles
constexpr double kOfNeedle = 4;  // degrees above kReflex that one below kNeedle counts as
constexpr double kBend = 1200;   // degrees that a bend of sqrt(area / charts) counts as
// tuned shapes
constexpr double kShortEdge = 0.3;  // edges shorter than this, in sqrt(area / charts), do not become shorter
constexpr double kFacing = 0.9;  // least cosine between a polygon that a move turns away from its chart, and that chart
// tuned needles
constexpr double kWorth = 1;            // degrees that a move has to gain
constexpr double kLeastFreedom = 1e-6;  // rounding: share of the shortest edge: with less a corner gains nothing

class CornerSlider {
 public:
  CornerSlider(State& state, Job& job) : s_(state), home_(state.corners.position), job_(job) {
    const Scale scale = s_.scale();
    size_ = scale.size;
    off_ = kOffPlanes * scale.deviation + kNoLength * s_.mesh.diagonal();
    bend_ = kBend / size_;
  }

  /// \return the moves that make corners less reflex and sharp
  std::vector<Move> run() {
    for (int round = 0; round < kSlideRounds; ++round) {
      job_.poll();
      for (std::int32_t c = 0; c < s_.corners.count(); ++c)
        if (may_slide(c)) slide(c);
    }
    std::vector<Move> moves;
    for (std::int32_t c = 0; c < s_.corners.count(); ++c) {
      if (s_.corners.position[c] == home_[c]) continue;
      moves.push_back({c, s_.corners.position[c]});
      s_.move(c, home_[c]);
    }
    return moves;
  }

 private:
  /// Whether a corner may move. Corners at a border of the mesh and corners held at their vertices stay.
  [[nodiscard]] bool may_slide(std::int32_t c) const {
    const auto around = s_.polygons.at(c);
    if (around.size() < 2 || !(s_.corners.radius[c] > 0)) return false;
    return s_.mesh.opposite(s_.mesh.vertex_halfedge()[s_.corners.vertex[c]]) != kNone;
  }

  /// The part of a polygon that a corner affects: two corners before it, two after it, and the direction of the chart.
  struct Beside {
    std::array<std::int32_t, 2> before, after;
    std::int32_t polygon;
    Vec3 normal;
    double facing;  ///< cosine between polygon and chart before the move
  };

  void find_beside(std::int32_t c) {
    beside_.clear();
    for (const std::int32_t q : s_.polygons.at(c)) {
      const auto loop = s_.polygons.of(q);
      const std::size_t n = loop.size(), i = std::find(loop.begin(), loop.end(), c) - loop.begin();
      const auto at = [&](std::size_t k) { return loop[(i + k) % n]; };
      beside_.push_back({{at(n - 2), at(n - 1)}, {at(1), at(2)}, q, s_.planes[s_.polygons.chart(q)].normal, 0});
    }
  }

  [[nodiscard]] double shortest_round(const Vec3& at) const {
    double shortest = kShortEdge * size_;
    for (const Beside& b : beside_) shortest = std::min(shortest, (s_.corners.position[b.after[0]] - at).norm());
    return shortest;
  }

  /// Degrees by which the corner at `at` and its neighbours are reflex or sharp, in reflex ones.
  [[nodiscard]] double angles_round(const Vec3& at) const {
    const auto& position = s_.corners.position;
    const auto cost = [](double angle) {
      return std::max(0.0, angle - kReflex) + kOfNeedle * std::max(0.0, kNeedle - angle);
    };
    double sum = 0;
    for (const auto& [before, after, polygon, normal, facing] : beside_) {
      const Vec3 &a = position[before[0]], &b = position[before[1]], &c = position[after[0]], &d = position[after[1]];
      sum += cost(angle_at(a, b, at, normal)) + cost(angle_at(b, at, c, normal)) + cost(angle_at(at, c, d, normal));
    }
    return sum;
  }

  /// The bend of the polygons at a corner, in degrees by kBend.
  [[nodiscard]] double bend_round() const {
    double sum = 0;
    for (const Beside& b : beside_) sum += bend_ * bend_of(s_.polygons.of(b.polygon), s_.corners.position);
    return sum;
  }

  /// The cosine between a polygon and its chart.
  [[nodiscard]] double facing(const Beside& b) const {
    const Vec3 area = vector_area(s_.polygons.of(b.polygon), s_.corners.position);
    const double length = area.norm();
    return length > 0 ? area.dot(b.normal) / length : -1;
  }

  /// Whether a polygon at a corner is turned from its chart more than before, and by more than kFacing allows.
  [[nodiscard]] bool turns_away() const {
    return std::any_of(beside_.begin(), beside_.end(),
                       [&](const Beside& b) { return facing(b) < std::min(b.facing, kFacing); });
  }

  /// The two directions in which the planes at a corner restrict it least, and its largest move in each.
  struct Freedom {
    std::array<Vec3, 2> along;
    std::array<double, 2> most{};
  };
  [[nodiscard]] Freedom freedom_of(std::int32_t c) const {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    const auto around = s_.polygons.at(c);
    for (const std::int32_t q : around) {
      const Vec3& n = s_.planes[s_.polygons.chart(q)].normal;
      a += n * n.transpose() / static_cast<double>(around.size());
    }
    const auto [values, vectors] = direct_spectrum_of(a);
    Freedom free;
    for (int k = 0; k < 2; ++k) {  // the third direction is normal to the planes
      const double away = std::sqrt(std::max(0.0, values[k]));
      free.along[k] = vectors.col(k);
      free.most[k] = away > 0 ? off_ / away : std::numeric_limits<double>::infinity();
    }
    return free;
  }

  void slide(std::int32_t c) {
    const Vec3 at = s_.corners.position[c], home = home_[c], vertex = s_.mesh.vertices()[s_.corners.vertex[c]];
    find_beside(c);
    const Freedom free = freedom_of(c);
    const double shortest = shortest_round(at);
    if (free.most[0] + free.most[1] < kLeastFreedom * shortest) return;
    const double now = angles_round(at);
    if (!(now > 0)) return;
    for (Beside& b : beside_) b.facing = facing(b);
    double least = now + bend_round() - kWorth;
    Vec3 best = at;
    for (const double step : kSteps)
      for (int d = 0; d < kSlideDirections; ++d) {
        const double turn = 2 * std::numbers::pi * d / kSlideDirections;
        Vec3 to = home;
        for (int k = 0; k < 2; ++k) {
          const double by = (at - home).dot(free.along[k]) + step * size_ * (k == 0 ? std::cos(turn) : std::sin(turn));
          to += std::clamp(by, -free.most[k], free.most[k]) * free.along[k];
        }
        if ((to - vertex).norm() > s_.corners.radius[c] || shortest_round(to) < shortest) continue;
        const double angles = angles_round(to);
        if (angles >= least) continue;
        s_.move(c, to);
        const double cost = angles + bend_round();
        if (cost >= least || turns_away()) continue;
        least = cost;
        best = to;
      }
    s_.move(c, best);
  }

  State& s_;
  const std::vector<Vec3> home_;  // by corner: its place before
  Job& job_;
  double size_ = 0, off_ = 0, bend_ = 0;
  std::vector<Beside> beside_;  // polygons at the current corner
};

}  // namespace

void slide_corners(State& state, Defects& defects, Job& job) {
  const std::vector<Move> moves = CornerSlider(state, job).run();
  move_corners(state, defects, moves, job);
}

}  // namespace isimp::meshing
