#include "complex/state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "complex/coplanar.h"
#include "complex/raggedness.h"
#include "discs/no_length.h"
#include "isimp/core/check.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

constexpr double kMostOff = 0.03, kMostOffBorder = 0.01;  ///< tuned unrecorded: chords of few regions, of the diagonal
constexpr double kLeastSine = 0.15;  ///< tuned unrecorded: how much less a chord counts between flat neighbours at most
// tuned real
constexpr double kRimWindow = 0.5;  ///< window of the raggedness, in sqrt(area / regions)

ChordTolerance chord_tolerance(const Mesh& mesh, std::span<const Plane> planes, const Partition& partition,
                               const MeshingOptions& options) {
  double area = 0;
  for (const Plane& p : planes) area += p.area;
  const double side = std::sqrt(area / std::max(partition.region_count(), 1)),
               tolerance = options.chord_tolerance * side;
  ChordTolerance t;
  t.most = std::min(tolerance, kMostOff * mesh.diagonal());
  t.most_on_border = std::min(tolerance, kMostOffBorder * mesh.diagonal());
  t.rim = rim_reach(mesh, partition, options, kRimWindow * side);
  t.of_area = options.chord_area;
  t.least_sine = kLeastSine;
  return t;
}

/// rounding: share of the area: with a shorter vector area, faces define no direction
constexpr double kNoDirection = 1e-12;
// tuned unrecorded
constexpr std::int32_t kFacesAChart = 60;  ///< with fewer, it is as quick to measure all charts again

/// A boundary half-edge of a chart, found from one of its faces.
std::int32_t boundary_start(const Labels& labels, std::span<const std::int32_t> faces) {
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (!labels.inner(h)) return h;
  return kNone;
}

/// The last face of a chart that shares an edge with some faces; kNone if there is none.
std::int32_t face_beside(const Labels& labels, std::span<const std::int32_t> faces, std::int32_t chart) {
  std::int32_t last = kNone;
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (labels.across(h) == chart) last = labels.mesh.opposite(h) / 3;
  return last;
}

/// Where a half-edge is in a loop, sought from a place on and round; the end if it is not there.
auto find_round(std::span<const std::int32_t> loop, std::span<const std::int32_t>::iterator from, std::int32_t h) {
  const auto at = std::find(from, loop.end(), h);
  if (at != loop.end()) return at;
  const auto before = std::find(loop.begin(), from, h);
  return before == from ? loop.end() : before;
}

}  // namespace

State::State(const Mesh& m, const Partition& p, const MeshingOptions& o, Job& job)
    : labels_(m),
      cutter_(labels_),
      complex_(labels_, planes_),
      corners_(m.vertex_count()),
      job_(job),
      mesh(m),
      partition(p),
      options(o),
      threads(o.threads),
      regions(partition.region_count()) {
  if (options.planar) labels_.outlying = outlying_faces(m, partition.face_region, regions, threads, job);
  Bits boundary = label_charts(labels_, partition.face_region, threads, job);
  merged_without_area_ = merge_charts_without_area(labels_, 2 * kThickness * m.diagonal(), boundary);
  job.report(0.02);
  cutter_.perforated = is_perforated(cutter_, regions, job);
  if (cutter_.perforated) {
    corners_.still = kNoLength * m.diagonal();
    part_walls(cutter_, job);
    planes_.assign(planes_of(labels_, threads, job));
    join_coplanar(*this, labels_, job);
    boundary = boundary_of(labels_);
  }
  const Outlines outlines = trace_outlines(labels, boundary, job);
  std::map<std::int32_t, Disc> discs;
  std::vector<std::int32_t> todo = find_non_discs(labels_, outlines, threads, job);
  make_discs(cutter_, std::move(todo), discs, job);
  if (mesh.report().closed_components > 0) split_closed_components(cutter_, kLeastClosed, discs, job);
  std::vector<std::vector<std::int32_t>> loops(labels.charts.size());
  for (std::int32_t l = 0; l < static_cast<std::int32_t>(outlines.loops.size()); ++l)
    loops[l].assign(outlines.of(l).begin(), outlines.of(l).end());
  sort_unique(labels_.touched);
  for (const std::int32_t l : labels.touched) {
    auto& [faces, loop] = discs.at(l);
    labels_.charts.edit(l).region = region_of(l, faces);
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    loops[l] = std::move(loop);
  }
  labels_.touched.clear();
  job.report(0.07);
  planes_.assign(planes_of(labels, threads, job));
  for (std::size_t l = 0; l < planes.size(); ++l)
    hold_by_hand(planes_.edit(l), partition, labels.charts[l].region, mesh.origin());
  complex_.tolerance = chord_tolerance(mesh, planes, partition, options);
  job.report(0.08);
  complex_.refresh(numbers_below(labels.chart_count()), std::move(loops), job);
  tips_ = tips_of(labels, complex, partition);
  for (const Tip& tip : tips_) {
    corners_.share(tip.nearest, tip.vertices);
    for (const std::int32_t v : bends_at(labels, complex, tip)) drop_corner(v);
  }
  job.report(0.1);
}

