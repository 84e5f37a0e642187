#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "edge_groups.h"
#include "formats.h"

namespace isimp::detail {
namespace {

enum class Scalar { i8, u8, i16, u16, i32, u32, f32, f64 };

constexpr std::array<std::pair<std::string_view, Scalar>, 16> kScalars{{{"char", Scalar::i8},
                                                                        {"int8", Scalar::i8},
                                                                        {"uchar", Scalar::u8},
                                                                        {"uint8", Scalar::u8},
                                                                        {"short", Scalar::i16},
                                                                        {"int16", Scalar::i16},
                                                                        {"ushort", Scalar::u16},
                                                                        {"uint16", Scalar::u16},
                                                                        {"int", Scalar::i32},
                                                                        {"int32", Scalar::i32},
                                                                        {"uint", Scalar::u32},
                                                                        {"uint32", Scalar::u32},
                                                                        {"float", Scalar::f32},
                                                                        {"float32", Scalar::f32},
                                                                        {"double", Scalar::f64},
                                                                        {"float64", Scalar::f64}}};

constexpr std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Scalar type = Scalar::f32;
  bool is_list = false;
  Scalar count_type = Scalar::u8;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;

  [[nodiscard]] int find(std::string_view property) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == property) return static_cast<int>(i);
    return -1;
  }
};

enum class Encoding { text, little_endian, big_endian };

struct Header {
  Encoding encoding = Encoding::text;
  std::vector<Element> elements;
  std::size_t body = 0;  ///< where the data begins
};

Scalar scalar(const FileText& file, std::string_view name) {
  for (const auto& [known, type] : kScalars)
    if (known == name) return type;
  file.fail_at(name.data(), "a PLY header names the unknown type " + shown(name));
}

Property read_property(const FileText& file, Words& words) {
  Property property;
  std::string_view type = words.next();
  if (type == "list") {
    property.is_list = true;
    property.count_type = scalar(file, words.next());
    if (property.count_type >= Scalar::f32) file.fail("a PLY list can't be counted by a type with decimals");
    type = words.next();
  }
  property.type = scalar(file, type);
  property.name = words.next();
  return property;
}

Element read_element(const FileText& file, std::string_view line, Words& words) {
  Element element;
  element.name = words.next();
  const std::string_view count_word = words.next();
  const auto count = to_integer(count_word);
  if (!count || *count < 0)
    file.fail_at(line.data(), "element " + shown(element.name) + " wants a count, got " + shown(count_word));
  element.count = static_cast<std::size_t>(*count);
  return element;
}

Header read_header(const FileText& file) {
  Header header;
  Lines lines(file.bytes);
  std::string_view line;
  if (!lines.next(line) || Words(line).next() != "ply")
    file.fail("it does not begin with \"ply\", as a PLY file does; is it of another kind?");
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
        header.encoding = Encoding::text;
      } else if (name == "binary_little_endian") {
        header.encoding = Encoding::little_endian;
      } else if (name == "binary_big_endian") {
        header.encoding = Encoding::big_endian;
      } else {
        file.fail_at(line.data(), "unknown PLY format " + shown(name));
      }
    } else if (keyword == "element") {
      header.elements.push_back(read_element(file, line, words));
    } else if (keyword == "property") {
      if (header.elements.empty()) file.fail_at(line.data(), "a PLY property comes before any element");
      header.elements.back().properties.push_back(read_property(file, words));
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      file.fail_at(line.data(), "unknown word " + shown(keyword) + " in the PLY header");
    }
  }
  file.fail("the PLY header has no end_header; the file is cut short or damaged");
}

/// Reads values from text or from bytes of either order.
class Values {
 public:
  Values(const FileText& file, const Header& header)
      : file_(file),
        text_(header.encoding == Encoding::text),
        swap_((header.encoding == Encoding::big_endian) != (std::endian::native == std::endian::big)),
        words_(std::string_view(file.bytes).substr(header.body)),
        at_(file.bytes.data() + header.body),
        end_(file.bytes.data() + file.bytes.size()) {}

