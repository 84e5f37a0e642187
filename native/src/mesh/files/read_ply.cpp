// Reads PLY files.
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "files/formats.h"
#include "files/ply_header.h"
#include "files/ply_rows.h"
#include "surface/edge_groups.h"

namespace isimp::detail {
namespace {

/// Reads values from text or from bytes of either order.
class Values {
 public:
  Values(const FileText& file, const PlyHeader& header)
      : file_(file),
        text_(header.encoding == PlyEncoding::text),
        swap_(header.swaps()),
        words_(file.text().substr(header.body)),
        at_(file.bytes.data() + header.body),
        end_(file.bytes.data() + file.bytes.size()) {}

  /// Fails if the file is too short for an element, before memory is allocated for it.
  void check_room(const PlyElement& element) const {
    std::size_t least = 0;  // a text value takes two characters, the last of all perhaps one
    for (const PlyProperty& p : element.properties) least += text_ ? 2 : size_of(p.is_list ? p.count_type : p.type);
    const std::size_t room = file_.bytes.size() - static_cast<std::size_t>(at_ - file_.bytes.data()) + 1;
    if (least > 0 && element.count > room / least)
      file_.fail("the header promises " + std::to_string(element.count) + " of element " + shown(element.name) +
                 ", but the whole file has " + std::to_string(file_.bytes.size()) +
                 " bytes; it is cut short or damaged");
  }
  /// The unread rest of a binary file; empty for a text file.
  [[nodiscard]] PlyBytes bytes() const {
    return {text_ ? std::string_view() : std::string_view(at_, static_cast<std::size_t>(end_ - at_)), swap_};
  }
  /// Skips bytes that were read elsewhere.
  void pass(std::size_t bytes) { at_ += bytes; }
  double number(PlyScalar type, const PlyElement& element, std::size_t row) {
    if (text_) {
      const std::string_view word = next_word(element, row);
      const auto value = to_number(word);
      if (!value) wrong(word, element, row);
      return *value;
    }
    const char* p = take(size_of(type), element, row);
    if (type == PlyScalar::f32) return load<float>(p);
    if (type == PlyScalar::f64) return load<double>(p);
    return static_cast<double>(whole(type, p));
  }
  std::int64_t integer(PlyScalar type, const PlyElement& element, std::size_t row) {
    if (text_) {
      const std::string_view word = next_word(element, row);
      const auto value = to_whole_number(word);
      if (!value) wrong(word, element, row);
      return *value;
    }
    return whole(type, take(size_of(type), element, row));
  }
  void skip(PlyScalar type, const PlyElement& element, std::size_t row) {
    if (text_) {
      next_word(element, row);
    } else {
      take(size_of(type), element, row);
    }
  }
  std::int64_t list_count(const PlyProperty& property, const PlyElement& element, std::size_t row) {
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
    return load_number<T>(p, swap_);
  }
  [[nodiscard]] std::int64_t whole(PlyScalar type, const char* p) const {
    switch (type) {
      case PlyScalar::i8:
        return load<std::int8_t>(p);
      case PlyScalar::u8:
        return load<std::uint8_t>(p);
      case PlyScalar::i16:
        return load<std::int16_t>(p);
      case PlyScalar::u16:
        return load<std::uint16_t>(p);
      case PlyScalar::i32:
        return load<std::int32_t>(p);
      default:
        return load<std::uint32_t>(p);
    }
  }
  std::string_view next_word(const PlyElement& element, std::size_t row) {
    const std::string_view word = words_.next();
    if (word.empty()) cut_short(element, row);
    return word;
  }
  const char* take(std::size_t size, const PlyElement& element, std::size_t row) {
    if (static_cast<std::size_t>(end_ - at_) < size) cut_short(element, row);
    return std::exchange(at_, at_ + size);
  }
  static std::string place(const PlyElement& element, std::size_t row) {
    return element.name + " " + std::to_string(row) + " (the first is 0)";
  }
  [[noreturn]] void cut_short(const PlyElement& element, std::size_t row) const {
    file_.fail("it ends within " + place(element, row) + " of " + std::to_string(element.count) +
               "; it is cut short or damaged");
  }
  [[noreturn]] void wrong(std::string_view word, const PlyElement& element, std::size_t row) const {
    file_.fail_at(word.data(), "expected a number for " + place(element, row) + ", got " + shown(word));
  }

