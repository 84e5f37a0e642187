#include "surface/topology.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <memory>
#include <utility>

#include "isimp/core/check.h"
#include "isimp/core/prefetch.h"
#include "isimp/mesh/mesh.h"
#include "surface/edge_groups.h"
#include "surface/parallel_loops.h"

namespace isimp::detail {
namespace {

constexpr std::uint32_t kMany = 24;        // work: entries of a bucket from which it is sorted and searched by halves
constexpr std::int32_t kMostReaders = 8;   // work: threads that read all faces, each for its own vertices
constexpr std::int32_t kWalkBlock = 4096;  // work: vertices that a thread takes at a time

std::string edge_name(std::int32_t a, std::int32_t b) {
  return "the edge of vertices " + std::to_string(std::min(a, b)) + " and " + std::to_string(std::max(a, b));
}

struct HalfEdge {
  std::int32_t from, to, h;
};

/// Faces or vertices, from `begin` to before `end`.
struct Interval {
  std::int32_t begin, end;
  [[nodiscard]] bool has(std::int32_t i) const {
    return static_cast<std::uint32_t>(i - begin) < static_cast<std::uint32_t>(end - begin);
  }
};

/// Calls visit(half_edge, soon) for the half-edges of some faces that run from a smaller to a larger vertex and for
/// which wanted(from) holds, or for all others; `soon` is one a little ahead. They are listed first, without a branch,
/// since no processor can predict their directions.
template <bool kRising, class Wanted, class Visit>
void for_each_halfedge(std::span<const Triangle> triangles, Interval faces, Job& job, Wanted wanted, Visit visit) {
  constexpr std::size_t kBunch = 512, kAhead = 12;  // work: faces
  std::array<HalfEdge, 3 * kBunch + 1> found;
  const auto first = static_cast<std::size_t>(faces.begin), last = static_cast<std::size_t>(faces.end);
  for (std::size_t begin = first; begin < last; begin += kBunch) {
    if ((begin - first) % kPollEvery == 0) job.poll();
    const std::size_t end = std::min(last, begin + kBunch);
    std::size_t n = 0;
    const auto list = [&](std::int32_t from, std::int32_t to, std::size_t h) {
      found[n] = {from, to, static_cast<std::int32_t>(h)};
      n += static_cast<std::size_t>((from < to) == kRising) & static_cast<std::size_t>(wanted(from));
    };
    for (std::size_t f = begin; f < end; ++f) {
      const auto& [a, b, c] = triangles[f];
      list(a, b, 3 * f);
      list(b, c, 3 * f + 1);
      list(c, a, 3 * f + 2);
    }
    for (std::size_t i = 0; i < n; ++i) visit(found[i], found[std::min(i + kAhead, n - 1)]);
  }
}

/// The half-edges that run from a smaller to a larger vertex, by the smaller one. In a sound mesh every other half-edge
/// finds its opposite among the few of its larger end's bucket.
class RisingHalfedges {
 public:
  RisingHalfedges(std::size_t vertex_count, std::span<const Triangle> triangles, const Threads& threads, Job& job)
      : end_(vertex_count + 1, 0) {
    const auto vertices = static_cast<std::int32_t>(vertex_count);
    const std::int32_t pieces = std::min(kMostReaders, threads.pieces(static_cast<std::int32_t>(triangles.size())));
    const auto for_each_from = [&](Interval from, const auto& visit) { for_each_rising(triangles, from, job, visit); };
    if (pieces == 1) {
      for_each_index(triangles.size(), job, [&](std::size_t f) {
        const auto& [a, b, c] = triangles[f];
        end_[a] += a < b;
        end_[b] += b < c;
        end_[c] += c < a;
      });
    } else {
      threads.run(vertices, pieces, [&](std::int32_t, std::int32_t first, std::int32_t last) {
        for_each_from({first, last}, [&](const HalfEdge& e, const HalfEdge&) { ++end_[e.from]; });
      });
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& end : end_) sum += std::exchange(end, sum);  // now the start of each bucket
    entries_ = std::make_unique_for_overwrite<HalfEdgeEnd[]>(sum + kAtOnce);
    for (std::uint32_t i = 0; i < kAtOnce; ++i) entries_[sum + i] = {kNone, kNone};
    std::vector<std::int32_t> limit;  // vertices that divide the work of the pieces about equally
    for (std::int32_t piece = 0; piece <= pieces; ++piece) {
      const auto share = static_cast<std::uint32_t>(std::uint64_t{sum} * static_cast<std::uint64_t>(piece) /
                                                    static_cast<std::uint64_t>(pieces));
      limit.push_back(static_cast<std::int32_t>(std::lower_bound(end_.begin(), end_.end(), share) - end_.begin()));
    }
    limit.front() = 0;
    limit.back() = vertices;
    threads.run(pieces, pieces, [&](std::int32_t piece, std::int32_t, std::int32_t) {
      for_each_from({limit[piece], limit[piece + 1]}, [&](const HalfEdge& e, const HalfEdge& soon) {
        prefetch_to_write(&entries_[end_[soon.from]]);
        entries_[end_[e.from]++] = {e.to, e.h};
      });
    });
    for_each_index(threads, vertex_count, job, [&](std::size_t v) {
      if (end_[v] - begin(v) > kMany) std::sort(&entries_[begin(v)], &entries_[end_[v]], by_end);
    });
  }

