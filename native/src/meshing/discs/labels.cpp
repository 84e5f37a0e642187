#include "discs/labels.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "isimp/core/check.h"
#include "isimp/core/errors.h"
#include "isimp/core/prefetch.h"

namespace isimp::meshing {
namespace {

constexpr std::int32_t kLabelsAPoll = 1 << 13;  ///< work: faces or vertices from one poll to the next

/// Whether faces of one label can be reached from each other by way of each other. Uses no marks, which callers may.
[[maybe_unused]] bool hang_together(const Labels& labels, std::span<const std::int32_t> faces) {
  std::unordered_set<std::int32_t> left(faces.begin(), faces.end());
  std::vector<std::int32_t> stack{faces.front()};
  left.erase(faces.front());
  while (!stack.empty()) {
    const std::int32_t f = stack.back();
    stack.pop_back();
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (labels.inner(h) && left.erase(labels.mesh.opposite(h) / 3) > 0) stack.push_back(labels.mesh.opposite(h) / 3);
  }
  return left.empty();
}

/// Whether every chart that is there has a face with its label.
[[maybe_unused]] bool have_faces(const Labels& labels) {
  for (std::int32_t l = 0; l < labels.chart_count(); ++l)
    if (const std::int32_t f = labels.charts[l].face; f != kNone && labels.label[f] != l) return false;
  return true;
}

}  // namespace

bool Shape::is_disc() const { return components == 1 && loops.size() == 1 && genus == 0 && pinches == 0; }

std::int32_t Shape::longest_loop(const Mesh& mesh) const {
  std::int32_t longest = 0;
  double most = -1;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    double length = 0;
    for (const std::int32_t h : loops[i])
      length += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
    if (length <= most) continue;
    most = length;
    longest = static_cast<std::int32_t>(i);
  }
  return longest;
}

Labels::Labels(const Mesh& m)
    : mesh(m),
      label(static_cast<std::size_t>(m.face_count()), kNone),
      face_marks(m.face_count()),
      vertex_marks(m.vertex_count()),
      halfedge_marks(3 * static_cast<std::size_t>(m.face_count())) {}

std::vector<std::int32_t> Labels::faces_of(std::int32_t chart) const {
  face_marks.clear();
  return flood(chart);
}

std::vector<std::int32_t> Labels::flood(std::int32_t chart) const {
  ISIMP_ASSERT(charts[chart].face != kNone, "a chart that is flooded has a face");
  ISIMP_ASSERT(label[charts[chart].face] == chart, "the face of a chart has its label");
  std::vector<std::int32_t> faces{charts[chart].face};
  face_marks.add(faces[0]);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + kAhead < faces.size()) prefetch(&mesh.opposite()[3 * static_cast<std::size_t>(faces[i + kAhead])]);
    for (std::int32_t h = 3 * faces[i], end = h + 3; h < end; ++h) {
      const std::int32_t o = mesh.opposite(h), g = o / 3;
      if (o != kNone && label[g] == chart && face_marks.add(g)) faces.push_back(g);
    }
  }
  walked.fetch_add(static_cast<std::int64_t>(faces.size()), std::memory_order_relaxed);
  return faces;
}

std::vector<std::int32_t> Labels::loop_from(std::int32_t h) const {
  ISIMP_ASSERT(!inner(h), "a loop begins on the boundary");
  std::vector<std::int32_t> loop;
  std::int32_t g = h;
  do {
    if (loop.size() == 3 * label.size()) throw Error("a boundary of polygons does not close; please report this mesh");
    loop.push_back(g);
    g = next_on_boundary(g);
  } while (g != h);
  return loop;
}

std::int32_t Labels::part(std::span<const std::int32_t> faces, std::int32_t stays, Cause cause) {
  ISIMP_ASSERT(!faces.empty(), "what goes is not empty");
  const std::int32_t from = label[faces[0]], to = chart_count();
  ISIMP_ASSERT(std::all_of(faces.begin(), faces.end(), [&](std::int32_t f) { return label[f] == from; }),
               "what goes is of one chart");
  for (const std::int32_t f : faces) label.set(f, to);
  ISIMP_ASSERT(label[stays] == from, "what stays is not empty");
  ISIMP_ASSERT(cause == Cause::handle || hang_together(*this, faces), "what goes is connected");
  charts.edit(from).face = stays;
  charts.push_back({faces[0], charts[from].region, cause});
  if (charts[from].cause == Cause::region) {  // it stands for the region, so it needs a face of it
    const auto is_own = [&](std::int32_t f) { return face_region[f] == charts[from].region; };
    const auto has_own = [&](std::span<const std::int32_t> some) {
      return std::any_of(some.begin(), some.end(), is_own);
    };
    if (!is_own(stays) && !has_own(faces_of(from)) && has_own(faces)) {
      charts.edit(from).cause = cause;
      charts.edit(to).cause = Cause::region;
    }
  }
  touched.insert(touched.end(), {from, to});
  return to;
}