  /// Fails if an element can't be as large as it says, before anything is set aside for it.
  void check_room(const Element& element) const {
    std::size_t least = 0;  // a text value takes two characters, the last of all perhaps one
    for (const Property& p : element.properties) least += text_ ? 2 : size_of(p.is_list ? p.count_type : p.type);
    const std::size_t room = file_.bytes.size() - static_cast<std::size_t>(at_ - file_.bytes.data()) + 1;
    if (least > 0 && element.count > room / least)
      file_.fail("the header promises " + std::to_string(element.count) + " of element " + shown(element.name) +
                 ", but the whole file has " + std::to_string(file_.bytes.size()) +
                 " bytes; it is cut short or damaged");
  }
  double number(Scalar type, const Element& element, std::size_t row) {
    if (text_) {
      const std::string_view word = next_word(element, row);
      const auto value = to_number(word);
      if (!value) wrong(word, element, row);
      return *value;
    }
    const char* p = take(size_of(type), element, row);
    if (type == Scalar::f32) return load<float>(p);
    if (type == Scalar::f64) return load<double>(p);
    return static_cast<double>(whole(type, p));
  }
  std::int64_t integer(Scalar type, const Element& element, std::size_t row) {
    if (text_) {
      const std::string_view word = next_word(element, row);
      const auto value = to_integer(word);
      if (!value) wrong(word, element, row);
      return *value;
    }
    return whole(type, take(size_of(type), element, row));
  }
  void skip(Scalar type, const Element& element, std::size_t row) {
    if (text_) {
      next_word(element, row);
    } else {
      take(size_of(type), element, row);
    }
  }
  std::int64_t list_count(const Property& property, const Element& element, std::size_t row) {
    const std::int64_t count = integer(property.count_type, element, row);
    const auto room = static_cast<std::int64_t>(text_ ? file_.bytes.size() : static_cast<std::size_t>(end_ - at_));
    if (count < 0 || count > room)
      file_.fail(place(element, row) + " promises a list of " + std::to_string(count) +
                 " values, more than the file holds; it is damaged");
    return count;
  }

 private:
  template <class T>
  T load(const char* p) const {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), p, sizeof(T));
    if (swap_)
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    return std::bit_cast<T>(bytes);
  }
  [[nodiscard]] std::int64_t whole(Scalar type, const char* p) const {
    switch (type) {
      case Scalar::i8:
        return load<std::int8_t>(p);
      case Scalar::u8:
        return load<std::uint8_t>(p);
      case Scalar::i16:
        return load<std::int16_t>(p);
      case Scalar::u16:
        return load<std::uint16_t>(p);
      case Scalar::i32:
        return load<std::int32_t>(p);
      default:
        return load<std::uint32_t>(p);
    }
  }
  std::string_view next_word(const Element& element, std::size_t row) {
    const std::string_view word = words_.next();
    if (word.empty()) cut_short(element, row);
    return word;
  }
  const char* take(std::size_t size, const Element& element, std::size_t row) {
    if (static_cast<std::size_t>(end_ - at_) < size) cut_short(element, row);
    return std::exchange(at_, at_ + size);
  }
  static std::string place(const Element& element, std::size_t row) {
    return element.name + " " + std::to_string(row) + " (the first is 0)";
  }
  [[noreturn]] void cut_short(const Element& element, std::size_t row) const {
    file_.fail("it ends within " + place(element, row) + " of " + std::to_string(element.count) +
               "; it is cut short or damaged");
  }
  [[noreturn]] void wrong(std::string_view word, const Element& element, std::size_t row) const {
    file_.fail_at(word.data(), "expected a number for " + place(element, row) + ", got " + shown(word));
  }

  const FileText& file_;
  bool text_, swap_;
  Words words_;
  const char* at_;
  const char* end_;
};

void skip_element(const Element& element, Values& values, Job& job) {
  if (element.properties.empty()) return;
  for (std::size_t row = 0; row < element.count; ++row) {
    if (row % kPollEvery == 0) job.poll();
    for (const Property& p : element.properties) {
      const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
      for (std::int64_t i = 0; i < count; ++i) values.skip(p.type, element, row);
    }
  }
}

void read_vertices(const FileText& file, const Element& element, Values& values, SoupBuilder& soup, Job& job) {
  const std::array<int, 3> axes{element.find("x"), element.find("y"), element.find("z")};
  for (const int axis : axes)
    if (axis < 0 || element.properties[static_cast<std::size_t>(axis)].is_list)
      file.fail("the PLY vertices have no x, y and z");
  for (std::size_t row = 0; row < element.count; ++row) {
    if (row % kPollEvery == 0) job.poll();
    Vec3 place = Vec3::Zero();
    for (int i = 0; const Property& p : element.properties) {
      if (p.is_list) {
        for (std::int64_t count = values.list_count(p, element, row); count > 0; --count)
          values.skip(p.type, element, row);
      } else if (i == axes[0] || i == axes[1] || i == axes[2]) {
        place[i == axes[0] ? 0 : i == axes[1] ? 1 : 2] = values.number(p.type, element, row);
      } else {
        values.skip(p.type, element, row);
      }
      ++i;
    }
    soup.add_vertex(place);
  }
}

