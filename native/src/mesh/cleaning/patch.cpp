// Fills a loop of edges with triangles.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/iterator.h>
#include <CGAL/utility.h>

#include <iterator>
#include <vector>

#include "cleaning/close.h"

namespace isimp::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

std::vector<Point> points(const std::vector<Vec3>& all) {
  std::vector<Point> result;
  result.reserve(all.size());
  for (const Vec3& p : all) result.emplace_back(p.x(), p.y(), p.z());
  return result;
}

/// CGAL's weight of a patch, and the middle corner of its last triangle: of equal patches the one with the lower corner is
/// the better one. By the weight alone it would be the one that CGAL comes to first, which depends on addresses in memory.
class PatchWeight {
 public:
  using Plain = CGAL::internal::Weight_min_max_dihedral_and_area;

  PatchWeight(const Plain& plain, int corner) : plain_(plain), corner_(corner) {}
  static PatchWeight DEFAULT() { return {Plain::DEFAULT(), -1}; }  // NOLINT(readability-identifier-naming): CGAL's name
  static PatchWeight NOT_VALID() { return {Plain::NOT_VALID(), -1}; }  // NOLINT(readability-identifier-naming)

  PatchWeight operator+(const PatchWeight& last) const { return {plain_ + last.plain_, last.corner_}; }
  bool operator<(const PatchWeight& other) const {
    return plain_ < other.plain_ || (plain_ == other.plain_ && corner_ < other.corner_);
  }
  bool operator==(const PatchWeight& other) const { return plain_ == other.plain_; }
  bool operator!=(const PatchWeight& other) const { return plain_ != other.plain_; }

 private:
  Plain plain_;
  int corner_;
};

struct WeightCalculator {
  using Weight = PatchWeight;

  template <class Table>
  Weight operator()(const std::vector<Point>& loop, const std::vector<Point>& beyond, int i, int j, int k,
                    const Table& middle) const {
    return {CGAL::internal::Weight_calculator<Weight::Plain, CGAL::internal::Is_not_degenerate_triangle>()(
                loop, beyond, i, j, k, middle),
            j};
  }
};

Patch without_new_vertices(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond) {
  Patch patch;
  if (loop.size() == 3) {
    patch.triangles.push_back({0, 1, 2});
    return patch;
  }
  if (loop.front() == loop.back()) return patch;  // CGAL would take the last vertex for the first one repeated
  using Triple = CGAL::Triple<int, int, int>;
  std::vector<Triple> found;
  CGAL::internal::Tracer_polyline_incomplete<Triple, std::back_insert_iterator<std::vector<Triple>>,
                                             CGAL::Emptyset_iterator>
      tracer(std::back_inserter(found), CGAL::Emptyset_iterator());
  CGAL::Polygon_mesh_processing::Hole_filling::Default_visitor visitor;
  CGAL::internal::triangulate_hole_polyline(points(loop), points(beyond), tracer, WeightCalculator(), visitor, true,
                                            false, Kernel());
  if (found.size() + 2 == loop.size())
    for (const auto& t : found) patch.triangles.push_back({t.first, t.second, t.third});
  return patch;
}

Patch round_the_middle(const std::vector<Vec3>& loop) {
  Patch patch;
  if (loop.size() == 3) return patch;  // plan 0 is the better one
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : loop) sum += p;
  patch.inner.emplace_back(sum / static_cast<double>(loop.size()));
  const auto n = static_cast<std::int32_t>(loop.size());
  for (std::int32_t i = 0; i < n; ++i) patch.triangles.push_back({i, (i + 1) % n, n});
  return patch;
}

}  // namespace

Patch cover(const std::vector<Vec3>& loop, const std::vector<Vec3>& beyond, int plan) {
  return plan == 0 ? without_new_vertices(loop, beyond) : round_the_middle(loop);
}

}  // namespace isimp::detail