Shape Labels::shape(std::span<const std::int32_t> faces, bool check_components) const {
  Shape s;
  vertex_marks.clear();
  halfedge_marks.clear();
  std::int64_t boundary = 0, inside = 0;
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      if (inner(h) || halfedge_marks.has(h)) continue;
      auto& loop = s.loops.emplace_back();
      for (std::int32_t g = h; halfedge_marks.add(g); g = next_on_boundary(g)) {
        loop.push_back(g);
        if (vertex_marks.add(mesh.from(g))) continue;
        ++s.pinches;
        s.pinch_vertex = mesh.from(g);
      }
      boundary += static_cast<std::int64_t>(loop.size());
    }
  for (const std::int32_t f : faces)
    for (const std::int32_t v : mesh.triangles()[f]) inside += vertex_marks.add(v);
  if (check_components) {
    s.components = 0;
    face_marks.clear();
    std::vector<std::int32_t> stack;
    for (const std::int32_t start : faces) {
      if (!face_marks.add(start)) continue;
      ++s.components;
      stack.push_back(start);
      while (!stack.empty()) {
        const std::int32_t f = stack.back();
        stack.pop_back();
        for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
          if (inner(h) && face_marks.add(mesh.opposite(h) / 3)) stack.push_back(mesh.opposite(h) / 3);
      }
    }
  }
  // A pinch counts as two vertices, so 2 chi = 2 V - 2 E + 2 F with V = inside + boundary, 2 E = 3 F + boundary.
  const std::int64_t chi = (2 * inside + boundary - static_cast<std::int64_t>(faces.size())) / 2;
  s.genus = static_cast<std::int32_t>((2 * s.components - static_cast<std::int64_t>(s.loops.size()) - chi) / 2);
  return s;
}

namespace {

/// A face during the search for charts. Each face of a chart hangs on a lower one, down to the lowest of the chart.
struct Hung {
  std::int32_t region, on;
};

std::int32_t lowest(std::vector<Hung>& faces, std::int32_t f) {
  while (faces[f].on != f) f = faces[f].on = faces[faces[f].on].on;
  return f;
}

/// Adds half-edge h to the boundary if the face across it, which is lower, is of another region. Else joins the two
/// faces.
/// \param root  the lowest known face that the face of h hangs on
void join(std::int32_t h, std::int32_t o, std::int32_t& root, std::vector<Hung>& faces, Bits& between) {
  const std::int32_t f = h / 3, g = o / 3;
  if (faces[g].region != faces[f].region) {
    between.add(h);
    between.add(o);
  } else if (faces[g].on != root) {
    const std::int32_t other = lowest(faces, g);
    faces[std::max(root, other)].on = std::min(root, other);
    root = std::min(root, other);
  }
}

/// Hangs faces first ... last - 1 on each other.
/// \return the half-edges with a face before the first one across
std::vector<std::int32_t> hang(const Mesh& mesh, std::span<const std::int32_t> face_region, std::int32_t first,
                               std::int32_t last, std::vector<Hung>& faces, Bits& between, const Job& job) {
  std::vector<std::int32_t> outside;
  for (std::int32_t f = first; f < last; ++f) {
    if (f % kLabelsAPoll == 0) job.poll();
    if (f + kAhead < last)
      for (std::int32_t h = 3 * (f + kAhead), end = h + 3; h < end; ++h)
        if (mesh.opposite(h) < h) prefetch(&faces[std::max(mesh.opposite(h), 0) / 3]);
    faces[f] = {face_region[f], f};
    if (face_region[f] == kNone) continue;
    std::int32_t root = f;
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      const std::int32_t o = mesh.opposite(h), g = o / 3;
      if (o == kNone) {
        between.add(h);
      } else if (g < first) {
        outside.push_back(h);
      } else if (g < f) {
        join(h, o, root, faces, between);
      }
    }
    faces[f].on = root;
  }
  return outside;
}

}  // namespace

