#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "files/file_text.h"

namespace isimp::detail {

/// The types of numbers in PLY; the types with decimals come last.
enum class PlyScalar { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Bytes of a number in a binary file.
constexpr std::size_t size_of(PlyScalar type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};  // format
  return kSizes[static_cast<std::size_t>(type)];
}

/// The type as numpy writes it.
constexpr std::string_view kind_of(PlyScalar type) {
  constexpr std::array<std::string_view, 8> kKinds{"i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"};
  return kKinds[static_cast<std::size_t>(type)];
}

/// A number of each row of an element, or a list of them with its count before it.
struct PlyProperty {
  std::string name;
  PlyScalar type = PlyScalar::f32;
  bool is_list = false;
  PlyScalar count_type = PlyScalar::u8;
};

/// A table of the file: rows of the same properties.
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  /// The index of a property, or -1.
  [[nodiscard]] int find(std::string_view property) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == property) return static_cast<int>(i);
    return -1;
  }
  /// The index of the list of whole numbers that names the vertices of a face, or -1.
  [[nodiscard]] int find_corners() const;
};

enum class PlyEncoding { text, little_endian, big_endian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::text;
  std::vector<PlyElement> elements;
  std::size_t body = 0;               ///< first byte of the data
  std::vector<std::string> textures;  ///< the texture files that comments name

  /// Whether the file's byte order is not this machine's.
  [[nodiscard]] bool swaps() const {
    return (encoding == PlyEncoding::big_endian) != (std::endian::native == std::endian::big);
  }
  /// The number of elements up to the last one with vertices, faces or strips; later ones are not read.
  [[nodiscard]] std::size_t wanted_elements() const;
};

/// Reads the header, up to the data.
/// \throws FileError  it is no PLY header; the message names the line
PlyHeader read_ply_header(const FileText& file);

}  // namespace isimp::detail
