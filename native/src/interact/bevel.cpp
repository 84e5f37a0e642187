#include "bevel.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace isimp {
namespace {

// tuned edits
constexpr double kOutlier = 2.0;     // times the usual deviation in a region: from here on a normal is not one of it
constexpr double kLeastOdd = 0.01;   // |n - N|^2; below it, 6 degrees, nothing is out of the usual
constexpr int kLongestWalk = 32;     // limit: steps at a vertex
constexpr double kMostDepth = 4.0;   // depth of the plane across a corner, in mean depths of the turned faces
constexpr double kLeastDepth = 2.0;  // the least such depth
constexpr double kMostWorse = 0.2;   // cost of the outline of a corner, as a share of a region's mean error
constexpr std::size_t kCorner = 3;   // unit: regions that meet in one

/// The faces at the vertex between edges k and k + 1 of a face, the face first; on a border only the faces to one side.
std::vector<std::int32_t> fan_of(const FaceGraph& graph, std::int32_t face, int k) {
  std::vector<std::int32_t> fan{face};
  std::int32_t before = face, at = graph.neighbours[face][k];
  for (int step = 0; step < kLongestWalk && at != graph.size() && at != face; ++step) {
    fan.push_back(at);
    const auto& next = graph.neighbours[at];
    const int back = next[0] == before ? 0 : next[1] == before ? 1 : 2;
    before = std::exchange(at, next[(back + 2) % 3]);
  }
  return fan;
}

/// The faces that share a vertex with a face, itself first.
std::vector<std::int32_t> ring_of(const FaceGraph& graph, std::int32_t face) {
  std::vector<std::int32_t> ring{face};
  for (int k = 0; k < 3; ++k)
    for (const std::int32_t i : fan_of(graph, face, k))
      if (std::find(ring.begin(), ring.end(), i) == ring.end()) ring.push_back(i);
  return ring;
}

/// The mean normal of a face and its neighbours: single faces are noise, or lie across the tip of a corner.
Vec3 smooth_normal(const FaceGraph& graph, std::int32_t face) {
  RegionSum around;
  for (const std::int32_t i : ring_of(graph, face)) around.add(graph.faces[i]);
  return around.normal();
}

struct Bevel {
  Vec3 normal = Vec3::Zero();         // half-way between the regions that meet
  std::vector<std::int32_t> regions;  // that meet, in the order of finding
};

/// The regions of some faces, each once, in the order of finding.
std::vector<std::int32_t> regions_of(const Edit& edit, const std::vector<std::int32_t>& faces) {
  std::vector<std::int32_t> regions;
  for (const std::int32_t i : faces) {
    const std::int32_t r = edit.labels.get(i);
    if (r >= 0 && std::find(regions.begin(), regions.end(), r) == regions.end()) regions.push_back(r);
  }
  return regions;
}

bool touches_corner(const Edit& edit, std::int32_t face) {
  bool touches = false;
  for (int k = 0; k < 3; ++k) touches |= regions_of(edit, fan_of(edit.graph, face, k)).size() >= kCorner;
  return touches;
}

/// The bevel that a face lies on; without regions if it lies on none.
Bevel find_bevel(const Edit& edit, std::int32_t face) {
  const auto& sums = edit.result.region_sum;
  Bevel bevel;
  bevel.regions = regions_of(edit, ring_of(edit.graph, face));
  for (const std::int32_t r : bevel.regions) bevel.normal += sums[r].normal();
  if (bevel.regions.size() < 2 || bevel.normal.norm() < kLeastOdd) return {};
  bevel.normal.normalize();
  const RegionSum& own = sums[edit.labels.get(face)];
  const double odd = (bevel.normal - own.normal()).squaredNorm();
  const double usual = own.weight > 0 ? 2 * own.error() / own.weight : 0.0;
  const Vec3 here = smooth_normal(edit.graph, face);
  const bool turned =
      touches_corner(edit, face) || (here - bevel.normal).squaredNorm() < (here - own.normal()).squaredNorm();
  return turned && odd > std::max(kLeastOdd, kOutlier * kOutlier * usual) ? bevel : Bevel{};
}

class Growth {
 public:
  Growth(Edit& edit, Bevel bevel, std::int32_t face)
      : edit_(edit), graph_(edit.graph), bevel_(std::move(bevel)), fresh_(edit.result.region_count()) {
    for (const RegionSum& s : edit.result.region_sum) normals_.push_back(s.normal());
    edit_.add_region();
    take(face);
  }

  [[nodiscard]] const std::vector<std::int32_t>& taken() const { return taken_; }

