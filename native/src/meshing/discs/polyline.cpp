#include "discs/polyline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "isimp/core/symmetric.h"

namespace isimp::meshing {
namespace {

void split(std::span<const Vec3> line, std::size_t offset, double reach, bool always, std::vector<std::size_t>& kept) {
  if (line.size() < 3) return;
  const auto [distance, where] = farthest(line);
  if (distance <= reach && !always) return;
  split(line.first(where + 1), offset, reach, false, kept);
  kept.push_back(offset + where);
  split(line.subspan(where), offset + where, reach, false, kept);
}

/// Sum of the squared distances of points first ... last from the segment between these two.
double misfit(std::span<const Vec3> line, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t i = first + 1; i < last; ++i) sum += squared_distance(line[i], line[first], line[last]);
  return sum;
}

bool fits(std::span<const Vec3> line, std::size_t first, std::size_t last, double reach) {
  for (std::size_t i = first + 1; i < last; ++i)
    if (squared_distance(line[i], line[first], line[last]) > reach * reach) return false;
  return true;
}

/// Moves each kept point to where the two chords that meet there fit best, while both stay within reach.
void slide(std::span<const Vec3> line, double reach, std::vector<std::size_t>& kept) {
  // tuned unrecorded
  constexpr std::size_t kFar = 8;  // limit: points that are tried on each side
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::size_t before = i > 0 ? kept[i - 1] : 0, after = i + 1 < kept.size() ? kept[i + 1] : line.size() - 1;
    const std::size_t low = std::max(before + 1, kept[i] > kFar ? kept[i] - kFar : 0),
                      high = std::min(after - 1, kept[i] + kFar);
    double least = misfit(line, before, kept[i]) + misfit(line, kept[i], after);
    const std::size_t old = kept[i];
    for (std::size_t k = low; k <= high; ++k) {
      if (k == old) continue;
      const double m = misfit(line, before, k) + misfit(line, k, after);
      if (m >= least * (1 - 1e-9) || !fits(line, before, k, reach) || !fits(line, k, after, reach)) continue;
      least = m;
      kept[i] = k;
    }
  }
}

constexpr double kNearlyFarthest =
    0.96;  // tuned unrecorded: of the square distance, of points that are nearly farthest
// tuned real
constexpr double kWithin = 0.9;  // share of a ragged line that is within reach of the straight line along it

struct StraightLine {
  Vec3 point, direction;
  [[nodiscard]] double squared_distance(const Vec3& p) const {
    const Vec3 d = p - point;
    return (d - direction * direction.dot(d)).squaredNorm();
  }
};

/// The straight line of least squares along a polyline.
StraightLine along(std::span<const Vec3> line) {
  double all = 0;
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = (line[i + 1] - line[i]).norm();
    mean += length * (line[i] + line[i + 1]) / 2;
    all += length;
  }
  if (!(all > 0)) return {line.front(), Vec3::Zero()};
  mean /= all;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3 d = line[i + 1] - line[i], middle = (line[i] + line[i + 1]) / 2 - mean;
    spread += d.norm() * (middle * middle.transpose() + d * d.transpose() / 12);
  }
  return {mean, direct_spectrum_of(spread).vectors.col(2)};
}

/// The distance from the straight line along it within which most of a polyline's length is.
double most_within(std::span<const Vec3> line) {
  struct Segment {
    double distance, length;
  };
  const StraightLine straight = along(line);
  std::vector<Segment> segments;
  double all = 0, before = straight.squared_distance(line.front());
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = (line[i + 1] - line[i]).norm(), after = straight.squared_distance(line[i + 1]);
    segments.push_back({std::max(before, after), length});
    all += length;
    before = after;
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.distance < b.distance; });
  double sum = 0;
  for (const Segment& p : segments)
    if ((sum += p.length) >= kWithin * all) return std::sqrt(p.distance);
  return segments.empty() ? 0.0 : std::sqrt(segments.back().distance);
}

}  // namespace

double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double l = d.squaredNorm();
  const double t = l > 0 ? std::clamp((p - a).dot(d) / l, 0.0, 1.0) : 0.0;
  return (p - a - t * d).squaredNorm();
}

Farthest farthest(std::span<const Vec3> line) {
  const Vec3 &a = line.front(), &b = line.back();
  double most = -1;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) most = std::max(most, squared_distance(line[i], a, b));
  if (most < 0) return {-1, 0};
  std::size_t where = line.size() / 2;
  double size = 0;
  for (const Vec3& p : line) size = std::max(size, (p - a).squaredNorm());
  if (most <= 1e-18 * size) return {std::sqrt(most), where};
  double longest = -1;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    if (squared_distance(line[i], a, b) < kNearlyFarthest * most) continue;
    const double way = (line[i] - a).norm() + (line[i] - b).norm();
    if (way <= longest * (1 + 1e-12)) continue;
    longest = way;
    where = i;
  }
  return {std::sqrt(most), where};
}

void take_out_zigzag(std::span<Vec3> line) {
  const std::size_t n = line.size();
  const auto turn_at = [&](std::size_t i) -> Vec3 { return line[i - 1] - 2 * line[i] + line[i + 1]; };
  if (n < 4) return;
  Vec3 before = Vec3::Zero(), turn = turn_at(1);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vec3 after = i + 2 < n ? turn_at(i + 1) : Vec3(Vec3::Zero());
    // The amount by which the neighbours turn the other way.
    const double against = std::max({0.0, -before.dot(turn), -after.dot(turn)});
    if (against > 0) line[i] += turn / 4 * std::min(1.0, against / turn.squaredNorm());
    before = turn;
    turn = after;
  }
}

Vec3 area_left_out(std::span<const Vec3> line) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < line.size(); ++i) sum += (line[i] - line[0]).cross(line[i + 1] - line[0]);
  return sum / 2;
}

std::vector<std::size_t> simplify(std::span<const Vec3> line, double reach) {
  std::vector<std::size_t> kept;
  const bool closed = line.front() == line.back();
  split(line, 0, reach, closed, kept);
  slide(line, reach, kept);
  return kept;
}

std::vector<std::size_t> simplify_ragged(std::span<const Vec3> line, double reach) {
  std::vector<std::size_t> kept = simplify(line, reach / 2);
  const std::size_t least = line.front() == line.back() ? 1 : 0, last = line.size() - 1;
  std::vector<double> without(kept.size());
  const auto measure = [&](std::size_t i) {
    const std::size_t first = i > 0 ? kept[i - 1] : 0, end = i + 1 < kept.size() ? kept[i + 1] : last;
    without[i] = most_within(line.subspan(first, end - first + 1));
  };
  for (std::size_t i = 0; i < kept.size(); ++i) measure(i);
  while (kept.size() > least) {
    const auto i = static_cast<std::size_t>(std::min_element(without.begin(), without.end()) - without.begin());
    if (without[i] > reach) break;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    if (i > 0) measure(i - 1);
    if (i < kept.size()) measure(i);
  }
  return kept;
}

}  // namespace isimp::meshing
