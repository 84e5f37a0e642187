#include "isimp/partition/soundness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "parts.h"

namespace isimp {
namespace {

constexpr std::int32_t kMostParts = 4096;  // limit: segments or rings: many more than any patch is cut into

std::string region_text(std::int32_t region) { return "region " + std::to_string(region); }

bool is_unit(const Vec3& v) { return std::abs(v.norm() - 1) < 1e-6; }

bool all_finite(std::span<const double> numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

/// The arrays that have one value for each region, or none.
std::string broken_sizes(const Partition& p) {
  const std::size_t regions = p.region_seed.size();
  const auto has_other_size = [&](const auto& values) { return !values.empty() && values.size() != regions; };
  if (p.region_normal.size() != regions) return "there must be a normal for each region";
  if (p.region_sum.size() != regions) return "there must be a sum for each region";
  if (has_other_size(p.region_locked)) return "region_locked has another size";
  if (has_other_size(p.region_held)) return "region_held has another size";
  if (has_other_size(p.region_offset)) return "region_offset has another size";
  if (has_other_size(p.region_cell)) return "region_cell has another size";
  if (regions > 0 && !p.region_held.empty() && p.region_offset.empty()) return "held planes have no offsets";
  if (regions > 0 && !p.region_cell.empty() && p.region_held.empty()) return "cells have no held planes";
  if (regions > 0 && !p.curved.empty() && p.region_cell.empty()) return "patches have no cells";
  return "";
}

/// Whether a patch has the numbers that its kind needs, all finite, with lists of the right lengths.
bool is_patch(const CurvedProxy& p) {
  const bool has_profile = p.kind == CurvedKind::revolution || p.kind == CurvedKind::extrusion;
  const std::size_t least = !has_profile ? 0 : p.closed ? 6 : 4;  // numbers of a profile: two for each corner
  const std::int32_t parts = p.kind == CurvedKind::extrusion ? p.segments : p.rings;
  return is_unit(p.axis) && is_unit(p.across) && p.point.allFinite() && p.profile.size() >= least &&
         p.profile.size() % 2 == 0 && all_finite(p.profile) && all_finite(p.knots) &&
         all_finite(std::array{p.radius, p.slope, p.side, p.phase, p.span}) && p.segments > 0 && p.rings > 0 &&
         p.segments <= kMostParts && p.rings <= kMostParts && p.knots.size() == static_cast<std::size_t>(parts) + 1 &&
         std::is_sorted(p.knots.begin(), p.knots.end());
}

/// The patches, and the cells that regions are.
std::string broken_cells(const Partition& p) {
  for (std::size_t k = 0; k < p.curved.size(); ++k)
    if (!is_patch(p.curved[k])) return "round part " + std::to_string(k) + " is damaged";
  for (std::int32_t r = 0; r < static_cast<std::int32_t>(p.region_cell.size()); ++r) {
    const CurvedCell& c = p.region_cell[r];
    if (c.proxy == kNone && p.region_held[r] == kPlaneRound) return region_text(r) + " has the plane of no cell";
    if (c.proxy == kNone) continue;
    if (c.proxy < 0 || c.proxy >= static_cast<std::int32_t>(p.curved.size())) return "a cell is of no patch";
    const CurvedProxy& patch = p.curved[c.proxy];
    if (c.ring < 0 || c.ring >= patch.rings || c.segment < 0 || c.segment >= patch.segments)
      return region_text(r) + " is a cell beyond its patch";
  }
  return "";
}

/// The values of one region.
std::string broken_region(const Partition& p, std::int32_t r, std::int32_t faces) {
  if (faces == 0) return region_text(r) + " is empty";
  const std::int32_t seed = p.region_seed[r];
  if (seed < 0 || seed >= static_cast<std::int32_t>(p.face_region.size()) || p.face_region[seed] != r)
    return region_text(r) + " has a seed outside it";
  const RegionSum& s = p.region_sum[r];
  if (s.faces != faces) return region_text(r) + " has a sum of another number of faces";
  if (!all_finite(std::array{s.x, s.y, s.z, s.weight}) || s.weight < 0) return region_text(r) + " has a damaged sum";
  if (!is_unit(p.region_normal[r]) && !p.region_normal[r].isZero(0))
    return region_text(r) + " has a normal that is not unit";
  if (!p.region_offset.empty() && !std::isfinite(p.region_offset[r]))
    return region_text(r) + " has an offset that is not finite";
  if (!p.region_locked.empty() && p.region_locked[r] > kBoxed) return region_text(r) + " has an unknown lock";
  if (!p.region_held.empty() && p.region_held[r] > kPlaneRound) return region_text(r) + " has an unknown plane";
  return "";
}

}  // namespace

std::int32_t find_unconnected(const Surface& surface, std::span<const std::int32_t> face_region, std::int32_t regions) {
  const Job job;
  const Parts parts = parts_of(
      surface.graph(), [&](std::int32_t f) { return face_region[f]; }, job);
  std::vector<std::int32_t> part(static_cast<std::size_t>(regions), kNone);
  for (std::size_t f = 0; f < face_region.size(); ++f) {
    const std::int32_t region = face_region[f];
    if (region == kNone) continue;
    if (part[region] == kNone) part[region] = parts.of_face[f];
    if (part[region] != parts.of_face[f]) return region;
  }
  return kNone;
}

std::string broken_arrays(const Partition& p) {
  if (std::string broken = broken_sizes(p); !broken.empty()) return broken;
  std::vector<std::int32_t> faces(p.region_seed.size(), 0);
  for (std::size_t f = 0; f < p.face_region.size(); ++f) {
    const std::int32_t region = p.face_region[f];
    if (region < kNone || region >= p.region_count())
      return "face " + std::to_string(f) + " has label " + std::to_string(region);
    if (region != kNone) ++faces[region];
  }
  for (std::int32_t r = 0; r < p.region_count(); ++r)
    if (std::string broken = broken_region(p, r, faces[r]); !broken.empty()) return broken;
  return broken_cells(p);
}

std::string broken_promise(const Surface& surface, const Partition& p) {
  if (p.face_region.size() != static_cast<std::size_t>(surface.face_count()))
    return "there must be a label for each face";
  if (std::string broken = broken_arrays(p); !broken.empty()) return broken;
  const std::int32_t loose = find_unconnected(surface, p.face_region, p.region_count());
  return loose == kNone ? "" : region_text(loose) + " is not connected";
}

}  // namespace isimp
