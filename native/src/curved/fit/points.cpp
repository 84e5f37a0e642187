#include "fit/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fit/numbers.h"
#include "isimp/core/symmetric.h"
#include "isimp/core/tiny.h"

namespace isimp::curved {
namespace {

// tuned round
constexpr double kOff = 9;  ///< mean areas of its faces: a centre at a larger squared distance from them is off
const double kJoins = std::cos(33 * std::numbers::pi / 180);  ///< least cosine between normals of joined points

/// Splits flat regions that go far along a parallel, such as the top of a torus. Their centre is near the axis, off the
/// surface, and that of each part is not.
class Splitter {
 public:
  /// \param label  (n) by graph index, below `count` or kNone; parts get new ones
  Splitter(const Faces& faces, Some& label, std::size_t count) : f_(faces), label_(label), members_(count) {
    for (std::int32_t i = 0; i < faces.size(); ++i)
      if (label[i] != kNone) members_[label[i]].push_back(i);
  }

  /// \return the number of labels
  std::size_t run() {
    for (std::size_t p = 0; p < members_.size(); ++p)
      while (is_off(members_[p]) && split(p)) {
      }
    return members_.size();
  }

 private:
  [[nodiscard]] Vec3 centre(const Some& some) const {
    Vec3 sum = Vec3::Zero();
    double area = 0;
    for (const std::int32_t i : some) {
      sum += f_.area(i) * f_.centre(i);
      area += f_.area(i);
    }
    return sum / std::max(area, kTiny);
  }

  /// Whether a flat region has its centre away from all of its faces.
  [[nodiscard]] bool is_off(const Some& some) const {
    if (some.size() < kLeastPoints) return false;
    Vec3 normal = Vec3::Zero();
    double area = 0;
    for (const std::int32_t i : some) {
      area += f_.area(i);
      normal += f_.area(i) * f_.normal(i);
    }
    if (normal.norm() <= (1 - kFlat) * area) return false;  // no ring on top of a round part
    const double far = kOff * area * f_.graph().area / static_cast<double>(some.size());
    const Vec3 middle = centre(some);
    return std::all_of(some.begin(), some.end(),
                       [&](std::int32_t i) { return (f_.centre(i) - middle).squaredNorm() > far; });
  }

  /// Halves a region across its longest direction; the second half gets a new label.
  /// \return whether both halves have faces; else nothing has changed
  bool split(std::size_t p) {
    const Vec3 middle = centre(members_[p]);
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const std::int32_t i : members_[p]) {
      const Vec3 v = f_.centre(i) - middle;
      spread += f_.area(i) * v * v.transpose();
    }
    const Vec3 along = spectrum_of(spread).vectors.col(2);
    Some first, second;
    for (const std::int32_t i : members_[p]) ((f_.centre(i) - middle).dot(along) < 0 ? first : second).push_back(i);
    if (first.empty() || second.empty()) return false;
    for (const std::int32_t i : second) label_[i] = static_cast<std::int32_t>(members_.size());
    members_[p] = std::move(first);
    members_.push_back(std::move(second));
    return true;
  }

  const Faces& f_;
  Some& label_;
  std::vector<Some> members_;  // by label
};

}  // namespace

Points points_of(const Faces& faces, std::span<const std::int32_t> small, std::span<const std::uint8_t> locked,
                 Job& job) {
  const FaceGraph& graph = faces.graph();
  const auto labels = small.empty() ? 0 : static_cast<std::size_t>(1 + *std::max_element(small.begin(), small.end()));
  Points points;
  points.of_face.resize(static_cast<std::size_t>(faces.size()));
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    const bool is_free = locked.empty() || locked[i] == 0;
    points.of_face[i] = is_free ? small[graph.mesh_face[i]] : kNone;
  }
  const std::size_t count = Splitter(faces, points.of_face, labels).run();
  points.area.assign(count, 0.0);
  points.centre.assign(count, Vec3::Zero());
  points.normal.assign(count, Vec3::Zero());
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    if ((i & 0xffff) == 0) job.poll();
    const std::int32_t p = points.of_face[i];
    if (p == kNone) continue;
    const double a = faces.area(i);
    points.area[p] += a;
    points.centre[p] += a * faces.centre(i);
    points.normal[p] += a * faces.normal(i);
  }
  for (std::size_t p = 0; p < count; ++p) {
    if (points.area[p] > 0) points.centre[p] /= points.area[p];
    const double length = points.normal[p].norm();
    if (length > 0) points.normal[p] /= length;
  }
  std::vector<std::array<std::int32_t, 2>> edges;
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    const std::int32_t p = points.of_face[i];
    if (p == kNone) continue;
    for (const std::int32_t j : graph.neighbours[i]) {
      const std::int32_t q = j == graph.size() ? kNone : points.of_face[j];
      if (p < q && points.normal[p].dot(points.normal[q]) > kJoins) edges.push_back({p, q});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  points.near.resize(count);
  for (const auto& [p, q] : edges) {
    points.near[p].push_back(q);
    points.near[q].push_back(p);
  }
  return points;
}

}  // namespace isimp::curved
