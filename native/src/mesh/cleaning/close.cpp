#include "cleaning/close.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "isimp/core/forest.h"
#include "isimp/mesh/mesh.h"

namespace isimp::detail {
namespace {

constexpr int kClosePasses = 8;  // limit
// tuned real
constexpr double kOffPlane = 0.1;  // deviation of a flat hole's border from its plane, share of sqrt(its area)
constexpr double kAlike = 0.7;     // mean cosine between that plane and the faces around the hole

double area(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a).norm(); }

/// The components' numbers by vertex, and their areas.
struct VertexComponents {
  std::vector<std::int32_t> of_vertex;
  std::vector<double> area;

  VertexComponents(const MeshArrays& arrays, Job& job) : of_vertex(arrays.vertices.size()) {
    Forest forest(of_vertex.size());
    for_each_index(arrays.triangles.size(), job, [&](std::size_t f) {
      const auto& [a, b, c] = arrays.triangles[f];
      forest.join(a, b);
      forest.join(a, c);
    });
    for (std::size_t v = 0; v < of_vertex.size(); ++v) of_vertex[v] = forest.root(static_cast<std::int32_t>(v));
    area.assign(of_vertex.size(), 0.0);
    for (const auto& [a, b, c] : arrays.triangles)
      area[of_vertex[a]] += detail::area(arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]);
  }
};

/// Whether a hole is in one plane with the faces around it: a gap in a wall, and no end of a tube and no outer rim.
/// \param border  half-edges of the border in order
bool is_flat(const MeshArrays& arrays, const std::vector<std::int32_t>& border) {
  const auto point = [&](std::int32_t h, std::int32_t k) -> const Vec3& {
    return arrays.vertices[arrays.triangles[h / 3][(h + k) % 3]];
  };
  const Vec3& origin = point(border[0], 0);
  Vec3 doubled = Vec3::Zero(), middle = Vec3::Zero(), normals = Vec3::Zero();
  for (const std::int32_t h : border) {
    const Vec3 a = point(h, 0) - origin, b = point(h, 1) - origin;
    doubled -= a.cross(b);  // the border runs clockwise around a hole
    middle += a;
    normals += (b - a).cross(point(h, 2) - origin - a).normalized();
  }
  const auto count = static_cast<double>(border.size());
  const Vec3 normal = doubled.normalized(), centre = middle / count;
  if (normals.dot(normal) < kAlike * count) return false;
  double squares = 0;
  for (const std::int32_t h : border) {
    const double d = (point(h, 0) - origin - centre).dot(normal);
    squares += d * d;
  }
  return squares / count <= kOffPlane * kOffPlane * doubled.norm() / 2;
}

std::vector<Opening> find_holes(const MeshArrays& arrays, const Topology& topology, const CleanOptions& options) {
  const auto end = [&](std::int32_t h) { return arrays.triangles[h / 3][(h + 1) % 3]; };
  std::vector<Opening> holes;
  std::vector<bool> seen(topology.opposite.size(), false);
  for (const std::int32_t h : topology.border) {
    if (seen[h]) continue;
    std::vector<std::int32_t> loop, border;
    for (std::int32_t g = h; !seen[g]; g = topology.vertex_halfedge[end(g)]) {
      seen[g] = true;
      loop.push_back(end(g));
      border.push_back(g);
    }
    const double round = length(arrays, loop);
    if (round > options.fill_holes && (round > options.fill_flat_holes || !is_flat(arrays, border))) continue;
    std::reverse(loop.begin(), loop.end());  // a patch runs against its neighbours
    holes.push_back({RepairKind::filled_holes, {}, {std::move(loop)}, {}, round, {}});
  }
  return holes;
}

/// Covers openings with patches: with one that meets nothing else where there is one.
class Closer {
 public:
  Closer(MeshArrays& arrays, const Topology& topology, const VertexComponents* components, const Threads& threads,
         Job& job)
      : arrays_(arrays), topology_(topology), components_(components), threads_(threads), job_(job) {}

