#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "edge_groups.h"
#include "formats.h"
#include "places.h"

namespace isimp::detail {
namespace {

constexpr std::size_t kHead = 84, kFacet = 50;  // bytes of a binary file: 80 of comment and the count; each facet

/// Corners at one place become one vertex.
class FacetBuilder {
 public:
  FacetBuilder(const FileText& file, std::size_t facets) : soup_(file), places_(soup_.vertices(), facets / 2 + 1, 0.0) {
    soup_.reserve(facets / 2, facets);
  }
  void begin_facet() { soup_.begin_polygon(); }
  void add_corner(const Vec3& place) {
    const auto fresh = static_cast<std::int32_t>(soup_.vertices().size());
    const std::int32_t v = places_.find_or_keep(place, fresh);
    if (v == kNone) soup_.add_vertex(place);
    soup_.add_corner(v == kNone ? fresh : v);
  }
  PolygonSoup finish(Job& job) { return soup_.finish(0, job); }

 private:
  SoupBuilder soup_;
  Places places_;
};

template <class T>
T load(const char* p) {  // STL is little-endian everywhere
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), p, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  return std::bit_cast<T>(bytes);
}

PolygonSoup read_binary(const FileText& file, std::size_t facets, Job& job) {
  FacetBuilder builder(file, facets);
  for (std::size_t f = 0; f < facets; ++f) {
    if (f % kPollEvery == 0) job.poll();
    const char* facet = file.bytes.data() + kHead + f * kFacet;  // normal, three corners, two bytes to skip
    builder.begin_facet();
    for (std::size_t corner = 1; corner <= 3; ++corner) {
      const char* p = facet + 12 * corner;
      builder.add_corner(Vec3(load<float>(p), load<float>(p + 4), load<float>(p + 8)));
    }
  }
  return builder.finish(job);
}

/// Whether a word is one of the format's, in upper or lower case.
bool is(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return (a | 0x20) == b; });
}

PolygonSoup read_text(const FileText& file, Job& job) {
  FacetBuilder builder(file, file.bytes.size() / 150);
  Lines lines(file.bytes);
  std::string_view line;
  int corners = 3;  // of the present facet
  for (std::size_t row = 0; lines.next(line); ++row) {
    if (row % kPollEvery == 0) job.poll();
    Words words(line);
    const std::string_view keyword = words.next();
    if (is(keyword, "outer")) {
      if (corners != 3)
        file.fail_at(line.data(), "the facet before has " + std::to_string(corners) + " corners, not 3");
      corners = 0;
      builder.begin_facet();
    } else if (is(keyword, "vertex")) {
      if (++corners > 3) file.fail_at(line.data(), "a vertex stands outside a facet's loop of three");
      Vec3 place;
      for (double& coordinate : place) {
        const std::string_view word = words.next();
        const auto value = to_number(word);
        if (!value) file.fail_at(line.data(), "expected three coordinates after \"vertex\", got " + shown(word));
        coordinate = *value;
      }
      builder.add_corner(place);
    }
  }
  if (corners != 3) file.fail("it ends within a facet; it is cut short");
  return builder.finish(job);
}

}  // namespace

/// A binary file may begin with "solid" too: what counts is whether its length fits the number of facets it states.
PolygonSoup read_stl(const FileText& file, Job& job) {
  const std::size_t size = file.bytes.size();
  const std::size_t facets = size >= kHead ? load<std::uint32_t>(file.bytes.data() + 80) : 0;
  if (size >= kHead && size == kHead + facets * kFacet) return read_binary(file, facets, job);
  const std::string_view start = std::string_view(file.bytes).substr(0, 1024);
  const std::string_view first = Words(start).next();
  if ((first == "solid" || first == "SOLID") && start.find('\0') == start.npos) return read_text(file, job);
  if (size < kHead) file.fail("it is neither a text STL file (\"solid ...\") nor long enough for a binary one");
  if (size < kHead + facets * kFacet)
    file.fail("it promises " + std::to_string(facets) + " facets, but has " + std::to_string(size) +
              " bytes, room for " + std::to_string((size - kHead) / kFacet) + "; it is cut short or not an STL file");
  return read_binary(file, facets, job);  // some programs write more after the last facet
}

}  // namespace isimp::detail
