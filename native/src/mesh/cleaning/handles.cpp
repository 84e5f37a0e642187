// Closes handles, the shortest first.
#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <unordered_map>
#include <utility>

#include "cleaning/close.h"
#include "cleaning/handle_loops.h"
#include "isimp/mesh/mesh.h"

namespace isimp::detail {
namespace {

constexpr int kAttempts = 8;  // limit: to close handles where the loops tried before could not be

/// The faces that touch a loop, if they are a ring with two borders and the surface does not fall apart without them
/// and all that was taken before.
class Rings {
 public:
  Rings(const MeshArrays& arrays, const Topology& topology)
      : arrays_(arrays),
        topology_(topology),
        taken_(arrays.vertices.size(), 0),
        gone_(arrays.triangles.size(), 0),
        seen_(arrays.triangles.size(), 0),
        in_ring_(arrays.triangles.size(), 0) {}

  /// \return no loops if the faces along the loop are no ring, or reach a border of the mesh or an opening taken before
  Opening take(const HandleLoop& loop) { return take(ring_of(loop)); }

  /// Makes an opening that was taken one that was not.
  void release(const Opening& o) {
    for (const std::int32_t f : o.removed) {
      gone_[f] = 0;
      for (const std::int32_t v : arrays_.triangles[f]) taken_[v] = 0;
    }
  }

  /// Calls `take` if one of the places selects the opening. Its faces count as removed for openings that are taken
  /// later, so that no other loop closes this opening: neither a loop that crosses it nor a loop in the same tunnel.
  Opening hold(const HandleLoop& loop, const std::vector<Vec3>& keep) {
    Opening o = ring_of(loop);
    return o.loops.empty() || !is_kept(arrays_, o, keep) ? Opening{} : take(std::move(o));
  }

 private:
  // tuned repairs
  static constexpr double kWider = 1.3;  // times the loop's length: a border beyond is no longer in the tunnel

  [[nodiscard]] Opening ring_of(const HandleLoop& loop) {
    Opening o;
    o.kind = RepairKind::cut_handles;
    o.length = loop.length;
    o.round = loop.vertices;
    add_fans(loop.vertices, o.removed);
    if (!free_inside(o.removed) || !find_borders(o, loop)) return {};
    for (int rows = 0; rows < 32 && widen(o, loop);) ++rows;
    return o;
  }

  Opening take(Opening o) {
    if (o.loops.empty() || parts_surface(o)) return {};
    for (const std::int32_t f : o.removed)
      for (const std::int32_t v : arrays_.triangles[f]) taken_[v] = 1;
    return o;
  }

  /// Adds the next faces on both sides to the ring, if they are in the same tunnel or on the same handle: a cut in the
  /// middle alone would leave a dent on both sides.
  /// \return whether there were any
  bool widen(Opening& o, const HandleLoop& loop) {
    bool any = false;
    for (int side = 0; side < 2; ++side) {
      Opening wider;
      wider.kind = o.kind;
      wider.length = o.length;
      wider.round = o.round;
      wider.removed = o.removed;
      add_fans(o.loops[side], wider.removed);
      if (!free_inside(wider.removed) || !find_borders(wider, loop)) continue;
      const auto is_narrow = [&](const std::vector<std::int32_t>& border) {
        return length(arrays_, border) <= kWider * loop.length;
      };
      // The border that did not move may be wide already.
      const bool narrow = std::all_of(wider.loops.begin(), wider.loops.end(), [&](const auto& border) {
        return is_narrow(border) || is_same(border, o.loops[1 - side]);
      });
      if (!narrow) continue;
      o = std::move(wider);
      any = true;
    }
    return any;
  }

  static bool is_same(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
    return a.size() == b.size() && std::find(b.begin(), b.end(), a[0]) != b.end();
  }

