#include "sharp_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <span>
#include <tuple>

#include "complex/planes.h"
#include "isimp/partition/noise.h"
#include "parts.h"

namespace isimp {
namespace {

// tuned real
constexpr double kEdges = 3.0;        // mean edges: the width where none is given
constexpr double kZigzag = 1.3;       // a border along faces is that much longer than the line that it follows
constexpr double kBeside = 0.7;       // least share of a strip's perimeter along wider regions
constexpr double kWider = 1.5;        // times a strip's width, from which a region is wider
constexpr double kLeastAngle = 25.0;  // degrees between the planes that meet at a strip
// tuned houses
constexpr double kMostAngle = 150.0;  // from here on they are the two faces of a plate, which meet at no edge
// tuned real
constexpr double kSpareAngle = 20.0;      // degrees that the angles to both may be more than that
constexpr double kOfNormal = 0.25;        // weight of the squared difference of normals; the distance in widths has 1
constexpr int kRounds = 3;                // limit
constexpr std::size_t kBesideLooked = 3;  // limit
// tuned houses
constexpr int kFlatFaces = 100;  // least mean number of faces of a region where planes are sure

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / std::numbers::pi;
}

struct Region {
  Vec3 normal = Vec3::Zero();
  double area = 0, perimeter = 0, width = 0;
  std::map<std::int32_t, double> beside;  // length of the border to each neighbour
};

class Sharpener {
 public:
  Sharpener(const Mesh& mesh, std::vector<std::int32_t> labels, double width, std::int32_t spare, Job& job)
      : mesh_(mesh), width_(width), spare_(static_cast<std::size_t>(spare)), job_(job), label_(std::move(labels)) {
    const auto count = static_cast<std::size_t>(mesh.face_count());
    centre_.reserve(count);
    vector_.reserve(count);
    for (const Triangle& t : mesh.triangles()) {
      const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
      centre_.push_back((a + b + c) / 3);
      vector_.push_back((b - a).cross(c - a) / 2);
    }
  }

  /// \return whether any strip was removed
  bool run() {
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      measure();
      std::vector<std::int32_t> strips = find_strips();
      strips.resize(std::min(strips.size(), spare_));
      if (strips.empty()) break;
      flood(strips);
      join_pieces();
      spare_ -= strips.size();
      any = true;
    }
    return any;
  }
  std::vector<std::int32_t> take_labels() && { return std::move(label_); }

 private:
  void measure() {
    const std::int32_t count = *std::max_element(label_.begin(), label_.end()) + 1;
    regions_.assign(static_cast<std::size_t>(count), {});
    for (std::size_t h = 0; h < 3 * label_.size(); ++h) {
      const std::int32_t r = label_[h / 3];
      if (r == kNone) continue;
      Region& region = regions_[r];
      if (h % 3 == 0) {
        region.normal += vector_[h / 3];
        region.area += vector_[h / 3].norm();
      }
      const auto g = static_cast<std::int32_t>(h);
      const std::int32_t other = mesh_.opposite(g) == kNone ? kNone : label_[mesh_.opposite(g) / 3];
      if (other == r) continue;
      const double length = (mesh_.vertices()[mesh_.to(g)] - mesh_.vertices()[mesh_.from(g)]).norm();
      region.perimeter += length;
      if (other != kNone) region.beside[other] += length;
    }
    for (Region& r : regions_) {
      if (r.normal.norm() > 0) r.normal.normalize();
      r.width = r.perimeter > 0 ? 2 * r.area / (r.perimeter / kZigzag) : 0;
    }
  }

