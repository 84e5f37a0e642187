#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "isimp/mesh/mesh.h"
#include "isimp/meshing/options.h"
#include "isimp/partition/partition.h"

/// How ragged the border of an open scan is, by which corners on it are chosen.
namespace isimp::meshing {

// tuned real
constexpr int kSamples = 33;  ///< points of a piece of a border that is measured

/// Points of a closed line at some lengths along it.
class Along {
 public:
  explicit Along(std::span<const Vec3> line) : line_(line), at_(line.size(), 0.0) {
    for (std::size_t i = 1; i < line.size(); ++i) at_[i] = at_[i - 1] + (line[i] - line[i - 1]).norm();
  }
  [[nodiscard]] double length() const { return at_.back(); }
  [[nodiscard]] Vec3 at(double length) const {
    length = std::fmod(length, at_.back());
    const auto next = std::upper_bound(at_.begin(), at_.end() - 1, length);
    const std::size_t i = std::max<std::ptrdiff_t>(next - at_.begin(), 1);
    const double step = at_[i] - at_[i - 1];
    return line_[i - 1] + (step > 0 ? (length - at_[i - 1]) / step : 0.0) * (line_[i] - line_[i - 1]);
  }

 private:
  std::span<const Vec3> line_;
  std::vector<double> at_;
};

/// How ragged the border of a mesh is: the median by length, over windows along its loops, of the largest distance of the
/// border from the window's own parabola. 0 for a clean cut, also with corners, as less than half of the windows hold
/// one.
/// \param face_region  (F) borders of faces in no region do not count
/// \param window  length, scene units; loops shorter than two do not count
/// Cost: O(V + F).
double raggedness(const Mesh& mesh, std::span<const std::int32_t> face_region, double window);

/// How far corners at the rim may leave the border, scene units; 0 where rims stay as they are.
/// \param window  as above
double rim_reach(const Mesh& mesh, const Partition& partition, const MeshingOptions& options, double window);

}  // namespace isimp::meshing
