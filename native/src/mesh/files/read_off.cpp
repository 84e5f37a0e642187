// Reads OFF files.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "files/formats.h"
#include "surface/edge_groups.h"

namespace isimp::detail {
namespace {

/// The lines with content: without comments, and not blank.
class OffLines {
 public:
  explicit OffLines(const FileText& file) : file_(file), lines_(file.text()) {}
  /// \param number  of the vertex or face wanted, if it is one
  std::string_view next(const char* wanted, std::size_t number = kNoNumber) {
    std::string_view line;
    while (lines_.next(line)) {
      line = line.substr(0, line.find('#'));
      if (!Words(line).next().empty()) return line;
    }
    std::string what = "it ends where ";
    what += wanted;
    if (number != kNoNumber) what.append(" ").append(std::to_string(number));
    file_.fail(what + " should be; it is cut short or damaged");
  }

 private:
  static constexpr std::size_t kNoNumber = ~std::size_t{0};  // format
  const FileText& file_;
  Lines lines_;
};

struct Counts {
  std::size_t vertices, faces;
};

/// The first word is OFF, perhaps after letters for further data of each vertex: ST, C, N.
/// \param skipped  these letters
void check_kind(const FileText& file, std::string_view word, std::vector<std::string>& skipped) {
  std::string_view rest = word;
  for (const std::string_view letters : {"ST", "C", "N"})
    if (rest.starts_with(letters)) {
      rest.remove_prefix(letters.size());
      skipped.emplace_back(letters);
    }
  if (rest == "4OFF" || rest == "nOFF" || rest == "4nOFF")
    file.fail("its vertices are not in three dimensions (" + shown(word) + "), which is not supported");
  if (rest != "OFF") file.fail("it does not begin with \"OFF\", as an OFF file does; is it in another format?");
}

Counts read_counts(const FileText& file, OffLines& lines, std::vector<std::string>& skipped) {
  std::string_view line = lines.next("the word OFF");
  Words words(line);
  check_kind(file, words.next(), skipped);
  std::string_view word = words.next();
  if (word == "BINARY") file.fail("it is a binary OFF file, which is not supported; save it as text or as PLY");
  if (word.empty()) {
    line = lines.next("the number of vertices and faces");
    words = Words(line);
    word = words.next();
  }
  const auto vertices = to_whole_number(word), faces = to_whole_number(words.next());
  if (!vertices || !faces || *vertices < 0 || *faces < 0)
    file.fail_at(line.data(), "expected the number of vertices and of faces");
  const auto size = static_cast<std::int64_t>(file.bytes.size());
  if (*vertices > size / 6 || *faces > size / 2)  // the shortest lines: "0 0 0" and "0"
    file.fail("it promises " + std::to_string(*vertices) + " vertices and " + std::to_string(*faces) +
              " faces, but has " + std::to_string(size) + " bytes; it is cut short or damaged");
  return {static_cast<std::size_t>(*vertices), static_cast<std::size_t>(*faces)};
}

}  // namespace

PolygonSoup read_off(const FileText& file, Columns* columns, const Threads& threads, Job& job) {
  OffLines lines(file);
  std::vector<std::string> skipped;
  const Counts counts = read_counts(file, lines, skipped);
  bool face_colors = false;
  SoupBuilder soup(file, threads);
  soup.reserve(counts.vertices, counts.faces);
  for (std::size_t v = 0; v < counts.vertices; ++v) {
    if (v % kPollEvery == 0) job.poll();
    const std::string_view line = lines.next("vertex", v);
    Words words(line);
    Vec3 place;
    for (double& coordinate : place) {
      const std::string_view word = words.next();
      const auto value = to_number(word);
      if (!value)
        file.fail_at(line.data(),
                     "expected three coordinates for vertex " + std::to_string(v) + ", got " + shown(word));
      coordinate = *value;
    }
    soup.add_vertex(place);
  }
  for (std::size_t f = 0; f < counts.faces; ++f) {
    if (f % kPollEvery == 0) job.poll();
    const std::string_view line = lines.next("face", f);
    Words words(line);
    const auto corners = to_whole_number(words.next());
    if (!corners || *corners < 0)
      file.fail_at(line.data(), "expected the number of corners of face " + std::to_string(f));
    soup.begin_polygon();
    for (std::int64_t k = 0; k < *corners; ++k) {
      const std::string_view word = words.next();
      const auto vertex = to_whole_number(word);
      if (!vertex)
        file.fail_at(line.data(), "expected " + std::to_string(*corners) + " vertices for face " + std::to_string(f) +
                                      ", got " + shown(word));
      soup.add_corner(*vertex);
    }
    face_colors = face_colors || !words.next().empty();
  }
  if (face_colors && std::ranges::find(skipped, "C") == skipped.end()) skipped.emplace_back("C");
  if (columns != nullptr) columns->skipped = std::move(skipped);
  return soup.finish(0, job);
}

}  // namespace isimp::detail
