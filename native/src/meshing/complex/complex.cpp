#include "complex/complex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "complex/angles.h"
#include "discs/polyline.h"
#include "isimp/core/check.h"
#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {
// tuned street
constexpr double kOfTriangle = 0.2;  ///< share of its chart's area that a triangle may leave out or add

/// The same for a triangle between three junctions that is no needle. The largest in a rectangle leaves out half of it.
constexpr double kOfThree = 0.45;
}  // namespace

Complex::Complex(const Labels& labels, const Logged<Plane>& planes)
    : labels_(labels),
      mesh_(labels.mesh),
      planes_(planes),
      corner_(static_cast<std::size_t>(labels.mesh.vertex_count()), 0) {}

int Complex::boundary_edges(std::int32_t vertex) const {
  int edges = 0;
  std::int32_t last = kNone;
  for_each_leaving(mesh_, vertex, [&](std::int32_t h) {
    edges += !labels_.inner(h);
    last = h;
  });
  edges += mesh_.opposite(Mesh::prev(last)) == kNone;  // the border edge that arrives
  return edges;
}

void Complex::refresh(std::span<const std::int32_t> charts, std::vector<std::vector<std::int32_t>> loops,
                      const Job& job) {
  ISIMP_ASSERT(charts.size() == loops.size() && std::is_sorted(charts.begin(), charts.end()),
               "there is a loop for each chart, in rising order");
  loops_.resize(labels_.charts.size());
  chords_.resize(labels_.charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    job.poll();
    ISIMP_ASSERT(!loops[i].empty(), "a chart is a disc, with a boundary");
    ISIMP_ASSERT(std::all_of(loops[i].begin(), loops[i].end(),
                             [&](std::int32_t h) {
                               return labels_.label[h / 3] == charts[i] && labels_.across(h) != charts[i];
                             }),
                 "a loop is of boundary half-edges of its chart");
    loops_.set(charts[i], std::move(loops[i]));
    add_anchors(loops_[charts[i]]);
    seed_ring(charts[i]);
  }
  dirty_.insert(dirty_.end(), charts.begin(), charts.end());
  collect_dirty();
  for (const std::int32_t l : charts) {
    job.poll();
    subdivide_chords(l, charts);
  }
  for (const std::int32_t l : charts) {
    job.poll();
    keep_shape(l);
  }
}

/// Adds a corner at each vertex where the chart across changes. A disc touches a vertex only once, so at all other
/// vertices only two charts meet.
void Complex::add_anchors(std::span<const std::int32_t> loop) {
  std::int32_t last = labels_.across(loop.back());
  for (const std::int32_t h : loop) {
    const std::int32_t across = labels_.across(h);
    if (across != last && !is_corner(mesh_.from(h))) add_corner(mesh_.from(h));
    last = across;
  }
}

/// A boundary without any corner gets two that are far apart, so that a square begins with two of its own corners.
void Complex::seed_ring(std::int32_t chart) {
  const auto& loop = loops_[chart];
  if (std::any_of(loop.begin(), loop.end(), [&](std::int32_t h) { return is_corner(mesh_.from(h)); })) return;
  const auto farthest_from = [&](std::int32_t v) {
    std::int32_t best = v;
    double most = -1;
    for (const std::int32_t h : loop) {
      const double d = (mesh_.vertices()[mesh_.from(h)] - mesh_.vertices()[v]).squaredNorm();
      if (d <= most * (1 + 1e-12)) continue;
      most = d;
      best = mesh_.from(h);
    }
    return best;
  };
  const std::int32_t a = farthest_from(mesh_.from(loop[0])), b = farthest_from(a);
  add_corner(a);
  add_corner(b);
}

double Complex::sine_at(std::int32_t chord) const {
  const std::int32_t other = labels_.across(chord);
  if (other == kNone) return 1;
  const Vec3 &left = planes_[labels_.label[chord / 3]].normal, &right = planes_[other].normal;
  return left.dot(right) < 0 ? 1.0 : std::max(left.cross(right).norm(), tolerance.least_sine);
}