  /// Adds patches for openings that can be closed, and returns these openings. The faces to be removed stay for now. A
  /// further call may close openings that are apart from these.
  /// \param meeting  whether a patch may meet other faces where no patch of any plan meets none
  std::vector<Opening> close(std::vector<Opening> openings, bool meeting) {
    if (openings.empty()) return {};
    const std::size_t before = closed_.size();
    find_faces_near(openings);
    for (int round = 0; round < (meeting ? 2 * kPlans : kPlans); ++round) {
      std::vector<Opening> covered, left;
      for (Opening& o : openings) (find_patches(o, round % kPlans) ? covered : left).push_back(std::move(o));
      for (bool all = round >= kPlans; !all;) {  // dropped openings keep their faces, which other patches may now meet
        std::vector<Opening> dropped = drop_crossed(covered);
        all = dropped.empty();
        std::move(dropped.begin(), dropped.end(), std::back_inserter(left));
      }
      const std::size_t faces = arrays_.triangles.size();
      append(covered);
      for (std::size_t f = faces; f < arrays_.triangles.size(); ++f) near_.push_back(static_cast<std::int32_t>(f));
      std::move(covered.begin(), covered.end(), std::back_inserter(closed_));
      openings = std::move(left);
    }
    return {closed_.begin() + static_cast<std::ptrdiff_t>(before), closed_.end()};
  }

 private:
  /// Finds the faces that patches of some openings may meet: patches are inside the boxes of their loops. If all
  /// openings are near the openings of an earlier call, only the faces found then, and faces added since, are searched.
  void find_faces_near(const std::vector<Opening>& openings) {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Opening& o : openings)
      for (const std::vector<std::int32_t>& loop : o.loops) {
        Eigen::AlignedBox3d& box = boxes.emplace_back();
        for (const std::int32_t v : loop) box.extend(arrays_.vertices[v]);
      }
    const bool known = std::all_of(boxes.begin(), boxes.end(), [&](const Eigen::AlignedBox3d& box) {
      return std::any_of(wider_.begin(), wider_.end(), [&](const Eigen::AlignedBox3d& w) { return w.contains(box); });
    });
    if (!known) {
      wider_ = boxes;
      for (Eigen::AlignedBox3d& box : wider_) {
        const Vec3 more = Vec3::Constant(kWider * box.diagonal().norm());
        box = Eigen::AlignedBox3d(box.min() - more, box.max() + more);
      }
      among_ = find_near(arrays_, nullptr, wider_, threads_, job_);
    } else {
      for (std::size_t f = looked_at_; f < arrays_.triangles.size(); ++f)
        among_.push_back(static_cast<std::int32_t>(f));
    }
    looked_at_ = arrays_.triangles.size();
    near_ = find_near(arrays_, &among_, boxes, threads_, job_);
  }

  static bool is_removed(const Opening& o, std::int32_t face) {
    return std::binary_search(o.removed.begin(), o.removed.end(), face);
  }

  /// The third vertex of the face that stays at the edge of two vertices; kNone if there is none.
  [[nodiscard]] std::int32_t apex(const Opening& o, std::int32_t a, std::int32_t b) const {
    const std::int32_t start = topology_.vertex_halfedge[a];
    std::int32_t h = start;
    do {
      const Triangle& t = arrays_.triangles[h / 3];
      if (std::find(t.begin(), t.end(), b) != t.end() && !is_removed(o, h / 3))
        return *std::find_if(t.begin(), t.end(), [&](std::int32_t v) { return v != a && v != b; });
      h = topology_.opposite[Mesh::prev(h)];
    } while (h != kNone && h != start);
    return kNone;
  }

  /// Finds a patch for every loop; false if some loop has none that fits.
  bool find_patches(Opening& o, int plan) {
    o.patches.clear();
    for (const std::vector<std::int32_t>& loop : o.loops) {
      job_.poll();
      std::vector<Vec3> line, beyond;
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t far = apex(o, loop[i], loop[(i + 1) % loop.size()]);
        if (far == kNone) return false;
        line.push_back(arrays_.vertices[loop[i]]);
        beyond.push_back(arrays_.vertices[far]);
      }
      o.patches.push_back(cover(line, beyond, loop.size() == 3 ? 0 : plan));
      if (o.patches.back().empty() || adds_to_an_edge(o, loop) || (components_ && is_outline(loop, o.patches.back())))
        return false;
    }
    return true;
  }

  /// Whether the last patch has an inner edge that two faces have already.
  [[nodiscard]] bool adds_to_an_edge(const Opening& o, const std::vector<std::int32_t>& loop) const {
    const auto n = static_cast<std::int32_t>(loop.size());
    for (const auto& t : o.patches.back().triangles)
      for (int k = 0; k < 3; ++k) {
        const std::int32_t a = t[k], b = t[(k + 1) % 3];
        const bool inner = a < n && b < n && (a + 1) % n != b && (b + 1) % n != a;
        if (inner && apex(o, loop[a], loop[b]) != kNone) return true;
      }
    return false;
  }

  /// Whether the loop is rather the outline of its part than a hole in it.
  [[nodiscard]] bool is_outline(const std::vector<std::int32_t>& loop, const Patch& patch) const {
    std::vector<Vec3> points;
    points.reserve(loop.size() + patch.inner.size());
    for (const std::int32_t v : loop) points.push_back(arrays_.vertices[v]);
    points.insert(points.end(), patch.inner.begin(), patch.inner.end());
    double sum = 0;
    for (const auto& [a, b, c] : patch.triangles) sum += area(points[a], points[b], points[c]);
    return sum >= kLargestShare * components_->area[components_->of_vertex[loop[0]]];
  }

  void append(const std::vector<Opening>& openings) {
    for (const Opening& o : openings)
      for (std::size_t i = 0; i < o.loops.size(); ++i) {
        const auto n = static_cast<std::int32_t>(o.loops[i].size());
        const auto first = static_cast<std::int32_t>(arrays_.vertices.size());
        arrays_.vertices.insert(arrays_.vertices.end(), o.patches[i].inner.begin(), o.patches[i].inner.end());
        arrays_.source_vertex.resize(arrays_.vertices.size(), kNone);
        for (const auto& t : o.patches[i].triangles) {
          Triangle face;
          for (int k = 0; k < 3; ++k) face[k] = t[k] < n ? o.loops[i][t[k]] : first + t[k] - n;
          arrays_.triangles.push_back(face);
          arrays_.source_face.push_back(kNone);
        }
      }
  }

  /// Removes each opening whose patches meet other faces from `openings`, and returns the removed ones.
  std::vector<Opening> drop_crossed(std::vector<Opening>& openings) {
    if (openings.empty()) return {};
    const std::size_t vertices = arrays_.vertices.size(), faces = arrays_.triangles.size();
    append(openings);
    const std::size_t fresh = arrays_.triangles.size() - faces;
    std::vector<char> removed(arrays_.triangles.size(), 0);
    for (const std::vector<Opening>* all : {&std::as_const(closed_), &std::as_const(openings)})
      for (const Opening& o : *all)
        for (const std::int32_t f : o.removed) removed[f] = 1;
    std::vector<std::int32_t> others = near_;
    for (std::size_t f = faces; f < faces + fresh; ++f) others.push_back(static_cast<std::int32_t>(f));
    const std::vector<char> crossed = find_crossed(arrays_, others, removed, fresh, job_);
    arrays_.vertices.resize(vertices);
    arrays_.source_vertex.resize(vertices);
    arrays_.triangles.resize(faces);
    arrays_.source_face.resize(faces);

    std::vector<Opening> kept, dropped;
    auto at = crossed.begin();
    for (Opening& o : openings) {
      auto end = at;
      for (const Patch& p : o.patches) end += static_cast<std::ptrdiff_t>(p.triangles.size());
      (std::find(at, end, 1) == end ? kept : dropped).push_back(std::move(o));
      at = end;
    }
    openings = std::move(kept);
    return dropped;
  }

  // tuned repairs
  static constexpr double kLargestShare = 0.5;  // share of the area of its component: a hole has less
  static constexpr double kWider = 0.5;  // share of a box's diagonal: another loop of the handle may be that far away

  MeshArrays& arrays_;
  const Topology& topology_;
  const VertexComponents* components_;  // to distinguish holes from outlines
  const Threads& threads_;
  Job& job_;
  std::vector<Opening> closed_;
  std::vector<std::int32_t> near_;          // faces that patches may meet, faces of patches too
  std::vector<Eigen::AlignedBox3d> wider_;  // widened boxes of the last full search
  std::vector<std::int32_t> among_;         // faces near these boxes
  std::size_t looked_at_ = 0;               // number of faces at the last search
};