  /// Checks the narrowest regions first, so that strips next to strips are found.
  [[nodiscard]] std::vector<std::int32_t> find_strips() const {
    std::vector<std::int32_t> order, strips;
    for (std::size_t r = 0; r < regions_.size(); ++r)
      if (!regions_[r].beside.empty() && regions_[r].width <= width_) order.push_back(static_cast<std::int32_t>(r));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t a, std::int32_t b) { return regions_[a].width < regions_[b].width; });
    std::vector<bool> is_strip(regions_.size(), false);
    for (const std::int32_t r : order) {
      is_strip[r] = is_strip_of_edge(regions_[r], is_strip);
      if (is_strip[r]) strips.push_back(r);
    }
    return strips;
  }

  [[nodiscard]] bool is_strip_of_edge(const Region& r, const std::vector<bool>& is_strip) const {
    double beside = 0;
    std::vector<std::pair<double, std::int32_t>> wider;
    for (const auto& [other, length] : r.beside) {
      if (!is_strip[other] && regions_[other].width <= kWider * r.width && regions_[other].width + r.width > width_)
        continue;
      beside += length;
      if (!is_strip[other]) wider.emplace_back(-length, other);
    }
    if (beside < kBeside * r.perimeter) return false;
    std::sort(wider.begin(), wider.end());
    wider.resize(std::min(wider.size(), kBesideLooked));
    for (std::size_t i = 0; i < wider.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Vec3 &a = regions_[wider[i].second].normal, &b = regions_[wider[j].second].normal;
        const double both = degrees_between(a, b), to_a = degrees_between(r.normal, a),
                     to_b = degrees_between(r.normal, b);
        if (both > kLeastAngle && both < kMostAngle && to_a + to_b < both + kSpareAngle && to_a < both && to_b < both)
          return true;
      }
    return false;
  }

  [[nodiscard]] double off_plane(std::int32_t f, std::int32_t r) const {
    return std::abs(planes_.at(r).normal.dot(centre_[f] - planes_.at(r).centre));
  }

  [[nodiscard]] double cost(std::int32_t f, std::int32_t r) const {
    const double area = vector_[f].norm(), off = off_plane(f, r) / width_;
    const double turned = area > 0 ? (vector_[f] / area - planes_.at(r).normal).squaredNorm() : 0.0;
    return kOfNormal * turned + off * off;
  }

  /// Adds the faces of strips to the adjacent regions, the cheapest first. Faces that none can reach stay.
  void flood(std::span<const std::int32_t> strips) {
    std::vector<bool> free(regions_.size(), false);
    for (const std::int32_t r : strips) free[r] = true;
    std::map<std::int32_t, std::vector<std::int32_t>> round;
    for (const std::int32_t r : strips)
      for (const auto& [other, length] : regions_[r].beside)
        if (!free[other]) round[other];
    const std::vector<std::int32_t> before = label_;
    for (std::size_t f = 0; f < label_.size(); ++f) {
      const std::int32_t r = label_[f];
      if (r == kNone) continue;
      if (const auto at = round.find(r); at != round.end()) at->second.push_back(static_cast<std::int32_t>(f));
      if (free[r]) label_[f] = kFree;
    }
    planes_.clear();
    std::vector<std::uint8_t> outlying(label_.size(), 0);
    for (const auto& [r, faces] : round) {
      job_.poll();
      meshing::mark_outlying(mesh_, faces, outlying);
      meshing::Plane& plane = planes_[r] = meshing::plane_of(mesh_, faces, outlying);
      plane.normal = best_normal(plane);
    }
    using LabelPrice = std::tuple<double, std::int32_t, std::int32_t>;
    std::priority_queue<LabelPrice, std::vector<LabelPrice>, std::greater<>> queue;
    const auto offer = [&](std::int32_t f, std::int32_t r) {
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
        const std::int32_t g = mesh_.opposite(h) == kNone ? kNone : mesh_.opposite(h) / 3;
        if (g != kNone && label_[g] == kFree) queue.emplace(cost(g, r), g, r);
      }
    };
    for (const auto& [r, faces] : round)
      for (const std::int32_t f : faces) offer(f, r);
    while (!queue.empty()) {
      const auto [price, f, r] = queue.top();
      queue.pop();
      if (label_[f] != kFree) continue;
      label_[f] = r;
      offer(f, r);
    }
    for (std::size_t f = 0; f < label_.size(); ++f)
      if (label_[f] == kFree) label_[f] = before[f];
  }

  /// Keeps only the largest piece of a region in several pieces. Each other piece joins the region it touches most.
  void join_pieces() {
    const Parts pieces = parts_of(
        mesh_.graph(), [&](std::int32_t f) { return label_[f]; }, job_);
    std::vector<std::int32_t> of(pieces.count), largest(regions_.size(), kNone);
    std::vector<std::vector<std::int32_t>> faces(pieces.count);
    std::vector<double> area(pieces.count, 0.0);
    for (std::size_t f = 0; f < label_.size(); ++f) {
      const std::int32_t p = pieces.of_face[f];
      if (p == kNone) continue;
      of[p] = label_[f];
      faces[p].push_back(static_cast<std::int32_t>(f));
      area[p] += vector_[f].norm();
    }
    for (std::size_t p = 0; p < of.size(); ++p) {
      std::int32_t& best = largest[of[p]];
      if (best == kNone || area[p] > area[best]) best = static_cast<std::int32_t>(p);
    }
    for (std::size_t p = 0; p < of.size(); ++p) {
      if (largest[of[p]] == static_cast<std::int32_t>(p)) continue;
      std::map<std::int32_t, double> touched;
      for (const std::int32_t f : faces[p])
        for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h) {
          const std::int32_t g = mesh_.opposite(h) == kNone ? kNone : mesh_.opposite(h) / 3;
          if (g != kNone && label_[g] != of[p] && label_[g] != kNone)
            touched[label_[g]] += (mesh_.vertices()[mesh_.to(h)] - mesh_.vertices()[mesh_.from(h)]).norm();
        }
      const auto most = std::max_element(touched.begin(), touched.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      if (most == touched.end()) continue;
      const std::int32_t to = most->first;
      for (const std::int32_t f : faces[p]) label_[f] = to;
    }
  }

  static constexpr std::int32_t kFree = -2;  // mark: label of a strip's face without a region yet

  const Mesh& mesh_;
  double width_;
  std::size_t spare_;  // strips that may join
  Job& job_;
  std::vector<std::int32_t> label_;
  std::vector<Vec3> centre_, vector_;
  std::vector<Region> regions_;
  std::map<std::int32_t, meshing::Plane> planes_;
};

}  // namespace

