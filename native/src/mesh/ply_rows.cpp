#include "ply_rows.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace isimp::detail {
namespace {

constexpr std::size_t kBlock = 4096;  // rows that a thread decodes at once: they stay in its cache

/// Where each property begins in a row, and the row's end; nothing if one besides `list` is a list. What follows the
/// list is as if the list took no bytes.
std::optional<std::vector<std::size_t>> offsets_of(const PlyElement& element, std::optional<std::size_t> list) {
  std::vector<std::size_t> offsets{0};
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& p = element.properties[i];
    if (p.is_list && i != list) return {};
    offsets.push_back(offsets.back() + (p.is_list ? 0 : size_of(p.type)));
  }
  return offsets;
}

/// Calls visit(begin, end) for blocks of rows in pieces, one a thread, until a call of the piece returns less than the
/// block's end: how far it came.
/// \return how far all of them came without a gap
template <class Visit>
std::size_t for_each_block(std::size_t rows, const Threads& threads, Job& job, const Visit& visit) {
  const auto n = static_cast<std::int32_t>(rows);
  const std::int32_t pieces = threads.pieces(n);
  std::vector<std::size_t> stopped(static_cast<std::size_t>(pieces), rows);
  threads.run(n, pieces, [&](std::int32_t piece, std::int32_t first, std::int32_t last) {
    const auto end = static_cast<std::size_t>(last);
    for (auto begin = static_cast<std::size_t>(first); begin < end; begin += kBlock) {
      job.poll();
      const std::size_t block_end = std::min(end, begin + kBlock), came = visit(begin, block_end);
      if (came == block_end) continue;
      stopped[piece] = came;
      return;
    }
  });
  return *std::min_element(stopped.begin(), stopped.end());
}

/// The lists of rows of equal size.
struct Lists {
  const char* first;  ///< the count of the first row's list
  std::size_t row_bytes = 0;
  std::size_t count_bytes = 0, corners = 0;
  bool swap = false;

  [[nodiscard]] const char* count(std::size_t row) const { return first + row * row_bytes; }
  [[nodiscard]] const char* items(std::size_t row) const { return count(row) + count_bytes; }
};

/// The first row from `begin` on whose list has another count; else `end`.
std::size_t find_other_count(const Lists& lists, PlyScalar type, std::size_t begin, std::size_t end) {
  return with_type(type, [&](auto zero) {
    std::size_t row = begin;
    const auto wanted = load_number<decltype(zero)>(lists.first, lists.swap);
    while (row < end && load_number<decltype(zero)>(lists.count(row), lists.swap) == wanted) ++row;
    return row;
  });
}

template <class T>
void copy_corners(const Lists& lists, std::size_t begin, std::size_t end, std::int32_t* to) {
  const auto corner = [&](const char* p) {
    return SoupBuilder::corner(static_cast<std::int64_t>(load_number<T>(p, lists.swap)));
  };
  if (lists.corners == 3) {  // nearly always: the loop below takes twice as long
    for (std::size_t row = begin; row < end; ++row, to += 3) {
      const char* p = lists.items(row);
      to[0] = corner(p);
      to[1] = corner(p + sizeof(T));
      to[2] = corner(p + 2 * sizeof(T));
    }
    return;
  }
  for (std::size_t row = begin; row < end; ++row)
    for (std::size_t k = 0; k < lists.corners; ++k) *to++ = corner(lists.items(row) + k * sizeof(T));
}

}  // namespace

std::size_t read_vertex_rows(const PlyBytes& bytes, const PlyElement& element, const std::array<int, 3>& axes,
                             SoupBuilder& soup, const Threads& threads, Job& job) {
  const auto offsets = offsets_of(element, {});
  if (!offsets || element.count > soup.room_for_vertices()) return 0;
  const std::size_t row_bytes = offsets->back();
  if (bytes.rest.size() / row_bytes < element.count) return 0;
  const std::span<Vec3> vertices = soup.add_vertices(element.count);
  for_each_block(element.count, threads, job, [&](std::size_t begin, std::size_t end) {
    for (int k = 0; k < 3; ++k) {
      const auto property = static_cast<std::size_t>(axes[static_cast<std::size_t>(k)]);
      const char* column = bytes.rest.data() + (*offsets)[property];
      with_type(element.properties[property].type, [&](auto zero) {
        for (std::size_t row = begin; row < end; ++row)
          vertices[row][k] = static_cast<double>(load_number<decltype(zero)>(column + row * row_bytes, bytes.swap));
      });
    }
    return end;
  });
  return element.count * row_bytes;
}

PlyRows read_face_rows(const PlyBytes& bytes, const PlyElement& element, std::size_t corners, std::size_t most,
                       SoupBuilder& soup, const Threads& threads, Job& job) {
  const auto offsets = offsets_of(element, corners);
  const PlyProperty& list = element.properties[corners];
  const std::size_t count_bytes = size_of(list.count_type);
  if (!offsets || bytes.rest.size() < offsets->back() + count_bytes) return {};
  Lists lists{bytes.rest.data() + (*offsets)[corners], 0, count_bytes, 0, bytes.swap};
  const auto count = with_type(list.count_type, [&](auto zero) {
    return static_cast<std::int64_t>(load_number<decltype(zero)>(lists.first, bytes.swap));
  });
  if (count < 0) return {};
  lists.corners = static_cast<std::size_t>(count);
  lists.row_bytes = offsets->back() + count_bytes + lists.corners * size_of(list.type);
  const std::size_t room = std::min(bytes.rest.size() / lists.row_bytes, soup.room_for_polygons(lists.corners));
  const std::size_t rows = std::min(most, room);
  const std::span<std::int32_t> to = soup.add_polygons(rows, lists.corners);
  const std::size_t equal = for_each_block(rows, threads, job, [&](std::size_t begin, std::size_t end) {
    const std::size_t other = find_other_count(lists, list.count_type, begin, end);
    with_type(list.type,
              [&](auto zero) { copy_corners<decltype(zero)>(lists, begin, other, to.data() + begin * lists.corners); });
    return other;
  });
  soup.drop_polygons(rows - equal, lists.corners);
  return {equal, equal * lists.row_bytes};
}

}  // namespace isimp::detail
