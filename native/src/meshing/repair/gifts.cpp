#include "repair/gifts.h"

#include <algorithm>

#include "isimp/core/sorted.h"

namespace isimp::meshing {
namespace {

/// The labels at a vertex, counter-clockwise; empty at a border of the mesh.
/// \param label_of  the label of a face
template <class LabelOf>
std::vector<std::int32_t> labels_around(const Mesh& mesh, std::int32_t vertex, LabelOf label_of) {
  std::vector<std::int32_t> round;
  if (mesh.opposite(mesh.vertex_halfedge()[vertex]) == kNone) return round;
  for_each_leaving(mesh, vertex, [&](std::int32_t h) {
    const std::int32_t l = label_of(h / 3);
    if (round.empty() || round.back() != l) round.push_back(l);
  });
  if (round.size() > 1 && round.front() == round.back()) round.pop_back();
  return round;
}

/// Marks some faces.
/// \return their boundary half-edges in order; empty if they are no disc
std::vector<std::int32_t> outline(const Labels& labels, std::span<const std::int32_t> faces) {
  const Mesh& mesh = labels.mesh;
  Marks &in = labels.face_marks, &seen = labels.vertex_marks;
  in.clear();
  seen.clear();
  for (const std::int32_t f : faces) in.add(f);
  const auto is_inner = [&](std::int32_t h) {
    const std::int32_t o = mesh.opposite(h);
    return o != kNone && in.has(o / 3);
  };
  std::size_t vertices = 0, boundary = 0;
  std::int32_t start = kNone;
  for (const std::int32_t f : faces)
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
      vertices += static_cast<std::size_t>(seen.add(mesh.from(h)));
      if (is_inner(h)) continue;
      ++boundary;
      start = h;
    }
  // A disc has V - E + F = 1 and one boundary loop, and 2 E = 3 F + boundary.
  if (2 * vertices != faces.size() + boundary + 2) return {};
  std::vector<std::int32_t> loop;
  seen.clear();
  for (std::int32_t h = start; seen.add(mesh.from(h));) {
    loop.push_back(h);
    h = Mesh::next(h);
    while (is_inner(h)) h = Mesh::next(mesh.opposite(h));
  }
  if (loop.size() != boundary) loop.clear();
  return loop;
}

}  // namespace

std::vector<std::int32_t> charts_around(const Labels& labels, std::int32_t vertex) {
  return labels_around(labels.mesh, vertex, [&](std::int32_t f) { return labels.label[f]; });
}

std::vector<std::int32_t> path_between(const Labels& labels, std::int32_t from, std::int32_t to,
                                       std::span<const std::int32_t> charts) {
  const Mesh& mesh = labels.mesh;
  const auto is_one = [&](std::int32_t l) { return std::find(charts.begin(), charts.end(), l) != charts.end(); };
  std::int32_t h = kNone;
  for_each_leaving(mesh, from, [&](std::int32_t first) {
    if (is_one(labels.label[first / 3]) && is_one(labels.across(first)) && !labels.inner(first)) h = first;
  });
  std::vector<std::int32_t> path;
  for (const std::int32_t right = h == kNone ? kNone : labels.across(h); h != kNone && labels.across(h) == right;
       h = labels.next_on_boundary(h)) {
    path.push_back(h);
    if (mesh.to(h) == to) return path;
  }
  return {};
}

void fill(Gift& gift, const Labels& labels, std::span<const std::int32_t> path) {
  const auto add_star = [&](std::int32_t v) {
    if (v == gift.keeps) return;
    for_each_leaving(labels.mesh, v, [&](std::int32_t h) {
      if (labels.label[h / 3] == gift.giver) gift.faces.push_back(h / 3);
    });
  };
  for (const std::int32_t h : path) add_star(labels.mesh.from(h));
  add_star(labels.mesh.to(path.back()));
  sort_unique(gift.faces);
}

bool keeps_discs(const Labels& labels, const Gift& gift, const std::vector<std::int32_t>& all) {
  const std::vector<std::int32_t> loop = outline(labels, gift.faces);
  // A disc without a disc along one path of its boundary is a disc, and so are two discs with one common path, if no
  // chart touches itself at a vertex.
  const auto runs = [&](std::int32_t label) {
    int count = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      count += labels.across(loop[i]) == label && labels.across(loop[i > 0 ? i - 1 : loop.size() - 1]) != label;
    return count;
  };
  if (runs(gift.giver) != 1 || runs(gift.taker) != 1) return false;
  const auto label_after = [&](std::int32_t f) { return labels.face_marks.has(f) ? gift.taker : labels.label[f]; };
  return std::all_of(loop.begin(), loop.end(), [&](std::int32_t h) {
    const std::int32_t v = labels.mesh.from(h);
    const std::vector<std::int32_t> before = charts_around(labels, v),
                                    after = labels_around(labels.mesh, v, label_after);
    std::vector<std::int32_t> sorted = after;
    sort_unique(sorted);
    if (before.empty() || sorted.size() != after.size()) return false;
    if (v == gift.keeps) return sorted == all;
    return after.size() > 2 ? before == after : v == gift.moves || before.size() <= 2;
  });
}

}  // namespace isimp::meshing