std::optional<std::vector<std::int32_t>> without_strips(const Mesh& mesh, const Partition& partition, double width,
                                                        std::int32_t least, Job& job) {
  const double wide = width > 0 ? width : kEdges * mean_edge(mesh);
  const std::int32_t spare = partition.region_count() - std::max(least, 1);
  if (!(wide > 0) || spare < 1) return std::nullopt;
  Sharpener sharpener(mesh, partition.face_region, wide, spare, job);
  if (!sharpener.run()) return std::nullopt;
  return std::move(sharpener).take_labels();
}

bool is_of_planes(const Mesh& mesh, const Partition& partition) {
  const auto count = static_cast<std::size_t>(partition.region_count());
  if (!(partition.noise > kScanNoise * mean_edge(mesh)) || partition.noise > partition.tolerance ||
      mesh.face_count() < kFlatFaces * partition.region_count())
    return false;
  std::vector<Vec3> middle(count, Vec3::Zero());
  std::vector<double> area(count, 0.0), share(partition.face_region.size(), 0.0);
  const auto each = [&](const auto& use) {
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      if (const std::int32_t r = partition.face_region[f]; r != kNone) {
        const Triangle& t = mesh.triangles()[f];
        const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
        use(f, r, (b - a).cross(c - a).norm(), (a + b + c) / 3);
      }
  };
  each([&](std::int32_t f, std::int32_t r, double of_face, const Vec3& centre) {
    share[f] = of_face;
    area[r] += of_face;
    middle[r] += of_face * centre;
  });
  for (std::size_t r = 0; r < count; ++r)
    if (area[r] > 0) middle[r] /= area[r];
  double near = 0, whole = 0;
  each([&](std::int32_t f, std::int32_t r, double, const Vec3& centre) {
    whole += share[f];
    if (std::abs(partition.region_normal[r].dot(centre - middle[r])) < partition.noise) near += share[f];
  });
  return near > whole / 2;
}

}  // namespace isimp
