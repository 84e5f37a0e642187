// Reads plain PLY files part by part on all threads.
#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <string_view>
#include <vector>

#include "files/formats.h"
#include "files/ply_header.h"
#include "files/ply_rows.h"

namespace isimp::detail {
namespace {

constexpr std::size_t kHead = std::size_t{1} << 16;  // bytes in which a header must end

/// A file of vertices and then faces.
struct Layout {
  PlyHeader header;
  PlyElement vertex, face;  ///< no faces where the file has none
  std::array<int, 3> axes{};
  std::size_t corners = 0;  ///< the property of faces that lists their vertices
};

std::optional<PlyHeader> read_head(const FileParts& parts) {
  FileText head{parts.file().name, {}};
  FileParts::Reader reader(parts);  // holds the bytes
  const std::string_view bytes = reader.bytes(0, std::min(kHead, parts.size()));
  head.bytes.assign(bytes.begin(), bytes.end());
  try {
    PlyHeader header = read_ply_header(head);
    if (header.body == head.bytes.size()) return {};  // half of the line's end may follow
    return header;
  } catch (const FileError&) {
    return {};
  }
}

std::optional<Layout> layout_of(const FileParts& parts) {
  std::optional<PlyHeader> header = read_head(parts);
  if (!header) return {};
  const std::size_t wanted = header->wanted_elements();
  const std::vector<PlyElement>& elements = header->elements;
  if (wanted < 1 || wanted > 2 || elements[0].name != "vertex") return {};
  Layout layout{*header, elements[0], {}, {}, 0};
  layout.axes = {layout.vertex.find("x"), layout.vertex.find("y"), layout.vertex.find("z")};
  for (const int axis : layout.axes)
    if (axis < 0) return {};
  for (const PlyProperty& p : layout.vertex.properties)
    if (p.is_list) return {};
  if (wanted == 1) return layout;
  if (elements[1].name != "face") return {};
  layout.face = elements[1];
  if (layout.face.count == 0) return layout;
  if (layout.face.find_corners() < 0) return {};
  layout.corners = static_cast<std::size_t>(layout.face.find_corners());
  return layout;
}

/// Faces first: files with faces of various sizes are soon recognised.
std::optional<PolygonSoup> read_binary(const FileParts& parts, const Layout& layout, const Threads& threads, Job& job) {
  const std::size_t row = *bytes_of_row(layout.vertex), body = layout.header.body;
  if ((parts.size() - body) / row < layout.vertex.count) return {};
  SoupBuilder soup(parts.file(), threads);
  PlyBytes bytes{parts, body + row * layout.vertex.count, layout.header.swaps()};
  if (layout.face.count > bytes.size()) return {};
  if (layout.face.count > 0) {
    const Job::Stage stage(job, "reading", 0.0, 0.5);
    const PlyRows read = read_face_rows(bytes, layout.face, layout.corners, layout.face.count, soup, threads, job);
    if (read.rows != layout.face.count) return {};
  }
  bytes.begin = body;
  const Job::Stage stage(job, "reading", 0.5, 1.0);
  if (read_vertex_rows(bytes, layout.vertex, layout.axes, soup, threads, job) != row * layout.vertex.count) return {};
  return soup.finish(0, job);
}

/// Reads lines of text, each of which is a row.
class TextRows {
 public:
  TextRows(const FileParts& parts, const Layout& layout, const Threads& threads, Job& job)
      : parts_(parts), layout_(layout), threads_(threads), job_(job), soup_(parts.file(), threads) {}

  std::optional<PolygonSoup> read() {
    edges_ = line_parts(parts_, layout_.header.body, job_);
    if (edges_.empty() || !count_rows() || !count_corners()) return {};
    vertices_ = soup_.add_vertices(layout_.vertex.count);
    polygons_ = soup_.add_mixed_polygons(layout_.face.count, corners_.back());
    const Job::Stage stage(job_, "reading", 0.3, 1.0);
    if (!for_each_part(parts_, edges_, threads_, job_,
                       [&](std::size_t i, std::string_view text) { return read_part(i, text); }))
      return {};
    return soup_.finish(0, job_);
  }

