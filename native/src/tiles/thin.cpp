#include "isimp/tiles/thin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "isimp/core/errors.h"

namespace isimp::tiles {
namespace {

// tuned tiles
// Cosine of the angle between a face and the mean direction of the scan faces that it represents. Structures inside a
// region stay, such as houses in one region with the ground: polygons are cut by the directions of their sides, if the
// roughness of the sides is at most 0.035 (meshing/discs/direction_cut.cpp). Source: own trials; at 0.95 the sides are
// lost in some tilings of a city.
constexpr double kLeastCosine = 0.97;  // of the angle by which a face may turn
constexpr double kLeastSine = 0.02;    // sine between two edges of a new face; far above rounding, so signs are certain
constexpr std::size_t kLargestRing = 40;     // limit: faces around a vertex that may go
constexpr std::size_t kTries = 8;            // limit: neighbours that a vertex may be collapsed into
constexpr std::int64_t kEnough = 50;         // limit: passes end if at most one vertex is removed for kEnough that stay
constexpr std::int32_t kPollEvery = 0x3fff;  // work

/// Removes vertices inside regions from a mesh.
class Thinner {
 public:
  Thinner(const Mesh& mesh, std::span<const std::int32_t> label)
      : mesh_(mesh),
        label_(label),
        triangle_(mesh.triangles().begin(), mesh.triangles().end()),
        head_(static_cast<std::size_t>(mesh.vertex_count()), kNone),
        next_(3 * triangle_.size()),
        heir_(triangle_.size(), kNone),
        seen_(head_.size(), 0),
        locked_(head_.size(), 0) {
    for (std::int32_t c = 3 * mesh.face_count() - 1; c >= 0; --c)
      next_[c] = std::exchange(head_[triangle_[c / 3][c % 3]], c);
    std::int32_t regions = 0;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      regions = std::max(regions, label[f] + 1);
      for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
        if (mesh.opposite(h) == kNone || label[mesh.opposite(h) / 3] != label[f])
          locked_[mesh.from(h)] = locked_[mesh.to(h)] = 1;
    }
    vector_area_.reserve(triangle_.size());
    for (const Triangle& face : triangle_) vector_area_.push_back(cross(face).cast<float>());
    normal_.assign(static_cast<std::size_t>(regions), Vec3::Zero());
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      if (label[f] != kNone) normal_[label[f]] += cross(triangle_[f]);
  }

  void run(Job& job) {
    for (bool more = true; more;) {
      std::int64_t gone = 0, left = 0;
      for (std::int32_t v = 0; v < mesh_.vertex_count(); ++v) {
        if ((v & kPollEvery) == 0) job.poll();
        if (locked_[v] != 0 || !read_star(v)) continue;
        if (take_out(v)) {
          head_[v] = kNone;
          ++gone;
        } else {
          ++left;
        }
      }
      more = gone > 0 && gone * kEnough > left;
    }
  }

  [[nodiscard]] bool lives(std::int32_t f) const { return heir_[f] == kNone && label_[f] != kNone; }
  /// Returns for each face the face that represents it after its removal; kNone: the face is live.
  std::vector<std::int32_t> take_heirs() { return std::move(heir_); }
  [[nodiscard]] const Triangle& triangle(std::int32_t f) const { return triangle_[f]; }