  /// Prefetches a vertex's bucket.
  void fetch(std::int32_t from) const { prefetch(&entries_[begin(static_cast<std::size_t>(from))]); }
  /// The first half-edge from one vertex to a larger one, or kNone.
  [[nodiscard]] std::int32_t find(std::int32_t from, std::int32_t to) const {
    const std::uint32_t at = place(from, to);
    return at < end_[from] ? entries_[at].half_edge : kNone;
  }
  /// Whether another half-edge runs the same way as a stored one.
  [[nodiscard]] bool has_twin(std::int32_t from, std::int32_t to) const {
    const std::uint32_t first = place(from, to), last = end_[from];
    std::uint32_t i = first + 1;
    if (last - begin(static_cast<std::size_t>(from)) > kMany) return i < last && entries_[i].to == to;  // sorted
    while (i < last && entries_[i].to != to) ++i;
    return i < last;
  }

 private:
  struct HalfEdgeEnd {
    std::int32_t to, half_edge;
  };
  static constexpr std::uint32_t kAtOnce = 4;  // work: entries compared before each decision

  template <class Visit>
  static void for_each_rising(std::span<const Triangle> triangles, Interval from, Job& job, const Visit& visit) {
    const Interval all{0, static_cast<std::int32_t>(triangles.size())};
    for_each_halfedge<true>(
        triangles, all, job, [&](std::int32_t v) { return from.has(v); }, visit);
  }
  static bool by_end(const HalfEdgeEnd& a, const HalfEdgeEnd& b) { return a.to < b.to; }
  [[nodiscard]] std::uint32_t begin(std::size_t v) const { return v == 0 ? 0 : end_[v - 1]; }

  /// The place of the first half-edge from one vertex to another; the bucket's end or more if there is none.
  [[nodiscard]] std::uint32_t place(std::int32_t from, std::int32_t to) const {
    const std::uint32_t last = end_[from];
    std::uint32_t i = begin(static_cast<std::size_t>(from));
    if (last - i > kMany) {
      const HalfEdgeEnd* at = std::lower_bound(&entries_[i], &entries_[last], HalfEdgeEnd{to, 0}, by_end);
      return at != &entries_[last] && at->to == to ? static_cast<std::uint32_t>(at - entries_.get()) : last;
    }
    for (; i < last; i += kAtOnce) {
      std::uint32_t equal = 0;
      for (std::uint32_t k = 0; k < kAtOnce; ++k) equal |= static_cast<std::uint32_t>(entries_[i + k].to == to) << k;
      if (equal != 0) return i + static_cast<std::uint32_t>(std::countr_zero(equal));
    }
    return last;
  }