bool Complex::has_chord(std::int32_t a, std::int32_t b) const {
  const auto leads = [&](std::int32_t from, std::int32_t to) {
    bool found = false;
    for_each_leaving(mesh_, from, [&](std::int32_t h) {
      const auto& chords = chords_[labels_.label[h / 3]];
      const auto at = std::find(chords.begin(), chords.end(), h);
      if (at == chords.end()) return;
      found = found || mesh_.from(at + 1 == chords.end() ? chords.front() : at[1]) == to;
    });
    return found;
  };
  return leads(a, b) || leads(b, a);  // along the border of the mesh it can be seen from one end only
}

std::size_t Complex::place_of(std::int32_t chord) const {
  const auto& loop = loops_[labels_.label[chord / 3]];
  const auto at = std::find(loop.begin(), loop.end(), chord);
  ISIMP_ASSERT(at != loop.end(), "a chord is in the loop of its chart");
  return at - loop.begin();
}

void Complex::collect_line(std::span<const std::int32_t> loop, std::size_t at, std::vector<Vec3>& line) const {
  const std::size_t start = at;
  std::int32_t v = mesh_.from(loop[at]);
  line.clear();
  do {
    line.push_back(mesh_.vertices()[v]);
    if (++at == loop.size()) at = 0;
    v = mesh_.from(loop[at]);
  } while (!is_corner(v) && at != start);  // the whole loop, if its corners were dropped and not yet replaced
  line.push_back(mesh_.vertices()[v]);
}

void Complex::add_corner(std::int32_t vertex) {
  ISIMP_ASSERT(boundary_edges(vertex) > 0, "a corner is on a boundary");
  corner_.set(vertex, 1);
  mark_dirty(vertex);
}

bool Complex::drop_corner(std::int32_t vertex) {
  if (is_anchor(vertex)) return false;
  corner_.set(vertex, 0);
  mark_dirty(vertex);
  return true;
}

void Complex::forget(std::int32_t chart) {
  loops_.set(chart, {});
  chords_.set(chart, {});
}

void Complex::mark_dirty(std::int32_t vertex) {
  for_each_leaving(mesh_, vertex, [&](std::int32_t h) {
    const std::int32_t l = labels_.label[h / 3];
    if (dirty_.empty() || dirty_.back() != l) dirty_.push_back(l);
  });
}

double Complex::depth(std::int32_t chord) const {
  std::vector<Vec3> line;
  collect_line(loops_[labels_.label[chord / 3]], place_of(chord), line);
  return farthest(line).distance;
}

bool Complex::bend(std::int32_t chord) {
  const auto& loop = loops_[labels_.label[chord / 3]];
  const std::size_t at = place_of(chord);
  collect_line(loop, at, line_);
  if (line_.size() < 3) return false;
  bent_.push_back(mesh_.from(loop[(at + farthest(line_).where) % loop.size()]));
  add_corner(bent_.back());
  return true;
}

/// Chooses corners on the chords of a chart that leave their paths too far, except chords that the other side handles.
void Complex::subdivide_chords(std::int32_t chart, std::span<const std::int32_t> charts) {
  const auto& loop = loops_[chart];
  std::size_t at = 0;
  for (const std::int32_t h : chords_[chart]) {
    while (loop[at] != h) ++at;
    if (!labels_.owns(h) && std::binary_search(charts.begin(), charts.end(), labels_.across(h))) continue;
    collect_line(loop, at, line_);
    take_out_zigzag(line_);
    const bool on_border = labels_.across(h) == kNone;
    const double reach = on_border ? tolerance.most_on_border : tolerance.most / sine_at(h);
    const bool ragged = on_border && tolerance.rim > 0;
    for (const std::size_t i : ragged ? simplify_ragged(line_, std::max(reach, tolerance.rim)) : simplify(line_, reach))
      add_corner(loop, at + i);
  }
}

