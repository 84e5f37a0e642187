// Removes broken and duplicate faces, and counts repairs.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "isimp/core/errors.h"
#include "surface/soup.h"

namespace isimp::detail {
namespace {

// The report's keys: an interface, so renamed kinds keep their older names here.
constexpr std::array kKeys{
    "non_finite_faces", "repeated_index_faces", "duplicate_faces",   "welded_vertices",   "flipped_faces",
    "cut_edges",        "split_edges",          "split_vertices",    "subdivided_edges",  "turned_edges",
    "unused_vertices",  "inner_faces",          "stitched_vertices", "smoothed_vertices", "filled_holes",
    "cut_handles"};
constexpr std::size_t kKeptPlaces = 16;  // limit

bool usable(const Vec3& p) { return p.cwiseAbs().maxCoeff() <= kFarthest && p.allFinite(); }

}  // namespace

RepairLog::RepairLog() {
  for (const char* key : kKeys) repairs_.push_back({key, 0, {}});
}

RepairLog::RepairLog(const RepairReport& before) : RepairLog() {
  if (!before.empty()) repairs_ = before;
}

void RepairLog::add(RepairKind what, std::int32_t where) {
  Repair& repair = repairs_[static_cast<std::size_t>(what)];
  if (static_cast<std::size_t>(repair.count++) < kKeptPlaces) repair.where.push_back(where);
}

void RepairLog::add_orientation(const RepairLog& other, const std::vector<std::int32_t>& face) {
  for (const RepairKind what : {RepairKind::reversed_faces, RepairKind::cut_edges, RepairKind::split_edges}) {
    Repair& repair = repairs_[static_cast<std::size_t>(what)];
    const Repair& more = other.repairs_[static_cast<std::size_t>(what)];
    repair.count += more.count;
    for (const std::int32_t f : more.where)
      if (repair.where.size() < kKeptPlaces) repair.where.push_back(face[f]);
  }
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

void drop_broken(Soup& soup, const Threads& threads, Job& job) {
  const std::size_t faces = soup.named.size();
  const auto is_bad = [&](std::int32_t v) { return !usable(soup.vertices[v]); };
  const bool all_usable = find_first(threads, soup.vertices.size(), [&](std::size_t v) {
                            return is_bad(static_cast<std::int32_t>(v));
                          }) == soup.vertices.size();
  const auto is_broken = [&](std::size_t f) {
    const auto& [a, b, c] = soup.named[f];
    return a == b || b == c || c == a || (!all_usable && (is_bad(a) || is_bad(b) || is_bad(c)));
  };
  number_all(threads, soup.source_face, faces, job);
  const std::vector<std::int32_t> broken =
      gather<std::int32_t>(threads, faces, job, [&](std::size_t f, std::vector<std::int32_t>& found) {
        if (is_broken(f)) found.push_back(static_cast<std::int32_t>(f));
      });
  for (const std::int32_t f : broken) {
    const Triangle& t = soup.named[f];
    const bool bad = std::any_of(t.begin(), t.end(), is_bad);
    soup.count_face(bad ? RepairKind::non_finite_faces : RepairKind::repeated_index_faces, f);
  }
  const std::int64_t bad = soup.log.count(RepairKind::non_finite_faces);
  const std::int64_t twice = soup.log.count(RepairKind::repeated_index_faces);
  if (broken.size() == faces)
    throw InvalidInput("no usable face is left: of " + std::to_string(bad + twice) + " faces " + std::to_string(bad) +
                       " have a corner that is not finite and " + std::to_string(twice) + " use a vertex twice");
  job.poll();
  if (broken.empty()) return;
  std::vector<char> marked(faces, 0);
  for (const std::int32_t f : broken) marked[f] = 1;
  soup.drop(marked);
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
    soup.count_face(RepairKind::duplicate_faces, static_cast<std::int32_t>(f));
    any = true;
  }
  if (any) soup.drop(marked);
  return any;
}

}  // namespace isimp::detail
