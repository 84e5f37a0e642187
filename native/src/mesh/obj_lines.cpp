#include "obj_lines.h"

#include <algorithm>
#include <atomic>
#include <span>
#include <string_view>
#include <vector>

namespace isimp::detail {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;  // bytes: some milliseconds

/// Whole lines, and what is in them.
struct Chunk {
  std::string_view text;
  std::size_t vertices = 0, faces = 0;
  std::size_t first_vertex = 0, first_face = 0;
  std::size_t corners = 0;  // of each face
};

std::vector<Chunk> chunks_of(std::string_view text) {
  std::vector<Chunk> chunks;
  while (!text.empty()) {
    std::size_t end = std::min(kChunk, text.size());
    end = std::min(text.find('\n', end - 1), text.size() - 1) + 1;
    chunks.push_back({text.substr(0, end)});
    text.remove_prefix(end);
  }
  return chunks;
}

/// Calls visit(line) until it returns false.
template <class Visit>
bool for_each_line(std::string_view text, const Visit& visit) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (!visit(text.substr(0, end))) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return true;
}

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

bool count_lines(Chunk& chunk) {
  return is_plain(chunk.text) && for_each_line(chunk.text, [&](std::string_view line) {
           if (begins(line, 'v')) {
             ++chunk.vertices;
             return true;
           }
           if (!begins(line, 'f')) return means_nothing(line);
           std::size_t corners = 0;
           Words words(line.substr(1));
           for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
             if (word[0] == '#') return false;
             ++corners;
           }
           if (chunk.faces++ == 0) chunk.corners = corners;
           return corners == chunk.corners && corners > 0;
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

bool read_corners(std::string_view line, std::span<std::int32_t> corners) {
  Words words(line.substr(1));
  for (std::int32_t& corner : corners) {
    const std::string_view word = words.next();
    const auto number = to_integer(word.substr(0, word.find('/')));
    if (!number || *number <= 0) return false;
    corner = SoupBuilder::corner(*number - 1);
  }
  return true;
}

/// Calls body(chunk) for all chunks on all threads; false if one of the calls returns false.
template <class Body>
bool for_each_chunk(std::vector<Chunk>& chunks, const Threads& threads, Job& job, const Body& body) {
  std::atomic<bool> fine = true;
  const auto count = static_cast<std::int32_t>(chunks.size());
  threads.run(count, threads.pieces(count, 1), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (std::int32_t i = begin; i < end && fine; ++i) {
      job.poll();
      if (!body(chunks[i])) fine = false;
    }
  });
  return fine;
}

}  // namespace

std::optional<PolygonSoup> read_obj_lines(const FileText& file, const Threads& threads, Job& job) {
  std::vector<Chunk> chunks = chunks_of(file.text());
  if (!for_each_chunk(chunks, threads, job, count_lines)) return {};
  std::size_t vertices = 0, faces = 0, corners = 0;
  for (Chunk& chunk : chunks) {
    chunk.first_vertex = vertices;
    chunk.first_face = faces;
    vertices += chunk.vertices;
    faces += chunk.faces;
    if (chunk.faces == 0) continue;
    if (corners == 0) corners = chunk.corners;
    if (corners != chunk.corners) return {};
  }
  SoupBuilder soup(file, threads);
  if (vertices == 0 || vertices > soup.room_for_vertices() || faces > soup.room_for_polygons(corners)) return {};
  const std::span<Vec3> places = soup.add_vertices(vertices);
  const std::span<std::int32_t> loops = soup.add_polygons(faces, corners);
  const bool read = for_each_chunk(chunks, threads, job, [&](const Chunk& chunk) {
    std::size_t vertex = chunk.first_vertex, at = chunk.first_face * corners;
    return for_each_line(chunk.text, [&](std::string_view line) {
      if (begins(line, 'v')) return read_vertex(line, places[vertex++]);
      if (!begins(line, 'f')) return true;
      at += corners;
      return read_corners(line, loops.subspan(at - corners, corners));
    });
  });
  if (!read) return {};
  return soup.finish(1, job);
}

}  // namespace isimp::detail
