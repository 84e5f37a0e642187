#include "isimp/partition/mirror.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace isimp {
namespace {

constexpr double kNear = 0.35;    // share of the root of the area: the largest distance of the centre from the image
constexpr double kOfArea = 0.6;   // the smaller area is at least this share of the larger
constexpr double kTurned = 0.87;  // cosine of the angle between the normals at least: 30 degrees

/// Patches sorted along the axis that is most nearly in the plane, so that few are compared for each.
class Sorted {
 public:
  Sorted(std::span<const Patch> patches, const Mirror& mirror) : patches_(patches), order_(patches.size()) {
    mirror.normal.cwiseAbs().minCoeff(&axis_);
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(),
              [&](std::int32_t a, std::int32_t b) { return at(a) != at(b) ? at(a) < at(b) : a < b; });
  }

  /// The nearest patch that is alike, kNone if there is none. Ties go to the lower number.
  [[nodiscard]] std::int32_t nearest(const Patch& wanted) const {
    const double reach = kNear * std::sqrt(wanted.area);
    double least = reach;
    std::int32_t best = kNone;
    auto it = std::lower_bound(order_.begin(), order_.end(), wanted.centre[axis_] - reach,
                               [&](std::int32_t p, double low) { return at(p) < low; });
    for (; it != order_.end() && at(*it) <= wanted.centre[axis_] + reach; ++it) {
      const Patch& p = patches_[*it];
      if (std::min(p.area, wanted.area) < kOfArea * std::max(p.area, wanted.area)) continue;
      if (p.normal.dot(wanted.normal) < kTurned) continue;
      const double distance = (p.centre - wanted.centre).norm();
      if (distance > least || (distance == least && best != kNone && *it > best)) continue;
      least = distance;
      best = *it;
    }
    return best;
  }

 private:
  [[nodiscard]] double at(std::int32_t p) const { return patches_[p].centre[axis_]; }

  std::span<const Patch> patches_;
  std::vector<std::int32_t> order_;
  Eigen::Index axis_ = 0;
};

}  // namespace

std::vector<std::int32_t> mirror_images(std::span<const Patch> patches, const Mirror& mirror) {
  const Sorted sorted(patches, mirror);
  std::vector<std::int32_t> image(patches.size(), kNone);
  for (std::size_t p = 0; p < patches.size(); ++p)
    image[p] = sorted.nearest({mirror.image(patches[p].centre), mirror.turned(patches[p].normal), patches[p].area});
  for (std::size_t p = 0; p < image.size(); ++p)
    if (image[p] != kNone && image[image[p]] != static_cast<std::int32_t>(p)) image[p] = kNone;
  return image;
}

}  // namespace isimp