  /// Adds the faces at some vertices to a rising list of faces.
  void add_fans(const std::vector<std::int32_t>& vertices, std::vector<std::int32_t>& faces) const {
    const auto had = static_cast<std::ptrdiff_t>(faces.size());
    for (const std::int32_t v : vertices) add_fan(v, faces);
    std::sort(faces.begin() + had, faces.end());
    std::inplace_merge(faces.begin(), faces.begin() + had, faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  }

  void add_fan(std::int32_t v, std::vector<std::int32_t>& faces) const {
    const std::int32_t start = topology_.vertex_halfedge[v];
    std::int32_t h = start;
    do {
      faces.push_back(h / 3);
      h = topology_.opposite[Mesh::prev(h)];
    } while (h != kNone && h != start);
  }

  [[nodiscard]] bool free_inside(const std::vector<std::int32_t>& faces) const {
    return std::all_of(faces.begin(), faces.end(), [&](std::int32_t f) {
      for (int k = 0; k < 3; ++k)
        if (taken_[arrays_.triangles[f][k]] || topology_.opposite[3 * f + k] == kNone) return false;
      return true;
    });
  }

  /// Finds the border loops of the removed faces.
  /// \return whether there are two, with no vertex twice and no vertex of `loop`
  [[nodiscard]] bool find_borders(Opening& o, const HandleLoop& loop) {
    ++ring_;
    for (const std::int32_t f : o.removed) in_ring_[f] = ring_;
    std::unordered_map<std::int32_t, std::int32_t> next;
    std::vector<std::int32_t> starts;
    for (const std::int32_t f : o.removed)
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        if (in_ring_[topology_.opposite[h] / 3] == ring_) continue;
        const std::int32_t a = arrays_.triangles[f][h % 3], b = arrays_.triangles[f][(h + 1) % 3];
        if (!next.emplace(a, b).second) return false;  // the border touches itself
        starts.push_back(a);
      }
    for (const std::int32_t v : loop.vertices)
      if (next.count(v)) return false;  // the loop would stay in part
    for (const std::int32_t start : starts) {
      const auto first = next.find(start);
      if (first == next.end()) continue;
      std::vector<std::int32_t> border;
      for (auto at = first; at != next.end(); at = next.find(border.back())) {
        border.push_back(at->second);
        next.erase(at);
      }
      o.loops.push_back(std::move(border));
    }
    return o.loops.size() == 2;
  }

  /// Whether no path outside the ring joins its borders. If a path does, the ring's faces are marked as removed. The
  /// search starts from both borders, so that its cost depends on the handle's faces and not on the whole surface.
  [[nodiscard]] bool parts_surface(const Opening& o) {
    for (const std::int32_t f : o.removed) gone_[f] = 1;
    std::array<std::vector<std::int32_t>, 2> front;
    rings_ += 2;
    bool joined = false;
    const auto visit = [&](std::int32_t f, int side) {
      if (gone_[f] || seen_[f] == rings_ + side) return;
      joined |= seen_[f] == rings_ + 1 - side;
      seen_[f] = rings_ + side;
      front[side].push_back(f);
    };
    for (int side = 0; side < 2; ++side) {
      std::vector<std::int32_t> faces;
      add_fans(o.loops[side], faces);
      for (const std::int32_t f : faces) visit(f, side);
    }
    while (!joined && !front[0].empty() && !front[1].empty())
      for (int side = 0; side < 2; ++side)
        for (const std::int32_t f : std::exchange(front[side], {}))
          for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
            if (const std::int32_t other = topology_.opposite[h]; other != kNone) visit(other / 3, side);
    if (!joined)
      for (const std::int32_t f : o.removed) gone_[f] = 0;
    return !joined;
  }

  const MeshArrays& arrays_;
  const Topology& topology_;
  std::vector<char> taken_;         // vertices of rings taken before
  std::vector<char> gone_;          // their faces
  std::vector<std::int32_t> seen_;  // by face: the last ring, and its border, from which it was reached
  std::int32_t rings_ = 0;
  std::vector<std::int32_t> in_ring_;  // by face: the last ring whose borders were searched that has it
  std::int32_t ring_ = 0;
};

}  // namespace

Handles close_handles(const MeshArrays& arrays, const Topology& topology, double longest, const HandleSearch* search,
                      const std::vector<Vec3>& keep,
                      const std::function<std::vector<Opening>(std::vector<Opening>, bool)>& close,
                      const Threads& threads, Job& job) {
  Handles handles;
  std::vector<HandleLoop> loops = find_loops(arrays, topology, longest, search, threads, job);
  Rings rings(arrays, topology);
  for (const HandleLoop& loop : loops) {
    if (keep.empty()) break;
    if (Opening o = rings.hold(loop, keep); !o.loops.empty()) handles.kept.push_back(std::move(o));
  }
  for (const HandleLoop& loop : loops) handles.loops.push_back(loop.vertices);
  using Failed = std::set<std::vector<std::int32_t>>;
  // Closes as many as it can, and returns whether another attempt may close more.
  const auto attempt = [&](bool meeting, Failed& failed) {
    std::vector<Opening> some;
    for (const HandleLoop& loop : loops) {
      if (failed.contains(rising(loop.vertices))) continue;
      if (Opening o = rings.take(loop); !o.loops.empty()) some.push_back(std::move(o));
    }
    if (some.empty()) return false;
    std::vector<Opening> closed = close(some, meeting);
    std::set<std::vector<std::int32_t>> done;
    for (const Opening& o : closed) done.insert(o.round);
    std::move(closed.begin(), closed.end(), std::back_inserter(handles.closed));
    for (const Opening& o : some) {
      if (done.contains(o.round)) continue;
      rings.release(o);
      failed.insert(rising(o.round));
      if (meeting) handles.failed.push_back(o.round);
    }
    return done.size() < some.size();
  };
  const Failed before = search ? search->failed : Failed{};
  Failed failed = before, failed_at_last = before;
  for (int i = 0; i < kAttempts && attempt(false, failed);) ++i;
  attempt(true, failed_at_last);
  return handles;
}

}  // namespace isimp::detail
