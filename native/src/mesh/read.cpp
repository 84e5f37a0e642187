#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>

#include "edge_groups.h"
#include "formats.h"
#include "isimp/mesh/io.h"
#include "pipe.h"

namespace isimp {
namespace {

namespace fs = std::filesystem;
using detail::FileText;

constexpr std::size_t kBlock = std::size_t{1} << 22;  // bytes between two polls: some milliseconds

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
      if (piece == 0) job.report(static_cast<double>(block) / end);  // the others are about as far
      job.poll();
      const std::size_t done = static_cast<std::size_t>(block) * kBlock;
      const std::size_t wanted = std::min(kBlock, file.bytes.size() - done);
      if (!in.read(file.bytes.data() + done, static_cast<std::streamsize>(wanted)))
        file.fail("it can't be read to its end");
    }
  });
}

FileText load(const fs::path& path, const Threads& threads, Job& job) {
  FileText file{detail::utf8(path), {}};
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) file.fail("there is no such file");
  if (fs::is_directory(status)) file.fail("it is a folder, not a mesh file");
  if (fs::is_fifo(status)) {
    file.bytes = detail::read_pipe(path, file.name, job);
    if (file.bytes.empty()) file.fail("it is empty");
    return file;
  }
  if (detail::is_stream(status)) file.fail("it is a device, not a mesh file");
  std::ifstream in(path, std::ios::binary);
  if (!in) file.fail("it can't be opened; check that you may read it");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) file.fail("its size can't be found: " + error.message());
  file.bytes.resize(size);
  read_bytes(path, file, threads, job);
  if (file.bytes.empty()) file.fail("it is empty");
  return file;
}

}  // namespace

std::span<const std::int32_t> PolygonSoup::polygon(std::int32_t q) const {
  const std::size_t begin = static_cast<std::size_t>(loop_start[q]), next = static_cast<std::size_t>(q) + 1;
  const std::size_t end = next < loop_start.size() ? static_cast<std::size_t>(loop_start[next]) : loops.size();
  return std::span(loops).subspan(begin, end - begin);
}

PolygonSoup read_polygons(const std::filesystem::path& path, Job& job, std::int32_t threads) {
  using Reader = PolygonSoup (*)(const FileText&, const Threads&, Job&);
  const std::string extension = lower_extension(path);
  const Reader reader = extension == ".ply"   ? detail::read_ply
                        : extension == ".obj" ? detail::read_obj
                        : extension == ".stl" ? detail::read_stl
                        : extension == ".off" ? detail::read_off
                                              : nullptr;
  if (reader == nullptr)
    FileText{detail::utf8(path), {}}.fail("the extension \"" + extension +
                                          "\" is not known; PLY, OBJ, STL and OFF files can be read");
  const Threads workers(threads);
  const FileText file = load(path, workers, job);
  try {
    return reader(file, workers, job);
  } catch (const std::bad_alloc&) {
    file.fail("there is not enough memory for it");
  }
}

}  // namespace isimp
