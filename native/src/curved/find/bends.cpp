// The bend between two pipes. Few points with noisy normals give no axis of a short bend, but its pipes do.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "find/find.h"
#include "fit/numbers.h"
#include "fit/surfaces.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr double kWidest = 8;     ///< radius of a bend, over that of the pipe
constexpr int kRadiusSteps = 80;  ///< work: number of tries of the radius

/// Two pipes whose axes meet, and the bend of one radius between them.
struct Bend {
  Vec3 meet, first, second;  ///< where the axes meet; unit, from there along the pipes
  Vec3 axis;
  double tube = 0, radius = 0;

  [[nodiscard]] double half() const { return std::acos(std::clamp(first.dot(second), -1.0, 1.0)) / 2; }
  [[nodiscard]] Vec3 centre() const { return meet + radius / std::sin(half()) * (first + second).normalized(); }
  /// Whether a point is before the ends of both pipes.
  [[nodiscard]] bool is_between(const Vec3& x) const {
    const double end = radius / std::tan(half());
    return (x - meet).dot(first) < end && (x - meet).dot(second) < end;
  }
};

CurvedSurface surface_of(const Bend& bend, double side) {
  CurvedSurface s;
  s.kind = CurvedKind::revolution;
  s.point = bend.centre();
  s.axis = bend.axis;
  s.radius = bend.radius + bend.tube;
  s.closed = true;
  s.side = side;
  for (int k = 0; k < kCorners; ++k) {
    const double angle = kTurn * k / kCorners;
    s.profile.insert(s.profile.end(), {bend.radius + bend.tube * std::cos(angle), bend.tube * std::sin(angle)});
  }
  return s;
}

class Bends {
 public:
  Bends(std::vector<Found> found, const Points& points, const Nearness& near)
      : found_(std::move(found)), p_(points), near_(near) {}

  std::vector<Found> run() {
    while (const auto next = largest()) add(next->first, next->second);
    return std::move(found_);
  }

 private:
  [[nodiscard]] bool is_pipe(std::size_t k) const {
    return found_[k].surface.kind == CurvedKind::cylinder &&
           turn_share(found_[k].surface, samples_of(p_, found_[k].points)) > kMost;
  }
  /// The largest pipes with a bend between them that was not tried yet. Small cylinders in a bend lose their points to it
  /// before they count as pipes.
  std::optional<std::pair<std::size_t, std::size_t>> largest() {
    Some pipes;
    for (std::size_t k = 0; k < found_.size(); ++k)
      if (is_pipe(k)) pipes.push_back(static_cast<std::int32_t>(k));
    std::stable_sort(pipes.begin(), pipes.end(),
                     [&](std::int32_t a, std::int32_t b) { return found_[a].area > found_[b].area; });
    for (std::size_t j = 1; j < pipes.size(); ++j)
      for (std::size_t i = 0; i < j; ++i) {
        const std::optional<Bend> bend = between(pipes[i], pipes[j]);
        if (!bend) continue;
        const auto is_known = [&](const Vec3& meet) { return !((meet - bend->meet).norm() > bend->tube); };
        if (std::any_of(met_.begin(), met_.end(), is_known)) continue;
        met_.push_back(bend->meet);
        return std::pair<std::size_t, std::size_t>(pipes[i], pipes[j]);
      }
    return std::nullopt;
  }

