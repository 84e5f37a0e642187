#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "isimp/core/array.h"
#include "isimp/core/job.h"

namespace isimp::detail {

/// Whether a path leads to a pipe or a device, which is read or written directly, since it can't be replaced.
bool is_stream(const std::filesystem::file_status& status);

/// The data of a pipe until its last writer closes it. Waits for the first writer; polls the job meanwhile.
/// \throws FileError  with `name` and the reason
Array<char> read_pipe(const std::filesystem::path& path, const std::string& name, Job& job);

/// Writes into a pipe or a device. Waits for a reader; polls the job meanwhile.
class StreamWriter {
 public:
  /// \throws FileError  `name` and why
  StreamWriter(const std::filesystem::path& path, std::string name, Job& job);
  ~StreamWriter();
  StreamWriter(const StreamWriter&) = delete;
  StreamWriter& operator=(const StreamWriter&) = delete;

  void write(std::string_view bytes);

 private:
  std::string name_;
  [[maybe_unused]] Job& job_;  // Windows has no such pipes
  [[maybe_unused]] int handle_ = -1;
};

}  // namespace isimp::detail
