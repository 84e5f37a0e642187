#include "files/ply_header.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace isimp::detail {
namespace {

constexpr std::array<std::pair<std::string_view, PlyScalar>, 16> kScalars{{{"char", PlyScalar::i8},
                                                                           {"int8", PlyScalar::i8},
                                                                           {"uchar", PlyScalar::u8},
                                                                           {"uint8", PlyScalar::u8},
                                                                           {"short", PlyScalar::i16},
                                                                           {"int16", PlyScalar::i16},
                                                                           {"ushort", PlyScalar::u16},
                                                                           {"uint16", PlyScalar::u16},
                                                                           {"int", PlyScalar::i32},
                                                                           {"int32", PlyScalar::i32},
                                                                           {"uint", PlyScalar::u32},
                                                                           {"uint32", PlyScalar::u32},
                                                                           {"float", PlyScalar::f32},
                                                                           {"float32", PlyScalar::f32},
                                                                           {"double", PlyScalar::f64},
                                                                           {"float64", PlyScalar::f64}}};

PlyScalar scalar(const FileText& file, std::string_view name) {
  for (const auto& [known, type] : kScalars)
    if (known == name) return type;
  file.fail_at(name.data(), "a PLY header names the unknown type " + shown(name));
}

PlyProperty read_property(const FileText& file, Words& words) {
  PlyProperty property;
  std::string_view type = words.next();
  if (type == "list") {
    property.is_list = true;
    property.count_type = scalar(file, words.next());
    if (property.count_type >= PlyScalar::f32)
      file.fail("a PLY list has a count with decimals; it must be a whole number");
    type = words.next();
  }
  property.type = scalar(file, type);
  property.name = words.next();
  return property;
}

bool is_texture_file(std::string_view word) {
  return std::ranges::equal(word, std::string_view("texturefile"), {}, [](unsigned char c) { return std::tolower(c); });
}

PlyElement read_element(const FileText& file, std::string_view line, Words& words) {
  PlyElement element;
  element.name = words.next();
  const std::string_view count_word = words.next();
  const auto count = to_whole_number(count_word);
  if (!count || *count < 0)
    file.fail_at(line.data(), "element " + shown(element.name) + " needs its number of rows, got " + shown(count_word));
  element.count = static_cast<std::size_t>(*count);
  return element;
}

}  // namespace

int PlyElement::find_corners() const {
  const int named = find("vertex_indices"), corners = named >= 0 ? named : find("vertex_index");
  if (corners < 0) return -1;
  const PlyProperty& p = properties[static_cast<std::size_t>(corners)];
  return p.is_list && p.type < PlyScalar::f32 ? corners : -1;
}

std::size_t PlyHeader::wanted_elements() const {
  std::size_t wanted = 0;
  for (std::size_t i = 0; i < elements.size(); ++i)
    if (const std::string& name = elements[i].name; name == "vertex" || name == "face" || name == "tristrips")
      wanted = i + 1;
  return wanted;
}

PlyHeader read_ply_header(const FileText& file) {
  PlyHeader header;
  Lines lines(file.text());
  std::string_view line;
  if (!lines.next(line) || Words(line).next() != "ply")
    file.fail("it does not begin with \"ply\", as a PLY file does; is it in another format?");
  bool has_format = false;
  while (lines.next(line)) {
    Words words(line);
    const std::string_view keyword = words.next();
    if (keyword == "end_header") {
      if (!has_format) file.fail("the PLY header has no format line");
      header.body = file.bytes.size() - lines.rest().size();
      return header;
    }
    if (keyword == "format") {
      const std::string_view name = words.next();
      has_format = true;
      if (name == "ascii") {
        header.encoding = PlyEncoding::text;
      } else if (name == "binary_little_endian") {
        header.encoding = PlyEncoding::little_endian;
      } else if (name == "binary_big_endian") {
        header.encoding = PlyEncoding::big_endian;
      } else {
        file.fail_at(line.data(), "unknown PLY format " + shown(name));
      }
    } else if (keyword == "element") {
      header.elements.push_back(read_element(file, line, words));
    } else if (keyword == "property") {
      if (header.elements.empty()) file.fail_at(line.data(), "a PLY property comes before any element");
      header.elements.back().properties.push_back(read_property(file, words));
    } else if (keyword == "comment") {
      if (is_texture_file(words.next()) && !words.rest().empty()) header.textures.emplace_back(words.rest());
    } else if (keyword != "obj_info" && !keyword.empty()) {
      file.fail_at(line.data(), "unknown word " + shown(keyword) + " in the PLY header");
    }
  }
  file.fail("the PLY header has no end_header; the file is cut short or damaged");
}

}  // namespace isimp::detail
