#include "isimp/mesh/face_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "isimp/core/prefetch.h"
#include "isimp/core/to_integer.h"
#include "surface/parallel_loops.h"

namespace isimp {
namespace {

using detail::for_each_index;
using detail::gather;

constexpr double kFlat =
    1e-12;  // rounding: doubled area over longest edge squared, below which a normal is rounding noise
constexpr double kLeastScaled =
    1e-20;  // rounding: share of the whole area: below it, floats would not hold the areas of single
            // faces
constexpr int kAxisBits =
    11;  // work: cells an axis, as a power of two: 33 bits of place leave 31 for the face's number
constexpr int kFaceBits = 31;       // work
constexpr int kDigitBits = 11;      // work: bits of the sort's first digit
constexpr int kByteBits = 8;        // work: bits of digits 2 to 4 of the sort's key
constexpr std::size_t kAhead = 12;  // work: faces to prefetch ahead

/// Moves every bit of the lower eleven to a place divisible by three.
constexpr std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16) & 0x070000ff;
  x = (x | x << 8) & 0x0700f00f;
  x = (x | x << 4) & 0x430c30c3;
  x = (x | x << 2) & 0x49249249;
  return x;
}

constexpr auto kSpread = [] {
  std::array<std::uint32_t, 1 << kAxisBits> table{};
  for (std::uint32_t x = 0; x < table.size(); ++x) table[x] = spread_bits(x);
  return table;
}();

/// The cells of a box in the order of a curve that keeps near cells near (Morton).
class Curve {
 public:
  explicit Curve(const Box& box) : low_(box.min()), scale_(0) {
    if (const double side = box.sizes().maxCoeff(); side > 0) scale_ = (kSpread.size() - 1) / side;
  }
  [[nodiscard]] std::uint64_t place(const Vec3& p) const {
    const Vec3 cell = (p - low_) * scale_;
    const auto axis = [&](int k) {
      return static_cast<std::uint64_t>(kSpread[to_integer(cell[k], 0, (1 << kAxisBits) - 1)]);
    };
    return axis(0) | axis(1) << 1 | axis(2) << 2;
  }

 private:
  Vec3 low_;
  double scale_;
};

/// Counting sort by some bits; equal ones keep their order.
template <int kBits>
void sort_by_bits(std::span<const std::uint64_t> keys, std::uint64_t* sorted, int shift, Job& job) {
  constexpr std::uint64_t kMask = (1 << kBits) - 1;  // unit
  std::array<std::uint32_t, (1 << kBits) + 1> begin{};
  for_each_index(keys.size(), job, [&](std::size_t i) { ++begin[(keys[i] >> shift & kMask) + 1]; });
  for (std::size_t d = 1; d < begin.size(); ++d) begin[d] += begin[d - 1];
  for_each_index(keys.size(), job, [&](std::size_t i) { sorted[begin[keys[i] >> shift & kMask]++] = keys[i]; });
}

/// Sorts keys by the first digit, in pieces, one a thread.
std::vector<std::uint32_t> sort_by_first_digit(std::span<const std::uint64_t> keys, std::uint64_t* sorted,
                                               const Threads& threads, Job& job) {
  constexpr int kShift = kFaceBits + 3 * kAxisBits - kDigitBits;  // unit
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;   // unit
  const auto n = static_cast<std::int32_t>(keys.size());
  const std::int32_t pieces = threads.pieces(n);
  std::vector<std::vector<std::uint32_t>> next(static_cast<std::size_t>(pieces));  // places of a piece's keys
  const auto for_each_key = [&](std::int32_t begin, std::int32_t end, const auto& visit) {
    const auto piece = keys.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin));
    for_each_index(piece.size(), job, [&](std::size_t i) { visit(piece[i], piece[i] >> kShift); });
  };
  threads.run(n, pieces, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    std::vector<std::uint32_t> own(kDigits, 0);
    for_each_key(begin, end, [&](std::uint64_t, std::uint64_t digit) { ++own[digit]; });
    next[piece] = std::move(own);
  });
  std::vector<std::uint32_t> start(kDigits + 1, 0);
  std::uint32_t sum = 0;
  for (std::size_t d = 0; d < kDigits; ++d) {
    start[d] = sum;
    for (std::vector<std::uint32_t>& of_piece : next) sum += std::exchange(of_piece[d], sum);
  }
  start[kDigits] = sum;
  threads.run(n, pieces, [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    std::vector<std::uint32_t>& own = next[piece];
    for_each_key(begin, end, [&](std::uint64_t key, std::uint64_t digit) { sorted[own[digit]++] = key; });
  });
  return start;
}

