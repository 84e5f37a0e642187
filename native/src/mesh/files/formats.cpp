#include "files/formats.h"

#include <algorithm>

#include "surface/parallel_loops.h"

namespace isimp::detail {

void SoupBuilder::reserve(std::size_t vertices, std::size_t polygons) {
  soup_.vertices.reserve(std::min(vertices, kMostIndices));
  soup_.loop_start.reserve(std::min(polygons, kMostIndices));
  soup_.loops.reserve(std::min(3 * polygons, kMostIndices));
}

void SoupBuilder::too_many(const char* what) const {
  file_.fail(std::string("it has more than 2,147,483,646 ") + what + ", the most that is supported");
}

std::span<Vec3> SoupBuilder::add_vertices(std::size_t count) {
  const std::size_t held = soup_.vertices.size();
  soup_.vertices.resize(held + count);
  return std::span(soup_.vertices).subspan(held);
}

std::span<std::int32_t> SoupBuilder::add_polygons(std::size_t count, std::size_t corners) {
  const std::size_t polygons = soup_.loop_start.size(), held = soup_.loops.size();
  soup_.loop_start.resize(polygons + count);
  soup_.loops.resize(held + count * corners);
  threads_.run(static_cast<std::int32_t>(count), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      soup_.loop_start[polygons + i] = static_cast<std::int32_t>(held + i * corners);
  });
  return std::span(soup_.loops).subspan(held);
}

void SoupBuilder::drop_polygons(std::size_t count, std::size_t corners) {
  soup_.loop_start.resize(soup_.loop_start.size() - count);
  soup_.loops.resize(soup_.loops.size() - count * corners);
}

PolygonSoup SoupBuilder::finish(std::int32_t first_index, Job& job) {
  constexpr std::size_t kChunk = std::size_t{1} << 24;  // format: corners between two polls
  const auto n = static_cast<std::int64_t>(soup_.vertices.size());
  for (std::size_t begin = 0; begin < soup_.loops.size(); begin += kChunk) {
    job.poll();
    const auto corners = std::span(soup_.loops).subspan(begin, std::min(kChunk, soup_.loops.size() - begin));
    const std::size_t i = find_first(threads_, corners.size(), [&](std::size_t c) { return corners[c] >= n; });
    if (i == corners.size()) continue;
    const auto after =
        std::upper_bound(soup_.loop_start.begin(), soup_.loop_start.end(), static_cast<std::int32_t>(begin + i));
    file_.fail("face " + std::to_string(after - soup_.loop_start.begin() - 1) + " (the first is 0) uses " +
               (corners[i] == kOut ? std::string("an impossible vertex")
                                   : "vertex " + std::to_string(std::int64_t{corners[i]} + first_index)) +
               ", but there are " + std::to_string(n) + " vertices, the first of them " + std::to_string(first_index));
  }
  return std::move(soup_);
}

}  // namespace isimp::detail