/// Removes the faces of openings, and the vertices that have no face left.
/// \return (V) the vertices' new numbers, kNone of removed ones
std::vector<std::int32_t> drop_removed(MeshArrays& arrays, const std::vector<Opening>& closed) {
  std::vector<char> removed(arrays.triangles.size(), 0), used(arrays.vertices.size(), 0);
  for (const Opening& o : closed)
    for (const std::int32_t f : o.removed) removed[f] = 1;
  std::size_t kept = 0;
  for (std::size_t f = 0; f < removed.size(); ++f) {
    if (removed[f]) continue;
    for (const std::int32_t v : arrays.triangles[f]) used[v] = 1;
    arrays.triangles[kept] = arrays.triangles[f];
    arrays.source_face[kept++] = arrays.source_face[f];
  }
  arrays.triangles.resize(kept);
  arrays.source_face.resize(kept);
  std::vector<std::int32_t> renamed(used.size(), kNone);
  kept = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    arrays.vertices[kept] = arrays.vertices[v];
    arrays.source_vertex[kept] = arrays.source_vertex[v];
    renamed[v] = static_cast<std::int32_t>(kept++);
  }
  arrays.vertices.resize(kept);
  arrays.source_vertex.resize(kept);
  for (Triangle& t : arrays.triangles)
    for (std::int32_t& v : t) v = renamed[v];
  return renamed;
}

