#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "files/pipe.h"
#include "isimp/core/job.h"

namespace isimp::detail {

/// A file that takes its place only when it is whole. Writes in large pieces.
///
/// An earlier file is replaced and its permissions stay; a link stays one, and the file it leads to is replaced. Pipes
/// and devices are written to directly.
class OutputFile {
 public:
  /// \throws FileError  a folder, a file that is read-only, or a place that can't be written
  OutputFile(const std::filesystem::path& path, Job& job);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::string& buffer() { return buffer_; }
  void flush_if_full() {
    if (buffer_.size() >= kFull) flush();
  }
  void keep();

 private:
  static constexpr std::size_t kFull = std::size_t{1} << 20;  // format
  void open_draft(const std::filesystem::file_status& before);
  void flush();
  [[noreturn]] void fail(const std::string& what) const;

  std::string name_;
  std::filesystem::path place_, draft_;
  std::optional<StreamWriter> stream_;
  std::ofstream out_;
  std::string buffer_;
  bool kept_ = false;
};

}  // namespace isimp::detail
