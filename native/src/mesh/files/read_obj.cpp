// Reads OBJ files that the plain reader leaves.
#include "files/formats.h"
#include "surface/edge_groups.h"

namespace isimp::detail {
namespace {

void read_vertex(const FileText& file, std::string_view line, Words& words, SoupBuilder& soup) {
  Vec3 place;
  for (double& coordinate : place) {
    const std::string_view word = words.next();
    const auto value = to_number(word);
    if (!value) file.fail_at(line.data(), "expected three coordinates after \"v\", got " + shown(word));
    coordinate = *value;
  }
  soup.add_vertex(place);
}

/// Corners are "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal"; numbers count from 1, or
/// backwards from the latest vertex if negative.
void read_face(const FileText& file, std::string_view line, Words& words, SoupBuilder& soup) {
  soup.begin_polygon();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word.starts_with('#')) return;
    const auto number = to_integer(word.substr(0, word.find('/')));
    if (!number || *number == 0)
      file.fail_at(line.data(), "expected the number of a vertex (1 is the first), got " + shown(word));
    const auto count = static_cast<std::int64_t>(soup.vertices().size());
    if (*number < -count)
      file.fail_at(line.data(),
                   "vertex " + shown(word) + " lies before the first, there are " + std::to_string(count) + " so far");
    soup.add_corner(*number > 0 ? *number - 1 : count + *number);
  }
}

}  // namespace

PolygonSoup read_obj(const FileText& file, Columns* /*columns*/, const Threads& threads, Job& job) {
  SoupBuilder soup(file, threads);
  Lines lines(file.text());
  std::string_view line;
  std::string joined;  // lines that end in a backslash, joined
  for (std::size_t row = 0; lines.next(line); ++row) {
    if (row % kPollEvery == 0) job.poll();
    std::string_view whole = line;
    if (line.ends_with('\\')) {
      joined.clear();
      std::string_view part = line;
      while (part.ends_with('\\')) {
        joined.append(part.substr(0, part.size() - 1)).push_back(' ');
        if (!lines.next(part)) break;
      }
      whole = joined.append(part.ends_with('\\') ? std::string_view() : part);
    }
    Words words(whole);
    const std::string_view keyword = words.next();
    if (keyword == "v") {
      read_vertex(file, line, words, soup);
    } else if (keyword == "f" || keyword == "fo") {
      read_face(file, line, words, soup);
    }
  }
  PolygonSoup result = soup.finish(1, job);
  if (result.vertices.empty()) file.fail("it has no line that begins with \"v \", as an OBJ file does");
  return result;
}

}  // namespace isimp::detail
