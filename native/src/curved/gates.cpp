#include <algorithm>
#include <cmath>
#include <numbers>

#include "face_labels.h"

namespace isimp::curved {
namespace {

const double kCrease = std::cos(24 * std::numbers::pi / 180);  ///< cosine between normals of points on both sides
constexpr double kNearlyAll = 0.85;   ///< least good share of the border of a patch that is no sphere and no full turn
constexpr double kMost = 0.62;        ///< least good share of a sphere's border, see good_share
constexpr double kAllRound = 0.92;    ///< share of a full turn that counts as a full turn
constexpr double kSome = 0.25;        ///< least good share of the border of a full turn, or of more than half a sphere
constexpr double kLargePlane = 0.02;  ///< share of the whole area: planes of free forms are smaller
constexpr double kHalfSphere = 0.42;  ///< 1 - |mean normal|, which is half of a half sphere's normals

/// The border of a patch: pairs of a face and its neighbour outside; kNone at the border of the scan.
struct Beside {
  std::int32_t face, other;
};

class Gates {
 public:
  Gates(const Faces& faces, const Points& points, const std::vector<Found>& found, const Some& labels)
      : f_(faces), p_(points), found_(found), labels_(labels), members_(found.size()), border_(found.size()) {
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
        kept[k] = found_[k].area > kLargePlane;
        continue;
      }
      kept[k] = !members_[k].empty();
      round[k] = round_of(k);
    }
    for (bool again = true; again;) {
      again = false;
      for (std::size_t k = 0; k < found_.size(); ++k) {
        if (found_[k].is_plane() || !kept[k]) continue;
        const double share = good_share(k, kept);
        const bool is_sphere = found_[k].surface.kind == CurvedKind::sphere;
        const double least = is_sphere ? kHalfSphere : kAllRound;
        if (share > (is_sphere ? kMost : kNearlyAll) || (round[k] > least && share > kSome)) continue;
        kept[k] = false;
        again = true;
      }
    }
    return kept;
  }

 private:
  /// The covered share of a full turn; of a sphere, 1 - |mean normal|, which is 1 if all of it is covered.
  [[nodiscard]] double round_of(std::size_t k) const {
    const Samples s = samples_of(f_, members_[k]);
    if (found_[k].surface.kind != CurvedKind::sphere) return turn_share(found_[k].surface, s);
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i];
    return 1 - sum.norm();
  }

  [[nodiscard]] double good_share(std::size_t k, const std::vector<bool>& kept) const {
    if (border_[k].empty()) return 1;
    double good = 0;
    for (const auto& [face, other] : border_[k]) {
      if (other == kNone || (labels_[other] != kNone && kept[labels_[other]])) {
        ++good;
        continue;
      }
      const std::int32_t a = p_.of_face[face], b = p_.of_face[other];
      good += b == kNone || p_.normal[a].dot(p_.normal[b]) < kCrease ? 1 : 0;
    }
    return good / static_cast<double>(border_[k].size());
  }

  const Faces& f_;
  const Points& p_;
  const std::vector<Found>& found_;
  const Some& labels_;
  std::vector<Some> members_;
  std::vector<std::vector<Beside>> border_;
};

}  // namespace

std::vector<bool> kept_surfaces(const Faces& faces, const Points& points, const std::vector<Found>& found,
                                const Some& labels) {
  return Gates(faces, points, found, labels).run();
}

}  // namespace isimp::curved