  [[nodiscard]] Vec3 middle(std::size_t k) const {
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t i : found_[k].points) sum += p_.area[i] * p_.centre[i];
    return sum / std::max(p_.area_of(found_[k].points), kTiny);
  }

  [[nodiscard]] std::optional<Bend> between(std::size_t i, std::size_t j) const {
    const CurvedSurface &a = found_[i].surface, &b = found_[j].surface;
    if (a.side != b.side || a.axis.cross(b.axis).norm() < kSquare ||
        std::abs(a.radius - b.radius) > kAlike * near_.distance)
      return std::nullopt;
    const Vec3 across = a.axis.cross(b.axis).normalized(), to = b.point - a.point;
    if (std::abs(to.dot(across)) > kAlike * near_.distance) return std::nullopt;
    const double cosine = a.axis.dot(b.axis), square = 1 - cosine * cosine;
    const double along = (to.dot(a.axis) - cosine * to.dot(b.axis)) / square;
    Bend bend;
    bend.meet = a.point + along * a.axis + to.dot(across) / 2 * across;
    bend.first = (middle(i) - bend.meet).dot(a.axis) < 0 ? Vec3(-a.axis) : a.axis;
    bend.second = (middle(j) - bend.meet).dot(b.axis) < 0 ? Vec3(-b.axis) : b.axis;
    bend.axis = bend.first.cross(bend.second).normalized();
    bend.tube = (a.radius + b.radius) / 2;
    double most = 0;
    Bend best = bend;
    for (int k = 0; k <= kRadiusSteps; ++k) {
      bend.radius = bend.tube * std::pow(kWidest, static_cast<double>(k) / kRadiusSteps);
      const double now = score(bend, i, j);
      if (now <= most) continue;
      most = now;
      best = bend;
    }
    return most > 0 ? std::optional(best) : std::nullopt;
  }

  /// The area that the pipes and the bend explain together, less where it is further away.
  [[nodiscard]] double score(const Bend& bend, std::size_t i, std::size_t j) const {
    const Vec3 centre = bend.centre();
    double sum = 0;
    const auto add = [&](std::int32_t p, double distance) {
      sum += p_.area[p] * std::max(0.0, 1 - std::pow(distance / near_.distance, 2));
    };
    const auto of_bend = [&](const Vec3& x) {
      const Vec3 v = x - centre;
      const double z = v.dot(bend.axis);
      return std::hypot((v - z * bend.axis).norm() - bend.radius, z) - bend.tube;
    };
    for (std::int32_t p = 0; p < p_.count(); ++p) {
      if (p_.area[p] <= 0) continue;
      if (bend.is_between(p_.centre[p])) add(p, of_bend(p_.centre[p]));
    }
    for (const std::size_t k : {i, j}) {
      const Locator on(found_[k].surface);
      for (const std::int32_t p : found_[k].points)
        if (!bend.is_between(p_.centre[p])) add(p, on.residual(p_.centre[p]).distance);
    }
    return sum;
  }

  /// Fits a pipe to its points outside a bend, since those inside turn its axis.
  void fit_again(std::size_t k, const Bend& bend) {
    Some some = found_[k].points;
    std::erase_if(some, [&](std::int32_t i) { return bend.is_between(p_.centre[i]); });
    if (some.size() < kLeastPoints) return;
    if (const auto again = fit(CurvedKind::cylinder, samples_of(p_, some))) found_[k].surface = *again;
  }

  /// Adds the bend of two pipes with its points, which other surfaces lose.
  void add(std::size_t first, std::size_t second) {
    Bend bend = *between(first, second);
    for (int round = 0; round < 2; ++round) {
      fit_again(first, bend);
      fit_again(second, bend);
      if (const std::optional<Bend> better = between(first, second)) bend = *better;
    }
    Found now{surface_of(bend, found_[first].surface.side), {}, 0, 0};
    std::vector<bool> is_mine(p_.area.size(), false);
    const Locator on(now.surface);
    for (std::int32_t i = 0; i < p_.count(); ++i) {
      if (p_.area[i] <= 0 || !bend.is_between(p_.centre[i])) continue;
      if (!near_.has(on.residual(p_.centre[i]), p_.normal[i], kReach, kReach)) continue;
      is_mine[i] = true;
      now.points.push_back(i);
    }
    now.area = p_.area_of(now.points);
    if (now.area < kSpeck) return;
    now.rms = rms(now.surface, samples_of(p_, now.points));
    for (Found& f : found_) {
      std::erase_if(f.points, [&](std::int32_t i) { return is_mine[i]; });
      const double left = p_.area_of(f.points), between = area_between(f, bend);
      if (left < kHalf * f.area || (!f.is_plane() && between > kHalf * left)) f.points.clear();
      f.area = left;
    }
    std::erase_if(found_, [](const Found& f) { return f.points.empty(); });
    found_.push_back(std::move(now));
  }

  [[nodiscard]] double area_between(const Found& f, const Bend& bend) const {
    double area = 0;
    for (const std::int32_t i : f.points) area += bend.is_between(p_.centre[i]) ? p_.area[i] : 0;
    return area;
  }

  std::vector<Found> found_;
  std::vector<Vec3> met_;  // where the axes of pipes meet whose bend was tried
  const Points& p_;
  const Nearness& near_;
};

}  // namespace

std::vector<Found> with_bends(std::vector<Found> found, const Points& points, const Nearness& near) {
  return Bends(std::move(found), points, near).run();
}

}  // namespace isimp::curved
