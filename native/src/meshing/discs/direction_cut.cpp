// Parts a chart by the directions of its faces.
#include <algorithm>
#include <utility>

#include "discs/discs.h"

namespace isimp::meshing {
namespace {

// tuned sides
constexpr double kExact = 1e-4;              ///< roughness of the sides up to which all of them are planes
constexpr double kRoundingRoughness = 1e-6;  ///< rounding: roughness that rounding makes
constexpr double kCurve = 0.035;             ///< roughness up to which a chart has one side, and its sides are planes
constexpr double kNear = 0.7071;             ///< cosine of 45 degrees: how near to a direction its faces look
constexpr double kStraight = 0.999;  ///< cosine of 2.5 degrees: a face that is nearer to a direction is no speck
constexpr double kRest = 0.01;       ///< share of the area that needs no direction of its own
constexpr double kSmall = 0.5;       ///< share of the adjacent component: a smaller one is no side of its own
constexpr int kMostDirections = 10;  ///< limit: at most
constexpr int kRefinements = 3;      ///< rounds: each direction becomes the mean of the faces near it
constexpr int kSmoothings = 2;       ///< rounds in which a face takes the direction of two of its neighbours

/// The faces of one chart and the directions they look in.
class Looks {
 public:
  Looks(const Cutter& cutter, std::span<const std::int32_t> faces)
      : labels_(cutter.labels), faces_(faces), place_(cutter.face_place.get()) {
    const FaceGraph& graph = labels_.mesh.graph();
    for (std::size_t i = 0; i < faces.size(); ++i) {
      place_[faces[i]] = static_cast<std::int32_t>(i);
      const FaceRecord& r = graph.faces[graph.graph_face[faces[i]]];
      looks_.push_back({Vec3(r.nx, r.ny, r.nz), r.area});
      area_ += r.area;
    }
  }

  /// 1 less the vector area over the area: 0 where all faces look in one direction.
  [[nodiscard]] double roughness() const { return roughness(std::vector<std::uint8_t>(looks_.size(), 0)); }

  /// 1 less the sum of the vector areas of the sides, one for each direction, over the area.
  [[nodiscard]] double roughness(const std::vector<std::uint8_t>& own) const {
    std::array<Vec3, kMostDirections> sums;
    sums.fill(Vec3::Zero());
    for (std::size_t i = 0; i < own.size(); ++i) sums[own[i]] += looks_[i].area * looks_[i].normal;
    double length = 0;
    for (const Vec3& s : sums) length += s.norm();
    return area_ > 0 ? 1 - length / area_ : 0;
  }

  /// By place of the face: which of the directions that most of the area looks in is its own.
  /// \param rest  share of the area that needs no direction of its own
  [[nodiscard]] std::vector<std::uint8_t> nearest_directions(double rest) const {
    const std::vector<Vec3> directions = find(rest);
    std::vector<std::uint8_t> own(looks_.size());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = nearest(directions, looks_[i].normal);
    for (int round = 0; round < kSmoothings; ++round) smooth(own, directions);
    return own;
  }

  /// The components of faces of one direction. A small one is united with an adjacent one of about the same
  /// direction: it is a strip of that side, left because regions did not end at the edge of the side.
  [[nodiscard]] std::vector<std::vector<std::int32_t>> components(const std::vector<std::uint8_t>& own) const {
    std::vector<std::vector<std::int32_t>> components;
    std::vector<std::int32_t> component_of(own.size(), kNone);
    for (std::size_t i = 0; i < own.size(); ++i)
      if (component_of[i] == kNone) {
        components.emplace_back(1, faces_[i]);
        flood(own, static_cast<std::int32_t>(components.size()) - 1, components.back(), component_of);
      }
    std::vector<Vec3> sum(components.size(), Vec3::Zero());
    for (std::size_t i = 0; i < own.size(); ++i) sum[component_of[i]] += looks_[i].area * looks_[i].normal;
    for (std::size_t k = 0; k < components.size(); ++k) {
      const std::int32_t to = larger_beside(components[k], component_of, sum);
      if (to == kNone) continue;
      for (const std::int32_t f : components[k]) component_of[place_[f]] = to;
      components[to].insert(components[to].end(), components[k].begin(), components[k].end());
      sum[to] += sum[k];
      components[k].clear();
    }
    std::erase_if(components, [](const auto& c) { return c.empty(); });
    return components;
  }

 private:
  struct Look {
    Vec3 normal;
    double area;
  };

  /// All faces of one direction that hang together with the first one.
  void flood(const std::vector<std::uint8_t>& own, std::int32_t number, std::vector<std::int32_t>& component,
             std::vector<std::int32_t>& component_of) const {
    const std::uint8_t direction = own[place_[component[0]]];
    component_of[place_[component[0]]] = number;
    for (std::size_t k = 0; k < component.size(); ++k)
      for_each_beside(component[k], [&](std::int32_t j) {
        if (component_of[j] != kNone || own[j] != direction) return;
        component_of[j] = number;
        component.push_back(faces_[j]);
      });
  }