 private:
  [[nodiscard]] Vec3 cross(const Triangle& t) const {
    const auto p = mesh_.vertices();
    return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
  }
  static bool has(const Triangle& t, std::int32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

  /// Calls fn(corner) for the corners of the live faces at a vertex, and removes other corners from its list.
  template <class Function>
  void for_each_corner(std::int32_t v, Function fn) {
    for (std::int32_t* at = &head_[v]; *at != kNone;) {
      const std::int32_t corner = *at;
      if (heir_[corner / 3] != kNone) {
        *at = next_[corner];
        continue;
      }
      fn(corner);
      at = &next_[corner];
    }
  }

  /// Reads the corners and the ring of a vertex inside a region.
  /// \return false if the vertex can't be removed
  bool read_star(std::int32_t v) {
    star_.clear();
    ring_.clear();
    ++stamp_;
    if (head_[v] == kNone) return false;
    for_each_corner(v, [&](std::int32_t corner) {
      star_.push_back(corner);
      for (const std::int32_t w : triangle_[corner / 3])
        if (w != v && std::exchange(seen_[w], stamp_) != stamp_) ring_.push_back(w);
    });
    return ring_.size() == star_.size() && ring_.size() >= 3 && ring_.size() <= kLargestRing &&
           label_[star_[0] / 3] != kNone;
  }

  bool take_out(std::int32_t v) {
    const auto p = mesh_.vertices();
    near_.clear();
    for (const std::int32_t w : ring_) near_.emplace_back((p[w] - p[v]).squaredNorm(), w);
    std::sort(near_.begin(), near_.end());
    for (std::size_t k = 0; k < std::min(near_.size(), kTries); ++k)
      if (fits(v, near_[k].second)) {
        collapse(v, near_[k].second);
        return true;
      }
    return false;
  }

  /// Returns whether the surface stays a manifold and no face turns over if v is collapsed into w.
  bool fits(std::int32_t v, std::int32_t w) {
    const auto p = mesh_.vertices();
    const Vec3& n = normal_[label_[star_[0] / 3]];
    for (const std::int32_t corner : star_) {
      const std::int32_t f = corner / 3;
      Triangle t = triangle_[f];
      if (has(t, w)) {
        if (!heir_fits(f, v, w)) return false;
        continue;
      }
      const Vec3 before = cross(t);
      t[corner % 3] = w;
      const Vec3 after = cross(t);
      const double size = after.norm();
      const int k = corner % 3;
      const double first = (p[t[(k + 1) % 3]] - p[w]).norm(), second = (p[t[(k + 2) % 3]] - p[w]).norm();
      if (!(size > kLeastSine * first * second) || !(along(f, after) > 0)) return false;
      if (n.dot(before) > 0 && !(n.dot(after) > 0)) return false;
    }
    return links_fit(v, w);
  }

  /// Compares a direction with the mean direction of the scan faces that a face represents. Above 0: the angle is less
  /// than the limit. 0: at the limit, or there is no direction.
  [[nodiscard]] double along(std::int32_t f, const Vec3& direction) const {
    const Vec3 own = vector_area_[f].cast<double>();
    return own.dot(direction) - kLeastCosine * own.norm() * direction.norm();
  }

  /// Returns whether the direction of a face's heir is near the face's mean direction after v is collapsed into w.
  [[nodiscard]] bool heir_fits(std::int32_t face, std::int32_t v, std::int32_t w) const {
    const std::int32_t heir = heir_of(face, v, w);
    if (heir == kNone) return true;
    Triangle t = triangle_[heir];
    std::replace(t.begin(), t.end(), v, w);
    return along(face, cross(t)) >= 0;
  }

  /// Returns whether the rings of v and w share exactly the two vertices opposite the edge between v and w.
  bool links_fit(std::int32_t v, std::int32_t w) {
    int common = 0;
    bool doubled = false;
    const std::int32_t ring_stamp = stamp_++;
    for_each_corner(w, [&](std::int32_t corner) {
      const Triangle& t = triangle_[corner / 3];
      int of_ring = 0;
      for (const std::int32_t u : t) {
        if (u == w || u == v) continue;
        if (seen_[u] == ring_stamp) {
          ++common;
          seen_[u] = stamp_;
        }
        of_ring += static_cast<int>(seen_[u] == stamp_);
      }
      doubled |= of_ring == 2 && !has(t, v);
    });
    for (const std::int32_t u : ring_) seen_[u] = stamp_;
    return common == 2 && !doubled;
  }

  void collapse(std::int32_t v, std::int32_t w) {
    for (const std::int32_t corner : star_) {
      const std::int32_t f = corner / 3;
      if (!has(triangle_[f], w)) continue;
      heir_[f] = heir_of(f, v, w);
      if (heir_[f] != kNone) vector_area_[heir_[f]] += vector_area_[f];
    }
    for (const std::int32_t corner : star_) {
      if (heir_[corner / 3] != kNone) continue;
      triangle_[corner / 3][corner % 3] = w;
      next_[corner] = std::exchange(head_[w], corner);
    }
  }

  /// Returns the neighbour of a removed face of the star that stays and will represent it; kNone: there is none.
  [[nodiscard]] std::int32_t heir_of(std::int32_t face, std::int32_t v, std::int32_t w) const {
    const Triangle& t = triangle_[face];
    const std::int32_t u = *std::find_if(t.begin(), t.end(), [&](std::int32_t x) { return x != v && x != w; });
    for (const std::int32_t corner : star_)
      if (corner / 3 != face && has(triangle_[corner / 3], u) && !has(triangle_[corner / 3], w)) return corner / 3;
    return kNone;
  }

  const Mesh& mesh_;
  std::span<const std::int32_t> label_;
  std::vector<Triangle> triangle_;
  std::vector<std::int32_t> head_, next_;     // lists of the corners at each vertex
  std::vector<std::int32_t> heir_;            // face that represents a removed face; kNone: the face is live
  std::vector<Eigen::Vector3f> vector_area_;  // by face: twice the vector area of the scan faces that it represents
  std::vector<std::int32_t> seen_;            // by vertex
  std::vector<std::uint8_t> locked_;
  std::vector<Vec3> normal_;  // by region, not normalised
  std::vector<std::int32_t> star_, ring_;
  std::vector<std::pair<double, std::int32_t>> near_;
  std::int32_t stamp_ = 0;
};

/// Returns the live face that represents a face. Shortens the paths.
std::int32_t stands_for(std::vector<std::int32_t>& heir, std::int32_t f) {
  while (heir[f] != kNone) {
    if (heir[heir[f]] != kNone) heir[f] = heir[heir[f]];
    f = heir[f];
  }
  return f;
}

SurfaceMoments moments_of_face(const Mesh& mesh, std::int32_t f) {
  const Triangle& t = mesh.triangles()[f];
  SurfaceMoments m = moments_of(mesh.vertices()[t[0]], mesh.vertices()[t[1]], mesh.vertices()[t[2]]);
  m.centre += mesh.origin();
  return m;
}

}  // namespace

Thinned thin(const Mesh& mesh, std::span<const std::int32_t> label, std::span<const SurfaceMoments> moments, Job& job) {
  const auto faces = static_cast<std::size_t>(mesh.face_count());
  if (label.size() != faces || (!moments.empty() && moments.size() != faces))
    throw InvalidInput("the mesh has " + std::to_string(faces) +
                       " faces; give one label, and one row of moments or none, for each");
  auto thinner = std::make_unique<Thinner>(mesh, label);
  thinner->run(job);
  Thinned result;
  std::vector<std::int32_t> vertex(static_cast<std::size_t>(mesh.vertex_count()), kNone), place(faces, kNone);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!thinner->lives(f)) continue;
    place[f] = static_cast<std::int32_t>(result.triangles.size());
    Triangle t = thinner->triangle(f);
    for (std::int32_t& v : t) {
      if (vertex[v] == kNone) {
        vertex[v] = static_cast<std::int32_t>(result.vertices.size());
        result.vertices.push_back(mesh.vertices()[v] + mesh.origin());
      }
      v = vertex[v];
    }
    result.triangles.push_back(t);
    result.label.push_back(label[f]);
  }
  std::vector<std::int32_t> heir = thinner->take_heirs();
  thinner.reset();  // before the moments, which need most memory
  result.moments.resize(result.triangles.size());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if ((f & kPollEvery) == 0) job.poll();
    if (label[f] != kNone)
      result.moments[place[stands_for(heir, f)]].add(moments.empty() ? moments_of_face(mesh, f) : moments[f]);
  }
  return result;
}

}  // namespace isimp::tiles
