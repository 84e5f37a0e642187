#include "place/rims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "complex/raggedness.h"
#include "isimp/core/symmetric.h"
#include "place/moves.h"

namespace isimp::meshing {
namespace {

// tuned real
constexpr double kEnds = 0.1;            // share of a border at each end that does not count for its line
constexpr double kOneLineSine = 0.35;    // sine of 20 degrees: lines that meet at less count as one line
constexpr std::size_t kLeastPoints = 4;  // vertices of a border that has a line

/// The border along a chord of a chart, in the order of the loop.
std::vector<Vec3> border_along(const State& s, std::int32_t chart, std::size_t chord) {
  const auto loop = s.complex.loop(chart);
  const auto chords = s.complex.chords(chart);
  const std::int32_t last = chords[(chord + 1) % chords.size()];
  std::size_t at = std::find(loop.begin(), loop.end(), chords[chord]) - loop.begin();
  std::vector<Vec3> line;
  do {
    line.push_back(s.mesh.vertices()[s.mesh.from(loop[at])]);
    at = at + 1 == loop.size() ? 0 : at + 1;
  } while (loop[at] != last && line.size() <= loop.size());
  line.push_back(s.mesh.vertices()[s.mesh.from(last)]);
  return line;
}

struct Line {
  Vec3 point, direction;
};

/// The line through the middle of a border, in the plane of a chart. Source: least squares, reweighted by the distance.
std::optional<Line> line_through(std::vector<Vec3> border, const Plane& plane, double reach) {
  const Along along(border);
  const double length = along.length();
  std::vector<Vec3> points;
  if (border.size() < kLeastPoints || !(length > 0)) return std::nullopt;
  for (int i = 0; i < kSamples; ++i) {
    const Vec3 p = along.at(length * (kEnds + (1 - 2 * kEnds) * i / (kSamples - 1)));
    points.push_back(p - plane.normal * plane.normal.dot(p - plane.centre));
  }
  std::vector<double> weight(points.size(), 1.0);
  Line line{};
  for (int round = 0; round < 4; ++round) {
    Vec3 mean = Vec3::Zero();
    double all = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      mean += weight[i] * points[i];
      all += weight[i];
    }
    mean /= all;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i)
      spread += weight[i] * (points[i] - mean) * (points[i] - mean).transpose();
    line = {mean, direct_spectrum_of(spread).vectors.col(2)};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 d = points[i] - mean;
      const double off = (d - line.direction * line.direction.dot(d)).squaredNorm() / (reach * reach);
      weight[i] = 1 / ((1 + off) * (1 + off));
    }
  }
  return line;
}

/// Chooses places for corners at the rim.
class Straightener {
 public:
  Straightener(const State& state, double reach) : s_(state), reach_(reach), rims_(state.corners.count()) {
    for (std::int32_t l = 0; l < s_.labels.chart_count(); ++l) {
      if (s_.polygons.count_of(l) == 0) continue;
      const auto chords = s_.complex.chords(l);
      for (std::size_t i = 0; i < chords.size(); ++i) {
        if (s_.mesh.opposite(chords[i]) != kNone) continue;
        const auto line = line_through(border_along(s_, l, i), s_.planes[l], reach_);
        for (const std::int32_t v : {s_.mesh.from(chords[i]), s_.mesh.from(chords[(i + 1) % chords.size()])}) {
          const std::int32_t c = s_.corners.of_vertex[v];
          if (c != kNone) rims_[c].push_back({line, l});
        }
      }
    }
  }

  /// The new place of a corner; nullopt if it stays.
  [[nodiscard]] std::optional<Vec3> place_of(std::int32_t c) const {
    const std::vector<Rim>& rims = rims_[c];
    if (rims.size() != 2 || !rims[0].line || !rims[1].line || !(s_.corners.radius[c] > 0)) return std::nullopt;
    const auto around = s_.polygons.at(c);
    std::optional<Vec3> to;
    if (around.size() == 1) to = meeting(c);
    if (around.size() == 2) to = on_shared_edge(c);
    const double most = std::min(reach_, s_.options.reach * s_.mesh.diagonal());
    if (!to || !((*to - s_.mesh.vertices()[s_.corners.vertex[c]]).norm() <= most)) return std::nullopt;
    return to;
  }

 private:
  struct Rim {
    std::optional<Line> line;
    std::int32_t chart;
  };

