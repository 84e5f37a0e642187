#include "judge/defects.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "complex/outline.h"
#include "isimp/core/check.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {

Defects::Source Defects::source_of(std::int32_t chart) const {
  Source s{{}, {}, s_.planes[chart].normal, s_.labels.is_face(chart)};
  s_.polygons.for_each_of(chart, [&](std::int32_t q) {
    for (const std::int32_t c : s_.polygons.of(q)) {
      s.loops.push_back(c);
      s.places.push_back(s_.corners.position[c]);
    }
    s.loops.push_back(kNone);
  });
  return s;
}

bool Defects::is_source(const Source& s, std::int32_t chart) const {
  auto loop = s.loops.begin();
  auto place = s.places.begin();
  const std::int32_t first = s_.polygons.first_of(chart);
  for (std::int32_t q = first; q < first + s_.polygons.count_of(chart); ++q) {
    for (const std::int32_t c : s_.polygons.of(q))
      if (loop == s.loops.end() || *loop++ != c || *place++ != s_.corners.position[c]) return false;
    if (loop == s.loops.end() || *loop++ != kNone) return false;
  }
  return loop == s.loops.end() && s.normal == s_.planes[chart].normal && s.is_face == s_.labels.is_face(chart);
}

bool Defects::is_given(std::int32_t chart) const {
  std::vector<Vec3> corners;
  for (const std::int32_t v : s_.mesh.triangles()[s_.labels.charts[chart].face])
    corners.push_back(s_.mesh.vertices()[v]);
  return (judge_polygon(std::array{0, 1, 2}, corners, Vec3::Zero(), bounds_).kinds & kNoArea) != 0;
}

PolygonDefects Defects::judge_one(std::int32_t chart, std::int32_t part, std::span<const Vec3> beyond,
                                  FlatView* view) const {
  const auto polygon = s_.polygons.of(s_.polygons.first_of(chart) + part);
  Bounds bounds = bounds_;
  Vec3 normal = s_.planes[chart].normal;
  if (!beyond.empty()) {
    bounds.facing = kFacingApart;
    const Vec3 area = vector_area(polygon, s_.corners.position), other = direction_on_scan(s_, chart, polygon, beyond);
    if (area.dot(other) > area.dot(normal)) normal = other;
  }
  return judge_polygon(polygon, s_.corners.position, normal, bounds, view);
}

PolygonDefects Defects::defects_now(std::int32_t chart, std::int32_t part) const {
  return judge_one(chart, part, areas_beyond(chart), nullptr);
}

bool Defects::meet_now(std::int32_t a, std::int32_t b) const {
  const FacetSet some = find(a, source_of(a)).facets;
  return a == b ? facets_meet(some, some) : facets_meet(some, find(b, source_of(b)).facets);
}

std::vector<Vec3> Defects::areas_beyond(std::int32_t chart) const {
  return apart_ && s_.polygons.count_of(chart) > 1 ? areas_beyond_chords(s_, chart) : std::vector<Vec3>{};
}

Defects::Looked Defects::look(std::int32_t chart, std::uint8_t allowed) const {
  Looked looked;
  const std::vector<Vec3> beyond = areas_beyond(chart);
  for (std::int32_t part = 0; part < s_.polygons.count_of(chart); ++part) {
    looked.polygons.push_back(judge_one(chart, part, beyond, &looked.views.emplace_back()));
    if (looked.polygons.back().kinds & ~allowed) break;
  }
  return looked;
}

Defects::Found Defects::find(std::int32_t chart, Source source, Looked looked) const {
  Found f{std::move(source), std::move(looked.polygons), {}};
  const std::int32_t first = s_.polygons.first_of(chart);
  for (std::int32_t part = 0; part < s_.polygons.count_of(chart); ++part)
    if (const FlatView& view = looked.views[part])
      triangulate(*view, s_.polygons.of(first + part), s_.corners.position, bounds_, {{}, chart, part},
                  f.facets.facets);
  f.facets.locate(s_.corners.position);
  if (f.polygons.size() == 1 && f.polygons[0].kinds == kNoArea && f.source.is_face && is_given(chart))
    f.polygons[0].kinds = kGiven;
  const auto is_home = [&](std::int32_t c) {
    return s_.corners.position[c] == s_.mesh.vertices()[s_.corners.vertex[c]];
  };
  const auto& loops = f.source.loops;  // three corners and the kNone after them
  f.facets.given = f.source.is_face && loops.size() == 4 && std::all_of(loops.begin(), loops.begin() + 3, is_home);
  return f;
}