/// Sorts by the bits above the face's number; equal ones keep their order. The highest digit comes first: the faces of
/// each of its values then fit into a cache together, where the other digits cost little.
void sort_by_place(std::span<std::uint64_t> keys, const Threads& threads, Job& job) {
  constexpr std::size_t kFew = 64;  // work: keys that are sorted by comparisons
  const auto other = std::make_unique_for_overwrite<std::uint64_t[]>(keys.size());
  const std::vector<std::uint32_t> begin = sort_by_first_digit(keys, other.get(), threads, job);
  const auto sort_digit = [&](std::size_t d) {
    const std::span<std::uint64_t> from(other.get() + begin[d], begin[d + 1] - begin[d]);
    const std::span<std::uint64_t> to = keys.subspan(begin[d], from.size());
    if (from.size() <= kFew) {
      std::sort(from.begin(), from.end());
      std::copy(from.begin(), from.end(), to.begin());
      return;
    }
    sort_by_bits<kByteBits>(from, to.data(), kFaceBits, job);
    sort_by_bits<kByteBits>(to, from.data(), kFaceBits + kByteBits, job);
    sort_by_bits<kByteBits>(from, to.data(), kFaceBits + 2 * kByteBits, job);
  };
  const auto digits = static_cast<std::int32_t>(begin.size()) - 1;
  if (threads.pieces(static_cast<std::int32_t>(keys.size())) == 1) {
    for (std::int32_t d = 0; d < digits; ++d) sort_digit(static_cast<std::size_t>(d));
    return;
  }
  threads.blocks(digits, 32, [&](std::int32_t, std::int32_t first, std::int32_t last) {
    for (std::int32_t d = first; d < last; ++d) sort_digit(static_cast<std::size_t>(d));
  });
}

bool has_normal(const FaceRecord& r) { return r.nx != 0 || r.ny != 0 || r.nz != 0; }

/// Faces without area take their normals from neighbours, breadth first from all faces that have one.
void fill_missing_normals(FaceGraph& graph, const std::vector<std::int32_t>& missing) {
  std::vector<std::int32_t> open = missing, next;
  while (!open.empty()) {
    std::vector<std::pair<std::int32_t, FaceRecord>> found;
    next.clear();
    for (const std::int32_t i : open) {
      std::int32_t source = graph.size();
      for (const std::int32_t j : graph.neighbours[i])
        if (j != graph.size() && has_normal(graph.faces[j]) &&
            graph.mesh_face[j] < (source == graph.size() ? INT32_MAX : graph.mesh_face[source]))
          source = j;
      if (source == graph.size()) {
        next.push_back(i);
      } else {
        found.emplace_back(i, graph.faces[source]);
      }
    }
    if (found.empty()) return;  // a component without any area keeps zero normals
    for (const auto& [i, record] : found) graph.faces[i] = {record.nx, record.ny, record.nz, 0.0F};
    open.swap(next);
  }
}

/// Prefetches the vertices of a face a little ahead.
void fetch_soon(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::size_t f) {
  if (f + kAhead >= triangles.size()) return;
  for (const std::int32_t v : triangles[f + kAhead]) prefetch(&vertices[v]);
}

/// A face's record, its area times `scale`; all zero for a face without area. Sets its area.
FaceRecord measure(const Vec3& a, const Vec3& b, const Vec3& c, double scale, double& area) {
  area = 0;
  const Vec3 u = b - a, v = c - a, cross = u.cross(v);
  const double doubled = cross.norm();
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  if (!(doubled > kFlat * longest)) return {};
  area = doubled / 2;
  const Vec3 normal = cross * (1 / doubled);
  return {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z()),
          static_cast<float>(doubled / 2 * scale)};
}

