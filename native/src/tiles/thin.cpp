#include "isimp/tiles/thin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace isimp::tiles {
namespace {

// tuned tiles
constexpr std::size_t kLargestRing = 40;  // limit: faces around a vertex that may go
constexpr std::int64_t kEnough = 20;      // limit: passes of one cost end if they remove at most one of kEnough faces
constexpr std::int32_t kPollEvery = 0x3fff;  // work
constexpr double kLeastCosine = 0.2;         // between a face and the mean direction of the scan's faces in it
constexpr double kLeastQuality = 0.05;       // twice the area of a new face by the square of its longest edge

// Costs are squared distances, summed over the area, in squares of the mean area of a face. The limit grows until few
// enough faces are left, so that vertices go nearly in the order of their costs.
constexpr double kFirstLimit = 1e-4, kLastLimit = 64.0;  // limit: of the cost in the first and in the last passes
constexpr double kGrowth = 4.0;                          // of the limit from pass to pass

/// The sum of squared distances from planes, by area, as a polynomial about a vertex
/// (Garland, Heckbert: Surface Simplification Using Quadric Error Metrics, 1997).
class Quadric {
 public:
  /// Adds a plane through the vertex.
  void add_plane(const Vec3& normal, double area) {
    for (int i = 0, k = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++k) square_[k] += static_cast<float>(area * normal[i] * normal[j]);
  }

  /// The sum at a place, relative to the vertex.
  [[nodiscard]] double at(const Vec3& x) const {
    return std::max(0.0, x.dot(times(x)) + 2 * linear().dot(x) + constant_);
  }

  /// Adds the quadric of another vertex, which lies at `apart` from this one.
  void add(const Quadric& other, const Vec3& apart) {
    const Vec3 turned = other.times(apart);
    constant_ += static_cast<float>(apart.dot(turned) - 2 * other.linear().dot(apart)) + other.constant_;
    for (int i = 0; i < 3; ++i) linear_[i] += other.linear_[i] - static_cast<float>(turned[i]);
    for (int k = 0; k < 6; ++k) square_[k] += other.square_[k];
  }

 private:
  [[nodiscard]] Vec3 times(const Vec3& x) const {
    const auto& s = square_;
    return {s[0] * x[0] + s[1] * x[1] + s[2] * x[2], s[1] * x[0] + s[3] * x[1] + s[4] * x[2],
            s[2] * x[0] + s[4] * x[1] + s[5] * x[2]};
  }
  [[nodiscard]] Vec3 linear() const { return {linear_[0], linear_[1], linear_[2]}; }

  std::array<float, 6> square_{};  // xx, xy, xz, yy, yz, zz
  std::array<float, 3> linear_{};
  float constant_ = 0;
};

/// Removes vertices from a mesh.
class Thinner {
 public:
  explicit Thinner(const Mesh& mesh)
      : mesh_(mesh),
        triangle_(mesh.triangles().begin(), mesh.triangles().end()),
        head_(static_cast<std::size_t>(mesh.vertex_count()), kNone),
        next_(3 * triangle_.size()),
        heir_(triangle_.size(), kNone),
        seen_(head_.size(), 0),
        least_(head_.size(), 0),
        quadric_(head_.size()),
        vector_area_(triangle_.size()),
        faces_(mesh.face_count()) {
    for (std::int32_t h = 3 * mesh.face_count() - 1; h >= 0; --h) next_[h] = std::exchange(head_[mesh.from(h)], h);
    for (std::size_t f = 0; f < triangle_.size(); ++f) {
      const Vec3 area = cross(triangle_[f]);
      vector_area_[f] = area.cast<float>();
      const double twice = area.norm();
      if (!(twice > 0)) continue;
      mean_area_ += twice / 2 / static_cast<double>(triangle_.size());
      for (const std::int32_t v : triangle_[f]) quadric_[v].add_plane(area / twice, twice / 6);
    }
  }

  void run(std::int64_t faces, Job& job) {
    const double unit = mean_area_ * mean_area_;
    for (double limit = kFirstLimit; limit <= kLastLimit && faces_ > faces; limit *= kGrowth)
      for (bool more = true; more && faces_ > faces;) more = pass(faces, limit * unit, job);
  }

  /// Returns for each face the face that represents it after its removal; kNone: the face is live.
  std::vector<std::int32_t> take_heirs() { return std::move(heir_); }
  [[nodiscard]] const Triangle& triangle(std::int32_t f) const { return triangle_[f]; }

 private:
  static constexpr float kNever = std::numeric_limits<float>::infinity();  // mark

  /// Removes vertices up to a cost, and returns whether there may be more.
  bool pass(std::int64_t faces, double limit, Job& job) {
    const std::int64_t before = faces_;
    for (std::int32_t v = 0; v < mesh_.vertex_count() && faces_ > faces; ++v) {
      if ((v & kPollEvery) == 0) job.poll();
      if (least_[v] > limit) continue;
      if (!read_star(v) || !take_out(v, limit)) continue;
      head_[v] = kNone;
      least_[v] = kNever;
    }
    return (before - faces_) * kEnough > before;
  }

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