void Defects::set(std::int32_t chart, Found found) {
  ISIMP_ASSERT(found.polygons.size() == static_cast<std::size_t>(s_.polygons.count_of(chart)),
               "every polygon of a chart is judged");
  found_[chart] = std::move(found);
  around_.set(chart, found_[chart].facets);
  kinds_[chart] = 0;
  for (const PolygonDefects& v : found_[chart].polygons) kinds_[chart] |= v.kinds & ~kGiven;
}

void Defects::judge(std::span<const std::int32_t> charts) {
  const std::size_t count = s_.labels.charts.size();
  ISIMP_ASSERT(found_.size() <= count, "charts keep their numbers");
  found_.resize(count);
  kept_.resize(count);
  kinds_.resize(count, 0);
  std::vector<bool> changed(count, false);
  std::vector<Was> was(charts.size(), Was::same);
  std::vector<Found> fresh(charts.size());
  const auto n = static_cast<std::int32_t>(charts.size());
  s_.threads.blocks(n, 4, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    job_.poll();
    for (std::int32_t i = begin; i < end; ++i) {
      const std::int32_t l = charts[i];
      if (is_source(found_[l].source, l)) continue;
      was[i] = kept_[l] && is_source(kept_[l]->source, l) ? Was::kept : Was::other;
      if (was[i] == Was::other) fresh[i] = find(l, source_of(l));
    }
  });
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t l = charts[i];
    if (was[i] == Was::same || changed[l]) continue;
    changed[l] = true;
    judged_ += static_cast<std::int64_t>(fresh[i].polygons.size());
    std::unique_ptr<Found>& kept = kept_[l];
    if (!kept) kept = std::make_unique<Found>(std::move(found_[l]));
    set(l, was[i] == Was::kept ? std::move(*kept) : std::move(fresh[i]));
    if (was[i] == Was::kept) kept.reset();
  }
  around_.settle();
  std::vector<bool> same(count);  // by chart: whether its defects are the kept ones
  for (std::size_t l = 0; l < count; ++l) same[l] = !kept_[l];
  find_hits_of(changed, same);
}

void Defects::find_hits_of(const std::vector<bool>& changed, const std::vector<bool>& same) {
  std::vector<const FacetSet*> facets;
  facets.reserve(found_.size());
  for (const Found& f : found_) facets.push_back(&f.facets);
  std::erase_if(hits_, [&](const Hit& h) { return changed[h.a] || changed[h.b]; });
  std::copy_if(kept_hits_.begin(), kept_hits_.end(), std::back_inserter(hits_),
               [&](const Hit& h) { return (changed[h.a] || changed[h.b]) && same[h.a] && same[h.b]; });
  const auto known = static_cast<std::ptrdiff_t>(hits_.size());
  const std::vector<Hit> found = find_hits(facets, around_, changed, same, s_.threads, job_);
  hits_.insert(hits_.end(), found.begin(), found.end());
  find_excuses(std::span(hits_).subspan(known));
  std::sort(hits_.begin(), hits_.end(), [](const Hit& x, const Hit& y) { return x.key() < y.key(); });
  ISIMP_ASSERT(std::adjacent_find(hits_.begin(), hits_.end(),
                                  [](const Hit& x, const Hit& y) { return !(x.key() < y.key()); }) == hits_.end(),
               "each pair of polygons that meet is there once");
}

FacetSet Defects::changed_facets(std::int32_t chart, const Found& fresh) const {
  const FacetSet &now = fresh.facets, &was = found_[chart].facets;
  FacetSet changed;
  for (std::size_t k = 0; k < now.facets.size(); ++k)
    if (k >= was.facets.size() || was.facets[k].corner != now.facets[k].corner || was.solids[k] != now.solids[k])
      changed.facets.push_back(now.facets[k]);
  changed.locate(s_.corners.position);
  return changed;
}

