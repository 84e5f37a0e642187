#include <algorithm>
#include <cmath>
#include <numbers>

#include "face_labels.h"

namespace isimp::curved {
namespace {

const double kCrease = std::cos(24 * std::numbers::pi / 180);  ///< cosine between normals of points on both sides
constexpr double kNearlyAll = 0.85;  ///< least good share of the border of a patch that is no sphere and no full turn
constexpr double kMost =
    0.62;  ///< least good share for a sphere, a tube, and a cylinder with kHalf of its border along planes
constexpr double kHalf = 0.5, kAlong = 0.12;
constexpr double kAllRound = 0.92;    ///< share of a full turn that counts as a full turn
constexpr double kSome = 0.25;        ///< least good share of the border of a full turn, or of more than half a sphere
constexpr double kLargePlane = 0.02;  ///< share of the whole area: planes of free forms are smaller ...
constexpr double kFlat = 0.45;        ///< times the nearness: ... or their faces are not so near to them
constexpr double kDisc = 2.3;         ///< outline of a disc of n equilateral triangles, in edges, over the root of n
constexpr double kHalfSphere = 0.42;  ///< 1 - |mean normal|, which is half of a half sphere's normals

/// The border of a patch: pairs of a face and its neighbour outside; kNone at the border of the scan.
struct Beside {
  std::int32_t face, other;
};

class Gates {
 public:
  Gates(const Faces& faces, const Points& points, const std::vector<Found>& found, const Some& labels,
        const Nearness& near)
      : f_(faces),
        p_(points),
        found_(found),
        labels_(labels),
        near_(near),
        members_(found.size()),
        border_(found.size()) {
    const FaceGraph& graph = faces.graph();
    for (std::int32_t i = 0; i < faces.size(); ++i) {
      const std::int32_t label = labels[i];
      if (label == kNone || found[label].is_plane()) continue;
      members_[label].push_back(i);
      for (const std::int32_t j : graph.neighbours[i]) {
        if (j == graph.size())
          border_[label].push_back({i, kNone});
        else if (labels[j] != label)
          border_[label].push_back({i, j});
      }
    }
  }

  std::vector<bool> run() {
    std::vector<bool> kept(found_.size(), true);
    std::vector<double> round(found_.size(), 0.0);
    for (std::size_t k = 0; k < found_.size(); ++k) {
      if (found_[k].is_plane()) {
        kept[k] = found_[k].area > kLargePlane && found_[k].rms < kFlat * near_.distance;
        continue;
      }
      kept[k] = !members_[k].empty();
      round[k] = round_of(k);
    }
    for (;;) {  // the worst first, as patches hold each other up
      std::size_t worst = found_.size();
      double least = 0;
      for (std::size_t k = 0; k < found_.size(); ++k) {
        if (found_[k].is_plane() || !kept[k]) continue;
        const bool is_sphere = found_[k].surface.kind == CurvedKind::sphere;
        const bool is_round = round[k] > (is_sphere ? kHalfSphere : kAllRound);
        const bool is_easier = is_sphere || found_[k].surface.closed || along_planes(k, kept) > kHalf;
        const double most = is_easier ? kMost : kNearlyAll;
        const double more = good_share(k, kept) - (is_round ? kSome : most);
        if (more > least) continue;
        least = more;
        worst = k;
      }
      if (worst == found_.size()) break;
      kept[worst] = false;
    }
    return kept;
  }

 private:
  /// The covered share of a full turn; of a sphere, 1 - |mean normal|, which is 1 if all of it is covered.
  [[nodiscard]] double round_of(std::size_t k) const {
    if (found_[k].surface.kind == CurvedKind::extrusion) return found_[k].surface.closed ? 1 : 0;
    const Samples s = samples_of(f_, members_[k]);
    if (found_[k].surface.kind != CurvedKind::sphere) return turn_share(found_[k].surface, s);
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i];
    return 1 - sum.norm();
  }

  /// The share of the border of a cylinder at kept planes along its axis, as that of a fillet.
  [[nodiscard]] double along_planes(std::size_t k, const std::vector<bool>& kept) const {
    const CurvedSurface& s = found_[k].surface;
    if (s.kind != CurvedKind::cylinder) return 0;
    double count = 0;
    for (const Beside& b : border_[k]) {
      const std::int32_t other = b.other == kNone ? kNone : labels_[b.other];
      count += other != kNone && kept[other] && found_[other].is_plane() &&
                       std::abs(found_[other].surface.axis.dot(s.axis)) < kAlong
                   ? 1
                   : 0;
    }
    return count / static_cast<double>(border_[k].size());
  }

  [[nodiscard]] double good_share(std::size_t k, const std::vector<bool>& kept) const {
    // A patch with a shorter border than a disc of as many faces is nearly closed, as a torus with a small hole.
    const double least = kDisc * std::sqrt(static_cast<double>(members_[k].size()));
    const double count = std::max(least, static_cast<double>(border_[k].size()));
    double good = count - static_cast<double>(border_[k].size());
    for (const auto& [face, other] : border_[k]) {
      if (other == kNone || (labels_[other] != kNone && kept[labels_[other]])) {
        ++good;
        continue;
      }
      const std::int32_t a = p_.of_face[face], b = p_.of_face[other];
      good += b == kNone || p_.normal[a].dot(p_.normal[b]) < kCrease ? 1 : 0;
    }
    return good / count;
  }

  const Faces& f_;
  const Points& p_;
  const std::vector<Found>& found_;
  const Some& labels_;
  const Nearness& near_;
  std::vector<Some> members_;
  std::vector<std::vector<Beside>> border_;
};

}  // namespace

std::vector<bool> kept_surfaces(const Faces& faces, const Points& points, const std::vector<Found>& found,
                                const Some& labels, const Nearness& near) {
  return Gates(faces, points, found, labels, near).run();
}

}  // namespace isimp::curved
