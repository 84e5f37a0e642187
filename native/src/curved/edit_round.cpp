#include "isimp/curved/edit_round.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "cells/patches.h"
#include "cells/rounding.h"
#include "find/face_labels.h"
#include "fit/numbers.h"
#include "isimp/core/errors.h"

namespace isimp::curved {
namespace {

void check_face(const Mesh& mesh, std::int32_t face) {
  if (face < 0 || face >= mesh.face_count())
    throw InvalidInput("face must be in [0, " + std::to_string(mesh.face_count()) + "), got " + std::to_string(face));
}

void check_range(const char* name, std::int32_t value, std::int32_t low, std::int32_t high) {
  if (value < low || value > high)
    throw InvalidInput(std::string(name) + " must be in [" + std::to_string(low) + ", " + std::to_string(high) +
                       "], got " + std::to_string(value));
}

bool is_locked(const Partition& part, std::int32_t region) {
  return !part.region_locked.empty() && part.region_locked[region] != 0;
}

std::int32_t patch_at(const Mesh& mesh, const Partition& part, std::int32_t face) {
  const std::int32_t patch = patch_of(mesh, part, face);
  if (patch == kNone) throw InvalidInput("face " + std::to_string(face) + " is in no round part");
  return patch;
}

/// (R) The regions that are cells of a patch.
/// \throws InvalidInput  one of them is locked
std::vector<bool> cells_of(const Partition& part, std::int32_t patch, std::int32_t face) {
  std::vector<bool> chosen(part.region_seed.size(), false);
  for (std::size_t r = 0; r < chosen.size(); ++r) {
    chosen[r] = part.region_cell[r].proxy == patch;
    if (chosen[r] && is_locked(part, static_cast<std::int32_t>(r)))
      throw InvalidInput("a cell of the round part at face " + std::to_string(face) + " is locked: unlock it first");
  }
  return chosen;
}

/// The faces by graph index of some regions.
Some faces_of(const Faces& faces, const Partition& part, const std::vector<bool>& chosen) {
  Some some;
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    const std::int32_t r = part.face_region[faces.graph().mesh_face[i]];
    if (r != kNone && chosen[r]) some.push_back(i);
  }
  return some;
}

/// A scene of one patch.
Scene scene_of(CurvedProxy proxy, PatchFaces faces) {
  Scene scene;
  RoundPatch patch{std::move(proxy), 0, std::move(faces)};
  scene.patches.push_back(std::move(patch));
  return scene;
}

std::optional<CurvedSurface> best_fit(const Faces& faces, const Some& some, std::optional<CurvedKind> kind,
                                      const Job& job) {
  const Samples samples = samples_of(faces, some);
  Some few;
  const std::size_t step = some.size() / kMostSamples + 1;
  for (std::size_t k = 0; k < some.size(); k += step) few.push_back(some[k]);
  std::optional<CurvedSurface> best;
  double least = 0;
  for (const CurvedKind k :
       {CurvedKind::cylinder, CurvedKind::sphere, CurvedKind::cone, CurvedKind::revolution, CurvedKind::extrusion}) {
    if (kind && *kind != k) continue;
    job.poll();
    const auto found =
        fit(k, k == CurvedKind::revolution || k == CurvedKind::extrusion ? samples_of(faces, few) : samples);
    if (!found || found->radius > faces.mesh().diagonal() * 8) continue;
    job.poll();
    const double now = rms(*found, samples);
    if (best && now * kNearlyAsWell >= least) continue;
    best = found;
    least = now;
  }
  return best;
}

}  // namespace
}  // namespace isimp::curved