  /// Adds the faces that turn towards the bevel.
  /// \return whether any single face does, and not only the mean of its neighbours
  bool take_turned() {
    bool any = false;
    for (std::size_t k = 0; k < taken_.size(); ++k) {
      const FaceRecord& f = graph_.faces[taken_[k]];
      any |= nearer(Vec3(f.nx, f.ny, f.nz), from_[k]);
      for (const std::int32_t j : graph_.neighbours[taken_[k]])
        if (may_take(j) && nearer(smooth_normal(graph_, j), edit_.labels.get(j))) take(j);
    }
    return any;
  }

  /// Adds the faces above a plane across the corner. Candidates are planes some mean depths of the added faces below
  /// their top; the plane with the shortest outline for its area is chosen.
  void take_above_plane() {
    const auto [top, mean] = depth();
    std::priority_queue<std::pair<double, std::int32_t>> queue;  // highest first, ties to the higher index
    const auto push_around = [&](std::int32_t i) {
      for (const std::int32_t j : graph_.neighbours[i])
        if (may_take(j)) queue.emplace(height(j), j);
    };
    double outline = 0.0, area = 0.0, best = std::numeric_limits<double>::infinity();
    for (const std::int32_t i : taken_) {
      push_around(i);
      for (int k = 0; k < 3; ++k)
        if (edit_.labels.get(graph_.neighbours[i][k]) != fresh_) outline += length(i, k);
      area += graph_.faces[i].area;
    }
    std::size_t kept = taken_.size();
    while (!queue.empty() && queue.top().first >= top - kMostDepth * (top - mean)) {
      const auto [at, j] = queue.top();
      const double score = outline * outline / area;
      queue.pop();
      if (!may_take(j)) continue;
      if (at < top - kLeastDepth * (top - mean) && score < best) {
        best = score;
        kept = taken_.size();
      }
      for (int k = 0; k < 3; ++k)
        outline += (edit_.labels.get(graph_.neighbours[j][k]) == fresh_ ? -1 : 1) * length(j, k);
      area += graph_.faces[j].area;
      take(j);
      push_around(j);
    }
    if (best < std::numeric_limits<double>::infinity()) shrink(kept);
  }

 private:
  [[nodiscard]] bool may_take(std::int32_t i) const {
    const std::int32_t r = edit_.labels.get(i);
    return r >= 0 && r != fresh_ && edit_.result.region_sum[r].faces > 1;
  }
  void take(std::int32_t i) {
    taken_.push_back(i);
    from_.push_back(edit_.labels.get(i));
    edit_.move(i, fresh_);
  }
  void shrink(std::size_t size) {
    for (std::size_t k = size; k < taken_.size(); ++k) edit_.move(taken_[k], from_[k]);
    taken_.resize(size);
    from_.resize(size);
  }
  [[nodiscard]] bool nearer(const Vec3& normal, std::int32_t region) const {
    return (normal - bevel_.normal).squaredNorm() < (normal - normals_[region]).squaredNorm();
  }
  [[nodiscard]] const Vec3& corner(std::int32_t i, int k) const {
    const Mesh& mesh = edit_.surface.mesh();
    return mesh.vertices()[mesh.triangles()[graph_.mesh_face[i]][k % 3]];
  }
  [[nodiscard]] double length(std::int32_t i, int k) const { return (corner(i, k + 1) - corner(i, k)).norm(); }
  [[nodiscard]] double height(std::int32_t i) const {
    return bevel_.normal.dot(corner(i, 0) + corner(i, 1) + corner(i, 2)) / 3;
  }
  /// Height of the highest vertex, and the mean.
  [[nodiscard]] std::pair<double, double> depth() const {
    double top = -std::numeric_limits<double>::infinity(), sum = 0.0, area = 0.0;
    for (const std::int32_t i : taken_) {
      for (int k = 0; k < 3; ++k) top = std::max(top, bevel_.normal.dot(corner(i, k)));
      sum += graph_.faces[i].area * height(i);
      area += graph_.faces[i].area;
    }
    return {top, area > 0 ? sum / area : top};
  }

  Edit& edit_;
  const FaceGraph& graph_;
  Bevel bevel_;
  std::int32_t fresh_;
  std::vector<Vec3> normals_;               // normals of the regions before
  std::vector<std::int32_t> taken_, from_;  // faces, and the region each was of
};

}  // namespace

bool grow_bevel(Edit& edit, const Partition& before, std::int32_t face, Job& job) {
  Bevel bevel = find_bevel(edit, face);
  if (bevel.regions.empty()) return false;
  const bool corner = bevel.regions.size() >= kCorner;
  Growth growth(edit, std::move(bevel), face);
  if (growth.take_turned()) {
    if (corner) growth.take_above_plane();
    edit.hints = growth.taken();
    edit.reconnect(growth.taken());
    if (!corner) edit.relax(growth.taken(), face, job);
    const double allowed = 1 + kMostWorse / before.region_count();
    if (edit.error() * edit.graph.area < allowed * before.error) return true;
  }
  edit.restart(before);
  return false;
}

}  // namespace isimp
