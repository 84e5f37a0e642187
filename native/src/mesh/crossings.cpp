#include <CGAL/Bbox_3.h>
#include <CGAL/box_intersection_d.h>

#include "close.h"
#include "isimp/mesh/meet.h"

namespace isimp::detail {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::int32_t>;

CGAL::Bbox_3 box_of(const Corners& t) {
  const Vec3 low = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  return {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
}

}  // namespace

std::vector<char> find_crossed(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                               const std::vector<char>& removed, std::size_t fresh, Job& job) {
  const auto corners = [&](std::int32_t f) {
    const auto& [a, b, c] = triangles[f];
    return Corners{vertices[a], vertices[b], vertices[c]};
  };
  const std::size_t old = triangles.size() - fresh;
  CGAL::Bbox_3 reach;
  std::vector<Box> patches, others;
  for (std::size_t f = old; f < triangles.size(); ++f) {
    patches.emplace_back(box_of(corners(static_cast<std::int32_t>(f))), static_cast<std::int32_t>(f));
    reach += patches.back().bbox();
  }
  for_each_index(triangles.size(), job, [&](std::size_t f) {
    if (removed[f]) return;
    const CGAL::Bbox_3 box = box_of(corners(static_cast<std::int32_t>(f)));
    if (CGAL::do_overlap(box, reach)) others.emplace_back(box, static_cast<std::int32_t>(f));
  });
  std::vector<char> crossed(fresh, 0);
  std::size_t tests = 0;
  CGAL::box_intersection_d(patches.begin(), patches.end(), others.begin(), others.end(),
                           [&](const Box& x, const Box& y) {
                             if (++tests % kPollEvery == 0) job.poll();
                             const std::int32_t f = x.info(), g = y.info();
                             if (f == g || crossed[f - old]) return;
                             const Corners s = corners(f), t = corners(g);
                             if (has_area(s) && has_area(t))
                               crossed[f - old] = meet_elsewhere(triangles[f], s, triangles[g], t);
                           });
  return crossed;
}

}  // namespace isimp::detail
