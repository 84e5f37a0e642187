#include <algorithm>
#include <cmath>
#include <utility>

#include "find/face_labels.h"
#include "fit/numbers.h"

namespace isimp::curved {
namespace {

constexpr double kDisc = 2.33;  ///< unit: outline of a disc of n equilateral triangles, in edges, over the root of n

/// An edge of the border of a patch: the point inside, the one outside and its surface; kNone at the border of the scan
/// and where there is none.
struct Beside {
  std::int32_t point, other, surface;
};

/// A patch as the gates see it.
struct Outline {
  Samples samples;
  double faces = 0;
  std::vector<Beside> border;
};

std::vector<Outline> outlines(const Faces& faces, const Points& points, const std::vector<Found>& found,
                              const Some& labels) {
  const FaceGraph& graph = faces.graph();
  std::vector<Outline> all(found.size());
  for (std::int32_t i = 0; i < faces.size(); ++i) {
    const std::int32_t label = labels[i];
    if (label == kNone || found[label].is_plane()) continue;
    all[label].samples.add(faces.area(i), faces.centre(i), faces.normal(i));
    ++all[label].faces;
    for (const std::int32_t j : graph.neighbours[i]) {
      if (j != graph.size() && labels[j] == label) continue;
      const bool is_rim = j == graph.size();
      all[label].border.push_back({points.of_face[i], is_rim ? kNone : points.of_face[j], is_rim ? kNone : labels[j]});
    }
  }
  return all;
}

class Gates {
 public:
  Gates(std::vector<Outline> outlines, const Points& points, const std::vector<Found>& found)
      : outlines_(std::move(outlines)), p_(points), found_(found) {
    for (Outline& o : outlines_) o.samples.normalise();
  }

  /// \param planes  of each surface whether it is kept if it is a plane
  std::vector<bool> run(const std::vector<bool>& planes) {
    std::vector<bool> kept = planes;
    std::vector<double> round(found_.size(), 0.0);
    for (std::size_t k = 0; k < found_.size(); ++k) {
      if (found_[k].is_plane()) continue;
      kept[k] = outlines_[k].faces > 0;
      round[k] = round_of(k);
    }
    for (;;) {  // the worst first, as patches hold each other up
      std::size_t worst = found_.size();
      double least = 0;
      for (std::size_t k = 0; k < found_.size(); ++k) {
        // A ring all round is closed: its border does not matter.
        if (found_[k].is_plane() || !kept[k] || (found_[k].surface.closed && round[k] > kMost)) continue;
        const bool is_sphere = found_[k].surface.kind == CurvedKind::sphere;
        const bool is_easier = is_sphere || found_[k].surface.closed || along_planes(k, kept) > kHalf;
        const double most = is_easier ? kHalf : kMost;
        const double more = good_share(k, kept) - (round[k] > kMost ? kQuarter : most);
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
    const Samples& s = outlines_[k].samples;
    if (found_[k].surface.kind != CurvedKind::sphere) return turn_share(found_[k].surface, s);
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < s.size(); ++i) sum += s.weight[i] * s.normal[i];
    return 1 - sum.norm();
  }

  /// The share of the border of a cylinder at kept planes along its axis, as that of a fillet.
  [[nodiscard]] double along_planes(std::size_t k, const std::vector<bool>& kept) const {
    const CurvedSurface& s = found_[k].surface;
    if (s.kind != CurvedKind::cylinder) return 0;
    const std::vector<Beside>& border = outlines_[k].border;
    const auto along = std::count_if(border.begin(), border.end(), [&](const Beside& b) {
      return b.surface != kNone && kept[b.surface] && found_[b.surface].is_plane() &&
             std::abs(found_[b.surface].surface.axis.dot(s.axis)) < kSquare;
    });
    return border.empty() ? 0 : static_cast<double>(along) / static_cast<double>(border.size());
  }

  [[nodiscard]] double good_share(std::size_t k, const std::vector<bool>& kept) const {
    const std::vector<Beside>& border = outlines_[k].border;
    const auto good = std::count_if(border.begin(), border.end(), [&](const Beside& b) {
      return b.other == kNone || (b.surface != kNone && kept[b.surface]) ||
             p_.normal[b.point].dot(p_.normal[b.other]) < kCrease;
    });
    const auto count = static_cast<double>(border.size());
    // A patch with a shorter border than a disc of as many faces is nearly closed, as a torus with a small hole.
    return 1 - (count - static_cast<double>(good)) / std::max({count, kDisc * std::sqrt(outlines_[k].faces), 1.0});
  }

  std::vector<Outline> outlines_;
  const Points& p_;
  const std::vector<Found>& found_;
};

}  // namespace

std::vector<bool> kept_surfaces(const Faces& faces, const Points& points, const std::vector<Found>& found,
                                const Some& labels, const Nearness& near) {
  std::vector<bool> planes(found.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    planes[k] = found[k].is_plane() && found[k].rms < kHalf * near.distance;  // faces of free forms are not so near
  return Gates(outlines(faces, points, found, labels), points, found).run(planes);
}

}  // namespace isimp::curved