  /// Reads the corners and the ring of a vertex inside the mesh.
  /// \return false if the vertex can't be removed
  bool read_star(std::int32_t v) {
    star_.clear();
    ring_.clear();
    ++stamp_;
    for_each_corner(v, [&](std::int32_t corner) {
      star_.push_back(corner);
      for (const std::int32_t w : triangle_[corner / 3])
        if (w != v && std::exchange(seen_[w], stamp_) != stamp_) ring_.push_back(w);
    });
    if (ring_.size() == star_.size() && ring_.size() >= 3 && ring_.size() <= kLargestRing) return true;
    least_[v] = kNever;
    return false;
  }

  bool take_out(std::int32_t v, double limit) {
    const auto p = mesh_.vertices();
    near_.clear();
    double least = kNever;
    for (const std::int32_t w : ring_) {
      const double cost = quadric_[v].at(p[w] - p[v]) + quadric_[w].at(Vec3::Zero());
      if (cost <= limit) near_.emplace_back(cost, w);
      least = std::min(least, cost);
    }
    std::sort(near_.begin(), near_.end());
    for (const auto& [cost, w] : near_)
      if (fits(v, w)) {
        collapse(v, w);
        return true;
      }
    least_[v] = near_.empty() ? static_cast<float>(least) : kNever;  // until its ring changes
    return false;
  }

  /// Returns whether the surface stays a manifold and no face turns over if v is collapsed into w.
  bool fits(std::int32_t v, std::int32_t w) {
    return std::all_of(star_.begin(), star_.end(),
                       [&](std::int32_t corner) { return has(triangle_[corner / 3], w) || face_fits(corner, w); }) &&
           links_fit(v, w);
  }

  /// Returns whether a face keeps its side and its shape if its corner moves to w.
  [[nodiscard]] bool face_fits(std::int32_t corner, std::int32_t w) const {
    Triangle t = triangle_[corner / 3];
    const double quality = quality_of(t, cross(t).norm());
    const Vec3 own = vector_area_[corner / 3].cast<double>();
    t[corner % 3] = w;
    const Vec3 after = cross(t);
    const double size = after.norm();
    return size > 0 && quality_of(t, size) > std::min(kLeastQuality, quality / 2) &&
           own.dot(after) > kLeastCosine * own.norm() * size;
  }

  [[nodiscard]] double quality_of(const Triangle& t, double twice_area) const {
    const auto p = mesh_.vertices();
    const double longest = std::max(
        {(p[t[1]] - p[t[0]]).squaredNorm(), (p[t[2]] - p[t[1]]).squaredNorm(), (p[t[0]] - p[t[2]]).squaredNorm()});
    return longest > 0 ? twice_area / longest : 0.0;
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
    const auto p = mesh_.vertices();
    quadric_[w].add(quadric_[v], p[v] - p[w]);
    for (const std::int32_t corner : star_) {
      const std::int32_t f = corner / 3;
      if (!has(triangle_[f], w)) continue;
      heir_[f] = heir_of(f, v, w);
      vector_area_[heir_[f]] += vector_area_[f];
      --faces_;
    }
    for (const std::int32_t corner : star_) {
      if (heir_[corner / 3] != kNone) continue;
      triangle_[corner / 3][corner % 3] = w;
      next_[corner] = std::exchange(head_[w], corner);
    }
    for (const std::int32_t u : ring_) least_[u] = 0;
  }

  /// Returns the neighbour of a removed face of the star that stays and will represent it.
  [[nodiscard]] std::int32_t heir_of(std::int32_t face, std::int32_t v, std::int32_t w) const {
    const Triangle& t = triangle_[face];
    const std::int32_t u = *std::find_if(t.begin(), t.end(), [&](std::int32_t x) { return x != v && x != w; });
    return *std::find_if(star_.begin(), star_.end(), [&](std::int32_t corner) {
      const Triangle& other = triangle_[corner / 3];
      return corner / 3 != face && has(other, u) && !has(other, w);
    }) / 3;
  }

  const Mesh& mesh_;
  std::vector<Triangle> triangle_;
  std::vector<std::int32_t> head_, next_;  // lists of the corners at each vertex
  std::vector<std::int32_t> heir_;         // face that represents a removed face; kNone: the face is live
  std::vector<std::int32_t> seen_;         // by vertex
  std::vector<float> least_;               // by vertex: it need not be looked at below this limit
  std::vector<Quadric> quadric_;
  std::vector<Eigen::Vector3f> vector_area_;  // by face: twice the vector area of the scan's faces in it
  std::int64_t faces_;
  double mean_area_ = 0;
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

}  // namespace

Thinned thin(const Mesh& mesh, std::int64_t faces, Job& job) {
  Thinner thinner(mesh);
  thinner.run(faces, job);
  std::vector<std::int32_t> heir = thinner.take_heirs();
  Thinned result;
  std::vector<std::int32_t> vertex(static_cast<std::size_t>(mesh.vertex_count()), kNone);
  result.face.assign(heir.size(), kNone);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (heir[f] != kNone) continue;
    result.face[f] = static_cast<std::int32_t>(result.triangles.size());
    Triangle t = thinner.triangle(f);
    for (std::int32_t& v : t) {
      if (vertex[v] == kNone) {
        vertex[v] = static_cast<std::int32_t>(result.vertices.size());
        result.vertices.push_back(mesh.vertices()[v] + mesh.origin());
      }
      v = vertex[v];
    }
    result.triangles.push_back(t);
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) result.face[f] = result.face[stands_for(heir, f)];
  return result;
}

}  // namespace isimp::tiles