/// Where handles may be that are left.
/// \param renamed  (V) the vertices' new numbers, kNone of removed ones
HandleSearch search_again(const HandleSearch& before, const Handles& found, const std::vector<std::int32_t>& renamed) {
  HandleSearch search;
  for (const auto& loop : found.loops) {
    const auto v = std::find_if(loop.begin(), loop.end(), [&](std::int32_t w) { return renamed[w] != kNone; });
    if (v != loop.end()) search.near.push_back(renamed[*v]);
  }
  search.near = rising(std::move(search.near));
  const auto keep = [&](const std::vector<std::int32_t>& loop) {
    std::vector<std::int32_t> vertices(loop.size());
    std::transform(loop.begin(), loop.end(), vertices.begin(), [&](std::int32_t v) { return renamed[v]; });
    vertices = rising(std::move(vertices));
    if (vertices.front() != kNone) search.failed.insert(std::move(vertices));
  };
  for (const auto& loop : before.failed) keep(loop);
  for (const auto& loop : found.failed) keep(loop);
  return search;
}

void fill(Array<std::int32_t>& source, std::size_t n) {
  if (!source.empty()) return;
  source.resize(n);
  std::iota(source.begin(), source.end(), 0);
}

Topology topology_of(const MeshArrays& arrays, const Threads& threads, Job& job) {
  const Job::Stage stage(job, "closing holes", 0.8, 1.0);
  return find_topology(arrays.vertices.size(), arrays.triangles, threads, job);
}

}  // namespace

std::vector<std::int32_t> rising(std::vector<std::int32_t> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

double length(const MeshArrays& arrays, const std::vector<std::int32_t>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (arrays.vertices[loop[i]] - arrays.vertices[loop[(i + 1) % loop.size()]]).norm();
  return sum;
}

std::vector<FoundOpening> close_small(MeshArrays& arrays, Topology& topology, const CleanOptions& options,
                                      const std::vector<Vec3>& keep, RepairLog& log, const Threads& threads, Job& job) {
  fill(arrays.source_face, arrays.triangles.size());
  fill(arrays.source_vertex, arrays.vertices.size());
  std::vector<FoundOpening> found;
  const auto tell = [&](const std::vector<Opening>& openings, bool kept) {
    for (const Opening& o : openings) found.push_back(found_opening(arrays, o, kept));
  };
  if ((options.fill_holes > 0 || options.fill_flat_holes > 0) && !topology.border.empty()) {
    const VertexComponents components(arrays, job);
    Closer closer(arrays, topology, &components, threads, job);
    std::vector<Opening> holes = find_holes(arrays, topology, options);
    const auto end =
        std::stable_partition(holes.begin(), holes.end(), [&](const Opening& o) { return !is_kept(arrays, o, keep); });
    tell({end, holes.end()}, true);
    holes.erase(end, holes.end());
    const std::vector<Opening> closed = closer.close(std::move(holes), true);
    tell(closed, false);
    for (const Opening& o : closed) log.add(o.kind, arrays.source_face[topology.vertex_halfedge[o.loops[0][0]] / 3]);
    if (!closed.empty()) topology = topology_of(arrays, threads, job);
  }
  // Cutting one handle may leave another that was too near it, so that a few passes are made.
  HandleSearch search;
  for (int pass = 0; options.cut_handles > 0 && pass < kClosePasses; ++pass) {
    Closer closer(arrays, topology, nullptr, threads, job);
    const Handles handles = close_handles(
        arrays, topology, options.cut_handles, pass == 0 ? nullptr : &search, keep,
        [&](std::vector<Opening> openings, bool meeting) { return closer.close(std::move(openings), meeting); },
        threads, job);
    if (pass == 0) tell(handles.kept, true);  // further passes find the same again
    tell(handles.closed, false);
    for (const Opening& o : handles.closed) log.add(o.kind, arrays.source_face[o.removed[0]]);
    if (handles.closed.empty()) break;
    search = search_again(search, handles, drop_removed(arrays, handles.closed));
    topology = topology_of(arrays, threads, job);
  }
  return found;
}

}  // namespace isimp::detail
