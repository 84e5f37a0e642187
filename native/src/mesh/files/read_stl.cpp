// Reads STL files.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "files/formats.h"
#include "isimp/mesh/hash_grid.h"
#include "surface/edge_groups.h"

namespace isimp::detail {
namespace {

constexpr std::size_t kHead = 84,
                      kFacet = 50;  // format: bytes of a binary file: 80 of comment and the count; each facet

/// Corners at one place become one vertex.
class FacetBuilder {
 public:
  FacetBuilder(const FileText& file, std::size_t facets, const Threads& threads)
      : soup_(file, threads), grid_(facets / 2 + 1, 0.0) {
    soup_.reserve(facets / 2, facets);
  }
  void begin_facet() { soup_.begin_polygon(); }
  void add_corner(const Vec3& place) {
    const auto fresh = static_cast<std::int32_t>(soup_.vertices().size());
    const std::int32_t v = grid_.find_or_keep(soup_.vertices(), place, fresh);
    if (v == kNone) soup_.add_vertex(place);
    soup_.add_corner(v == kNone ? fresh : v);
  }
  PolygonSoup finish(Job& job) { return soup_.finish(0, job); }

 private:
  SoupBuilder soup_;
  HashGrid grid_;
};

template <class T>
T load(const char* p) {  // STL is little-endian everywhere
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), p, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  return std::bit_cast<T>(bytes);
}

PolygonSoup read_binary(const FileText& file, std::size_t facets, Columns* columns, const Threads& threads, Job& job) {
  FacetBuilder builder(file, facets, threads);
  bool colors = false;
  for (std::size_t f = 0; f < facets; ++f) {
    if (f % kPollEvery == 0) job.poll();
    const char* facet = file.bytes.data() + kHead + f * kFacet;  // normal, three corners, two bytes of a colour
    builder.begin_facet();
    for (std::size_t corner = 1; corner <= 3; ++corner) {
      const char* p = facet + 12 * corner;
      builder.add_corner(Vec3(load<float>(p), load<float>(p + 4), load<float>(p + 8)));
    }
    colors = colors || facet[kFacet - 2] != 0 || facet[kFacet - 1] != 0;
  }
  if (colors && columns != nullptr) columns->skipped = {"C"};
  return builder.finish(job);
}

/// Whether a word is one of the format's, in upper or lower case.
bool is(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a | 0x20) == b; });
}

/// A text file word by word, since some programs write all of it on one line.
class TextReader {
 public:
  TextReader(const FileText& file, const Threads& threads, Job& job)
      : file_(file), job_(job), builder_(file, file.bytes.size() / 150, threads), words_(file.text()) {}

  PolygonSoup read() {
    for (std::size_t count = 0;; ++count) {
      if (count % kPollEvery == 0) job_.poll();
      const std::string_view word = words_.next();
      if (word.empty()) break;
      take(word);
    }
    if (corners_ != 3) file_.fail("it ends within a facet; it is cut short");
    if (is_open_) file_.fail("it has no \"endsolid\" after its last facet; it is cut short");
    return builder_.finish(job_);
  }

 private:
  void take(std::string_view word) {
    if (is(word, "vertex")) {
      add_corner(word);
    } else if (is(word, "outer")) {
      if (corners_ != 3)
        file_.fail_at(word.data(), "the facet before this line has " + std::to_string(corners_) + " corners, not 3");
      corners_ = 0;
      is_open_ = true;
      builder_.begin_facet();
    } else if (is(word, "solid")) {
      is_open_ = true;
      skip_name(word);
    } else if (is(word, "endsolid")) {
      is_open_ = false;
      skip_name(word);
    }
  }
  void add_corner(std::string_view keyword) {
    if (++corners_ > 3)
      file_.fail_at(keyword.data(), "a facet has more than three vertices, or a vertex is outside a facet");
    Vec3 place;
    for (double& coordinate : place) {
      const std::string_view word = words_.next();
      const auto value = to_number(word);
      if (!value) file_.fail_at(keyword.data(), "expected three coordinates after \"vertex\", got " + shown(word));
      coordinate = *value;
    }
    builder_.add_corner(place);
  }
  /// Skips the name of a solid, which may hold any word: it ends with its line, or where a facet or the end of the
  /// solid follows on the same one.
  void skip_name(std::string_view keyword) {
    const auto is_end = [](char c) { return c == '\n' || c == '\r'; };
    for (std::string_view before = keyword;;) {
      Words after = words_;
      const std::string_view word = after.next();
      if (word.empty() || std::any_of(before.data() + before.size(), word.data(), is_end) || is(word, "endsolid"))
        return;
      words_ = after;
      if (is(before, "facet") && is(word, "normal")) return;
      before = word;
    }
  }

  const FileText& file_;
  Job& job_;
  FacetBuilder builder_;
  Words words_;
  int corners_ = 3;       // corners of the present facet
  bool is_open_ = false;  // a solid or facet has begun and its solid has not ended
};

}  // namespace

/// A binary file may begin with "solid" too: the file is binary if its length fits the number of facets that it states.
PolygonSoup read_stl(const FileText& file, Columns* columns, const Threads& threads, Job& job) {
  const std::size_t size = file.bytes.size();
  const std::size_t facets = size >= kHead ? load<std::uint32_t>(file.bytes.data() + 80) : 0;
  if (size >= kHead && size == kHead + facets * kFacet) return read_binary(file, facets, columns, threads, job);
  const std::string_view start = file.text().substr(0, 1024);
  const std::string_view first = Words(start).next();
  if (is(first, "solid") && start.find('\0') == start.npos) return TextReader(file, threads, job).read();
  if (size < kHead) file.fail("it is neither a text STL file (\"solid ...\") nor long enough for a binary one");
  if (size < kHead + facets * kFacet)
    file.fail("it promises " + std::to_string(facets) + " facets, but has " + std::to_string(size) +
              " bytes, room for " + std::to_string((size - kHead) / kFacet) + "; it is cut short or not an STL file");
  return read_binary(file, facets, columns, threads, job);  // some programs write more after the last facet
}

}  // namespace isimp::detail
