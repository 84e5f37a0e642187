#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "cells/patches.h"
#include "fit/numbers.h"

namespace isimp::curved {
namespace {

constexpr std::int32_t kMostOfPipe = 128;  // limit

/// Makes the profile of a bend a circle with corners at its knots, which are at equal angles, the first half a width from
/// the axis: a pipe of the same radius has its edges there.
void set_knots(CurvedProxy& bend, const Tube& tube, std::int32_t rings) {
  double area = 0;
  const std::size_t n = corners(bend);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = corner(bend, i), b = corner(bend, (i + 1) % n);
    area += a.x() * b.y() - a.y() * b.x();
  }
  const std::int32_t of_ring = kCorners / rings + 1, count = of_ring * rings;
  const double step = (area < 0 ? 1 : -1) * kTurn / count, edge = 2 * tube.radius * std::sin(kTurn / count / 2);
  bend.profile.clear();
  for (std::int32_t k = 0; k < count; ++k) {
    const double angle = -kTurn / rings / 2 + k * step;
    bend.profile.insert(bend.profile.end(), {tube.middle.x() + tube.radius * std::sin(angle),
                                             tube.middle.y() + tube.radius * std::cos(angle)});
  }
  bend.knots.clear();
  for (std::int32_t k = 0; k <= rings; ++k) bend.knots.push_back(k * of_ring * edge);
  bend.rings = rings;
}

/// Makes a pipe meet its bend exactly: its axis is square to that of the bend, at its height and at its radius.
void align(CurvedProxy& pipe, const CurvedProxy& bend, const Tube& tube) {
  pipe.axis = (pipe.axis - pipe.axis.dot(bend.axis) * bend.axis).normalized();
  const Vec3 from = pipe.point - bend.point, out = pipe.axis.cross(bend.axis);
  const double far = from.dot(out) < 0 ? -tube.middle.x() : tube.middle.x();
  pipe.point += (far - from.dot(out)) * out + (tube.middle.y() - from.dot(bend.axis)) * bend.axis;
  pipe.radius = tube.radius;
  pipe.across = bend.axis;
}

/// A bend and the straight pipes at its ends.
struct PipeRun {
  std::size_t bend = 0;
  std::vector<std::size_t> pipes;
};

class Pipes {
 public:
  Pipes(const Faces& faces, Scene& scene, double distance) : f_(faces), s_(scene), distance_(distance) {}

  std::vector<bool> run() {
    std::vector<bool> done(s_.patches.size(), false);
    for (const PipeRun& r : runs()) {
      const bool is_free =
          !done[r.bend] && std::none_of(r.pipes.begin(), r.pipes.end(), [&](std::size_t k) { return done[k]; });
      if (!is_free || r.pipes.empty() || !choose(r)) continue;
      done[r.bend] = true;
      for (const std::size_t k : r.pipes) done[k] = true;
    }
    return done;
  }

 private:
  [[nodiscard]] std::vector<PipeRun> runs() const {
    std::vector<std::int32_t> patch(s_.found.size(), kNone);
    for (std::size_t k = 0; k < s_.patches.size(); ++k) patch[s_.patches[k].found] = static_cast<std::int32_t>(k);
    std::vector<PipeRun> all;
    for (std::size_t k = 0; k < s_.patches.size(); ++k) {
      const CurvedProxy& bend = s_.patches[k].proxy;
      if (bend.kind != CurvedKind::revolution || !bend.closed || bend.full) continue;
      std::set<std::int32_t> beside;
      for (const std::int32_t i : s_.patches[k].faces.face)
        for (const std::int32_t j : f_.graph().neighbours[i])
          if (j != f_.size() && s_.label[j] != kNone && patch[s_.label[j]] != kNone) beside.insert(patch[s_.label[j]]);
      PipeRun run{k, {}};
      const double radius = tube_of(bend).radius;
      for (const std::int32_t other : beside) {
        const CurvedProxy& p = s_.patches[other].proxy;
        if (p.kind == CurvedKind::cylinder && p.full && std::abs(p.axis.dot(bend.axis)) < kSquare &&
            std::abs(p.radius - radius) < kAlike * distance_)
          run.pipes.push_back(static_cast<std::size_t>(other));
      }
      all.push_back(std::move(run));
    }
    return all;
  }

  /// Makes the axis of a bend square to the axes of its pipes, which are longer.
  void square_to_pipes(const PipeRun& run) {
    if (run.pipes.size() < 2) return;
    CurvedProxy& bend = s_.patches[run.bend].proxy;
    const Vec3 axis = s_.patches[run.pipes[0]].proxy.axis.cross(s_.patches[run.pipes[1]].proxy.axis);
    if (axis.norm() < kSquare) return;
    bend.axis = axis.dot(bend.axis) < 0 ? Vec3(-axis.normalized()) : axis.normalized();
    bend.across = (bend.across - bend.across.dot(bend.axis) * bend.axis).normalized();
  }

  /// Segments of the pipes, which are the rings of the bend, and segments of the bend.
  bool choose(const PipeRun& run) {
    RoundPatch& bend = s_.patches[run.bend];
    const Tube tube = tube_of(bend.proxy);
    double cells = bend.cells, all = bend.faces.whole;
    for (const std::size_t k : run.pipes) {
      cells += s_.patches[k].cells;
      all += s_.patches[k].faces.whole;
    }
    std::int32_t rings = 0, segments = 0;
    double least = 0;
    for (std::int32_t n = 3; n <= kMostOfPipe; ++n)
      for (std::int32_t m = 1; m <= kMostOfPipe; ++m) {
        if (n * (m + static_cast<double>(run.pipes.size())) > kMoreCells * cells + kHalfCell) break;
        if (rings > 0 && tube.radius * (1 - std::cos(std::numbers::pi / n)) < bend.faces.rough) break;
        const double cost = all * tube.radius * tube.radius * of_chord(kTurn / n) +
                            bend.faces.whole * tube.middle.squaredNorm() / 2 * of_chord(bend.proxy.span / m);
        if (rings > 0 && cost >= least) continue;
        least = cost;
        rings = n;
        segments = m;
      }
    if (rings == 0) return false;
    bend.together = static_cast<std::int32_t>(run.bend);
    square_to_pipes(run);
    set_knots(bend.proxy, tube, rings);
    bend.proxy.segments = segments;
    bend.faces = PatchFaces(f_, bend.proxy, std::move(bend.faces.face));
    for (const std::size_t k : run.pipes) {
      RoundPatch& pipe = s_.patches[k];
      pipe.together = bend.together;
      CurvedProxy& p = pipe.proxy;
      align(p, bend.proxy, tube);
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

std::vector<bool> choose_pipes(const Faces& faces, Scene& scene, double distance) {
  return Pipes(faces, scene, distance).run();
}

}  // namespace isimp::curved
