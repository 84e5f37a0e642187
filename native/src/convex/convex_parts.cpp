#include "isimp/convex/convex_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "enclose.h"
#include "hull.h"
#include "isimp/core/errors.h"
#include "pieces.h"
#include "solid.h"
#include "walls.h"

namespace isimp {
namespace {

using convex::Piece;
using convex::Pieces;

// tuned colliders
constexpr std::int32_t kFew = 16;    // parts that a small piece may become, and twice the cuts tried to their end
constexpr std::int32_t kMore = 3;    // times the wanted parts are cut before they are merged
constexpr std::size_t kSmall = 100;  // limit: cells of such a piece

/// Removes the piece with the largest missing volume and returns it.
Piece take_worst(std::vector<Piece>& open) {
  const auto at = std::ranges::max_element(open, {}, &Piece::missing);
  Piece piece = std::move(*at);
  open.erase(at);
  return piece;
}

/// How many parts a piece becomes if it is cut by a plane, and its parts always by the plane that is best at once.
/// At `most`, counting stops.
std::int32_t parts_after(Pieces pieces, const Piece& piece, std::int32_t plane, std::int32_t most, Job& job) {
  std::vector<Piece> open = pieces.cut(piece, plane);
  std::int32_t done = 0;
  while (!open.empty() && done + std::ssize(open) < most) {
    job.poll();
    const Piece next = take_worst(open);
    const auto planes = pieces.fills_space(next, job) ? pieces.choices(next, job) : std::vector<std::int32_t>();
    if (planes.empty())
      ++done;
    else
      std::ranges::move(pieces.cut(next, planes[0]), std::back_inserter(open));
  }
  return done + static_cast<std::int32_t>(open.size());
}

/// The plane to cut a piece by. If it is small, the one after which it becomes the fewest parts.
std::int32_t best_plane(const Pieces& pieces, const Piece& piece, Job& job) {
  const std::vector<std::int32_t> planes = pieces.choices(piece, job);
  if (planes.empty()) return kNone;
  if (piece.cells.size() > kSmall || planes.size() == 1) return planes[0];
  const auto [some, same] = pieces.alone(piece);
  std::int32_t best = planes[0], least = parts_after(some, same, best, kFew, job);
  for (std::size_t i = 1; i < std::min<std::size_t>(planes.size(), kFew / 2) && least > 2 && least < kFew; ++i) {
    const std::int32_t parts = parts_after(some, same, planes[i], least, job);
    if (parts >= least) continue;
    least = parts;
    best = planes[i];
  }
  return best;
}

/// Cuts pieces, the largest missing volume first, until none fills free space or there are `most`.
std::vector<Piece> cut_all(Pieces& pieces, std::int32_t most, Job& job) {
  std::vector<Piece> open = pieces.whole(), done;
  double all = 0, finished = 0;
  for (const Piece& piece : open) all += piece.volume;
  while (!open.empty()) {
    job.report(std::min(finished / all, 1.0));
    Piece piece = take_worst(open);
    const bool more = std::ssize(open) + std::ssize(done) + 1 < most && pieces.fills_space(piece, job);
    const std::int32_t plane = more ? best_plane(pieces, piece, job) : kNone;
    if (plane == kNone) {
      finished += piece.volume;
      done.push_back(std::move(piece));
    } else {
      std::ranges::move(pieces.cut(piece, plane), std::back_inserter(open));
    }
  }
  return done;
}

/// Merges pairs of pieces, the smallest added volume first, while no hull fills free space, and further while there are
/// more than `most`.
void merge_all(const Pieces& pieces, std::vector<Piece>& parts, std::int32_t most, Job& job) {
  struct Pair {
    std::int32_t a, b;
    double added;
    Piece both;
    bool refused = false;
  };
  std::vector<Pair> pairs;
  std::vector<char> alive(parts.size(), 1);
  auto count = static_cast<std::int32_t>(parts.size());
  const auto propose = [&](std::int32_t a, std::int32_t b) {
    job.poll();
    Piece both = pieces.joined(parts[a], parts[b]);
    const double added = both.missing() - parts[a].missing() - parts[b].missing();
    pairs.push_back({a, b, added, std::move(both)});
  };
  for (const auto& [a, b] : pieces.touching(parts)) propose(a, b);
  while (true) {
    job.poll();
    Pair* best = nullptr;
    for (Pair& pair : pairs)
      if (!pair.refused && (best == nullptr || pair.added < best->added)) best = &pair;
    if (best != nullptr && pieces.fills_space(best->both, job)) {
      best->refused = true;
      continue;
    }
    if (best == nullptr && count > most) {
      for (Pair& pair : pairs)
        if (best == nullptr || pair.added < best->added) best = &pair;
      if (best == nullptr) {  // the pieces do not touch
        for (std::int32_t a = 0; a < std::ssize(parts); ++a)
          for (std::int32_t b = a + 1; b < std::ssize(parts); ++b)
            if (alive[a] && alive[b]) propose(a, b);
        continue;
      }
    }
    if (best == nullptr) break;
    const auto [a, b] = std::pair(best->a, best->b);
    parts[a] = std::move(best->both);
    alive[b] = 0;
    --count;
    std::vector<std::int32_t> beside;
    for (const Pair& pair : pairs) {
      if (pair.a == a || pair.a == b) beside.push_back(pair.b);
      if (pair.b == a || pair.b == b) beside.push_back(pair.a);
    }
    std::erase_if(pairs, [a = a, b = b](const Pair& p) { return p.a == a || p.a == b || p.b == a || p.b == b; });
    std::ranges::sort(beside);
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    for (const std::int32_t c : beside)
      if (c != a && c != b) propose(std::min(a, c), std::max(a, c));
  }
  std::size_t kept = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!alive[p]) continue;
    if (kept != p) parts[kept] = std::move(parts[p]);
    ++kept;
  }
  parts.resize(kept);
}

