#include "planar/fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"
#include "planar/blocks.h"

namespace isimp::meshing::planar {
namespace {

using Mat3 = Eigen::Matrix3d;

// tuned planar
/// Weight of the square step of a corner, if the square distance of a mean unit has weight 1. Source: own trials.
constexpr double kStep = 0.7;
constexpr double kMostTurn = 0.2;   ///< largest turn of a plane in a round, radians
constexpr double kDamping = 1e-9;   ///< rounding: share of the square diagonal, for a system that is singular
constexpr double kQuiet = 0.15;     ///< noise, as a share of the reach, below which a plane costs more
constexpr double kPower = 3;        ///< power of the ratio of that noise to the plane's: factor on the cost
constexpr double kMostTrust = 1e4;  ///< limit: largest such factor
constexpr double kTooFar = 4;       ///< times the usual noise: planes that were moved by more cost more
constexpr double kDearer = 4;       ///< largest increase of that cost in one round, as a factor

/// The noise of the unit in the middle: one of few faces may be planar by chance.
double usual_noise(const std::vector<Unit>& units) {
  std::vector<double> all(units.size());
  std::transform(units.begin(), units.end(), all.begin(), [](const Unit& u) { return u.noise; });
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

/// A corner on a plane, with the derivative of their distance by the three unknowns of the plane.
struct Link {
  std::int32_t unit, corner;
  Vec3 slope;  ///< for two turns about the middle of its scan, and the offset, where the corner is now
};

class Solver {
 public:
  Solver(std::vector<Unit>& units, const Places& places, const Kept& kept)
      : units_(units), places_(places), first_(places.start.size() + 1, 0), unknown_(units.size(), kNone) {
    double area = 0;
    for (std::size_t u = 0; u < units.size(); ++u) {
      area += units[u].scan.area;
      if (!units[u].is_fixed() && units[u].binds()) unknown_[u] = count_++;
    }
    std::vector<bool> counts(places.start.size(), false);  // by corner: whether one of its planes changes
    for (std::size_t u = 0; u < units.size(); ++u)
      for (std::size_t i = 0; unknown_[u] != kNone && i < units[u].loop.size(); ++i)
        if (kept[u][i]) counts[units[u].loop[i]] = true;
    for (std::size_t u = 0; u < units.size(); ++u)
      for (std::size_t i = 0; units[u].binds() && i < units[u].loop.size(); ++i)
        if (kept[u][i] && counts[units[u].loop[i]])
          links_.push_back({static_cast<std::int32_t>(u), units[u].loop[i], Vec3::Zero()});
    mean_area_ = area > 0 ? area / static_cast<double>(units.size()) : 1;
    std::stable_sort(links_.begin(), links_.end(), [](const Link& a, const Link& b) { return a.corner < b.corner; });
    for (const Link& l : links_) ++first_[l.corner + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    axes_.resize(units.size());
    right_.resize(count_);
    system_ = BlockSystem(count_, pairs());
  }

  void round(double penalty) {
    start();
    for (std::int32_t c = 0; c + 1 < static_cast<std::int32_t>(first_.size()); ++c) eliminate(c, penalty);
    const std::vector<Vec3>& turns = system_.solve(right_);
    for (std::size_t u = 0; u < units_.size(); ++u)
      if (unknown_[u] != kNone) turn(u, turns[unknown_[u]]);
  }

 private:
  [[nodiscard]] std::span<const Link> at(std::int32_t c) const {
    return std::span(links_).subspan(first_[c], first_[c + 1] - first_[c]);
  }
  [[nodiscard]] const Vec3& normal(const Link& l) const { return units_[l.unit].normal; }
  [[nodiscard]] double weight(std::size_t u) const { return units_[u].trust * units_[u].scan.area / mean_area_; }

  /// Pairs of planes that share a corner, in the order in which `eliminate` comes to them.
  [[nodiscard]] std::vector<std::array<std::int32_t, 2>> pairs() const {
    std::vector<std::array<std::int32_t, 2>> all;
    for (std::int32_t c = 0; c + 1 < static_cast<std::int32_t>(first_.size()); ++c)
      for (const Link& l : at(c))
        for (const Link& m : at(c))
          if (unknown_[m.unit] != kNone && unknown_[m.unit] < unknown_[l.unit])
            all.push_back({unknown_[l.unit], unknown_[m.unit]});
    return all;
  }

  /// The terms of the planes alone.
  void start() {
    system_.clear();
    pair_ = 0;
    for (std::size_t u = 0; u < units_.size(); ++u) {
      const Unit& unit = units_[u];
      if (unknown_[u] == kNone) continue;
      const Axes axes = axes_[u] = axes_of(unit.normal);
      Mat3 h = Mat3::Zero();
      h.topLeftCorner<2, 2>() = axes.transpose() * unit.scan.spread * axes;
      h(2, 2) = 1;
      Vec3 b;
      b << -axes.transpose() * (unit.scan.spread * unit.normal), unit.normal.dot(unit.scan.centre) - unit.offset;
      const double size = places_.diagonal * places_.diagonal;
      system_.diagonal(unknown_[u]) = weight(u) * h + kDamping * Vec3(size, size, 1).asDiagonal().toDenseMatrix();
      right_[unknown_[u]] = weight(u) * b;
    }
  }

  /// The signed distance of a corner's start from a plane.
  [[nodiscard]] double miss(const Link& l) const {
    return normal(l).dot(places_.start[l.corner]) - units_[l.unit].offset;
  }

  /// Adds the cost of a corner to the equations of its planes. With the corner at its place of least cost, this cost is
  /// a quadratic form, with matrix `form_`, in the distances of the planes from the corner's start. The form needs no
  /// subtraction, so there is no cancellation if planes are nearly parallel or the penalty is high.
  void eliminate(std::int32_t c, double penalty) {
    const std::span<Link> links = std::span(links_).subspan(first_[c], first_[c + 1] - first_[c]);
    const auto n = static_cast<Eigen::Index>(links.size());
    if (n == 0) return;
    const double share = places_.base / std::max(places_.reach[c], kTiny);
    const double cost = kStep * share * share;
    form_.resize(n, n);
    off_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      off_[i] = miss(links[i]);
      for (Eigen::Index j = 0; j <= i; ++j) form_(i, j) = form_(j, i) = normal(links[i]).dot(normal(links[j])) / cost;
      form_(i, i) += 1 / penalty;
    }
    form_ = inverse_of_definite(form_);
    const Eigen::VectorXd pull = form_ * off_;
    Vec3 at = places_.start[c];
    for (Eigen::Index i = 0; i < n; ++i) at -= pull[i] / cost * normal(links[i]);
    for (Link& l : links)
      if (unknown_[l.unit] != kNone) l.slope << axes_[l.unit].transpose() * (at - units_[l.unit].scan.centre), -1.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::int32_t k = unknown_[links[i].unit];
      if (k == kNone) continue;
      right_[k] -= pull[i] * links[i].slope;
      for (Eigen::Index m = 0; m < n; ++m) {
        const std::int32_t j = unknown_[links[m].unit];
        if (j == kNone || j > k) continue;
        const Mat3 block = form_(i, m) * links[i].slope * links[m].slope.transpose();
        if (j == k) {
          system_.diagonal(k) += block;
        } else {
          system_.add(pair_++, block);
        }
      }
    }
  }

  void turn(std::size_t u, const Vec3& y) {
    Unit& unit = units_[u];
    const double by = std::hypot(y[0], y[1]), share = by > kMostTurn ? kMostTurn / by : 1;
    const double beyond = unit.offset - unit.normal.dot(unit.scan.centre) + y[2];
    unit.normal = (unit.normal + share * (axes_[u] * y.head<2>())).normalized();
    unit.offset = unit.normal.dot(unit.scan.centre) + beyond;
  }

  using Axes = Eigen::Matrix<double, 3, 2>;
  static Axes axes_of(const Vec3& n) {
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    Axes axes;
    axes.col(0) = n.cross(Vec3::Unit(axis)).normalized();
    axes.col(1) = n.cross(axes.col(0));
    return axes;
  }

  std::vector<Unit>& units_;
  const Places& places_;
  std::vector<Link> links_;          // by corner
  std::vector<std::int32_t> first_;  // by corner: where its links begin
  std::vector<std::int32_t> unknown_;
  std::int32_t count_ = 0;
  double mean_area_ = 1;
  std::vector<Axes> axes_;   // by unit: the directions in which its plane turns
  std::vector<Vec3> right_;  // by unknown
  std::size_t pair_ = 0;     // index of the next pair of `pairs`
  BlockSystem system_;
  Eigen::MatrixXd form_;  // matrix of the current corner
  Eigen::VectorXd off_;
};

}  // namespace

void weigh(std::vector<Unit>& units, double base) {
  const double usual = usual_noise(units);
  for (Unit& u : units) {
    const double quiet = kQuiet * base / std::max({u.noise, usual, kTiny});
    u.trust = std::clamp(std::pow(quiet, kPower), 1.0, kMostTrust);
  }
}

void weigh_again(std::vector<Unit>& units) {
  const double most = kTooFar * std::max(usual_noise(units), kTiny);
  for (Unit& u : units) {
    if (u.is_fixed() || u.free) continue;
    const double beyond = u.offset - u.normal.dot(u.scan.centre);
    const double moved = u.normal.dot(u.scan.spread * u.normal) + beyond * beyond - u.noise * u.noise;
    u.trust *= std::clamp(moved / (most * most), 1.0, kDearer);
  }
}

void fit(std::vector<Unit>& units, const Places& places, const Kept& kept, const Schedule& schedule, const Job& job) {
  Solver solver(units, places, kept);
  for (int k = 0; k < schedule.rounds; ++k) {
    job.poll();
    solver.round(schedule.from * std::pow(schedule.to / schedule.from, k / (schedule.rounds - 1.0)));
  }
}

}  // namespace isimp::meshing::planar