 private:
  [[nodiscard]] std::size_t rows() const { return layout_.vertex.count + layout_.face.count; }
  /// Replaces the numbers of parts by the sums of all parts before each.
  static void add_up(std::vector<std::size_t>& numbers) {
    std::exclusive_scan(numbers.begin(), numbers.end(), numbers.begin(), std::size_t{0});
  }
  bool count_rows() {
    const Job::Stage stage(job_, "reading", 0.0, 0.1);
    rows_.assign(edges_.size(), 0);
    for_each_part(parts_, edges_, threads_, job_, [&](std::size_t i, std::string_view text) {
      rows_[i] = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + (text.back() == '\n' ? 0 : 1);
      return true;
    });
    add_up(rows_);
    return rows_.back() >= layout_.vertex.count && rows_.back() - layout_.vertex.count >= layout_.face.count;
  }
  bool count_corners() {
    const Job::Stage stage(job_, "reading", 0.1, 0.3);
    corners_.assign(edges_.size(), 0);
    const bool fine = for_each_part(parts_, edges_, threads_, job_, [&](std::size_t i, std::string_view text) {
      if (rows_[i + 1] <= layout_.vertex.count || rows_[i] >= rows()) return true;
      std::size_t row = rows_[i];
      return for_each_line(text, [&](std::string_view line) {
        const std::size_t own = row++;
        if (own < layout_.vertex.count || own >= rows()) return true;
        const std::optional<std::size_t> corners = corners_of(line);
        corners_[i] += corners.value_or(0);
        return corners.has_value();
      });
    });
    add_up(corners_);
    return fine && soup_.has_room(layout_.vertex.count, layout_.face.count, corners_.back());
  }
  /// The number of corners that a face's line promises; nothing if the line is too short for them.
  [[nodiscard]] std::optional<std::size_t> corners_of(std::string_view line) const {
    Words words(line);
    for (std::size_t i = 0; i < layout_.corners; ++i) {
      const PlyProperty& p = layout_.face.properties[i];
      const std::string_view word = words.next();
      const auto count = p.is_list ? to_integer(word) : 0;
      if (!count || *count < 0 || *count > static_cast<std::int64_t>(line.size())) return {};
      for (std::int64_t k = 0; k < *count; ++k) words.next();
    }
    const auto corners = to_integer(words.next());
    if (!corners || *corners < 0 || *corners > static_cast<std::int64_t>(line.size())) return {};
    return static_cast<std::size_t>(*corners);
  }
  /// The numbers of rows and corners keep a file that is written meanwhile from places outside the arrays.
  bool read_part(std::size_t i, std::string_view text) {
    std::size_t row = rows_[i], corner = corners_[i];
    const bool fine = for_each_line(text, [&](std::string_view line) {
      if (row >= rows()) return true;
      if (row == rows_[i + 1]) return false;
      const std::size_t own = row++;
      if (own < layout_.vertex.count) return read_vertex(line, vertices_[own]);
      polygons_.starts[own - layout_.vertex.count] = static_cast<std::int32_t>(corner);
      return read_face(line, corner, corners_[i + 1]);
    });
    return fine && row == std::max(rows_[i], std::min(rows(), rows_[i + 1])) && corner == corners_[i + 1];
  }
  bool read_vertex(std::string_view line, Vec3& place) const {
    Words words(line);
    for (int i = 0; i < static_cast<int>(layout_.vertex.properties.size()); ++i) {
      const std::string_view word = words.next();
      if (word.empty()) return false;
      for (std::size_t k = 0; k < 3; ++k) {
        if (i != layout_.axes[k]) continue;
        const auto value = to_number(word);
        if (!value) return false;
        place[static_cast<int>(k)] = *value;
      }
    }
    return words.next().empty();
  }
  bool read_face(std::string_view line, std::size_t& corner, std::size_t end) const {
    Words words(line);
    for (std::size_t i = 0; i < layout_.face.properties.size(); ++i) {
      const bool is_list = layout_.face.properties[i].is_list;
      const auto count = is_list ? to_integer(words.next()) : 1;
      if (!count || *count < 0) return false;
      for (std::int64_t k = 0; k < *count; ++k) {
        const std::string_view word = words.next();
        if (word.empty()) return false;
        if (i != layout_.corners) continue;
        const auto vertex = to_integer(word);
        if (!vertex || corner == end) return false;
        polygons_.corners[corner++] = SoupBuilder::corner(*vertex);
      }
    }
    return words.next().empty();
  }

  const FileParts& parts_;
  const Layout& layout_;
  const Threads& threads_;
  Job& job_;
  SoupBuilder soup_;
  std::vector<std::size_t> edges_, rows_, corners_;  // start of each part; rows and corners before it
  std::span<Vec3> vertices_;
  SoupBuilder::Polygons polygons_;
};

}  // namespace

std::optional<PolygonSoup> read_plain_ply(const FileParts& parts, const Threads& threads, Job& job) {
  const std::optional<Layout> layout = layout_of(parts);
  if (!layout) return {};
  if (layout->header.encoding != PlyEncoding::text) return read_binary(parts, *layout, threads, job);
  return TextRows(parts, *layout, threads, job).read();
}

}  // namespace isimp::detail