bool Complex::is_sharp(std::span<const std::int32_t> loop, const std::array<std::size_t, 3>& at) const {
  for (int k = 0; k < 3; ++k) {
    const Vec3& p = mesh_.vertices()[mesh_.from(loop[at[k]])];
    const Vec3 a = mesh_.vertices()[mesh_.from(loop[at[(k + 1) % 3]])] - p,
               b = mesh_.vertices()[mesh_.from(loop[at[(k + 2) % 3]])] - p;
    if (a.dot(b) > kSharpCosine * a.norm() * b.norm()) return true;
  }
  return false;
}

/// Adds corners to a chart whose polygon is too different from it, however small it is. One that would become a
/// triangle, as a window or a strip, gets a fourth corner sooner.
void Complex::keep_shape(std::int32_t chart) {
  struct ChordArea {
    std::size_t at;  // where its chord begins in the loop
    double area;     // that the chord leaves out, below 0 where it adds; less the flatter the two charts meet
    double plain;    // the same however they meet
  };
  const auto& loop = loops_[chart];
  const auto area_at = [&](std::size_t at) {
    collect_line(loop, at, line_);
    if (line_.size() < 3) return ChordArea{at, 0, 0};
    take_out_zigzag(line_);
    const double area = area_left_out(line_).dot(planes_[chart].normal);
    return ChordArea{at, area * sine_at(loop[at]), area};
  };
  std::vector<ChordArea> areas;  // in the order of the loop
  for (std::size_t i = 0; i < loop.size(); ++i)
    if (is_corner(mesh_.from(loop[i]))) areas.push_back(area_at(i));
  const double allowed = tolerance.of_area * planes_[chart].area;
  while (true) {
    const bool is_triangle = areas.size() == 3;
    const bool is_needle = is_triangle && is_sharp(loop, {areas[0].at, areas[1].at, areas[2].at});
    const auto left_out = [&](const ChordArea& p) { return is_needle ? p.plain : p.area; };
    double sum = 0, most = 0;
    auto worst = areas.end();
    for (auto p = areas.begin(); p != areas.end(); ++p) {
      sum += left_out(*p);
      if (!(std::abs(left_out(*p)) > most)) continue;
      most = std::abs(left_out(*p));
      worst = p;
    }
    const bool has_three =
        is_triangle && !is_needle &&
        std::all_of(areas.begin(), areas.end(), [&](const ChordArea& p) { return is_anchor(mesh_.from(loop[p.at])); });
    const double of_triangle = (has_three ? kOfThree : kOfTriangle) * planes_[chart].area;
    const double limit = is_triangle ? std::min(of_triangle, allowed) : allowed;
    if (!(std::abs(sum) > limit) || worst == areas.end()) return;  // also where a plane is not a number
    collect_line(loop, worst->at, line_);
    take_out_zigzag(line_);
    const std::size_t at = worst->at + farthest(line_).where;
    add_corner(loop, at);
    // The chord ends there now, and another begins: the first one, if that is beyond the end of the loop.
    *worst = area_at(worst->at);
    const bool beyond = at >= loop.size();
    areas.insert(beyond ? areas.begin() : worst + 1, area_at(beyond ? at - loop.size() : at));
  }
}

void Complex::collect_dirty() {
  sort_unique(dirty_);
  for (const std::int32_t l : dirty_) {
    std::vector<std::int32_t>& chords = chords_.edit(l);
    chords.clear();
    for (const std::int32_t h : loops_[l])
      if (is_corner(mesh_.from(h))) chords.push_back(h);
  }
  ISIMP_ASSERT(
      std::all_of(dirty_.begin(), dirty_.end(), [&](std::int32_t l) { return chords_[l].size() <= loops_[l].size(); }),
      "chords begin at half-edges of the loop");
  changed_.insert(changed_.end(), dirty_.begin(), dirty_.end());
  dirty_.clear();
}

std::vector<std::int32_t> Complex::make_regular() {
  for (bool any = true; any;) {
    collect_dirty();
    sort_unique(changed_);
    any = add_third_corners();
    if (any) continue;
    const std::vector<std::int32_t> near = with_neighbours(changed_);
    // An edge or a chart can occur twice now only if all its corners are corners of changed charts.
    labels_.vertex_marks.clear();
    for (const std::int32_t l : changed_)
      for (const std::int32_t h : chords_[l]) labels_.vertex_marks.add(mesh_.from(h));
    any = part_multi_edges(near) || part_duplicates(near);
  }
  ISIMP_ASSERT(dirty_.empty(), "all chords are up to date");
  return std::exchange(changed_, {});
}