Bits label_charts(Labels& labels, std::span<const std::int32_t> face_region, const Threads& threads, const Job& job) {
  const Mesh& mesh = labels.mesh;
  labels.face_region = face_region;
  const std::int32_t count = mesh.face_count();
  Bits between(3 * static_cast<std::size_t>(count));
  std::vector<Hung> faces(count);
  // work: parts of the faces whose half-edges begin with a word of the bits.
  constexpr std::int32_t kAligned = 64;
  const std::int32_t parts = threads.pieces(count);
  std::vector<std::vector<std::int32_t>> outside(parts);
  threads.run(count / kAligned + 1, parts, [&](std::int32_t part, std::int32_t begin, std::int32_t end) {
    outside[part] = hang(mesh, face_region, kAligned * begin, std::min(kAligned * end, count), faces, between, job);
  });
  for (const std::vector<std::int32_t>& some : outside)
    for (const std::int32_t h : some) {
      std::int32_t root = lowest(faces, h / 3);
      join(h, mesh.opposite(h), root, faces, between);
    }
  std::vector<bool> seen;
  for (std::int32_t f = 0; f < count; ++f) {
    const auto [region, on] = faces[f];
    if (region == kNone) continue;
    if (on != f) {
      labels.label.set(f, labels.label[on]);
      continue;
    }
    labels.label.set(f, labels.chart_count());
    if (seen.size() <= static_cast<std::size_t>(region)) seen.resize(region + 1, false);
    labels.charts.push_back({f, region, seen[region] ? Cause::unconnected : Cause::region});
    seen[region] = true;
  }
  ISIMP_ASSERT(have_faces(labels), "every chart has a face with its label");
  return between;
}

Outlines trace_outlines(const Labels& labels, const Bits& boundary, const Job& job) {
  const Mesh& mesh = labels.mesh;
  std::vector<std::int32_t> walked, loop_start;
  Bits left = boundary;
  for (std::int64_t first = left.next(0); first >= 0; first = left.next(first)) {
    job.poll();
    loop_start.push_back(static_cast<std::int32_t>(walked.size()));
    for (auto h = static_cast<std::int32_t>(first); left.has(h);) {
      left.remove(h);
      walked.push_back(h);
      h = Mesh::next(h);
      while (!boundary.has(h)) h = Mesh::next(mesh.opposite(h));
    }
  }
  loop_start.push_back(static_cast<std::int32_t>(walked.size()));
  // The loops sorted by chart.
  Outlines o{std::vector<std::int32_t>(walked.size()), {}, {}};
  o.start.assign(labels.charts.size() + 1, 0);
  o.loops.assign(labels.charts.size(), 0);
  const auto chart = [&](std::size_t loop) { return labels.label[walked[loop_start[loop]] / 3]; };
  for (std::size_t i = 0; i + 1 < loop_start.size(); ++i) {
    ++o.loops[chart(i)];
    o.start[chart(i) + 1] += loop_start[i + 1] - loop_start[i];
  }
  std::partial_sum(o.start.begin(), o.start.end(), o.start.begin());
  std::vector<std::int32_t> fill(o.start.begin(), o.start.end() - 1);
  for (std::size_t i = 0; i + 1 < loop_start.size(); ++i) {
    std::copy(walked.begin() + loop_start[i], walked.begin() + loop_start[i + 1], o.halfedges.begin() + fill[chart(i)]);
    fill[chart(i)] += loop_start[i + 1] - loop_start[i];
  }
  return o;
}

std::vector<std::int32_t> find_non_discs(Labels& labels, const Outlines& outlines, const Threads& threads,
                                         const Job& job) {
  const Mesh& mesh = labels.mesh;
  labels.vertex_marks.clear();
  for (const std::int32_t h : outlines.halfedges) labels.vertex_marks.add(mesh.from(h));
  // By piece of the mesh: 2 * inner vertices - faces of each chart. One piece if there are too many charts to add pieces.
  const bool is_fine = labels.chart_count() > mesh.face_count() / 16;
  const std::int32_t parts = is_fine ? 1 : threads.pieces(mesh.face_count());
  std::vector<std::vector<std::int32_t>> inside(parts, std::vector<std::int32_t>(labels.charts.size(), 0));
  threads.run(mesh.face_count(), parts, [&](std::int32_t part, std::int32_t begin, std::int32_t end) {
    for (std::int32_t f = begin; f < end; ++f)
      if (const std::int32_t l = labels.label[f]; l != kNone) --inside[part][l];
  });
  threads.run(mesh.vertex_count(), parts, [&](std::int32_t part, std::int32_t begin, std::int32_t end) {
    for (std::int32_t v = begin; v < end; ++v) {
      if (v % kLabelsAPoll == 0) job.poll();
      const std::int32_t h = mesh.vertex_halfedge()[v];
      if (h == kNone || labels.label[h / 3] == kNone || labels.vertex_marks.has(v)) continue;
      inside[part][labels.label[h / 3]] += 2;
    }
  });
  std::vector<std::int32_t> found;
  for (std::int32_t l = 0; l < labels.chart_count(); ++l) {
    const auto outline = outlines.of(l);
    bool pinched = false;
    labels.vertex_marks.clear();
    for (const std::int32_t h : outline) pinched = !labels.vertex_marks.add(mesh.from(h)) || pinched;
    std::int64_t chi2 = static_cast<std::int64_t>(outline.size());
    for (const std::vector<std::int32_t>& some : inside) chi2 += some[l];
    const std::int64_t chi = chi2 / 2;
    if (outlines.loops[l] != 1 || chi != 1 || pinched) found.push_back(l);
  }
  return found;
}