/// Which property of faces or strips lists their vertices.
int list_of_corners(const FileText& file, const Element& element, const char* what) {
  const int named = element.find("vertex_indices"), corners = named >= 0 ? named : element.find("vertex_index");
  const auto usable = [&](const Property& p) { return p.is_list && p.type < Scalar::f32; };
  if (element.count > 0 && (corners < 0 || !usable(element.properties[static_cast<std::size_t>(corners)])))
    file.fail(std::string("the PLY ") + what + " have no list of whole numbers called vertex_indices or vertex_index");
  return corners;
}

void read_faces(const FileText& file, const Element& element, Values& values, SoupBuilder& soup, Job& job) {
  const int corners = list_of_corners(file, element, "faces");
  for (std::size_t row = 0; row < element.count; ++row) {
    if (row % kPollEvery == 0) job.poll();
    soup.begin_polygon();
    for (int i = 0; const Property& p : element.properties) {
      const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
      for (std::int64_t k = 0; k < count; ++k)
        if (i == corners) {
          soup.add_corner(values.integer(p.type, element, row));
        } else {
          values.skip(p.type, element, row);
        }
      ++i;
    }
  }
}

/// Makes triangles of strips: each vertex from the third on makes one with the two before, turned over every second
/// time; -1 ends a strip. A vertex that comes twice in a row only turns the strip: it makes no triangle.
class Strips {
 public:
  explicit Strips(SoupBuilder& soup) : soup_(soup) {}
  void end() { held_ = 0; }
  void add(std::int64_t vertex) {
    if (held_ >= 2 && first_ != second_ && second_ != vertex && vertex != first_) {
      soup_.begin_polygon();
      soup_.add_corner(held_ % 2 == 0 ? first_ : second_);
      soup_.add_corner(held_ % 2 == 0 ? second_ : first_);
      soup_.add_corner(vertex);
    }
    first_ = std::exchange(second_, vertex);
    ++held_;
  }

 private:
  SoupBuilder& soup_;
  std::int64_t first_ = 0, second_ = 0, held_ = 0;
};

void read_strips(const FileText& file, const Element& element, Values& values, SoupBuilder& soup, Job& job) {
  const int corners = list_of_corners(file, element, "triangle strips");
  std::size_t done = 0;
  for (std::size_t row = 0; row < element.count; ++row) {
    Strips strips(soup);
    for (int i = 0; const Property& p : element.properties) {
      const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
      for (std::int64_t k = 0; k < count; ++k) {
        if (done++ % kPollEvery == 0) job.poll();
        if (i != corners) {
          values.skip(p.type, element, row);
          continue;
        }
        const std::int64_t vertex = values.integer(p.type, element, row);
        const bool ends = vertex == -1 || (p.type == Scalar::u32 && vertex == 0xffffffff);
        if (ends) {
          strips.end();
        } else {
          strips.add(vertex);
        }
      }
      ++i;
    }
  }
}

/// How many elements there are up to the last one that holds what is wanted; what comes after is not looked at.
std::size_t wanted_elements(const Header& header) {
  std::size_t wanted = 0;
  for (std::size_t i = 0; i < header.elements.size(); ++i)
    if (const std::string& name = header.elements[i].name; name == "vertex" || name == "face" || name == "tristrips")
      wanted = i + 1;
  return wanted;
}

}  // namespace

PolygonSoup read_ply(const FileText& file, Job& job) {
  const Header header = read_header(file);
  Values values(file, header);
  SoupBuilder soup(file);
  bool vertices = false, faces = false;
  for (const Element& element : std::span(header.elements).first(wanted_elements(header))) {
    values.check_room(element);
    if (element.name == "vertex" && !vertices) {
      vertices = true;
      soup.reserve(element.count, 0);
      read_vertices(file, element, values, soup, job);
    } else if (element.name == "face" && !faces) {
      faces = true;
      soup.reserve(0, element.count);
      read_faces(file, element, values, soup, job);
    } else if (element.name == "tristrips") {
      read_strips(file, element, values, soup, job);
    } else {
      skip_element(element, values, job);
    }
  }
  if (!vertices) file.fail("the PLY header has no vertex element");
  return soup.finish(0, job);
}

}  // namespace isimp::detail
