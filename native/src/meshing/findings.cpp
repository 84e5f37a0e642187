#include "findings.h"

#include <algorithm>
#include <numeric>

namespace isimp::meshing {

std::uint8_t Findings::Found::faults() const {
  std::uint8_t all = 0;
  for (const PolygonVerdict& v : polygons) all |= v.faults;
  return all & ~kGiven;
}

bool Findings::is_given(std::int32_t piece) const {
  const std::int32_t f = s_.labels.pieces[piece].face;
  for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
    if (s_.labels.inner(h)) return false;
  std::vector<Vec3> corners;
  for (const std::int32_t v : s_.mesh.triangles()[f]) corners.push_back(s_.mesh.vertices()[v]);
  return (judge_polygon(std::array{0, 1, 2}, corners, Vec3::Zero(), bounds_).faults & kNoArea) != 0;
}

void Findings::judge(std::span<const std::int32_t> pieces) {
  found_.resize(s_.labels.pieces.size());
  std::vector<bool> changed(s_.labels.pieces.size(), false);
  for (const std::int32_t l : pieces) {
    changed[l] = true;
    Found& f = found_[l];
    f.polygons.clear();
    f.facets.clear();
    for (std::int32_t q = s_.polygons.first_of[l]; q < s_.polygons.first_of[l + 1]; ++q)
      f.polygons.push_back(judge_polygon(s_.polygons.of(q), s_.corners.position, s_.planes[l].normal, bounds_,
                                         {{}, l, q - s_.polygons.first_of[l]}, &f.facets.facets));
    f.facets.locate(s_.corners.position);
    if (f.polygons.size() == 1 && f.polygons[0].faults == kNoArea && is_given(l)) f.polygons[0].faults = kGiven;
  }
  std::vector<const FacetSet*> facets;
  facets.reserve(found_.size());
  for (const Found& f : found_) facets.push_back(&f.facets);
  std::erase_if(hits_, [&](const Hit& h) { return changed[h.a] || changed[h.b]; });
  const std::vector<Hit> fresh = find_hits(facets, s_.corners.position, changed);
  hits_.insert(hits_.end(), fresh.begin(), fresh.end());
  std::sort(hits_.begin(), hits_.end(), [](const Hit& x, const Hit& y) { return x.key() < y.key(); });
}

bool Findings::excused(const Hit& h) {
  std::array<std::int32_t, 2> regions{s_.labels.pieces[h.a].region, s_.labels.pieces[h.b].region};
  std::sort(regions.begin(), regions.end());
  const auto [at, fresh] = excuses_.try_emplace(regions, false);
  if (fresh) at->second = scan_intersects(s_.mesh, faces_of_region(regions[0]), faces_of_region(regions[1]));
  return at->second;
}

std::vector<bool> Findings::faulty() {
  std::vector<bool> faulty(found_.size());
  for (std::size_t l = 0; l < found_.size(); ++l) faulty[l] = found_[l].faults() != 0;
  for (const Hit& h : hits_)
    if (!excused(h)) faulty[h.a] = faulty[h.b] = true;
  return faulty;
}

std::span<const std::int32_t> Findings::faces_of_region(std::int32_t region) {
  if (region_start_.empty()) {
    const auto& of = s_.partition.face_region;
    region_start_.assign(s_.regions + 1, 0);
    for (const std::int32_t r : of)
      if (r != kNone) ++region_start_[r + 1];
    std::partial_sum(region_start_.begin(), region_start_.end(), region_start_.begin());
    region_faces_.resize(region_start_.back());
    std::vector<std::int32_t> fill(region_start_.begin(), region_start_.end() - 1);
    for (std::int32_t f = 0; f < s_.mesh.face_count(); ++f)
      if (of[f] != kNone) region_faces_[fill[of[f]]++] = f;
  }
  return std::span(region_faces_).subspan(region_start_[region], region_start_[region + 1] - region_start_[region]);
}

}  // namespace isimp::meshing
