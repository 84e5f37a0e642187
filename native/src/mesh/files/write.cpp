// Writes polygons to files.
#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <string>

#include "files/file_text.h"
#include "files/output_file.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/io.h"
#include "surface/edge_groups.h"

namespace isimp {
namespace {

using detail::OutputFile;

struct Polygons {
  std::span<const Vec3> vertices;
  std::span<const std::int32_t> loops, loop_start;

  [[nodiscard]] std::size_t count() const { return loop_start.size(); }
  [[nodiscard]] std::span<const std::int32_t> operator[](std::size_t q) const {
    const auto begin = static_cast<std::size_t>(loop_start[q]);
    return loops.subspan(begin, (q + 1 < count() ? static_cast<std::size_t>(loop_start[q + 1]) : loops.size()) - begin);
  }
};

void check(const Polygons& polygons) {
  const auto n = static_cast<std::int32_t>(polygons.vertices.size());
  const auto corners = static_cast<std::int64_t>(polygons.loops.size());
  for (std::size_t q = 0; q < polygons.count(); ++q) {
    const std::int64_t begin = polygons.loop_start[q];
    const std::int64_t end = q + 1 < polygons.count() ? polygons.loop_start[q + 1] : corners;
    if ((q == 0 && begin != 0) || begin < 0 || end > corners || end - begin < 3)
      throw InvalidInput("polygon " + std::to_string(q) + " has the corners " + std::to_string(begin) + " up to " +
                         std::to_string(end) + " of " + std::to_string(corners) +
                         "; loop_start must begin with 0, and each polygon needs at least 3 corners");
    for (const std::int32_t v : polygons[q])
      if (v < 0 || v >= n)
        throw InvalidInput("polygon " + std::to_string(q) + " uses vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(n) + " vertices");
  }
  if (polygons.count() == 0 && corners > 0) throw InvalidInput("there are loops, but loop_start is empty");
}

template <class T>
void append_bytes(std::string& buffer, T value) {  // little-endian
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  buffer.append(bytes.data(), bytes.size());
}

template <class T>
void append_number(std::string& buffer, T value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  buffer.append(digits.data(), end);
}

void write_ply(const Polygons& polygons, OutputFile& file, Job& job) {
  std::size_t most_corners = 0;
  for (std::size_t q = 0; q < polygons.count(); ++q) most_corners = std::max(most_corners, polygons[q].size());
  const bool bytes = most_corners <= 255;  // the count that every reader accepts; larger polygons need the larger count
  std::string& out = file.buffer();
  out += "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(polygons.vertices.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(polygons.count()) +
         "\nproperty list " + (bytes ? "uchar" : "int") + " int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < polygons.vertices.size(); ++v) {
    if (v % detail::kPollEvery == 0) job.poll();
    for (const double coordinate : polygons.vertices[v]) append_bytes(out, coordinate);
    file.flush_if_full();
  }
  for (std::size_t q = 0; q < polygons.count(); ++q) {
    if (q % detail::kPollEvery == 0) job.poll();
    const auto polygon = polygons[q];
    if (bytes) {
      append_bytes(out, static_cast<std::uint8_t>(polygon.size()));
    } else {
      append_bytes(out, static_cast<std::int32_t>(polygon.size()));
    }
    for (const std::int32_t v : polygon) append_bytes(out, v);
    file.flush_if_full();
  }
}

void write_obj(const Polygons& polygons, OutputFile& file, Job& job) {
  std::string& out = file.buffer();
  for (std::size_t v = 0; v < polygons.vertices.size(); ++v) {
    if (v % detail::kPollEvery == 0) job.poll();
    out += 'v';
    for (const double coordinate : polygons.vertices[v]) append_number(out += ' ', coordinate);
    out += '\n';
    file.flush_if_full();
  }
  for (std::size_t q = 0; q < polygons.count(); ++q) {
    if (q % detail::kPollEvery == 0) job.poll();
    out += 'f';
    for (const std::int32_t v : polygons[q]) append_number(out += ' ', v + 1);
    out += '\n';
    file.flush_if_full();
  }
}

}  // namespace

void write_polygons(const std::filesystem::path& path, std::span<const Vec3> vertices,
                    std::span<const std::int32_t> loops, std::span<const std::int32_t> loop_start, Job& job) {
  std::string extension = detail::utf8(path.extension());
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".ply" && extension != ".obj")
    throw FileError(detail::utf8(path) + ": the extension \"" + extension + "\" can't be written; choose .ply or .obj");
  const Polygons polygons{vertices, loops, loop_start};
  check(polygons);
  job.poll();
  OutputFile file(path, job);
  (extension == ".ply" ? write_ply : write_obj)(polygons, file, job);
  file.keep();
}

}  // namespace isimp
