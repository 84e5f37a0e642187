#include "evaluate.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace isimp::bench {
namespace {

std::int32_t count_pieces(const PlainSurface& surface, std::span<const std::int32_t> label) {
  std::vector<bool> seen(label.size(), false);
  std::vector<std::int32_t> stack;
  std::int32_t pieces = 0;
  for (std::size_t start = 0; start < label.size(); ++start) {
    if (seen[start] || label[start] < 0) continue;
    ++pieces;
    seen[start] = true;
    stack.push_back(static_cast<std::int32_t>(start));
    while (!stack.empty()) {
      const std::int32_t face = stack.back();
      stack.pop_back();
      for (const std::int32_t other : surface.neighbours[face]) {
        if (other == kNone || seen[other] || label[other] != label[face]) continue;
        seen[other] = true;
        stack.push_back(other);
      }
    }
  }
  return pieces;
}

void measure_borders(const Mesh& mesh, std::span<const std::int32_t> label, Score& score) {
  const auto half_edges = static_cast<std::int32_t>(mesh.opposite().size());
  for (std::int32_t h = 0; h < half_edges; ++h) {
    const std::int32_t other = mesh.opposite(h);
    if (other < h) continue;  // each edge once; kNone is below every half-edge
    const std::int32_t a = label[Mesh::face(h)], b = label[Mesh::face(other)];
    if (a == b || a < 0 || b < 0) continue;
    ++score.border_edges;
    score.border_length += (mesh.vertices()[mesh.to(h)] - mesh.vertices()[mesh.from(h)]).norm();
  }
}

}  // namespace

Score evaluate(const Mesh& mesh, const PlainSurface& surface, std::span<const std::int32_t> label) {
  Score score;
  const auto regions = static_cast<std::size_t>(std::max(*std::max_element(label.begin(), label.end()), -1) + 1);
  std::vector<Vec3> normal(regions, Vec3::Zero());
  std::vector<std::int64_t> faces(regions, 0);
  score.fingerprint = 14695981039346656037U;  // FNV-1a over the labels
  for (std::size_t f = 0; f < label.size(); ++f) {
    score.fingerprint = (score.fingerprint ^ static_cast<std::uint32_t>(label[f])) * 1099511628211U;
    if (label[f] < 0) {
      ++score.unlabelled;
      score.unlabelled_area += surface.area[f];
    } else {
      normal[label[f]] += surface.area[f] * surface.normal[f];
      ++faces[label[f]];
    }
  }
  for (Vec3& n : normal)
    if (n.norm() > 0) n.normalize();
  for (std::size_t f = 0; f < label.size(); ++f)
    if (label[f] >= 0) score.error += surface.area[f] * (surface.normal[f] - normal[label[f]]).squaredNorm();
  score.regions = static_cast<std::int32_t>(std::count_if(faces.begin(), faces.end(), [](auto n) { return n > 0; }));
  score.fragments = count_pieces(surface, label) - score.regions;
  measure_borders(mesh, label, score);
  return score;
}

Json to_json(const Score& score) {
  Json json;
  json["error"] = score.error;
  json["border_edges"] = score.border_edges;
  json["border_length"] = score.border_length;
  json["regions"] = score.regions;
  json["fragments"] = score.fragments;
  json["unlabelled"] = score.unlabelled;
  json["unlabelled_area"] = score.unlabelled_area;
  json["fingerprint"] = std::to_string(score.fingerprint);  // text: a double has no room for 64 bits
  return json;
}

std::uint64_t fingerprint(const PolygonMesh& polygons) {
  std::uint64_t print = 14695981039346656037U;  // FNV-1a over the bytes
  const auto add = [&](const auto& values) {
    for (const std::byte b : std::as_bytes(std::span(values)))
      print = (print ^ std::to_integer<std::uint8_t>(b)) * 1099511628211U;
  };
  add(polygons.vertices);
  add(polygons.loops);
  add(polygons.loop_start);
  add(polygons.polygon_region);
  return print;
}

}  // namespace isimp::bench