  std::vector<std::uint32_t> end_;  // end of each vertex's bucket
  std::unique_ptr<HalfEdgeEnd[]> entries_;
};

/// The half-edges that run from a larger to a smaller vertex: the single ones, and the number of pairs.
struct Falling {
  std::vector<std::pair<std::int32_t, std::int32_t>> alone;  ///< those on a border, reversed; rising
  std::size_t pairs = 0;                                     ///< number of the others
};

Falling match_falling(const RisingHalfedges& rising, Array<std::int32_t>& opposite, std::span<const Triangle> triangles,
                      const Threads& threads, Job& job) {
  const auto faces = static_cast<std::int32_t>(triangles.size());
  const std::int32_t pieces = threads.pieces(faces);
  std::vector<Falling> found(static_cast<std::size_t>(pieces));
  const auto any = [](std::int32_t) { return true; };
  threads.run(faces, pieces, [&](std::int32_t piece, std::int32_t first, std::int32_t last) {
    Falling own;  // own memory for each thread
    for_each_halfedge<false>(triangles, {first, last}, job, any, [&](const HalfEdge& e, const HalfEdge& soon) {
      rising.fetch(soon.to);
      const std::int32_t other = rising.find(e.to, e.from);
      if (other == kNone) {
        own.alone.emplace_back(e.to, e.from);
        return;
      }
      ++own.pairs;
      // At an edge that is not sound, two threads may have found the same one: the value is not read then.
      std::atomic_ref(opposite[other]).store(e.h, std::memory_order_relaxed);
      opposite[e.h] = other;
    });
    found[piece] = std::move(own);
  });
  for (std::int32_t piece = 1; piece < pieces; ++piece) {
    found[0].alone.insert(found[0].alone.end(), found[piece].alone.begin(), found[piece].alone.end());
    found[0].pairs += found[piece].pairs;
  }
  std::sort(found[0].alone.begin(), found[0].alone.end());
  return std::move(found[0]);
}

/// Pairs all half-edges; false if an edge has three or more faces, or two that run the same way.
bool pair_halfedges(Topology& topology, std::size_t vertex_count, std::span<const Triangle> triangles,
                    const Threads& threads, Job& job) {
  const RisingHalfedges rising(vertex_count, triangles, threads, job);
  job.report(0.3);
  Array<std::int32_t>& opposite = topology.opposite;
  opposite.resize(3 * triangles.size());
  for_each_index(threads, opposite.size(), job, [&](std::size_t h) { opposite[h] = kNone; });
  const Falling falling = match_falling(rising, opposite, triangles, threads, job);
  bool sound = std::adjacent_find(falling.alone.begin(), falling.alone.end()) == falling.alone.end();
  topology.border = gather<std::int32_t>(threads, opposite.size(), job, [&](std::size_t h, auto& border) {
    if (opposite[h] == kNone) border.push_back(static_cast<std::int32_t>(h));
  });
  // Among several rising ones that run the same way only the first has found its opposite.
  for (const std::int32_t h : topology.border) {
    const std::int32_t from = triangles[h / 3][h % 3], to = triangles[h / 3][(h + 1) % 3];
    sound = sound && (from > to || !rising.has_twin(from, to));
  }
  return sound && opposite.size() == topology.border.size() + 2 * falling.pairs;  // else one was found by several
}

/// Names the first edge that is not sound.
std::string describe_bad_edge(std::size_t vertex_count, std::span<const Triangle> triangles, Job& job) {
  std::string what;
  const auto from = [&](std::int32_t h) { return triangles[h / 3][h % 3]; };
  EdgeGroups(vertex_count, triangles, job).for_each(job, [&](const EdgeGroup& edge) {
    if (!what.empty() || edge.size() < 2) return;
    const std::string name = edge_name(from(edge[0]), from(Mesh::next(edge[0])));
    if (edge.size() > 2) {
      what = name + " has three or more faces, face " + std::to_string(edge[2] / 3) + " among them";
    } else if (from(edge[0]) == from(edge[1])) {
      what = "faces " + std::to_string(edge[0] / 3) + " and " + std::to_string(edge[1] / 3) +
             " have opposite orientations at " + name;
    }
  });
  return what;
}

/// The number of faces around a vertex from one half-edge that leaves it to another or a border.
std::int64_t walk(const Array<std::int32_t>& opposite, std::int32_t from, std::int32_t to) {
  std::int64_t met = 0;
  std::int32_t h = from;
  do {
    ++met;
    h = opposite[Mesh::prev(h)];
  } while (h != kNone && h != to);
  return met;
}

std::string describe_bad_vertex(const Topology& topology, std::span<const Triangle> triangles) {
  std::vector<std::int64_t> faces(topology.vertex_halfedge.size(), 0);
  for (const Triangle& t : triangles)
    for (const std::int32_t v : t) ++faces[v];
  const auto met = [&](std::int32_t start) { return walk(topology.opposite, start, start); };
  std::size_t v = 0;
  while (faces[v] == 0 || faces[v] == met(topology.vertex_halfedge[v])) ++v;
  return "the faces of vertex " + std::to_string(v) + " form two or more fans";
}

/// The number of faces around each of some vertices, together.
///
/// Several walks at once, which take the next vertex by a choice between values and not by a branch: the length of a
/// walk can't be predicted, and each of its steps waits for the one before.
std::int64_t walk_all(const Array<std::int32_t>& opposite, std::span<const std::int32_t> starts) {
  constexpr std::size_t kWalks = 4;  // work
  std::int64_t met = 0;
  std::size_t next = std::min(kWalks, starts.size());
  std::array<std::int32_t, kWalks> start{}, at{};
  for (std::size_t k = 0; k < next; ++k) start[k] = at[k] = starts[k];
  while (next + kWalks <= starts.size()) {
    met += kWalks;
    for (std::size_t k = 0; k < kWalks; ++k) {
      const std::int32_t h = opposite[Mesh::prev(at[k])];
      const bool done = static_cast<int>(h == kNone) | static_cast<int>(h == start[k]);
      start[k] = done ? starts[next] : start[k];
      at[k] = done ? starts[next] : h;
      next += done ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < std::min(kWalks, starts.size()); ++k) met += walk(opposite, at[k], start[k]);
  for (; next < starts.size(); ++next) met += walk(opposite, starts[next], starts[next]);
  return met;
}

/// Sets a half-edge that leaves each vertex: the one on the border if there is one, from where a walk meets all faces;
/// else the last.
void find_leaving(Topology& topology, std::size_t vertex_count, std::span<const Triangle> triangles,
                  const Threads& threads, Job& job) {
  Array<std::int32_t>& leaving = topology.vertex_halfedge;
  leaving.resize(vertex_count);
  const auto vertices = static_cast<std::int32_t>(vertex_count);
  const std::int32_t pieces = std::min(kMostReaders, threads.pieces(static_cast<std::int32_t>(triangles.size())));
  threads.run(vertices, pieces, [&](std::int32_t, std::int32_t first, std::int32_t last) {
    const Interval own{first, last};
    std::fill(leaving.begin() + first, leaving.begin() + last, kNone);
    std::int32_t elsewhere = kNone;  // receives the results of other threads, so that there is no branch
    for_each_index(triangles.size(), job, [&](std::size_t f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t v = triangles[f][k];
        *(own.has(v) ? &leaving[v] : &elsewhere) = static_cast<std::int32_t>(3 * f + k);
      }
    });
  });
  for (const std::int32_t h : topology.border) leaving[triangles[h / 3][h % 3]] = h;
}

/// Finds a half-edge that leaves each vertex; false if the faces of some vertex are not one fan.
bool find_fans(Topology& topology, std::size_t vertex_count, std::span<const Triangle> triangles,
               const Threads& threads, Job& job) {
  find_leaving(topology, vertex_count, triangles, threads, job);
  std::atomic<std::int64_t> met{0}, used{0};
  threads.blocks(static_cast<std::int32_t>(vertex_count), kWalkBlock,
                 [&](std::int32_t, std::int32_t begin, std::int32_t end) {
                   job.poll();
                   std::array<std::int32_t, kWalkBlock + 1> starts;
                   std::size_t n = 0;
                   for (std::int32_t v = begin; v < end; ++v) {
                     starts[n] = topology.vertex_halfedge[v];
                     n += starts[n] == kNone ? 0 : 1;
                   }
                   met += walk_all(topology.opposite, std::span(starts).first(n));
                   used += static_cast<std::int64_t>(n);
                 });
  topology.unused_vertices = static_cast<std::int32_t>(static_cast<std::int64_t>(vertex_count) - used);
  // No walk meets more than its vertex's faces, so that the sum shows whether one met fewer.
  return met == static_cast<std::int64_t>(topology.opposite.size());
}

}  // namespace

Topology find_topology(std::size_t vertex_count, std::span<const Triangle> triangles, const Threads& threads,
                       Job& job) {
  Topology topology;
  if (!pair_halfedges(topology, vertex_count, triangles, threads, job)) {
    topology.defect = describe_bad_edge(vertex_count, triangles, job);
    return topology;
  }
  job.report(0.7);
  if (!find_fans(topology, vertex_count, triangles, threads, job)) {
    topology.defect = describe_bad_vertex(topology, triangles);
  }
  ISIMP_ASSERT(std::ranges::is_sorted(topology.border), "half-edges on the border rise");
  ISIMP_ASSERT(std::ranges::all_of(topology.opposite,
                                   [&, h = 0](std::int32_t other) mutable {
                                     const std::int32_t own = h++;
                                     return other == kNone || topology.opposite[other] == own;
                                   }),
               "the opposite of the opposite is the half-edge itself");
  return topology;
}

}  // namespace isimp::detail
