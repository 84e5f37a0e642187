#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "patches.h"

namespace isimp::curved {
namespace {

constexpr double kSquare = 0.1;    ///< cosine of the axes of a pipe and its bend
constexpr double kSameRadius = 3;  ///< times the nearness
constexpr std::int32_t kMostOfPipe = 128;
constexpr int kLeastEdges = 6;  ///< least number of edges of a common border

/// The mean square distance of an arc of radius 1 from its chord through the mean.
double of_chord(double angle) {
  const double sinc = std::sin(angle / 2) / (angle / 2);
  return 0.5 + std::sin(angle) / (2 * angle) - sinc * sinc;
}

/// The middle and the mean radius of a closed profile.
struct Tube {
  Vec2 middle = Vec2::Zero();
  double radius = 0;
};

Tube tube_of(const CurvedProxy& bend) {
  Tube t;
  double length = 0;
  const std::size_t n = corners(bend);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = corner(bend, i), b = corner(bend, (i + 1) % n);
    t.middle += (b - a).norm() * (a + b) / 2;
    length += (b - a).norm();
  }
  t.middle /= length;
  for (std::size_t i = 0; i < n; ++i) t.radius += (corner(bend, i) - t.middle).norm() / static_cast<double>(n);
  return t;
}

/// Where a profile crosses the ray from the tube's middle at an angle from the axis.
struct Crossing {
  std::size_t edge = 0;
  Vec2 place = Vec2::Zero();
};

Crossing crossing(const CurvedProxy& bend, const Tube& tube, double angle) {
  const Vec2 ray(std::sin(angle), std::cos(angle)), beside(ray.y(), -ray.x());
  const std::size_t n = corners(bend);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = corner(bend, i) - tube.middle, b = corner(bend, (i + 1) % n) - tube.middle;
    const double da = a.dot(beside), db = b.dot(beside);
    if (da * db > 0 || da == db) continue;
    const Vec2 p = a + da / (da - db) * (b - a);
    if (p.dot(ray) > 0) return {i, tube.middle + p};
  }
  return {0, corner(bend, 0)};
}

/// Turns the corners of a profile so that it begins at an angle, and puts knots at equal angles from there on.
void set_knots(CurvedProxy& bend, const Tube& tube, std::int32_t rings) {
  const double width = kTurn / rings;
  const Crossing first = crossing(bend, tube, -width / 2);
  std::vector<double> profile = {first.place.x(), first.place.y()};
  const std::size_t n = corners(bend);
  for (std::size_t k = 1; k <= n; ++k) {
    const Vec2 c = corner(bend, (first.edge + k) % n);
    profile.insert(profile.end(), {c.x(), c.y()});
  }
  bend.profile = std::move(profile);
  std::vector<double> knots;
  double total = 0;
  for (std::size_t i = 0; i < corners(bend); ++i)
    total += (corner(bend, (i + 1) % corners(bend)) - corner(bend, i)).norm();
  for (std::int32_t k = 1; k < rings; ++k) {
    const Crossing at = crossing(bend, tube, (k - 0.5) * width);
    knots.push_back(along(bend, {at.place.x(), at.place.y(), Vec3::Zero()}));
  }
  std::sort(knots.begin(), knots.end());
  knots.insert(knots.begin(), 0.0);
  knots.push_back(total);
  bend.knots = std::move(knots);
  bend.rings = rings;
}

/// A bend and the straight pipes at its ends.
struct Run {
  std::size_t bend = 0;
  std::vector<std::size_t> pipes;
};

class Pipes {
 public:
  Pipes(const Faces& faces, Scene& scene, double distance) : f_(faces), s_(scene), distance_(distance) {}

  std::vector<bool> run() {
    std::vector<bool> done(s_.patches.size(), false);
    for (const Run& r : runs()) {
      const bool is_free =
          !done[r.bend] && std::none_of(r.pipes.begin(), r.pipes.end(), [&](std::size_t k) { return done[k]; });
      if (!is_free || r.pipes.empty() || !choose(r)) continue;
      done[r.bend] = true;
      for (const std::size_t k : r.pipes) done[k] = true;
    }
    return done;
  }

