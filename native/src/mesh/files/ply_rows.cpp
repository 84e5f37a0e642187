#include "files/ply_rows.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "isimp/core/to_integer.h"

namespace isimp::detail {
namespace {

constexpr std::size_t kBlock = 4096;  // format: rows that a thread decodes at once: they stay in its cache

/// The offset of each property in a row, and of the row's end; nothing if a property besides `list` is a list. The list
/// counts as no bytes in the offsets behind it.
std::optional<std::vector<std::size_t>> offsets_of(const PlyElement& element, std::optional<std::size_t> list) {
  std::vector<std::size_t> offsets{0};
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& p = element.properties[i];
    if (p.is_list && i != list) return {};
    offsets.push_back(offsets.back() + (p.is_list ? 0 : size_of(p.type)));
  }
  return offsets;
}

/// Calls visit(begin, end) for blocks of rows in pieces, one a thread, until a call of the piece returns less
/// than the block's end: the row that it reached.
/// \return the row that all of them reached without a gap
template <class Visit>
std::size_t for_each_block(std::size_t rows, const Threads& threads, Job& job, const Visit& visit) {
  const auto n = static_cast<std::int32_t>(rows);
  const std::int32_t pieces = threads.pieces(n);
  std::vector<std::size_t> stopped(static_cast<std::size_t>(pieces), rows);
  threads.run(n, pieces, [&](std::int32_t piece, std::int32_t first, std::int32_t last) {
    const auto end = static_cast<std::size_t>(last);
    for (auto begin = static_cast<std::size_t>(first); begin < end; begin += kBlock) {
      report_piece(job, piece, static_cast<double>(begin) / last);
      const std::size_t block_end = std::min(end, begin + kBlock), came = visit(begin, block_end);
      if (came == block_end) continue;
      stopped[piece] = came;
      return;
    }
  });
  return *std::min_element(stopped.begin(), stopped.end());
}

/// The lists of some rows of equal size.
struct Lists {
  std::size_t offset = 0;  ///< offset of the list in its row
  std::size_t row_bytes = 0;
  std::size_t count_bytes = 0, corners = 0;
  bool swap = false;
};

/// A number of a list; one that is no index where it is not even an integer of 64 bits.
template <class T>
std::int64_t load_integer(const char* p, bool swap) {
  const T value = load_number<T>(p, swap);
  if constexpr (std::is_floating_point_v<T>)
    return to_integer(value, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max());
  else
    return static_cast<std::int64_t>(value);
}

std::int64_t load_count(const char* p, PlyScalar type, bool swap) {
  return with_type(type, [&](auto zero) { return load_integer<decltype(zero)>(p, swap); });
}

/// The number of rows before the first one whose list has another count.
std::size_t rows_with_count(const Lists& lists, PlyScalar type, const char* block, std::size_t rows) {
  return with_type(type, [&](auto zero) {
    using Count = decltype(zero);
    const auto wanted = static_cast<Count>(lists.corners);
    const char* p = block + lists.offset;
    std::size_t row = 0;
    for (; row < rows && load_number<Count>(p, lists.swap) == wanted; ++row) p += lists.row_bytes;
    return row;
  });
}

template <class T>
void copy_corners(const Lists& lists, const char* block, std::size_t rows, std::int32_t* to) {
  const auto corner = [&](const char* p) { return SoupBuilder::corner(load_integer<T>(p, lists.swap)); };
  const char* p = block + lists.offset + lists.count_bytes;
  if (lists.corners == 3) {  // nearly always: the loop below takes twice as long
    for (std::size_t row = 0; row < rows; ++row, to += 3, p += lists.row_bytes) {
      to[0] = corner(p);
      to[1] = corner(p + sizeof(T));
      to[2] = corner(p + 2 * sizeof(T));
    }
    return;
  }
  for (std::size_t row = 0; row < rows; ++row, p += lists.row_bytes)
    for (std::size_t k = 0; k < lists.corners; ++k) *to++ = corner(p + k * sizeof(T));
}

}  // namespace

std::size_t read_vertex_rows(const PlyBytes& bytes, const PlyElement& element, const std::array<int, 3>& axes,
                             SoupBuilder& soup, const Threads& threads, Job& job) {
  const auto offsets = offsets_of(element, {});
  if (!offsets || element.count > soup.room_for_vertices()) return 0;
  const std::size_t row_bytes = offsets->back();
  if (bytes.rest.size() / row_bytes < element.count) return 0;
  const std::span<Vec3> vertices = soup.add_vertices(element.count);
  const auto read = [&](std::size_t begin, std::size_t end) {
    const char* block = bytes.rest.data() + begin * row_bytes;
    for (int k = 0; k < 3; ++k) {
      const auto property = static_cast<std::size_t>(axes[static_cast<std::size_t>(k)]);
      with_type(element.properties[property].type, [&](auto zero) {
        const char* p = block + (*offsets)[property];
        for (std::size_t row = begin; row < end; ++row, p += row_bytes)
          vertices[row][k] = static_cast<double>(load_number<decltype(zero)>(p, bytes.swap));
      });
    }
    return end;
  };
  for_each_block(element.count, threads, job, read);
  return element.count * row_bytes;
}

PlyRows read_face_rows(const PlyBytes& bytes, const PlyElement& element, std::size_t corners, std::size_t most,
                       SoupBuilder& soup, const Threads& threads, Job& job) {
  const auto offsets = offsets_of(element, corners);
  const PlyProperty& list = element.properties[corners];
  const std::size_t count_bytes = size_of(list.count_type);
  if (!offsets || bytes.rest.size() < offsets->back() + count_bytes) return {};
  Lists lists{(*offsets)[corners], 0, count_bytes, 0, bytes.swap};
  const std::int64_t count = load_count(bytes.rest.data() + lists.offset, list.count_type, bytes.swap);
  if (count < 0) return {};
  lists.corners = static_cast<std::size_t>(count);
  lists.row_bytes = offsets->back() + count_bytes + lists.corners * size_of(list.type);
  const std::size_t room = std::min(bytes.rest.size() / lists.row_bytes, soup.room_for_polygons(lists.corners));
  const std::size_t rows = std::min(most, room);
  const std::span<std::int32_t> to = soup.add_polygons(rows, lists.corners);
  const auto read = [&](std::size_t begin, std::size_t end) {
    const char* block = bytes.rest.data() + begin * lists.row_bytes;
    const std::size_t equal = rows_with_count(lists, list.count_type, block, end - begin);
    with_type(list.type,
              [&](auto zero) { copy_corners<decltype(zero)>(lists, block, equal, to.data() + begin * lists.corners); });
    return begin + equal;
  };
  const std::size_t equal = for_each_block(rows, threads, job, read);
  soup.drop_polygons(rows - equal, lists.corners);
  return {equal, equal * lists.row_bytes};
}

}  // namespace isimp::detail
