// Splits a region in two, by itself or along a line.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "edit.h"
#include "isimp/core/errors.h"
#include "isimp/interact/merge.h"

namespace isimp {
namespace {

constexpr int kArc = 12;  // work: points on the circle that closes a line around one side

using Vec2 = Eigen::Vector2d;

std::int32_t splittable(const Edit& edit, std::int32_t face) {
  const std::int32_t region = edit.region_at(face);
  if (edit.result.region_sum[region].faces < 2)
    throw InvalidInput("the region of face " + std::to_string(face) + " is that face alone: there is nothing to split");
  return region;
}

/// A line seen along a direction; classifies points by its sides.
class Curtain {
 public:
  Curtain(std::span<const Vec3> line, const Vec3& direction, const Vec3& middle) : middle_(middle) {
    if (line.size() < 2)
      throw InvalidInput("a line to cut along needs at least 2 points, got " + std::to_string(line.size()));
    for (std::size_t k = 0; k < line.size(); ++k)
      if (!line[k].allFinite()) throw InvalidInput("point " + std::to_string(k) + " of the line is not finite");
    if (!direction.allFinite()) throw InvalidInput("the direction of the cut is not finite");
    right_ = direction.unitOrthogonal();
    up_ = direction.normalized().cross(right_);
    for (const Vec3& p : line)
      if (points_.empty() || flat(p) != points_.back()) points_.push_back(flat(p));
    if (points_.size() < 2) throw InvalidInput("the line to cut along is a point when seen along its direction");
  }

  [[nodiscard]] Vec2 flat(const Vec3& p) const { return {right_.dot(p - middle_), up_.dot(p - middle_)}; }

  /// Extends the line straight at both ends to beyond `reach` of the middle, and around the left side far outside.
  void close(double reach) {
    for (const Vec2& p : points_) reach = std::max(reach, p.norm());
    const auto beyond = [&](const Vec2& p, const Vec2& from) { return Vec2(p + 4 * reach * (p - from).normalized()); };
    const std::size_t n = points_.size();
    const Vec2 begin = beyond(points_[0], points_[1]), end = beyond(points_[n - 1], points_[n - 2]);
    points_.insert(points_.begin(), begin);
    points_.push_back(end);
    const double first = std::atan2(end.y(), end.x());
    double turn = std::atan2(begin.y(), begin.x()) - first;
    if (turn <= 0) turn += 2 * std::numbers::pi;
    for (int k = 0; k <= kArc; ++k) {
      const double angle = first + turn * k / kArc;
      points_.emplace_back(8 * reach * std::cos(angle), 8 * reach * std::sin(angle));
    }
  }

  [[nodiscard]] bool left(const Vec2& p) const {
    bool inside = false;
    for (std::size_t k = 0, before = points_.size() - 1; k < points_.size(); before = k++) {
      const Vec2 &a = points_[before], &b = points_[k];
      if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        inside = !inside;
    }
    return inside;
  }