 private:
  [[nodiscard]] std::vector<Run> runs() const {
    std::vector<std::int32_t> patch(s_.found.size(), kNone);
    for (std::size_t k = 0; k < s_.patches.size(); ++k) patch[s_.patches[k].found] = static_cast<std::int32_t>(k);
    std::vector<Run> all;
    for (std::size_t k = 0; k < s_.patches.size(); ++k) {
      const CurvedProxy& bend = s_.patches[k].proxy;
      if (bend.kind != CurvedKind::revolution || !bend.closed || bend.full) continue;
      std::map<std::int32_t, int> beside;
      for (const std::int32_t i : s_.patches[k].faces.face)
        for (const std::int32_t j : f_.graph().neighbours[i])
          if (j != f_.size() && s_.label[j] != kNone && patch[s_.label[j]] != kNone) ++beside[patch[s_.label[j]]];
      Run run{k, {}};
      const double radius = tube_of(bend).radius;
      for (const auto& [other, edges] : beside) {
        const CurvedProxy& p = s_.patches[other].proxy;
        if (p.kind == CurvedKind::cylinder && p.full && edges >= kLeastEdges &&
            std::abs(p.axis.dot(bend.axis)) < kSquare && std::abs(p.radius - radius) < kSameRadius * distance_)
          run.pipes.push_back(static_cast<std::size_t>(other));
      }
      all.push_back(std::move(run));
    }
    return all;
  }

  [[nodiscard]] double area(std::size_t patch) const {
    double sum = 0;
    for (const double a : s_.patches[patch].faces.area) sum += a;
    return sum;
  }

  /// Segments of the pipes, which are the rings of the bend, and segments of the bend.
  bool choose(const Run& run) {
    RoundPatch& bend = s_.patches[run.bend];
    const Tube tube = tube_of(bend.proxy);
    double cells = bend.cells, all = area(run.bend);
    for (const std::size_t k : run.pipes) {
      cells += s_.patches[k].cells;
      all += area(k);
    }
    std::int32_t rings = 0, segments = 0;
    double least = 0;
    for (std::int32_t n = 3; n <= kMostOfPipe; ++n)
      for (std::int32_t m = 1; m <= kMostOfPipe; ++m) {
        if (n * (m + static_cast<double>(run.pipes.size())) > kMoreCells * cells + kHalfCell) break;
        if (rings > 0 && tube.radius * (1 - std::cos(std::numbers::pi / n)) < bend.faces.rough) break;
        const double cost = all * tube.radius * tube.radius * of_chord(kTurn / n) +
                            area(run.bend) * tube.middle.squaredNorm() / 2 * of_chord(bend.proxy.span / m);
        if (rings > 0 && cost >= least) continue;
        least = cost;
        rings = n;
        segments = m;
      }
    if (rings == 0) return false;
    bend.together = static_cast<std::int32_t>(run.bend);
    set_knots(bend.proxy, tube, rings);
    bend.proxy.segments = segments;
    bend.faces = PatchFaces(f_, bend.proxy, std::move(bend.faces.face));
    for (const std::size_t k : run.pipes) {
      RoundPatch& pipe = s_.patches[k];
      pipe.together = bend.together;
      CurvedProxy& p = pipe.proxy;
      p.across = (bend.proxy.axis - bend.proxy.axis.dot(p.axis) * p.axis).normalized();
      pipe.faces = PatchFaces(f_, p, std::move(pipe.faces.face));
      apply(p, Cuts(p, pipe.faces).of(rings, 1, pipe.cells));
    }
    return true;
  }

  const Faces& f_;
  Scene& s_;
  double distance_;
};

}  // namespace

std::vector<bool> choose_pipes(const Faces& faces, Scene& scene, double distance) {
  return Pipes(faces, scene, distance).run();
}

}  // namespace isimp::curved