namespace {

/// The chart with an area along most of whose boundary a chart lies, kNone if none touches it.
std::int32_t neighbour_with_area(const Labels& labels, std::int32_t chart, const std::vector<bool>& thin) {
  const Mesh& mesh = labels.mesh;
  std::map<std::int32_t, double> length;
  for (const std::int32_t f : labels.faces_of(chart))
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (const std::int32_t l = labels.across(h); l != kNone && l != chart && !thin[l])
        length[l] += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
  std::int32_t best = kNone;
  double longest = -1;
  for (const auto& [l, x] : length)
    if (x > longest) {
      longest = x;
      best = l;
    }
  return best;
}

/// Half the diagonal of a chart's bounding box.
double extent_of(const Labels& labels, std::int32_t chart) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;
  for (const std::int32_t f : labels.faces_of(chart))
    for (const std::int32_t v : labels.mesh.triangles()[f]) {
      low = low.cwiseMin(labels.mesh.vertices()[v]);
      high = high.cwiseMax(labels.mesh.vertices()[v]);
    }
  return (high - low).norm() / 2;
}

}  // namespace

void drop_gone(Labels& labels) {
  std::vector<std::int32_t> moved(labels.charts.size());
  std::int32_t next = 0;
  for (std::size_t l = 0; l < moved.size(); ++l) moved[l] = labels.charts[l].face == kNone ? kNone : next++;
  for (std::size_t f = 0; f < labels.label.size(); ++f)
    if (const std::int32_t l = labels.label[f]; l != kNone) labels.label.set(f, moved[l]);
  std::vector<Chart> charts = labels.charts;
  std::erase_if(charts, [](const Chart& p) { return p.face == kNone; });
  labels.charts.assign(std::move(charts));
  ISIMP_ASSERT(have_faces(labels), "the labels that are left move down with their charts");
}

bool keeps_own(const Labels& labels, std::int32_t chart, std::span<const std::int32_t> faces) {
  const auto [face, region, cause] = labels.charts[chart];
  const auto stays = [&, region = region](std::int32_t f) {
    return labels.face_region[f] == region && !std::binary_search(faces.begin(), faces.end(), f);
  };
  if (stays(face)) return true;
  const std::vector<std::int32_t> all = labels.faces_of(chart);
  return std::any_of(all.begin(), all.end(), stays);
}

Bits boundary_of(const Labels& labels) {
  Bits boundary(3 * labels.label.size());
  for (std::int32_t h = 0; h < 3 * labels.mesh.face_count(); ++h)
    if (labels.label[h / 3] != kNone && !labels.inner(h)) boundary.add(h);
  return boundary;
}

std::int32_t merge_charts_without_area(Labels& labels, double thickness, Bits& boundary) {
  const Mesh& mesh = labels.mesh;
  std::vector<double> area(labels.charts.size(), 0);  // at least as far as it takes to see that there is one
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (const std::int32_t l = labels.label[f]; l != kNone && area[l] <= thickness * mesh.diagonal())
      area[l] += mesh.graph().area * mesh.graph().faces[mesh.graph().graph_face[f]].area;
  std::vector<std::int32_t> empty;
  std::vector<bool> thin(labels.charts.size(), false);
  for (std::int32_t l = 0; l < labels.chart_count(); ++l) {
    if (area[l] > thickness * mesh.diagonal()) continue;
    thin[l] = area[l] <= thickness * extent_of(labels, l);
    if (thin[l]) empty.push_back(l);
  }
  std::int32_t gone = 0;
  for (bool any = true; any;) {  // a chart among others without area has to wait until one of them is merged
    any = false;
    for (std::int32_t& l : empty) {
      const std::int32_t to = l == kNone ? kNone : neighbour_with_area(labels, l, thin);
      if (to == kNone) continue;
      for (const std::int32_t f : labels.faces_of(l)) labels.label.set(f, to);
      labels.charts.edit(l).face = kNone;
      l = kNone;
      ++gone;
      any = true;
    }
  }
  if (gone == 0) return 0;
  drop_gone(labels);
  for (std::int64_t h = boundary.next(0); h >= 0; h = boundary.next(h + 1))
    if (labels.inner(static_cast<std::int32_t>(h))) boundary.remove(static_cast<std::int32_t>(h));
  return gone;
}

}  // namespace isimp::meshing