 private:
  Vec3 middle_, right_, up_;
  std::vector<Vec2> points_;
};

Vec3 middle_of(const Mesh& mesh, std::int32_t face) {
  const Triangle& t = mesh.triangles()[face];
  return (mesh.vertices()[t[0]] + mesh.vertices()[t[1]] + mesh.vertices()[t[2]]) / 3;
}

/// The connected piece of the faces with a label that has the largest area; ties prefer the first found. Sets `mark` on
/// its faces; the others keep their label.
std::vector<std::int32_t> largest_piece(const FaceGraph& graph, EditLabels labels, std::span<const std::int32_t> faces,
                                        std::int32_t label, std::int32_t mark) {
  std::vector<std::vector<std::int32_t>> pieces;
  double most = -1.0;
  std::size_t best = 0;
  for (const std::int32_t face : faces) {
    if (labels.get(face) != label) continue;
    pieces.push_back(take_out(graph, labels, face));
    double area = 0.0;
    for (const std::int32_t i : pieces.back()) area += graph.faces[i].area;
    if (area > most) best = pieces.size() - 1;
    most = std::max(most, area);
  }
  for (std::size_t k = 0; k < pieces.size(); ++k)
    for (const std::int32_t i : pieces[k]) labels.set(i, k == best ? mark : label);
  return std::move(pieces[best]);
}

/// Makes a new region of the faces labelled kLeft, and connects both regions by moving pieces between them.
void settle(Edit& edit, std::span<const std::int32_t> faces, std::int32_t region, std::int32_t face,
            std::int32_t left) {
  const FaceGraph& graph = edit.graph;
  const std::int32_t fresh = edit.add_region();
  largest_piece(graph, edit.labels, faces, left, fresh);
  for (const std::int32_t i : faces)
    if (edit.labels.get(i) == left) edit.labels.set(i, region);
  constexpr std::int32_t kRest = -5;  // mark
  largest_piece(graph, edit.labels, faces, region, kRest);
  for (const std::int32_t i : faces) edit.labels.set(i, edit.labels.get(i) == kRest ? region : fresh);
  if (edit.labels.get(face) == fresh)
    for (const std::int32_t i : faces) edit.labels.set(i, edit.labels.get(i) == fresh ? region : fresh);
  for (const std::int32_t r : {region, fresh}) edit.result.region_sum[r] = {};
  for (const std::int32_t i : faces) edit.result.region_sum[edit.labels.get(i)].add(graph.faces[i]);
  edit.result.region_seed[region] = kNone;
  edit.hints.assign(faces.begin(), faces.end());
}

}  // namespace

Partition split_region(const Mesh& mesh, const Partition& partition, std::int32_t face, Job& job) {
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  const std::int32_t region = splittable(edit, face), start = edit.at(face);
  Job::Stage stage(job, "splitting", 0.0, 1.0);
  const std::vector<std::int32_t> faces = edit.take_region(start);
  const std::int32_t fresh = edit.add_region();
  Halves halves = split_in_two(graph, edit.labels, faces, edit.result.region_sum[region], {region, fresh});
  if (edit.labels.get(start) == fresh) {
    for (const std::int32_t i : faces) edit.labels.set(i, edit.labels.get(i) == fresh ? region : fresh);
    std::swap(halves.sum[0], halves.sum[1]);
  }
  edit.result.region_sum[region] = halves.sum[0];
  edit.result.region_sum[fresh] = halves.sum[1];
  edit.result.region_seed[region] = kNone;
  const std::int32_t both[] = {region, fresh};
  edit.hold_all_but(both);
  edit.relax(faces, start, job);
  edit.hints = faces;
  return edit.finish();
}

Partition split_along(const Mesh& mesh, const Partition& partition, std::int32_t face, std::span<const Vec3> line,
                      const Vec3& direction, Job& job) {
  constexpr std::int32_t kLeft = -4;  // mark
  Edit edit(mesh, partition);
  const FaceGraph& graph = edit.graph;
  const std::int32_t region = splittable(edit, face), start = edit.at(face);
  Job::Stage stage(job, "splitting", 0.0, 1.0);
  const Vec3 normal = partition.region_normal[region];
  const Vec3 middle = middle_of(mesh, face);
  const Vec3 along = direction != Vec3::Zero() ? direction : normal != Vec3::Zero() ? normal : Vec3(0, 0, 1);
  std::vector<Vec3> local(line.begin(), line.end());
  for (Vec3& p : local) p -= mesh.origin();
  Curtain curtain(local, along, middle);
  const std::vector<std::int32_t> faces = edit.take_region(start);
  job.poll();
  double reach = 0.0;
  for (const std::int32_t i : faces) reach = std::max(reach, (middle_of(mesh, graph.mesh_face[i]) - middle).norm());
  curtain.close(reach);
  std::size_t left = 0;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if ((k & 0xfff) == 0) job.poll();
    const bool is_left = curtain.left(curtain.flat(middle_of(mesh, graph.mesh_face[faces[k]])));
    edit.labels.set(faces[k], is_left ? kLeft : region);
    left += is_left ? 1 : 0;
  }
  if (left == 0 || left == faces.size())
    throw InvalidInput("the line does not cut the region of face " + std::to_string(face) +
                       ": all of it lies on one side");
  settle(edit, faces, region, start, kLeft);
  return edit.finish();
}

}  // namespace isimp