  /// Where both lines meet; between them where they are nearly one.
  [[nodiscard]] std::optional<Vec3> meeting(std::int32_t c) const {
    const Line &a = *rims_[c][0].line, &b = *rims_[c][1].line;
    const Vec3& n = s_.planes[rims_[c][0].chart].normal;
    const Vec3 &at = s_.corners.position[c], across = n.cross(b.direction);
    const double sine = a.direction.dot(across);
    const auto onto = [&](const Line& l) -> Vec3 { return l.point + l.direction * l.direction.dot(at - l.point); };
    if (std::abs(sine) < kOneLineSine) return (onto(a) + onto(b)) / 2;
    return a.point + a.direction * ((b.point - a.point).dot(across) / sine);
  }

  /// The place nearest to both lines on the edge that two polygons share.
  [[nodiscard]] std::optional<Vec3> on_shared_edge(std::int32_t c) const {
    const auto around = s_.polygons.at(c);
    std::int32_t other = kNone;
    for (const std::int32_t d : beside(around[0], c))
      for (const std::int32_t e : beside(around[1], c))
        if (d == e) other = d;
    if (other == kNone) return std::nullopt;
    const Vec3& at = s_.corners.position[c];
    const Vec3 edge = (at - s_.corners.position[other]).normalized();
    double numerator = 0, denominator = 0;
    for (const Rim& rim : rims_[c]) {
      const auto across = [&](const Vec3& d) -> Vec3 { return d - rim.line->direction * rim.line->direction.dot(d); };
      const Vec3 step = across(edge), off = across(rim.line->point - at);
      numerator += step.dot(off);
      denominator += step.squaredNorm();
    }
    if (denominator < 2 * kOneLineSine * kOneLineSine) return std::nullopt;
    return at + edge * (numerator / denominator);
  }

  [[nodiscard]] std::array<std::int32_t, 2> beside(std::int32_t q, std::int32_t c) const {
    const auto loop = s_.polygons.of(q);
    const std::size_t n = loop.size(), i = std::find(loop.begin(), loop.end(), c) - loop.begin();
    return {loop[(i + n - 1) % n], loop[(i + 1) % n]};
  }

  const State& s_;
  double reach_;
  std::vector<std::vector<Rim>> rims_;  // by corner: the chords at the border that end there
};

}  // namespace

void straighten_rims(State& state, Defects& defects, Job& job) {
  const double reach = state.complex.tolerance.rim;
  if (!(reach > 0)) return;
  const Straightener straightener(state, reach);
  std::vector<Move> moves;
  for (std::int32_t c = 0; c < state.corners.count(); ++c)
    if (const std::optional<Vec3> to = straightener.place_of(c)) moves.push_back({c, *to});
  move_corners(state, defects, moves, job);
}

RimReport rims_of(const State& state) {
  RimReport report;
  report.reach = state.complex.tolerance.rim;
  if (!(report.reach > 0)) return report;
  for (std::int32_t l = 0; l < state.labels.chart_count(); ++l) {
    if (state.polygons.count_of(l) == 0) continue;
    const auto chords = state.complex.chords(l);
    const auto position = [&](std::size_t i) -> const Vec3& {
      return state.corners.position[state.corners.of_vertex[state.mesh.from(chords[i % chords.size()])]];
    };
    for (std::size_t i = 0; i < chords.size(); ++i) {
      if (state.mesh.opposite(chords[i]) != kNone) continue;
      const Vec3 &a = position(i), &b = position(i + 1);
      const Vec3 along = (b - a).normalized(), inward = state.planes[l].normal.cross(along);
      const std::vector<Vec3> border = border_along(state, l, i);
      for (std::size_t k = 0; k + 1 < border.size(); ++k) {
        const double width = along.dot(border[k + 1] - border[k]);  // below 0 where the border turns back
        const double y = inward.dot(border[k] - a), z = inward.dot(border[k + 1] - a);
        // A trapezium with ends y and z has a part above and a part below the chord.
        const double up = std::max(y, 0.0) + std::max(z, 0.0), down = std::max(-y, 0.0) + std::max(-z, 0.0);
        const double cut = y * z < 0 ? up / (up + down) : 1.0;
        report.area_added += width / 2 * up * (y * z < 0 ? cut : 1.0);
        report.area_lost += width / 2 * down * (y * z < 0 ? 1 - cut : 1.0);
      }
      ++report.edges;
    }
  }
  return report;
}

}  // namespace isimp::meshing
