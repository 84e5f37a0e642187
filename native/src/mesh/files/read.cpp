// Reads a file by its ending, and binary files by several threads.
#include <algorithm>
#include <cctype>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>

#include "files/formats.h"
#include "files/pipe.h"
#include "isimp/core/errors.h"
#include "isimp/mesh/io.h"
#include "surface/edge_groups.h"

namespace isimp {
namespace {

namespace fs = std::filesystem;
using detail::FileText;

constexpr std::size_t kBlock = std::size_t{1} << 22;  // format: bytes between two polls: some milliseconds

std::string lower_extension(const fs::path& path) {
  std::string extension = detail::utf8(path.extension());
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Reads a file in pieces, one a thread, each through a stream of its own.
void read_bytes(const fs::path& path, FileText& file, const Threads& threads, Job& job) {
  const auto blocks = static_cast<std::int32_t>((file.bytes.size() + kBlock - 1) / kBlock);
  threads.run(blocks, threads.pieces(blocks, 1), [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    std::ifstream in(path, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(begin) * static_cast<std::streamoff>(kBlock));
    for (std::int32_t block = begin; block < end; ++block) {
      detail::report_piece(job, piece, static_cast<double>(block) / end);
      const std::size_t done = static_cast<std::size_t>(block) * kBlock;
      const std::size_t wanted = std::min(kBlock, file.bytes.size() - done);
      if (!in.read(file.bytes.data() + done, static_cast<std::streamsize>(wanted)))
        file.fail("it can't be read to its end");
    }
  });
}

/// Checks the file behind a path, and reads it if it is a pipe.
/// \return its size if it is a regular file
std::optional<std::size_t> begin(const fs::path& path, FileText& file, Job& job) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) file.fail("there is no such file");
  if (fs::is_directory(status)) file.fail("it is a folder, not a mesh file");
  std::optional<std::size_t> size;
  if (fs::is_fifo(status)) {
    file.bytes = detail::read_pipe(path, file.name, job);
  } else {
    if (detail::is_stream(status)) file.fail("it is a device, not a mesh file");
    if (!std::ifstream(path, std::ios::binary)) file.fail("it can't be opened; check that you may read it");
    size = fs::file_size(path, error);
    if (error) file.fail("its size can't be found: " + error.message());
  }
  if (size.value_or(file.bytes.size()) == 0) file.fail("it is empty");
  return size;
}

using Reader = PolygonSoup (*)(const FileText&, Columns*, const Threads&, Job&);

/// The reader of a format, or null.
Reader reader_of(std::string_view extension) {
  if (extension == ".ply") return detail::read_ply;
  if (extension == ".obj") return detail::read_obj;
  if (extension == ".stl") return detail::read_stl;
  if (extension == ".off") return detail::read_off;
  return nullptr;
}

}  // namespace

std::span<const std::int32_t> PolygonSoup::polygon(std::int32_t q) const {
  const std::size_t begin = static_cast<std::size_t>(loop_start[q]), next = static_cast<std::size_t>(q) + 1;
  const std::size_t end = next < loop_start.size() ? static_cast<std::size_t>(loop_start[next]) : loops.size();
  return std::span(loops).subspan(begin, end - begin);
}

void PolygonSoup::check() const {
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (loops[i] < 0 || loops[i] >= std::ssize(vertices))
      throw InvalidInput("corner " + std::to_string(i) + " uses vertex " + std::to_string(loops[i]) +
                         ", but there are " + std::to_string(vertices.size()) + " vertices");
  const auto corners = static_cast<std::int32_t>(loops.size());
  if (loop_start.empty() && corners > 0)
    throw InvalidInput("loop_start is empty, but there are " + std::to_string(corners) + " corners");
  std::int32_t before = 0;
  for (std::size_t q = 0; q < loop_start.size(); ++q) {
    const std::int32_t start = loop_start[q];
    if (start < before || start > corners || (q == 0 && start != 0))
      throw InvalidInput("loop_start must rise from 0 to at most the " + std::to_string(corners) + " corners, got " +
                         std::to_string(start) + " for polygon " + std::to_string(q));
    before = start;
  }
}

PolygonSoup read_polygons(const std::filesystem::path& path, Job& job, std::int32_t threads, Columns* columns) {
  const std::string extension = lower_extension(path);
  FileText file{detail::utf8(path), {}};
  const Reader reader = reader_of(extension);
  if (reader == nullptr)
    file.fail("the extension \"" + extension + "\" is not known; PLY, OBJ, STL and OFF files can be read");
  try {
    const std::optional<std::size_t> size = begin(path, file, job);
    if (size) {
      file.bytes.resize(*size);
      read_bytes(path, file, Threads(threads), job);
    }
    return reader(file, columns, Threads(threads), job);
  } catch (const std::bad_alloc&) {
    file.fail("there is not enough memory for it");
  }
}

}  // namespace isimp