  const FileText& file_;
  bool text_, swap_;
  Words words_;
  const char* at_;
  const char* end_;
};

void skip_element(const PlyElement& element, Values& values, Job& job) {
  if (element.properties.empty()) return;
  for (std::size_t row = 0; row < element.count; ++row) {
    if (row % kPollEvery == 0) job.poll();
    for (const PlyProperty& p : element.properties) {
      const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
      for (std::int64_t i = 0; i < count; ++i) values.skip(p.type, element, row);
    }
  }
}

/// For each property of an element where its values go, or null to skip them.
using Targets = std::vector<std::vector<double>*>;

bool has_any(const Targets& targets) {
  return std::ranges::any_of(targets, [](const auto* target) { return target != nullptr; });
}

/// Adds the columns of an element that are wanted.
Targets add_columns(const PlyElement& element, const std::vector<std::string>& names, std::vector<Column>& columns) {
  Targets targets(element.properties.size());
  columns.reserve(targets.size());  // the targets are members of its items
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const PlyProperty& p = element.properties[i];
    if (p.is_list || std::ranges::find(names, p.name) == names.end()) continue;
    targets[i] = &columns.emplace_back(Column{p.name, std::string(kind_of(p.type)), {}}).values;
    targets[i]->reserve(element.count);
  }
  return targets;
}

void read_vertices(const FileText& file, const PlyElement& element, Values& values, Columns& columns, SoupBuilder& soup,
                   const Threads& threads, Job& job) {
  const std::array<int, 3> axes{element.find("x"), element.find("y"), element.find("z")};
  for (const int axis : axes)
    if (axis < 0 || element.properties[static_cast<std::size_t>(axis)].is_list)
      file.fail("the PLY vertices have no x, y and z");
  const Targets targets = add_columns(element, columns.names, columns.vertices);
  if (!has_any(targets))
    if (const std::size_t read = read_vertex_rows(values.bytes(), element, axes, soup, threads, job); read > 0)
      return values.pass(read);
  for (std::size_t row = 0; row < element.count; ++row) {
    if (row % kPollEvery == 0) job.poll();
    Vec3 place = Vec3::Zero();
    for (int i = 0; const PlyProperty& p : element.properties) {
      if (p.is_list) {
        for (std::int64_t count = values.list_count(p, element, row); count > 0; --count)
          values.skip(p.type, element, row);
      } else if (i == axes[0] || i == axes[1] || i == axes[2]) {
        place[i == axes[0] ? 0 : i == axes[1] ? 1 : 2] = values.number(p.type, element, row);
      } else if (auto* target = targets[static_cast<std::size_t>(i)]; target != nullptr) {
        target->push_back(values.number(p.type, element, row));
      } else {
        values.skip(p.type, element, row);
      }
      ++i;
    }
    soup.add_vertex(place);
  }
}

/// The property of faces or strips that lists their vertices.
int list_of_corners(const FileText& file, const PlyElement& element, const char* what) {
  const int corners = element.find_corners();
  if (element.count > 0 && corners < 0)
    file.fail(std::string("the PLY ") + what + " have no list of whole numbers called vertex_indices or vertex_index");
  return corners;
}

void read_face(const PlyElement& element, std::size_t row, int corners, const Targets& targets, Values& values,
               SoupBuilder& soup) {
  soup.begin_polygon();
  for (int i = 0; const PlyProperty& p : element.properties) {
    const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
    for (std::int64_t k = 0; k < count; ++k)
      if (i == corners) {
        soup.add_corner(values.integer(p.type, element, row));
      } else if (auto* target = targets[static_cast<std::size_t>(i)]; target != nullptr) {
        target->push_back(values.number(p.type, element, row));
      } else {
        values.skip(p.type, element, row);
      }
    ++i;
  }
}

/// Checks the texture coordinates of a face, and adds zeros if it has none.
/// \param before  how many numbers the faces before it have
void finish_uv(const FileText& file, std::size_t row, std::size_t before, std::size_t corners,
               std::vector<double>& uv) {
  const std::size_t found = uv.size() - before;
  if (found != 0 && found != 2 * corners)
    file.fail("face " + std::to_string(row) + " has " + std::to_string(found) +
              " numbers in texcoord, not two for each corner");
  uv.resize(before + 2 * corners);
}

/// Stretches of faces with the same number of corners are read together, the others one by one. After each end of a
/// stretch the next one is tried over few rows, then over more: so files without long stretches lose little.
void read_faces(const FileText& file, const PlyElement& element, Values& values, Columns& columns, SoupBuilder& soup,
                const Threads& threads, Job& job) {
  constexpr std::size_t kOneByOne = 1024, kFew = 1 << 12;  // format: rows
  const int corners = list_of_corners(file, element, "faces");
  Targets targets = add_columns(element, columns.names, columns.faces);
  if (const int list = element.find("texcoord"); !columns.names.empty() && list >= 0)
    if (const auto i = static_cast<std::size_t>(list); element.properties[i].is_list)
      targets[i] = &columns.uv.emplace();
  const bool in_stretches = !has_any(targets);
  std::size_t tried = element.count;
  for (std::size_t row = 0; row < element.count;) {
    job.poll();
    const PlyBytes bytes = values.bytes();
    if (in_stretches && !bytes.rest.empty()) {
      const PlyRows read = read_face_rows(bytes, element, static_cast<std::size_t>(corners),
                                          std::min(tried, element.count - row), soup, threads, job);
      values.pass(read.bytes);
      row += read.rows;
      tried = read.rows < tried ? kFew : 2 * tried;
    }
    for (const std::size_t end = std::min(element.count, row + kOneByOne); row < end; ++row) {
      const std::size_t corners_before = soup.corners(), uv_before = columns.uv ? columns.uv->size() : 0;
      read_face(element, row, corners, targets, values, soup);
      if (columns.uv) finish_uv(file, row, uv_before, soup.corners() - corners_before, *columns.uv);
    }
  }
}

/// Makes triangles of strips: each vertex from the third on makes one with the two before, every second one with its
/// orientation reversed; -1 ends a strip. A vertex twice in a row makes no triangle, but counts for the orientation.
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

void read_strips(const FileText& file, const PlyElement& element, Values& values, SoupBuilder& soup, Job& job) {
  const int corners = list_of_corners(file, element, "triangle strips");
  std::size_t done = 0;
  for (std::size_t row = 0; row < element.count; ++row) {
    Strips strips(soup);
    for (int i = 0; const PlyProperty& p : element.properties) {
      const std::int64_t count = p.is_list ? values.list_count(p, element, row) : 1;
      for (std::int64_t k = 0; k < count; ++k) {
        if (done++ % kPollEvery == 0) job.poll();
        if (i != corners) {
          values.skip(p.type, element, row);
          continue;
        }
        const std::int64_t vertex = values.integer(p.type, element, row);
        const bool ends = vertex == -1 || (p.type == PlyScalar::u32 && vertex == 0xffffffff);
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

/// Names of all properties and elements that are not read.
/// \param columns  with what was read
std::vector<std::string> skipped_names(const PlyHeader& header, const Columns& columns) {
  std::vector<std::string> skipped;
  const auto is_read = [](const std::vector<Column>& read, const std::string& name) {
    return std::ranges::find(read, name, &Column::name) != read.end();
  };
  for (const PlyElement& element : header.elements) {
    const bool vertex = element.name == "vertex", face = element.name == "face" || element.name == "tristrips";
    if (!vertex && !face && element.count > 0) skipped.push_back(element.name);
    if (!vertex && !face) continue;
    const int corners = element.find_corners();
    for (int i = 0; const PlyProperty& p : element.properties) {
      const bool place = vertex && (p.name == "x" || p.name == "y" || p.name == "z");
      const bool uv = face && p.name == "texcoord" && columns.uv.has_value();
      if (!place && !uv && (vertex || i != corners) && !is_read(vertex ? columns.vertices : columns.faces, p.name))
        skipped.push_back(p.name);
      ++i;
    }
  }
  return skipped;
}

}  // namespace

PolygonSoup read_ply(const FileText& file, Columns* wanted, const Threads& threads, Job& job) {
  const PlyHeader header = read_ply_header(file);
  Columns none;
  Columns& columns = wanted != nullptr ? *wanted : none;
  columns.files = header.textures;
  Values values(file, header);
  SoupBuilder soup(file, threads);
  bool vertices = false, faces = false;
  for (const PlyElement& element : std::span(header.elements).first(header.wanted_elements())) {
    values.check_room(element);
    if (element.name == "vertex" && !vertices) {
      vertices = true;
      soup.reserve(element.count, 0);
      read_vertices(file, element, values, columns, soup, threads, job);
    } else if (element.name == "face" && !faces) {
      faces = true;
      soup.reserve(0, element.count);
      read_faces(file, element, values, columns, soup, threads, job);
    } else if (element.name == "tristrips") {
      read_strips(file, element, values, soup, job);
    } else {
      skip_element(element, values, job);
    }
  }
  if (!vertices) file.fail("the PLY header has no vertex element");
  PolygonSoup result = soup.finish(0, job);
  if (columns.uv && columns.uv->size() != 2 * result.loops.size()) columns.uv.reset();  // triangles of strips have none
  std::erase_if(columns.faces, [&](const Column& c) { return c.values.size() != result.loop_start.size(); });
  columns.skipped = skipped_names(header, columns);
  return result;
}

}  // namespace isimp::detail
