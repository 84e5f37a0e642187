#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "flat/flat.h"

namespace isimp::meshing::flat {
namespace {

constexpr std::int32_t kPollEvery = 1 << 12;  // work

/// The sum of faces: twice their area times the normal, and twice their area times their middle.
struct Sum {
  Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
  double area = 0;
};

class Grower {
 public:
  Grower(const Mesh& mesh, double angle, std::span<const std::int32_t> group)
      : mesh_(mesh), group_(group), least_(std::cos(angle * std::numbers::pi / 180)), far_(kSame * mesh.diagonal()) {
    label_.assign(mesh.face_count(), kNone);
    normal_.reserve(mesh.face_count());
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const Vec3 a = corner(f, 0);
      normal_.push_back((corner(f, 1) - a).cross(corner(f, 2) - a));
    }
  }

  std::vector<std::int32_t> grow_all(const Job& job) {
    std::vector<std::int32_t> order(mesh_.face_count());
    std::vector<double> area(order.size());
    for (std::size_t f = 0; f < area.size(); ++f) area[f] = normal_[f].norm();
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](std::int32_t a, std::int32_t b) { return area[a] != area[b] ? area[a] > area[b] : a < b; });
    std::int32_t region = 0;
    for (const std::int32_t seed : order) {
      if (label_[seed] == kNone) grow(seed, region++, job);
    }
    return std::move(label_);
  }

 private:
  [[nodiscard]] Vec3 corner(std::int32_t f, std::size_t k) const { return mesh_.vertices()[mesh_.triangles()[f][k]]; }

  void grow(std::int32_t seed, std::int32_t region, const Job& job) {
    Sum sum;
    queue_.assign(1, seed);
    label_[seed] = region;
    add(sum, seed);
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      if (next % kPollEvery == 0) job.poll();
      for (std::int32_t k = 0; k < 3; ++k) {
        const std::int32_t other = mesh_.opposite(3 * queue_[next] + k);
        if (other == kNone) continue;
        const std::int32_t f = Mesh::face(other);
        if (label_[f] != kNone || (!group_.empty() && group_[f] != group_[seed]) || !fits(sum, f)) continue;
        label_[f] = region;
        add(sum, f);
        queue_.push_back(f);
      }
    }
  }

  void add(Sum& sum, std::int32_t f) const {
    const double area = normal_[f].norm();
    sum.normal += normal_[f];
    sum.area += area;
    sum.middle += area / 3 * (corner(f, 0) + corner(f, 1) + corner(f, 2));
  }

  /// Whether a face lies in the plane of the others.
  [[nodiscard]] bool fits(const Sum& sum, std::int32_t f) const {
    const double length = sum.normal.norm(), area = normal_[f].norm();
    if (!(length > 0)) return false;
    const Vec3 n = sum.normal / length, c = sum.middle / sum.area;
    const double along = normal_[f].dot(n);
    if (area > 0 && along >= least_ * area) return true;
    if (along < 0) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs((corner(f, k) - c).dot(n)) > far_) return false;
    }
    return true;
  }

  const Mesh& mesh_;
  std::span<const std::int32_t> group_;
  double least_, far_;
  std::vector<Vec3> normal_;
  std::vector<std::int32_t> label_, queue_;
};

}  // namespace

Regions find_regions(const Mesh& mesh, double angle, std::span<const std::int32_t> group, const Job& job) {
  Regions found;
  found.label = Grower(mesh, angle, group).grow_all(job);
  std::vector<std::int32_t> number(mesh.face_count(), kNone);  // by first face
  std::int32_t count = 0;
  for (std::int32_t& label : found.label) {
    if (number[label] == kNone) number[label] = count++;
    label = number[label];
  }
  found.start.assign(count + 1, 0);
  for (const std::int32_t label : found.label) ++found.start[label + 1];
  std::partial_sum(found.start.begin(), found.start.end(), found.start.begin());
  found.of.resize(mesh.face_count());
  std::vector<std::int32_t> place(found.start.begin(), found.start.end() - 1);
  std::vector<Sum> sums(count);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t r = found.label[f];
    found.of[place[r]++] = f;
    const Triangle& t = mesh.triangles()[f];
    const Vec3 a = mesh.vertices()[t[0]], b = mesh.vertices()[t[1]], c = mesh.vertices()[t[2]];
    const Vec3 normal = (b - a).cross(c - a);
    sums[r].normal += normal;
    sums[r].area += normal.norm();
    sums[r].middle += normal.norm() / 3 * (a + b + c);
  }
  for (const Sum& sum : sums) {
    const double length = sum.normal.norm();
    found.plane.push_back(length > 0 ? Plane{sum.normal / length, sum.middle / sum.area} : Plane{});
  }
  return found;
}

std::vector<std::vector<Loop>> find_loops(const Mesh& mesh, const Regions& regions) {
  std::vector<std::vector<Loop>> loops(regions.count());
  std::vector<char> seen(3 * static_cast<std::size_t>(mesh.face_count()), 0);
  const auto ends = [&](std::int32_t h) {
    const std::int32_t other = mesh.opposite(h);
    return other == kNone || regions.label[Mesh::face(other)] != regions.label[Mesh::face(h)];
  };
  for (std::int32_t first = 0; first < 3 * mesh.face_count(); ++first) {
    if (seen[first] != 0 || !ends(first)) continue;
    Loop loop;
    for (std::int32_t h = first; seen[h] == 0;) {
      seen[h] = 1;
      loop.push_back(mesh.from(h));
      h = Mesh::next(h);
      while (!ends(h)) h = Mesh::next(mesh.opposite(h));
    }
    loops[regions.label[Mesh::face(first)]].push_back(std::move(loop));
  }
  return loops;
}

}  // namespace isimp::meshing::flat
