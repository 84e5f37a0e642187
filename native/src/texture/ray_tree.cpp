#include "ray_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace isimp::detail {
namespace {

constexpr std::int32_t kLeaf = 4, kBins = 16, kDeepest = 60;
constexpr float kFar = std::numeric_limits<float>::infinity();

struct Box {
  Eigen::Array3f low = Eigen::Array3f::Constant(kFar), high = Eigen::Array3f::Constant(-kFar);

  void add(const Eigen::Array3f& a, const Eigen::Array3f& b) {
    low = low.min(a);
    high = high.max(b);
  }
  [[nodiscard]] float area() const {
    const Eigen::Array3f d = (high - low).max(0.0F);
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

}  // namespace

struct RayTree::Builder {
  std::vector<Box> boxes;
  std::vector<Eigen::Array3f> middles;
  std::vector<std::int32_t> order;
  std::vector<Node>& nodes;
  Job& job;

  void build(std::int32_t begin, std::int32_t end, std::int32_t depth) {
    const auto at = static_cast<std::int32_t>(nodes.size());
    if (at % 4096 == 0) job.poll();
    Box box, centres;
    for (std::int32_t i = begin; i < end; ++i) {
      box.add(boxes[order[i]].low, boxes[order[i]].high);
      centres.add(middles[order[i]], middles[order[i]]);
    }
    nodes.push_back({box.low, box.high, begin, end - begin});
    if (end - begin <= kLeaf) return;
    const std::int32_t middle = split(begin, end, centres, depth);
    nodes[at].count = 0;
    build(begin, middle, depth + 1);
    nodes[at].first = static_cast<std::int32_t>(nodes.size());
    build(middle, end, depth + 1);
  }

  /// Moves the faces of one side before the faces of the other; returns the first of the latter.
  std::int32_t split(std::int32_t begin, std::int32_t end, const Box& centres, std::int32_t depth) {
    Eigen::Index axis = 0;
    const float length = (centres.high - centres.low).maxCoeff(&axis);
    const std::int32_t half = begin + (end - begin) / 2;
    if (!(length > 0) || depth > kDeepest / 2) return half_of(begin, half, end, axis);
    const float scale = kBins / length, low = centres.low[axis];
    const auto bin_of = [&](std::int32_t f) {
      return std::min(static_cast<std::int32_t>((middles[f][axis] - low) * scale), kBins - 1);
    };
    std::array<Box, kBins> bins;
    std::array<std::int32_t, kBins> counts{};
    for (std::int32_t i = begin; i < end; ++i) {
      const std::int32_t b = bin_of(order[i]);
      bins[b].add(boxes[order[i]].low, boxes[order[i]].high);
      ++counts[b];
    }
    std::array<float, kBins> right{};
    Box box;
    for (std::int32_t b = kBins - 1, n = 0; b > 0; --b) {
      box.add(bins[b].low, bins[b].high);
      n += counts[b];
      right[b] = n > 0 ? box.area() * static_cast<float>(n) : 0.0F;
    }
    float least = kFar;
    std::int32_t best = 1;
    box = {};
    for (std::int32_t b = 1, n = 0; b < kBins; ++b) {
      box.add(bins[b - 1].low, bins[b - 1].high);
      n += counts[b - 1];
      const float cost = (n > 0 ? box.area() * static_cast<float>(n) : 0.0F) + right[b];
      if (n == 0 || n == end - begin || cost >= least) continue;
      least = cost;
      best = b;
    }
    const auto it = std::stable_partition(order.begin() + begin, order.begin() + end,
                                          [&](std::int32_t f) { return bin_of(f) < best; });
    const auto middle = static_cast<std::int32_t>(it - order.begin());
    return middle > begin && middle < end ? middle : half_of(begin, half, end, axis);
  }

  std::int32_t half_of(std::int32_t begin, std::int32_t half, std::int32_t end, Eigen::Index axis) {
    std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end,
                     [&](std::int32_t a, std::int32_t b) {
                       return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis] : a < b;
                     });
    return half;
  }
};

RayTree::RayTree(const Mesh& mesh, Job& job) {
  const auto count = mesh.face_count();
  Builder builder{std::vector<Box>(count), std::vector<Eigen::Array3f>(count), std::vector<std::int32_t>(count), nodes_,
                  job};
  const auto vertices = mesh.vertices();
  for (std::int32_t f = 0; f < count; ++f) {
    for (const std::int32_t v : mesh.triangles()[f]) {
      const Eigen::Array3f p = vertices[v].cast<float>();
      builder.boxes[f].add(p, p);
    }
    builder.middles[f] = (builder.boxes[f].low + builder.boxes[f].high) / 2;
  }
  std::iota(builder.order.begin(), builder.order.end(), 0);
  if (count > 0) builder.build(0, count, 0);
  faces_.reserve(count);
  for (const std::int32_t f : builder.order) {
    const Triangle& t = mesh.triangles()[f];
    const Eigen::Vector3f a = vertices[t[0]].cast<float>();
    faces_.push_back({a, vertices[t[1]].cast<float>() - a, vertices[t[2]].cast<float>() - a, f});
  }
}

/// Moeller and Trumbore 1997, from both sides.
bool RayTree::hits_face(const Face& face, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                        float reach) const {
  const Eigen::Vector3f p = direction.cross(face.v);
  const float det = face.u.dot(p);
  if (det == 0) return false;
  const float over = 1 / det;
  const Eigen::Vector3f s = origin - face.corner;
  const float b = s.dot(p) * over;
  if (!(b >= 0 && b <= 1)) return false;
  const Eigen::Vector3f q = s.cross(face.u);
  const float c = direction.dot(q) * over;
  if (!(c >= 0 && b + c <= 1)) return false;
  const float t = face.v.dot(q) * over;
  return t > 0 && t <= reach;
}

bool RayTree::hits(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float reach,
                   std::int32_t skip) const {
  if (nodes_.empty()) return false;
  const Eigen::Array3f from = origin.array(), over = direction.array().inverse();
  std::array<std::int32_t, kDeepest + 4> open;
  std::int32_t size = 0;
  open[size++] = 0;
  while (size > 0) {
    const std::int32_t at = open[--size];
    const Node& node = nodes_[at];
    const Eigen::Array3f a = (node.low - from) * over, b = (node.high - from) * over;
    const float enter = std::max(a.min(b).maxCoeff(), 0.0F), leave = std::min(a.max(b).minCoeff(), reach);
    if (enter > leave * 1.00001F) continue;  // a face in a side of its box counts
    if (node.count == 0) {
      open[size++] = node.first;
      open[size++] = at + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i)
      if (faces_[i].number != skip && hits_face(faces_[i], origin, direction, reach)) return true;
  }
  return false;
}

}  // namespace isimp::detail