/// The graph's order of the faces and its inverse.
void set_order(FaceGraph& graph, const Curve& curve, std::span<const Vec3> vertices,
               std::span<const Triangle> triangles, const Threads& threads, Job& job) {
  const auto memory = std::make_unique_for_overwrite<std::uint64_t[]>(triangles.size());
  const std::span<std::uint64_t> keys(memory.get(), triangles.size());
  for_each_index(threads, triangles.size(), job, [&](std::size_t f) {
    fetch_soon(vertices, triangles, f);
    const auto& [a, b, c] = triangles[f];
    keys[f] = curve.place((vertices[a] + vertices[b] + vertices[c]) * (1.0 / 3.0)) << kFaceBits | f;
  });
  sort_by_place(keys, threads, job);
  graph.mesh_face.resize(triangles.size());
  graph.graph_face.resize(triangles.size());
  for_each_index(threads, triangles.size(), job, [&](std::size_t i) {
    const auto f = static_cast<std::int32_t>(keys[i] & ((1U << kFaceBits) - 1));
    graph.mesh_face[i] = f;
    graph.graph_face[f] = static_cast<std::int32_t>(i);
  });
}

/// Sets the records, the neighbours and the whole area, in the mesh's own order, in which a face's vertices and
/// neighbours tend to be near: half the cache misses. Areas are added in that order too, so that no bit of their sum
/// depends on the number of threads.
/// \return the faces without a normal, as places in the graph
std::vector<std::int32_t> measure_all(FaceGraph& graph, std::span<const Vec3> vertices,
                                      std::span<const Triangle> triangles, std::span<const std::int32_t> opposite,
                                      double scale, const Threads& threads, Job& job) {
  constexpr std::size_t kRound = std::size_t{1} << 19;  // work: faces whose areas are kept until they are added
  const auto n = static_cast<std::int32_t>(triangles.size());
  std::vector<double> areas(std::min(kRound, triangles.size()));
  std::vector<std::int32_t> missing;
  graph.area = 0;
  for (std::size_t begin = 0; begin < triangles.size(); begin += kRound) {
    const std::size_t count = std::min(kRound, triangles.size() - begin);
    const auto found = gather<std::int32_t>(threads, count, job, [&](std::size_t k, auto& without) {
      const std::size_t f = begin + k;
      fetch_soon(vertices, triangles, f);
      const std::int32_t i = graph.graph_face[f];
      const auto& [a, b, c] = triangles[f];
      const FaceRecord record = measure(vertices[a], vertices[b], vertices[c], scale, areas[k]);
      graph.faces[i] = record;
      if (!has_normal(record)) without.push_back(i);
      for (std::size_t side = 0; side < 3; ++side) {
        const std::int32_t other = opposite[3 * f + side];
        graph.neighbours[i][side] = other == kNone ? n : graph.graph_face[other / 3];
      }
    });
    missing.insert(missing.end(), found.begin(), found.end());
    for (std::size_t k = 0; k < count; ++k) graph.area += areas[k];
  }
  return missing;
}

}  // namespace

FaceGraph make_face_graph(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                          std::span<const std::int32_t> opposite, const Box& box, const Threads& threads, Job& job) {
  FaceGraph graph;
  const auto n = static_cast<std::int32_t>(triangles.size());
  set_order(graph, Curve(box), vertices, triangles, threads, job);
  job.report(0.5);

  graph.faces.resize(triangles.size() + 1);
  graph.faces[triangles.size()] = {};
  graph.neighbours.resize(triangles.size() + 1);
  graph.neighbours[triangles.size()] = {n, n, n};
  const double side = box.sizes().maxCoeff();
  double scale = side * side > 0 ? 1 / (side * side) : 1.0;  // floats hold the areas
  std::vector<std::int32_t> missing = measure_all(graph, vertices, triangles, opposite, scale, threads, job);
  if (graph.area > 0 && scale * graph.area < kLeastScaled) {  // all faces are small, in a box that is large by faces
                                                              // without area
    scale = 1 / graph.area;
    missing = measure_all(graph, vertices, triangles, opposite, scale, threads, job);
  }
  const auto share = static_cast<float>(graph.area > 0 ? 1 / (scale * graph.area) : 0.0);
  for_each_index(threads, graph.faces.size(), job, [&](std::size_t i) { graph.faces[i].area *= share; });
  fill_missing_normals(graph, missing);
  return graph;
}

}  // namespace isimp
