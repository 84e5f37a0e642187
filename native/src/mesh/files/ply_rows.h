#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "files/formats.h"
#include "files/ply_header.h"

/// Rows of equal size in a binary PLY file: their starts are known, so threads share them.
namespace isimp::detail {

/// A number at a place in the file, its bytes in reverse order if `swap`.
template <class T>
T load_number(const char* p, bool swap) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), p, sizeof(T));
  if (swap)
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  return std::bit_cast<T>(bytes);
}

/// Calls visit(zero) with a zero of the type in memory, and returns its result.
template <class Visit>
auto with_type(PlyScalar type, const Visit& visit) {
  switch (type) {
    case PlyScalar::i8:
      return visit(std::int8_t{});
    case PlyScalar::u8:
      return visit(std::uint8_t{});
    case PlyScalar::i16:
      return visit(std::int16_t{});
    case PlyScalar::u16:
      return visit(std::uint16_t{});
    case PlyScalar::i32:
      return visit(std::int32_t{});
    case PlyScalar::u32:
      return visit(std::uint32_t{});
    case PlyScalar::f32:
      return visit(float{});
    default:
      return visit(double{});
  }
}

/// The part of the file that is not read yet.
struct PlyBytes {
  std::string_view rest;
  bool swap = false;  ///< whether the file's byte order is the other one
};

/// Reads all vertices if none of their properties is a list and the file holds all of them; else reads nothing.
/// \param axes  the properties that are x, y and z
/// \return how many bytes were read
std::size_t read_vertex_rows(const PlyBytes& bytes, const PlyElement& element, const std::array<int, 3>& axes,
                             SoupBuilder& soup, const Threads& threads, Job& job);

/// Numbers of the rows that were read, and of their bytes.
struct PlyRows {
  std::size_t rows = 0, bytes = 0;
};

/// Reads polygons as long as each has as many corners as the first one. Reads nothing where another property is a list.
/// \param corners  the property that lists the corners
/// \param most     how many polygons to read at most
PlyRows read_face_rows(const PlyBytes& bytes, const PlyElement& element, std::size_t corners, std::size_t most,
                       SoupBuilder& soup, const Threads& threads, Job& job);

}  // namespace isimp::detail