namespace isimp {

std::int32_t patch_of(const Mesh& mesh, const Partition& part, std::int32_t face) {
  using namespace curved;
  check_is_of(mesh, part);
  check_face(mesh, face);
  const std::int32_t region = part.face_region[face];
  return region == kNone || part.region_cell.empty() ? kNone : part.region_cell[region].proxy;
}

Partition with_segments(const Mesh& mesh, const Partition& part, std::int32_t face, std::int32_t segments,
                        std::int32_t rings, Job& job) {
  using namespace curved;
  const std::int32_t patch = patch_at(mesh, part, face);
  CurvedProxy proxy = part.curved[patch];
  const bool is_extrusion = proxy.kind == CurvedKind::extrusion;
  check_range("segments", segments, proxy.full ? 3 : 1, is_extrusion ? kMostStrips : kMostSegments);
  check_range("rings", rings, 0, is_extrusion ? 1 : kMostRings);
  const std::vector<bool> chosen = cells_of(part, patch, face);
  const Surface surface(mesh, part.guided);
  const Faces faces(surface);
  proxy.point -= mesh.origin();
  PatchFaces cells(faces, proxy, faces_of(faces, part, chosen));
  begin_at_border(faces, proxy, cells, segments);
  const double now = static_cast<double>(proxy.segments) * proxy.rings;
  apply(proxy, Cuts(proxy, cells).of(segments, rings, now));
  return with_cells(surface, part, scene_of(std::move(proxy), std::move(cells)), job);
}

Partition explode_round(const Mesh& mesh, const Partition& part, std::int32_t face, Job& job) {
  using namespace curved;
  job.poll();
  const std::int32_t patch = patch_at(mesh, part, face);
  cells_of(part, patch, face);
  Partition out = part;
  for (std::size_t r = 0; r < out.region_cell.size(); ++r) {
    std::int32_t& proxy = out.region_cell[r].proxy;
    if (proxy != patch) {
      proxy -= proxy > patch;
      continue;
    }
    out.region_cell[r] = {};
    out.region_held[r] = 0;
    out.region_normal[r] = out.region_sum[r].normal();
  }
  out.curved.erase(out.curved.begin() + patch);
  out.regularity.reset();
  place_free_planes(mesh, out);
  return out;
}

Partition make_round(const Mesh& mesh, const Partition& part, std::span<const std::int32_t> faces,
                     std::optional<CurvedKind> kind, Job& job) {
  using namespace curved;
  check_is_of(mesh, part);
  if (faces.empty()) throw InvalidInput("no face is given");
  std::vector<bool> chosen(part.region_seed.size(), false);
  for (const std::int32_t f : faces) {
    check_face(mesh, f);
    const std::int32_t region = part.face_region[f];
    if (region == kNone) throw InvalidInput("face " + std::to_string(f) + " lies in a part that was left out");
    if (is_locked(part, region))
      throw InvalidInput("the region of face " + std::to_string(f) + " is locked: unlock it first");
    chosen[region] = true;
  }
  const Surface surface(mesh, part.guided);
  const Faces all(surface);
  Some some = faces_of(all, part, chosen);
  const auto found = best_fit(all, some, kind, job);
  if (!found) throw InvalidInput("the faces given determine no round surface: choose more regions of one round part");
  CurvedProxy proxy;
  static_cast<CurvedSurface&>(proxy) = *found;
  if (proxy.kind == CurvedKind::sphere) proxy.axis = Vec3::UnitZ();
  if (proxy.kind != CurvedKind::extrusion) proxy.across = frame(proxy.axis)[0];
  PatchFaces cells(all, proxy, std::move(some));
  set_span(proxy, cells);
  const double count = std::max<double>(proxy.full ? kLeastRound : 3,
                                        static_cast<double>(std::count(chosen.begin(), chosen.end(), true)));
  begin_at_border(all, proxy, cells, count);
  job.poll();
  const std::vector<Grid> cuts = Cuts(proxy, cells).within(count, cells.rough);
  if (cuts.empty()) throw InvalidInput("the faces given can't be cut into segments");
  apply(proxy,
        *std::min_element(cuts.begin(), cuts.end(), [](const Grid& a, const Grid& b) { return a.cost < b.cost; }));
  return with_cells(surface, part, scene_of(std::move(proxy), std::move(cells)), job);
}

}  // namespace isimp
