#include "formats.h"

#include <algorithm>

#include "edge_groups.h"

namespace isimp::detail {

void SoupBuilder::reserve(std::size_t vertices, std::size_t polygons) {
  soup_.vertices.reserve(std::min(vertices, kMost));
  soup_.loop_start.reserve(std::min(polygons, kMost));
  soup_.loops.reserve(std::min(3 * polygons, kMost));
}

void SoupBuilder::too_many(const char* what) const {
  file_.fail(std::string("it has more than 2,147,483,646 ") + what + ", the most that is supported");
}

PolygonSoup SoupBuilder::finish(std::int32_t first_index, Job& job) {
  const auto n = static_cast<std::int64_t>(soup_.vertices.size());
  for (std::int32_t q = 0; q < soup_.polygon_count(); ++q) {
    if (q % kPollEvery == 0) job.poll();
    for (const std::int32_t v : soup_.polygon(q))
      if (v >= n)
        file_.fail("face " + std::to_string(q) + " (the first is 0) uses " +
                   (v == kOut ? std::string("an impossible vertex") : "vertex " + std::to_string(v + first_index)) +
                   ", but there are " + std::to_string(n) + " vertices, the first of them " +
                   std::to_string(first_index));
  }
  return std::move(soup_);
}

}  // namespace isimp::detail
