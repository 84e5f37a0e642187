#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>
#include <vector>

#include "files/file_text.h"
#include "isimp/core/array.h"
#include "isimp/core/job.h"
#include "isimp/core/threads.h"

namespace isimp::detail {

/// A file's bytes, read from the disk part by part, so that it is never in memory as a whole. A mapping would save one
/// copy within the cache, but SIGBUS would end the process if the file were cut short meanwhile.
class FileParts {
 public:
  /// Bytes that are in memory already. `held` outlives this.
  explicit FileParts(const FileText& held) : file_(held), size_(held.bytes.size()), is_held_(true) {}
  /// A regular file. `named` holds its name alone and outlives this.
  FileParts(std::filesystem::path path, const FileText& named, std::size_t size)
      : file_(named), path_(std::move(path)), size_(size) {}

  [[nodiscard]] const FileText& file() const { return file_; }
  [[nodiscard]] std::size_t size() const { return size_; }

  /// Reads parts one after another. Each thread has its own.
  class Reader {
   public:
    explicit Reader(const FileParts& parts);
    /// The bytes [begin, end) of the file, valid until the next call.
    /// \throws FileError  the file has become shorter, or the disk fails
    std::string_view bytes(std::size_t begin, std::size_t end);

   private:
    const FileParts& parts_;
    std::ifstream in_;
    Array<char> buffer_;
  };

 private:
  const FileText& file_;
  std::filesystem::path path_;
  std::size_t size_;
  bool is_held_ = false;
};

/// The boundaries of parts of whole lines, about a quarter of a megabyte each: rising, the end of the file last. Empty
/// if a line is longer than some parts, as in a file whose lines don't end in line feeds.
std::vector<std::size_t> line_parts(const FileParts& parts, std::size_t begin, Job& job);

/// Polls in each piece of work, and reports how far the first one is, since the others are about as far.
inline void report_piece(Job& job, std::int32_t piece, double share) {
  if (piece == 0) {
    job.report(share);
  } else {
    job.poll();
  }
}

/// Calls body(i, text) for each part of whole lines on all threads; false if one of the calls returns false.
template <class Body>
bool for_each_part(const FileParts& parts, const std::vector<std::size_t>& edges, const Threads& threads, Job& job,
                   const Body& body) {
  std::atomic<bool> fine = true;
  const auto count = static_cast<std::int32_t>(edges.size()) - 1;
  threads.run(count, threads.pieces(count, 1), [&](std::int32_t piece, std::int32_t begin, std::int32_t end) {
    FileParts::Reader reader(parts);
    for (std::int32_t i = begin; i < end && fine; ++i) {
      report_piece(job, piece, static_cast<double>(i) / end);
      const auto k = static_cast<std::size_t>(i);
      if (!body(k, reader.bytes(edges[k], edges[k + 1]))) fine = false;
    }
  });
  return fine;
}

/// Calls visit(line), without its line feed, until it returns false.
template <class Visit>
bool for_each_line(std::string_view text, const Visit& visit) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (!visit(text.substr(0, end))) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return true;
}

}  // namespace isimp::detail
