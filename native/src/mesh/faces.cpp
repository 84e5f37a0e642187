#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "isimp/core/errors.h"
#include "soup.h"

namespace isimp::detail {
namespace {

constexpr std::array kKeys{
    "non_finite_faces", "repeated_index_faces", "duplicate_faces", "welded_vertices",  "flipped_faces",
    "cut_edges",        "split_edges",          "split_vertices",  "subdivided_edges", "turned_edges",
    "unused_vertices",  "filled_holes",         "cut_handles"};
constexpr std::size_t kKeptPlaces = 16;
constexpr double kFarthest = 1e30;  // areas, their squares and sums of them stay finite

bool usable(const Vec3& p) { return p.cwiseAbs().maxCoeff() <= kFarthest && p.allFinite(); }

}  // namespace

RepairLog::RepairLog() {
  for (const char* key : kKeys) repairs_.push_back({key, 0, {}});
}

void RepairLog::add(Mend what, std::int32_t where) {
  Repair& repair = repairs_[static_cast<std::size_t>(what)];
  if (static_cast<std::size_t>(repair.count++) < kKeptPlaces) repair.where.push_back(where);
}

void Soup::drop(const std::vector<char>& marked) {
  std::size_t kept = 0;
  for (std::size_t f = 0; f < named.size(); ++f) {
    if (marked[f]) continue;
    named[kept] = named[f];
    if (!welded.empty()) welded[kept] = welded[f];
    source_face[kept++] = source_face[f];
  }
  named.resize(kept);
  if (!welded.empty()) welded.resize(kept);
  source_face.resize(kept);
}

void drop_broken(Soup& soup, Job& job) {
  std::vector<char> bad_vertex(soup.vertices.size()), broken(soup.named.size(), 0);
  for (std::size_t v = 0; v < bad_vertex.size(); ++v) bad_vertex[v] = !usable(soup.vertices[v]);
  soup.source_face.resize(soup.named.size());
  std::iota(soup.source_face.begin(), soup.source_face.end(), 0);
  for (std::size_t f = 0; f < broken.size(); ++f) {
    const auto& [a, b, c] = soup.named[f];
    const auto face = static_cast<std::int32_t>(f);
    if (bad_vertex[a] || bad_vertex[b] || bad_vertex[c]) {
      soup.count_face(Mend::non_finite_faces, face);
    } else if (a == b || b == c || c == a) {
      soup.count_face(Mend::repeated_index_faces, face);
    } else {
      continue;
    }
    broken[f] = 1;
  }
  const std::int64_t bad = soup.log.count(Mend::non_finite_faces);
  const std::int64_t twice = soup.log.count(Mend::repeated_index_faces);
  if (bad + twice == static_cast<std::int64_t>(broken.size()))
    throw InvalidInput("no usable face is left: of " + std::to_string(bad + twice) + " faces " + std::to_string(bad) +
                       " have a corner that is not finite and " + std::to_string(twice) + " name a vertex twice");
  job.poll();
  if (bad + twice > 0) soup.drop(broken);
}

bool drop_duplicates(Soup& soup, const EdgeGroups& edges, Job& job) {
  std::vector<char> marked(soup.named.size(), 0);
  std::vector<std::pair<std::int32_t, std::int32_t>> by_apex;
  edges.for_each(job, [&](const EdgeGroup& edge) {
    if (edge.size() < 2 || (edge.size() == 2 && soup.apex(edge[0]) != soup.apex(edge[1]))) return;
    by_apex.clear();
    for (std::size_t i = 0; i < edge.size(); ++i) by_apex.emplace_back(soup.apex(edge[i]), edge[i] / 3);
    std::sort(by_apex.begin(), by_apex.end());
    for (std::size_t i = 1; i < by_apex.size(); ++i)
      if (by_apex[i].first == by_apex[i - 1].first) marked[by_apex[i].second] = 1;
  });
  bool any = false;
  for (std::size_t f = 0; f < marked.size(); ++f) {
    if (!marked[f]) continue;
    soup.count_face(Mend::duplicate_faces, static_cast<std::int32_t>(f));
    any = true;
  }
  if (any) soup.drop(marked);
  return any;
}

}  // namespace isimp::detail
