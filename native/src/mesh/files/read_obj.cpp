// Reads OBJ files.
#include <algorithm>
#include <array>
#include <vector>

#include "files/formats.h"
#include "surface/edge_groups.h"

namespace isimp::detail {
namespace {

constexpr std::size_t kMostSkipped = 64;  // format: keywords; a file of other content may have any number

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

/// Collects texture coordinates and colours.
class Look {
 public:
  explicit Look(const FileText& file) : file_(file) {}

  /// Reads the second number of a line "vt" as 0 where it has one only.
  void add_uv(std::string_view line, Words& words) {
    const auto u = to_number(words.next());
    const std::string_view second = words.next();
    const auto v = second.empty() ? 0.0 : to_number(second);
    if (!u || !v) file_.fail_at(line.data(), "expected two numbers after \"vt\", got " + shown(line));
    uv_.push_back({*u, *v});
  }
  /// Reads the number of the texture coordinate of a corner.
  void add_corner(std::string_view line, std::string_view word) {
    const std::size_t slash = word.find('/');
    const std::string_view rest = slash == word.npos ? std::string_view() : word.substr(slash + 1);
    const std::string_view own = rest.substr(0, rest.find_first_of("/#"));
    const auto number = own.empty() ? 0 : to_whole_number(own);
    const auto count = static_cast<std::int64_t>(uv_.size());
    if (!number || *number > 0x7fffffff || *number < -count)
      file_.fail_at(line.data(), "expected the number of a texture coordinate, got " + shown(word));
    corner_.push_back(static_cast<std::int32_t>(*number >= 0 ? *number : count + 1 + *number));
  }
  /// Reads the words behind a vertex: a colour, perhaps after a fourth coordinate.
  void add_color(Words& words) {
    std::array<double, 5> found{};
    std::size_t n = 0;
    for (std::string_view word = words.next(); !word.empty() && n < found.size(); word = words.next()) {
      const auto value = to_number(word);
      if (!value) has_colors_ = false;
      found[n++] = value.value_or(0);
    }
    has_colors_ = has_colors_ && (n == 3 || n == 4);
    for (std::size_t k = 0; k < 3 && has_colors_; ++k) colors_[k].push_back(found[n - 3 + k]);
  }
  void finish(Columns& columns) {
    auto& uv = columns.uv.emplace();
    uv.reserve(2 * corner_.size());
    for (const std::int32_t number : corner_) {
      const auto i = static_cast<std::size_t>(number);
      if (i > uv_.size())
        file_.fail("a face uses texture coordinate " + std::to_string(number) + ", but there are " +
                   std::to_string(uv_.size()));
      const std::array<double, 2> place = i == 0 ? std::array{0.0, 0.0} : uv_[i - 1];
      uv.insert(uv.end(), place.begin(), place.end());
    }
    if (has_colors_)
      columns.vertices = {{"red", "f8", std::move(colors_[0])},
                          {"green", "f8", std::move(colors_[1])},
                          {"blue", "f8", std::move(colors_[2])}};
  }

 private:
  const FileText& file_;
  std::vector<std::array<double, 2>> uv_;
  std::vector<std::int32_t> corner_;  // numbers from 1 on, 0 for none
  std::array<std::vector<double>, 3> colors_;
  bool has_colors_ = true;
};

/// Corners are "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal"; numbers count from 1, or
/// backwards from the latest vertex if negative.
/// \param look  null: texture coordinates are skipped
void read_face(const FileText& file, std::string_view line, Words& words, SoupBuilder& soup, Look* look) {
  soup.begin_polygon();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word.starts_with('#')) return;
    const auto number = to_whole_number(word.substr(0, word.find('/')));
    if (!number || *number == 0)
      file.fail_at(line.data(), "expected the number of a vertex (1 is the first), got " + shown(word));
    const auto count = static_cast<std::int64_t>(soup.vertices().size());
    if (*number < -count)
      file.fail_at(line.data(),
                   "vertex " + shown(word) + " lies before the first, there are " + std::to_string(count) + " so far");
    soup.add_corner(*number > 0 ? *number - 1 : count + *number);
    if (look != nullptr) look->add_corner(line, word);
  }
}

/// Keeps a keyword of a line that is skipped, unless it only names or groups faces.
void note_skipped(std::string_view keyword, std::vector<std::string>& skipped) {
  if (keyword.empty() || keyword.starts_with('#') || keyword == "o" || keyword == "g" || keyword == "s") return;
  if (skipped.size() < kMostSkipped && std::ranges::find(skipped, keyword) == skipped.end())
    skipped.emplace_back(keyword);
}

}  // namespace

PolygonSoup read_obj(const FileText& file, Columns* columns, const Threads& threads, Job& job) {
  SoupBuilder soup(file, threads);
  std::optional<Look> look;
  if (columns != nullptr) look.emplace(file);
  Lines lines(file.text().substr(file.text().starts_with("\xef\xbb\xbf") ? 3 : 0));
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
      if (look) look->add_color(words);
    } else if (keyword == "f" || keyword == "fo") {
      read_face(file, line, words, soup, look ? &*look : nullptr);
    } else if (columns == nullptr) {
      continue;
    } else if (keyword == "vt") {
      look->add_uv(line, words);
    } else if (keyword == "usemtl") {
      columns->materials.emplace_back(static_cast<std::int32_t>(soup.polygons()), words.rest());
    } else if (keyword == "mtllib") {
      columns->files.emplace_back(words.rest());
    } else {
      note_skipped(keyword, columns->skipped);
    }
  }
  PolygonSoup result = soup.finish(1, job);
  if (result.vertices.empty()) file.fail("it has no line that begins with \"v \", as an OBJ file does");
  if (look) look->finish(*columns);
  return result;
}

}  // namespace isimp::detail
