// Reads plain OBJ files part by part on all threads.
#include <numeric>
#include <span>
#include <string_view>
#include <vector>

#include "files/formats.h"

namespace isimp::detail {
namespace {

/// Numbers of things of each kind in a part of the file, or before it.
struct Counts {
  std::size_t vertices = 0, faces = 0, corners = 0;

  friend Counts operator+(const Counts& a, const Counts& b) {
    return {a.vertices + b.vertices, a.faces + b.faces, a.corners + b.corners};
  }
};

bool begins(std::string_view line, char keyword) {
  return line.size() > 1 && line[0] == keyword && (line[1] == ' ' || line[1] == '\t');
}

/// Whether a line that is no plain vertex or face is none at all.
bool means_nothing(std::string_view line) {
  if (line.empty() || line == "\r") return true;
  if (line[0] <= ' ' || line.substr(0, 2) == "fo") return false;
  return (line[0] != 'v' && line[0] != 'f') || (line.size() > 1 && line[1] > ' ');
}

/// Whether the words of a line are all that counts in it: no continued line, no other ends of lines.
bool is_plain(std::string_view text) {
  if (text.find('\\') != std::string_view::npos) return false;
  for (std::size_t at = text.find('\r'); at != std::string_view::npos; at = text.find('\r', at + 1))
    if (at + 1 < text.size() && text[at + 1] != '\n') return false;
  return true;
}

/// Counts the content of whole lines; false if one of them is not plain.
bool count_lines(std::string_view text, Counts& counts) {
  return is_plain(text) && for_each_line(text, [&](std::string_view line) {
           if (begins(line, 'v')) {
             ++counts.vertices;
             return true;
           }
           if (!begins(line, 'f')) return means_nothing(line);
           ++counts.faces;
           Words words(line.substr(1));
           for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
             if (word[0] == '#') return false;
             ++counts.corners;
           }
           return true;
         });
}

bool read_vertex(std::string_view line, Vec3& place) {
  Words words(line.substr(1));
  for (double& coordinate : place) {
    const auto value = to_number(words.next());
    if (!value) return false;
    coordinate = *value;
  }
  return true;
}

/// The arrays that are filled.
struct Arrays {
  std::span<Vec3> vertices;
  SoupBuilder::Polygons polygons;
};

/// The ends prevent writes outside the arrays if the file changes meanwhile.
bool read_corners(std::string_view line, const Arrays& arrays, Counts& at, const Counts& end) {
  if (at.faces == end.faces) return false;
  arrays.polygons.starts[at.faces++] = static_cast<std::int32_t>(at.corners);
  Words words(line.substr(1));
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    const auto number = to_integer(word.substr(0, word.find('/')));
    if (!number || *number <= 0 || at.corners == end.corners) return false;
    arrays.polygons.corners[at.corners++] = SoupBuilder::corner(*number - 1);
  }
  return true;
}

/// Reads whole lines; false if one of them is damaged, or if they differ from the counted ones.
bool read_lines(std::string_view text, const Arrays& arrays, Counts at, const Counts& end) {
  const bool fine = for_each_line(text, [&](std::string_view line) {
    if (begins(line, 'v')) return at.vertices < end.vertices && read_vertex(line, arrays.vertices[at.vertices++]);
    return !begins(line, 'f') || read_corners(line, arrays, at, end);
  });
  return fine && at.vertices == end.vertices && at.faces == end.faces && at.corners == end.corners;
}

}  // namespace

std::optional<PolygonSoup> read_plain_obj(const FileParts& parts, const Threads& threads, Job& job) {
  const std::vector<std::size_t> edges = line_parts(parts, 0, job);
  if (edges.empty()) return {};
  std::vector<Counts> counts(edges.size());  // counts of each part; then of all parts before it, the last one of all
                                             // parts
  {
    const Job::Stage counting(job, "reading", 0.0, 0.2);
    if (!for_each_part(parts, edges, threads, job,
                       [&](std::size_t i, std::string_view text) { return count_lines(text, counts[i]); }))
      return {};
  }
  std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), Counts{});
  const Counts& all = counts.back();
  SoupBuilder soup(parts.file(), threads);
  if (all.vertices == 0 || !soup.has_room(all.vertices, all.faces, all.corners)) return {};
  const Arrays arrays{soup.add_vertices(all.vertices), soup.add_mixed_polygons(all.faces, all.corners)};
  const Job::Stage reading(job, "reading", 0.2, 1.0);
  if (!for_each_part(parts, edges, threads, job, [&](std::size_t i, std::string_view text) {
        return read_lines(text, arrays, counts[i], counts[i + 1]);
      }))
    return {};
  return soup.finish(1, job);
}

}  // namespace isimp::detail