  /// The largest adjacent component that is much larger and has about the same direction; kNone where there is none.
  [[nodiscard]] std::int32_t larger_beside(std::span<const std::int32_t> component,
                                           std::span<const std::int32_t> component_of,
                                           std::span<const Vec3> sum) const {
    if (component.empty()) return kNone;
    const std::int32_t from = component_of[place_[component[0]]];
    std::int32_t best = kNone;
    for (const std::int32_t f : component)
      for_each_beside(f, [&](std::int32_t j) {
        const std::int32_t k = component_of[j];
        const double size = sum[from].norm(), other = sum[k].norm();
        if (k == from || size > kSmall * other || sum[from].dot(sum[k]) < kSameWay * size * other) return;
        if (best == kNone || other > sum[best].norm()) best = k;
      });
    return best;
  }

  static std::uint8_t nearest(std::span<const Vec3> directions, const Vec3& normal) {
    std::size_t best = 0;
    double most = directions[0].dot(normal);
    for (std::size_t i = 1; i < directions.size(); ++i)
      if (const double cosine = directions[i].dot(normal); cosine > most) {
        best = i;
        most = cosine;
      }
    return static_cast<std::uint8_t>(best);
  }

  /// The directions of most of the area, the one with the largest area first.
  [[nodiscard]] std::vector<Vec3> find(double share) const {
    std::vector<Vec3> found;
    std::vector<Look> rest = looks_;
    for (double left = area_;
         static_cast<int>(found.size()) < kMostDirections && !rest.empty() && left > share * area_;) {
      Vec3 d = fullest(rest);
      for (int i = 0; i < kRefinements; ++i) d = mean_near(rest, d);
      found.push_back(d);
      const auto gone =
          std::partition(rest.begin(), rest.end(), [&](const Look& l) { return l.normal.dot(d) < kNear; });
      if (gone == rest.end()) break;
      for (auto l = gone; l != rest.end(); ++l) left -= l->area;
      rest.erase(gone, rest.end());
    }
    return found;
  }

  /// The one of the 26 directions from a cell of a grid to its neighbours that is nearest to most of the area.
  static Vec3 fullest(std::span<const Look> looks) {
    std::vector<Vec3> directions;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x != 0 || y != 0 || z != 0) directions.push_back(Vec3(x, y, z).normalized());
    std::vector<double> area(directions.size(), 0);
    for (const Look& l : looks) area[nearest(directions, l.normal)] += l.area;
    return directions[std::max_element(area.begin(), area.end()) - area.begin()];
  }

  static Vec3 mean_near(std::span<const Look> looks, const Vec3& direction) {
    Vec3 sum = Vec3::Zero();
    for (const Look& l : looks)
      if (l.normal.dot(direction) >= kNear) sum += l.area * l.normal;
    return sum.norm() > 0 ? Vec3(sum.normalized()) : direction;
  }

  /// Specks take the direction of two neighbours that agree. A face that looks straight in its own is none: it may be
  /// half of a side.
  void smooth(std::vector<std::uint8_t>& own, std::span<const Vec3> directions) const {
    const std::vector<std::uint8_t> before = own;
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (looks_[i].normal.dot(directions[before[i]]) > kStraight) continue;
      std::array<std::int32_t, 3> beside{kNone, kNone, kNone};
      int n = 0;
      for_each_beside(faces_[i], [&](std::int32_t j) { beside[n++] = before[j]; });
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < a; ++b)
          if (beside[a] == beside[b]) own[i] = static_cast<std::uint8_t>(beside[a]);
    }
  }

  template <class Function>
  void for_each_beside(std::int32_t f, Function fn) const {
    for (std::int32_t h = 3 * f; h < 3 * f + 3; ++h)
      if (labels_.inner(h)) fn(place_[labels_.mesh.opposite(h) / 3]);
  }

  const Labels& labels_;
  std::span<const std::int32_t> faces_;
  std::int32_t* place_;  // by face of the mesh, valid for faces of the chart
  std::vector<Look> looks_;
  double area_ = 0;
};

}  // namespace

std::int32_t cut_by_direction(Cutter& cutter, std::int32_t chart) {
  const std::vector<std::int32_t> faces = cutter.labels.faces_of(chart);
  const Looks looks(cutter, faces);
  const double before = looks.roughness();
  // In a plate with holes, few faces of another side would tilt the polygon, its neighbours and their neighbours. Only
  // where all sides are planes can these faces be distinguished from roughness.
  const bool few = before <= kCurve;
  if (few && (!cutter.perforated || before <= kRoundingRoughness)) return 0;
  const std::vector<std::uint8_t> own = looks.nearest_directions(few ? 0 : kRest);
  const double after = looks.roughness(own);
  if (after > (few ? kExact : kCurve) || after > before) return 0;
  const std::vector<std::vector<std::int32_t>> components = looks.components(own);
  for (std::size_t k = 1; k < components.size(); ++k) cutter.labels.part(components[k], components[0][0], Cause::wall);
  return static_cast<std::int32_t>(components.size()) - 1;
}

bool has_flat_sides(const Cutter& cutter, const Job& job) {
  for (std::int32_t l = 0; l < cutter.labels.chart_count(); ++l) {
    job.poll();
    const std::vector<std::int32_t> faces = cutter.labels.faces_of(l);
    const Looks looks(cutter, faces);
    if (looks.roughness() > kRoundingRoughness && looks.roughness(looks.nearest_directions(0)) > kExact) return false;
  }
  return true;
}

}  // namespace isimp::meshing