std::int32_t State::region_of(std::int32_t chart, std::span<const std::int32_t> faces) const {
  ISIMP_ASSERT(!faces.empty(), "a chart has faces");
  std::map<std::int32_t, double> area;
  auto at = area.end();
  for (const std::int32_t f : faces) {
    const std::int32_t region = partition.face_region[f];
    if (at == area.end() || at->first != region) at = area.try_emplace(region, 0).first;
    at->second += mesh.graph().faces[mesh.graph().graph_face[f]].area;
  }
  const Chart& p = labels.charts[chart];
  if (p.cause == Cause::region && area.contains(p.region)) return p.region;
  return std::max_element(area.begin(), area.end(), [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

bool State::split(std::int32_t chart, Job& job) {
  const std::int32_t fresh = bisect(cutter_, chart, Cause::repair);
  if (fresh == kNone) return false;
  make_discs(cutter_, {chart, fresh}, pending_.discs, job);
  diagonals_.resize(labels.charts.size());
  for (const std::int32_t l : labels.touched) diagonals_.set(l, {});
  return true;
}

bool State::shatter(std::int32_t chart) {
  const std::vector<std::int32_t> faces = labels.faces_of(chart);
  bool any = faces.size() > 1;
  pending_.discs.erase(chart);
  for (std::size_t i = 1; i < faces.size(); ++i) labels_.part(std::span(faces).subspan(i, 1), faces[0], Cause::repair);
  for (const std::int32_t f : faces)
    for (const std::int32_t v : mesh.triangles()[f]) {
      if (!complex.is_corner(v)) {
        add_corner(v);
        any = true;
      }
      const std::int32_t c = corner_at(v);
      any = corners.position[c] != mesh.vertices()[v] || any;
      move(c, mesh.vertices()[v]);
      pending_.at_home.push_back(c);
    }
  diagonals_.resize(labels.charts.size());
  any = !diagonals[chart].empty() || any;
  set_diagonals(chart, {});
  // Where nothing has changed no update need follow, in which the chart would stop being listed.
  if (any) labels_.touched.push_back(chart);
  return any;
}

std::vector<std::int32_t> State::neighbours(std::int32_t chart) const {
  std::vector<std::int32_t> some;
  for_each_neighbour(chart, [&](std::int32_t l) { some.push_back(l); });
  sort_unique(some);
  return some;
}

void State::add_neighbours(std::vector<std::int32_t>& charts) const {
  for (std::size_t i = 0, n = charts.size(); i < n; ++i) {
    const std::vector<std::int32_t> beside = neighbours(charts[i]);
    charts.insert(charts.end(), beside.begin(), beside.end());
  }
  sort_unique(charts);
}

SharedBoundary State::shared_boundary(std::int32_t chart) const {
  SharedBoundary found;
  for (const std::int32_t h : complex.loop(chart)) {
    const double length = (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
    found.all += length;
    const std::int32_t k = labels.across(h);
    if (k == kNone || k == chart) continue;
    (labels.charts[k].region == labels.charts[chart].region ? found.with : found.others)[k] += length;
  }
  return found;
}

std::vector<std::int32_t> State::loop_together(std::int32_t kept, std::int32_t gone) const {
  const auto a = complex.loop(kept), b = complex.loop(gone);
  std::vector<std::int32_t> together;
  // Two discs are a disc together if they share one path and no vertex beyond it.
  std::size_t shared = 0, common = 0;
  labels.vertex_marks.clear();
  for (const std::int32_t h : a) {
    shared += labels.across(h) == gone;
    labels.vertex_marks.add(mesh.from(h));
  }
  for (const std::int32_t h : b) common += labels.vertex_marks.has(mesh.from(h));
  if (shared == 0 || shared == a.size() || shared == b.size() || common != shared + 1) return together;
  const auto add_rest = [&](std::span<const std::int32_t> loop, std::int32_t other) {
    std::size_t i = 0;  // after the path
    const auto n = loop.size();
    while (labels.across(loop[i]) == other || labels.across(loop[(i + n - 1) % n]) != other) ++i;
    for (; labels.across(loop[i % n]) != other; ++i) together.push_back(loop[i % n]);
  };
  add_rest(a, gone);
  add_rest(b, kept);
  return together;
}

void State::unite(std::int32_t kept, std::int32_t gone, std::vector<std::int32_t> loop) {
  ISIMP_ASSERT(kept != gone && labels.charts[kept].face != kNone && labels.charts[gone].face != kNone,
               "two charts that are there become one");
  ISIMP_ASSERT(!loop.empty(), "two charts are a disc together");
  const Chart kept_chart = labels.charts[kept], gone_chart = labels.charts[gone];
  std::vector<std::int32_t> between;
  for (const std::int32_t h : complex.loop(gone))
    if (labels.across(h) == kept) between.insert(between.end(), {mesh.from(h), mesh.to(h)});
  for (const std::int32_t f : labels.faces_of(gone)) labels_.label.set(f, kept);
  if (kept_chart.cause == Cause::repair) labels_.charts.edit(kept).cause = gone_chart.cause;
  labels_.charts.edit(gone).face = kNone;
  labels_.touched.push_back(kept);
  pending_.discs.erase(kept);
  // Most of the area of each chart is of the same region, so most of their union is of it too.
  if (kept_chart.region == gone_chart.region && planes[kept].projected > 0 && planes[gone].projected > 0) {
    Plane& plane = planes_.edit(kept);
    plane = united(plane, planes[gone]);
    hold_by_hand(plane, partition, kept_chart.region, mesh.origin());
    if (plane.projected > kNoDirection * plane.area &&
        !pending_.known.try_emplace(kept, Known{1, false, std::move(loop)}).second)
      pending_.known[kept].touches = 0;
  }
  set_diagonals(kept, {});
  set_diagonals(gone, {});
  complex_.forget(gone);
  pending_.united.push_back(gone);
  for (const std::int32_t v : between) drop_corner(v);
}

void State::touch(std::span<const std::int32_t> charts) {
  labels_.touched.insert(labels_.touched.end(), charts.begin(), charts.end());
}

void State::hand_over(std::int32_t giver, std::int32_t taker, std::span<const std::int32_t> faces,
                      std::span<const std::int32_t> charts) {
  ISIMP_ASSERT(giver != taker &&
                   std::all_of(faces.begin(), faces.end(), [&](std::int32_t f) { return labels.label[f] == giver; }),
               "the giver has the faces that it hands over");
  for (const std::int32_t f : faces) labels_.label.set(f, taker);
  if (labels.label[labels.charts[giver].face] != giver) {
    const std::int32_t kept = face_beside(labels, faces, giver);
    ISIMP_ASSERT(kept != kNone, "a chart keeps some of its faces");
    labels_.charts.edit(giver).face = kept;
  }
  touch(charts);
  if (mesh.face_count() / kFacesAChart < labels.chart_count()) return;
  pending_.handed_faces.insert(pending_.handed_faces.end(), faces.begin(), faces.end());
  const auto is_simple = [&](std::int32_t l) {  // neither held nor of a region that may change with its faces
    return labels.charts[l].cause == Cause::region && !planes[l].held &&
           planes[l].projected > kNoDirection * planes[l].area;
  };
  const Plane part = plane_of(mesh, faces, labels.outlying);
  const bool simple = part.projected > kNoDirection * part.area && is_simple(giver) && is_simple(taker);
  for (const std::int32_t l : charts)
    if (simple || (l != giver && l != taker)) ++pending_.known[l].touches;
  if (!simple) return;
  planes_.set(giver, without(planes[giver], part));
  planes_.set(taker, united(planes[taker], part));
  pending_.known[giver].has_moved = pending_.known[taker].has_moved = true;
}

std::vector<std::int32_t> State::loop_again(std::int32_t chart) const {
  const auto loop = complex.loop(chart);
  auto at = std::find_if(loop.begin(), loop.end(),
                         [&](std::int32_t h) { return labels.label[h / 3] == chart && !labels.inner(h); });
  std::vector<std::int32_t> again;
  if (at == loop.end()) return again;
  const std::int32_t start = *at;
  std::int32_t h = start;
  do {
    ISIMP_ASSERT(again.size() < 3 * labels.label.size(), "a boundary closes");
    again.push_back(h);
    // At other vertices the old boundary is still valid, and to read it is faster than to search for the next edge.
    if (labels.vertex_marks.has(mesh.to(h)) || (at = find_round(loop, at, h)) == loop.end()) {
      h = labels.next_on_boundary(h);
      if (at == loop.end()) at = loop.begin();
    } else {
      if (++at == loop.end()) at = loop.begin();
      h = *at;
    }
  } while (h != start);
  return again;
}

void State::move_onto(std::span<const Plane> planes_by_chart, std::span<const std::int32_t> moving) {
  meshing::place(polygons, mesh, planes_by_chart, moving, std::max(options.flatten, 1), threads, corners_);
}

void State::limit(std::span<const std::int32_t> moving) {
  set_radii(polygons, mesh, options.reach * mesh.diagonal(), moving, corners_);
  // Among faces of the scan alone a corner has its place already.
  for (const std::int32_t c : moving) {
    const auto around = polygons.at(c);
    if (std::all_of(around.begin(), around.end(), [&](std::int32_t q) { return labels.is_face(polygons.chart(q)); }))
      corners_.radius.set(c, 0);
  }
}

void State::place(std::span<const std::int32_t> moving, bool from_vertices) {
  if (from_vertices)
    for (const std::int32_t c : moving) move(c, mesh.vertices()[corners.vertex[c]]);
  meshing::place(polygons, mesh, planes, moving, options.flatten, threads, corners_);
}

std::vector<std::int32_t> State::take_stale() {
  std::vector<std::int32_t> some;
  for (std::size_t c = 0; c < stale_.size(); ++c)
    if (stale_[c] != 0 && !polygons.at(static_cast<std::int32_t>(c)).empty())
      some.push_back(static_cast<std::int32_t>(c));
  stale_.assign(std::vector<std::uint8_t>(stale_.size(), 0));
  return some;
}

std::vector<Vec3> State::better_places(std::span<const std::int32_t> moving, bool from_vertices) {
  std::vector<Vec3> before, after;
  for (const std::int32_t c : moving) before.push_back(corners.position[c]);
  limit(moving);
  place(moving, from_vertices);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    after.push_back(corners.position[moving[i]]);
    move(moving[i], before[i]);
  }
  return after;
}

void State::begin_transaction() {
  ISIMP_ASSERT(labels.touched.empty() && pending_.united.empty() && !complex.is_pending(),
               "a transaction begins with a state that is up to date");
  polygons_.close_gaps();
  for_each_array(*this, [](auto& array) { array.begin_transaction(); });
}

void State::commit() {
  for_each_array(*this, [](auto& array) { array.commit(); });
}

void State::rollback() {
  for_each_array(*this, [](auto& array) { array.rollback(); });
  labels_.touched.clear();
  complex_.drop_pending();
  pending_ = {};
}

std::vector<std::int32_t> State::take_touched(std::map<std::int32_t, Known>& known) {
  std::vector<std::int32_t> touched = std::exchange(labels_.touched, {});
  std::sort(touched.begin(), touched.end());
  for (std::size_t i = 0, end = 0; i < touched.size(); i = end) {
    while (end < touched.size() && touched[end] == touched[i]) ++end;
    const auto at = known.find(touched[i]);
    if (at != known.end() && at->second.touches != static_cast<std::int32_t>(end - i)) known.erase(at);
  }
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  // A chart may have been united with another since it was touched.
  std::erase_if(touched, [&](std::int32_t l) { return labels.charts[l].face == kNone; });
  return touched;
}

void State::derive_charts(std::span<const std::int32_t> touched, Pending& pending) {
  planes_.resize(labels.charts.size());
  diagonals_.resize(labels.charts.size());
  std::vector<std::vector<std::int32_t>> loops(touched.size());
  labels.face_marks.clear();
  labels.vertex_marks.clear();
  for (const std::int32_t f : pending.handed_faces)
    for (const std::int32_t v : mesh.triangles()[f]) labels.vertex_marks.add(v);
  const std::span<Chart> charts = labels_.charts.edit_all(touched);
  const std::span<Plane> fitted = planes_.edit_all(touched);
  const auto known_loop = [&](std::int32_t l) {
    const auto known = pending.known.find(l);
    if (known == pending.known.end()) return std::vector<std::int32_t>();
    if (!known->second.loop.empty()) return std::move(known->second.loop);
    if (known->second.has_moved) return loop_again(l);
    return std::vector<std::int32_t>(complex.loop(l).begin(), complex.loop(l).end());
  };
  const auto derive = [&](std::int32_t l, std::vector<std::int32_t>& loop) {
    loop = known_loop(l);
    if (!loop.empty()) return;
    std::vector<std::int32_t> faces;
    if (const auto disc = pending.discs.find(l); disc != pending.discs.end()) {
      faces = std::move(disc->second.faces);
      loop = std::move(disc->second.loop);
    } else {
      faces = labels.flood(l);
      loop = labels.loop_from(boundary_start(labels, faces));
    }
    charts[l].region = region_of(l, faces);
    fitted[l] = plane_of(mesh, faces, labels.outlying);
    hold_by_hand(fitted[l], partition, charts[l].region, mesh.origin());
  };
  threads.blocks(static_cast<std::int32_t>(loops.size()), 4, [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    job_.poll();
    for (std::int32_t i = begin; i < end; ++i) derive(touched[i], loops[i]);
  });
  ISIMP_ASSERT(planes.size() == labels.charts.size() && diagonals.size() == labels.charts.size(),
               "every chart has a plane and diagonals");
  complex_.refresh(touched, std::move(loops), job_);
  for (const Tip& tip : tips_) {
    if (!corners.is_shared(tip.vertices)) continue;
    const std::vector<std::int32_t> some = charts_of(labels, tip.vertices);
    if (std::ranges::find_first_of(some, touched) == some.end()) continue;
    for (const std::int32_t v : bends_at(labels, complex, tip)) drop_corner(v);
  }
}

std::vector<std::int32_t> State::part_tips() {
  std::vector<std::int32_t> charts;
  for (const Tip& tip : tips_) {
    if (!corners.is_shared(tip.vertices) || is_whole(labels, complex, tip)) continue;
    corners_.part(tip.nearest, tip.vertices);
    const std::vector<std::int32_t> some = charts_of(labels, tip.vertices);
    charts.insert(charts.end(), some.begin(), some.end());
  }
  return charts;
}

std::vector<std::int32_t> State::update(std::vector<std::int32_t> changed, bool in_place) {
  job_.poll();
  Pending pending = std::exchange(pending_, {});
  derive_charts(take_touched(pending.known), pending);
  const std::vector<std::int32_t> cornered = complex_.make_regular();
  changed.insert(changed.end(), cornered.begin(), cornered.end());
  changed.insert(changed.end(), pending.united.begin(), pending.united.end());
  const std::vector<std::int32_t> parted = part_tips();
  changed.insert(changed.end(), parted.begin(), parted.end());
  std::vector<bool> used;  // by corner, before the polygons change; a transaction keeps it
  if (in_place && !polygons.in_transaction())
    for (std::int32_t c = 0; c < corners.count(); ++c) used.push_back(polygons.was_used(c));
  collect(changed);
  sort_unique(changed);
  sort_unique(pending.at_home);
  const auto keeps = [&](std::int32_t c) {
    const bool was_used = polygons.in_transaction() ? polygons.was_used(c) : c < std::ssize(used) && used[c];
    return (in_place && was_used) || std::binary_search(pending.at_home.begin(), pending.at_home.end(), c);
  };
  const std::vector<std::int32_t> moved = polygons.corners_of(changed);
  limit(moved);
  stale_.resize(corners.count());
  std::vector<std::int32_t> moving;
  for (const std::int32_t c : moved) {
    mark_stale(c);
    if (keeps(c))
      corners_.position.restore(c);
    else
      moving.push_back(c);
  }
  for (const std::int32_t c : pending.at_home) move(c, mesh.vertices()[corners.vertex[c]]);
  job_.poll();
  placed_ += static_cast<std::int64_t>(moving.size());
  place(moving, true);
  ISIMP_ASSERT(std::all_of(moved.begin(), moved.end(), [&](std::int32_t c) { return corners.position[c].allFinite(); }),
               "corners have places");
  ISIMP_ASSERT(!complex.is_pending(), "corners are up to date");
  return polygons.charts_at(moved);
}

}  // namespace isimp::meshing