bool Defects::meets_any(std::size_t i, std::span<const std::int32_t> charts, std::span<const Found> fresh,
                        const FacetSet& changed) {
  if (changed.solid.empty()) return false;
  const std::int32_t l = charts[i];
  const auto is_excused = [&](std::int32_t k) {
    const auto [low, high] = std::minmax(s_.labels.charts[l].region, s_.labels.charts[k].region);
    const ScanMeetings::Pair pair{low, high};
    excuses_.test({&pair, 1}, s_.threads, job_);
    return excuses_.meet(pair);
  };
  bool any = false;
  const auto look = [&](std::int32_t k, const FacetSet& other) {
    if (any || other.around.apart(changed.around)) return;
    any = facets_meet(changed, other) && !is_excused(k);
  };
  const auto look_up = [&](std::int32_t k) {
    if (std::find(charts.begin(), charts.end(), k) == charts.end()) look(k, found_[k].facets);
  };
  around_.free.for_each_near(changed.around, look_up);
  if (!fresh[i].facets.given) around_.given.for_each_near(changed.around, look_up);
  for (std::size_t k = 0; k < charts.size(); ++k)
    if (k != i) look(charts[k], fresh[k].facets);
  // The polygons of one chart are tested as a whole, since facets of one polygon meet by design.
  if (fresh[i].polygons.size() > 1) any = any || (facets_meet(fresh[i].facets, fresh[i].facets) && !is_excused(l));
  return any;
}

bool Defects::accepts(std::span<const std::int32_t> charts, std::int32_t whole) {
  std::vector<std::int32_t> changed;
  for (const std::int32_t l : charts)
    if (!is_source(found_[l].source, l)) changed.push_back(l);
  // Without facets first, and `whole` before the others: most changes that are refused have a defect there.
  std::vector<Looked> looked(changed.size());
  const auto is_good = [&](std::size_t i) {
    const std::int32_t l = changed[i];
    const std::uint8_t allowed = l == whole ? kGiven : kinds_[l] | kGiven;
    looked[i] = look(l, allowed);
    if (!looked[i].polygons.empty() && (looked[i].polygons.back().kinds & ~allowed)) return false;
    judged_ += s_.polygons.count_of(l);
    return true;
  };
  const std::size_t first = std::find(changed.begin(), changed.end(), whole) - changed.begin();
  if (first < changed.size() && !is_good(first)) return false;
  for (std::size_t i = 0; i < changed.size(); ++i)
    if (i != first && !is_good(i)) return false;
  std::vector<Found> fresh;
  fresh.reserve(changed.size());
  for (std::size_t i = 0; i < changed.size(); ++i)
    fresh.push_back(find(changed[i], source_of(changed[i]), std::move(looked[i])));
  for (std::size_t i = 0; i < changed.size(); ++i)
    if (meets_any(i, changed, fresh, changed_facets(changed[i], fresh[i]))) return false;
  for (std::size_t i = 0; i < changed.size(); ++i) set(changed[i], std::move(fresh[i]));
  accepted_.insert(accepted_.end(), changed.begin(), changed.end());
  around_.settle();
  return true;
}

void Defects::renew_hits() {
  std::vector<bool> changed(found_.size(), false);
  for (const std::int32_t l : std::exchange(accepted_, {})) changed[l] = true;
  find_hits_of(changed, std::vector<bool>(found_.size(), false));
  keep();
}

void Defects::keep() {
  for (auto& kept : kept_) kept.reset();
  kept_hits_ = hits_;
}

ScanMeetings::Pair Defects::regions_of(const Hit& h) const {
  ScanMeetings::Pair regions{s_.labels.charts[h.a].region, s_.labels.charts[h.b].region};
  std::sort(regions.begin(), regions.end());
  return regions;
}

void Defects::find_excuses(std::span<Hit> hits) {
  std::vector<ScanMeetings::Pair> pairs;
  pairs.reserve(hits.size());
  for (const Hit& h : hits) pairs.push_back(regions_of(h));
  excuses_.test(pairs, s_.threads, job_);
  for (std::size_t i = 0; i < hits.size(); ++i) hits[i].excused = excuses_.meet(pairs[i]);
}

GivenHits Defects::given_hits(std::size_t most, std::int64_t most_counted) const {
  std::vector<const FacetSet*> facets;
  facets.reserve(found_.size());
  for (const Found& f : found_) facets.push_back(&f.facets);
  return find_given_hits(facets, around_, most, most_counted, job_);
}

std::vector<bool> Defects::defective(std::uint8_t which) const {
  std::vector<bool> defective(found_.size());
  for (std::size_t l = 0; l < found_.size(); ++l) defective[l] = (kinds_[l] & which) != 0;
  for (const Hit& h : hits_)
    if (!h.excused) defective[h.a] = defective[h.b] = true;
  return defective;
}

}  // namespace isimp::meshing