/// Leaves out parts whose corners are all within the tolerance of one larger part: skins of noise.
void leave_out_skins(std::vector<ConvexPart>& parts, double tolerance) {
  std::vector<ConvexPart> kept;
  for (ConvexPart& part : parts) {
    const bool covered = std::ranges::any_of(kept, [&](const ConvexPart& other) {
      return std::ranges::all_of(other.triangles, [&](const Triangle& t) {
        const Vec3 &a = other.vertices[t[0]], &b = other.vertices[t[1]], &c = other.vertices[t[2]];
        const Vec3 normal = (b - a).cross(c - a).normalized();
        return std::ranges::all_of(part.vertices, [&](const Vec3& p) { return normal.dot(p - a) <= tolerance; });
      });
    });
    if (!covered) kept.push_back(std::move(part));
  }
  parts = std::move(kept);
}

/// The parts of a solid.
std::vector<ConvexPart> parts_of(convex::Solid& solid, const Vec3& origin, const ConvexOptions& options, Job& job) {
  convex::Cells cells;
  {
    const Job::Stage stage(job, "cells", 0.0, 0.3);
    cells = convex::cells_of(solid, origin, job);
  }
  std::vector<ConvexPart> made;
  const std::int32_t most = options.parts > 0 ? options.parts : std::numeric_limits<std::int32_t>::max();
  {
    const Job::Stage stage(job, "cutting", 0.3, 0.9);
    Pieces pieces(solid, std::move(cells), job);
    std::vector<Piece> parts =
        cut_all(pieces, most > std::numeric_limits<std::int32_t>::max() / kMore ? most : kMore * most, job);
    merge_all(pieces, parts, most, job);
    std::ranges::stable_sort(parts, std::ranges::greater{}, &Piece::volume);
    for (const Piece& piece : parts) {
      std::vector<Vec3> corners = pieces.corners(piece);
      for (Vec3& p : corners) p += origin;
      ConvexPart part = convex::simple_hull_of(corners, solid.lengths.slight, options.most_vertices);
      if (!part.vertices.empty()) made.push_back(std::move(part));
    }
  }
  return made;
}

}  // namespace

std::vector<ConvexPart> convex_parts(const PolygonSoup& polygons, std::span<const std::int32_t> region,
                                     std::span<const Vec3> enclosed, const ConvexOptions& options, Job& job) {
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw InvalidInput("tolerance must be a finite length of at least 0, got " + std::to_string(options.tolerance));
  if (options.parts < 0)
    throw InvalidInput("parts must be at least 0 (0: no limit), got " + std::to_string(options.parts));
  if (options.most_vertices < 8)
    throw InvalidInput("most_vertices must be at least 8, got " + std::to_string(options.most_vertices));
  if (!(options.thickness >= 0) || !std::isfinite(options.thickness))
    throw InvalidInput("thickness must be a finite length of at least 0, got " + std::to_string(options.thickness));
  if (options.thickness > 0 && options.parts > 0)
    throw InvalidInput("parts can't be limited with a thickness: each polygon has a slab of its own");
  for (std::size_t i = 0; i < enclosed.size(); ++i)
    if (!enclosed[i].allFinite()) throw InvalidInput("point " + std::to_string(i) + " to enclose is not finite");
  const Eigen::AlignedBox3d box = convex::box_of(polygons.vertices);
  const Vec3 origin = box.center();  // not finite without vertices, which is refused below
  const double tolerance = options.tolerance > 0 ? options.tolerance : convex::kTolerance * box.diagonal().norm();
  convex::Solid solid = convex::solid_of(polygons, region, origin, tolerance, job);
  std::vector<ConvexPart> made;
  if (options.thickness > 0) {
    const Job::Stage stage(job, "walls", 0.0, 0.9);
    made = convex::walls_of(polygons, region, origin, solid, options.thickness, options.most_vertices, job);
    std::ranges::stable_sort(made, std::ranges::greater{}, &ConvexPart::volume);
    for (ConvexPart& part : made)
      for (Vec3& p : part.vertices) p += origin;
  } else {
    made = parts_of(solid, origin, options, job);
  }
  leave_out_skins(made, tolerance);
  if (!enclosed.empty() && !made.empty()) {
    const Job::Stage stage(job, "enclosing", 0.9, 1.0);
    convex::enclose(made, enclosed, solid.lengths.same, options.most_vertices, job);
  }
  return made;
}

}  // namespace isimp