/// Some charts and all charts that have a corner in common with one of them, in rising order.
std::vector<std::int32_t> Complex::with_neighbours(std::span<const std::int32_t> charts) const {
  std::vector<std::int32_t> near;
  for (const std::int32_t l : charts)
    for (const std::int32_t h : chords_[l])
      for_each_leaving(mesh_, mesh_.from(h), [&](std::int32_t g) {
        const std::int32_t k = labels_.label[g / 3];
        if (near.empty() || near.back() != k) near.push_back(k);
      });
  sort_unique(near);
  return near;
}

bool Complex::add_third_corners() {
  bool any = false;
  for (const std::int32_t l : changed_) {
    if (chords_[l].size() >= 3 || loops_[l].empty()) continue;
    std::int32_t best = kNone;
    double most = -1;
    for (const std::int32_t h : chords_[l]) {
      const double d = depth(h);
      if (d <= most) continue;
      most = d;
      best = h;
    }
    any = (best != kNone && bend(best)) || any;
  }
  return any;
}

bool Complex::part_multi_edges(std::span<const std::int32_t> charts) {
  struct ChordOf {
    std::int32_t a, b, chord;
    auto operator<=>(const ChordOf&) const = default;
  };
  std::vector<ChordOf> entries;
  for (const std::int32_t l : charts) {
    const std::vector<std::int32_t>& chords = chords_[l];
    for (std::size_t i = 0; i < chords.size(); ++i) {
      const std::int32_t h = chords[i], a = mesh_.from(h);
      if (!labels_.vertex_marks.has(a)) continue;
      const std::int32_t b = mesh_.from(chords[i + 1 < chords.size() ? i + 1 : 0]);
      if (!labels_.vertex_marks.has(b) || !labels_.owns(h)) continue;
      entries.push_back({std::min(a, b), std::max(a, b), h});
    }
  }
  std::sort(entries.begin(), entries.end());
  bool any = false;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i + 1;
    while (end < entries.size() && entries[end].a == entries[i].a && entries[end].b == entries[i].b) ++end;
    if (end - i > 1) {
      // All but the straightest get a corner; at most one of them is a bare edge of the mesh.
      std::vector<std::pair<double, std::int32_t>> bent;
      for (std::size_t k = i; k < end; ++k) {
        bent.emplace_back(depth(entries[k].chord), entries[k].chord);
      }
      std::sort(bent.begin(), bent.end());
      for (std::size_t k = 1; k < bent.size(); ++k) any = bend(bent[k].second) || any;
    }
    i = end;
  }
  return any;
}

bool Complex::part_duplicates(std::span<const std::int32_t> charts) {
  struct CornersOf {
    std::vector<std::int32_t> corners;
    std::int32_t chart;
    auto operator<=>(const CornersOf&) const = default;
  };
  std::vector<CornersOf> entries;
  for (const std::int32_t l : charts) {
    const std::vector<std::int32_t>& chords = chords_[l];
    const auto is_marked = [&](std::int32_t h) { return labels_.vertex_marks.has(mesh_.from(h)); };
    if (loops_[l].empty() || !std::all_of(chords.begin(), chords.end(), is_marked)) continue;
    CornersOf e{{}, l};
    for (const std::int32_t h : chords) e.corners.push_back(mesh_.from(h));
    std::sort(e.corners.begin(), e.corners.end());
    entries.push_back(std::move(e));
  }
  std::sort(entries.begin(), entries.end());
  bool any = false;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    if (entries[i].corners != entries[i - 1].corners) continue;
    bool done = false;
    for (const std::size_t k : {i, i - 1})
      for (const std::int32_t h : chords_[entries[k].chart]) done = done || bend(h);
    any = any || done;
  }
  return any;
}

}  // namespace isimp::meshing
