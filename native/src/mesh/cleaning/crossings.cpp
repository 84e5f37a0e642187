// Finds triangles that cross others.
#include <CGAL/Bbox_3.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>

#include "cleaning/close.h"
#include "isimp/core/to_integer.h"
#include "isimp/mesh/meet.h"

namespace isimp::detail {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

CGAL::Bbox_3 box_of(const Corners& t) {
  const Vec3 low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  return {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
}

/// The cells of a grid that some boxes touch, to exclude most other boxes at once.
class Cells {
 public:
  explicit Cells(const std::vector<Box>& boxes) : marked_(kSide * kSide * kSide, 0) {
    for (const Box& b : boxes) reach_ += b.bbox();
    for (int k = 0; k < 3; ++k) {
      const double length = reach_.max(k) - reach_.min(k);
      per_length_[k] = length > 0 ? kSide / length : 0;
    }
    for (const Box& b : boxes)
      find(b.bbox(), [&](std::size_t cell) {
        marked_[cell] = 1;
        return false;
      });
  }
  /// Whether a box may touch one of these boxes.
  [[nodiscard]] bool has(const CGAL::Bbox_3& box) const {
    return CGAL::do_overlap(box, reach_) && find(box, [&](std::size_t cell) { return marked_[cell] != 0; });
  }

 private:
  static constexpr int kSide = 64;

  /// Whether fn(cell) is true of a cell that a box touches, which reaches into the grid.
  template <class Function>
  bool find(const CGAL::Bbox_3& box, Function fn) const {
    std::array<std::array<int, 2>, 3> range{};
    for (int k = 0; k < 3; ++k)
      for (int side = 0; side < 2; ++side) {
        const double at = ((side == 0 ? box.min(k) : box.max(k)) - reach_.min(k)) * per_length_[k];
        range[k][side] = to_integer(at, 0, kSide - 1);
      }
    for (int x = range[0][0]; x <= range[0][1]; ++x)
      for (int y = range[1][0]; y <= range[1][1]; ++y)
        for (int z = range[2][0]; z <= range[2][1]; ++z)
          if (fn((static_cast<std::size_t>(x) * kSide + y) * kSide + z)) return true;
    return false;
  }

  std::vector<char> marked_;
  CGAL::Bbox_3 reach_;
  std::array<double, 3> per_length_{};
};

}  // namespace

std::vector<std::int32_t> find_near(const MeshArrays& arrays, const std::vector<std::int32_t>* among,
                                    const std::vector<Eigen::AlignedBox3d>& boxes, const Threads& threads, Job& job) {
  std::vector<Box> places;
  places.reserve(boxes.size());
  for (const Eigen::AlignedBox3d& b : boxes)
    places.emplace_back(CGAL::Bbox_3(b.min().x(), b.min().y(), b.min().z(), b.max().x(), b.max().y(), b.max().z()),
                        kNone);
  const Cells cells(places);
  const std::size_t count = among ? among->size() : arrays.triangles.size();
  std::vector<Box> faces = gather<Box>(threads, count, job, [&](std::size_t i, auto& found) {
    const std::int32_t f = among ? (*among)[i] : static_cast<std::int32_t>(i);
    const auto& [a, b, c] = arrays.triangles[f];
    const CGAL::Bbox_3 box = box_of({arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]});
    if (cells.has(box)) found.emplace_back(box, f);
  });
  std::vector<std::int32_t> near;
  CGAL::box_intersection_d(places.begin(), places.end(), faces.begin(), faces.end(),
                           [&](const Box&, const Box& face) { near.push_back(face.info()); });
  return rising(std::move(near));
}

std::vector<char> find_crossed(const MeshArrays& arrays, const std::vector<std::int32_t>& others,
                               const std::vector<char>& removed, std::size_t fresh, Job& job) {
  const auto corners = [&](std::int32_t f) {
    const auto& [a, b, c] = arrays.triangles[f];
    return Corners{arrays.vertices[a], arrays.vertices[b], arrays.vertices[c]};
  };
  const auto all = static_cast<std::int32_t>(arrays.triangles.size()), old = all - static_cast<std::int32_t>(fresh);
  std::vector<Box> patches, kept;
  for (std::int32_t f = old; f < all; ++f) patches.emplace_back(box_of(corners(f)), f);
  for (const std::int32_t f : others)
    if (!removed[f]) kept.emplace_back(box_of(corners(f)), f);
  std::vector<char> crossed(fresh, 0);
  std::size_t tests = 0;
  CGAL::box_intersection_d(patches.begin(), patches.end(), kept.begin(), kept.end(), [&](const Box& x, const Box& y) {
    if (++tests % kPollEvery == 0) job.poll();
    const std::int32_t f = x.info(), g = y.info();
    if (f == g || crossed[f - old]) return;
    const Corners s = corners(f), t = corners(g);
    if (has_area(s) && has_area(t)) crossed[f - old] = meet_elsewhere(arrays.triangles[f], s, arrays.triangles[g], t);
  });
  return crossed;
}

}  // namespace isimp::detail
