#include "files/pipe.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include "isimp/core/errors.h"

#ifndef _WIN32
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>
#endif

namespace isimp::detail {

namespace fs = std::filesystem;

bool is_stream(const fs::file_status& status) {
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

#ifndef _WIN32

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 16;  // format

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw FileError(name + ": " + what + ": " + std::strerror(errno));
}

/// Waits a short time for the handle; returns whether it is ready.
bool wait_for(int handle, short what) {
  pollfd waiting{handle, what, 0};
  return ::poll(&waiting, 1, 20) > 0;  // milliseconds until the job is polled
}

/// A handle that is closed at the end of its block.
struct Handle {
  int number;
  ~Handle() { ::close(number); }
};

}  // namespace

Array<char> read_pipe(const fs::path& path, const std::string& name, Job& job) {
  const int handle = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);  // does not wait for a writer
  if (handle < 0) fail(name, "it can't be opened");
  const Handle open{handle};
  Array<char> bytes;
  while (true) {
    job.poll();
    if (!wait_for(handle, POLLIN)) continue;  // else there is data to read, or the writer has closed the pipe
    const std::size_t held = bytes.size();
    bytes.resize(held + kPiece);
    const ssize_t count = ::read(handle, bytes.data() + held, kPiece);
    bytes.resize(held + static_cast<std::size_t>(count > 0 ? count : 0));
    if (count == 0) return bytes;
    if (count < 0 && errno != EAGAIN && errno != EINTR) fail(name, "it can't be read to its end");
  }
}

StreamWriter::StreamWriter(const fs::path& path, std::string name, Job& job) : name_(std::move(name)), job_(job) {
  while (true) {
    handle_ = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (handle_ >= 0) return;
    if (errno != ENXIO || !fs::is_fifo(path)) fail(name_, "it can't be opened for writing");
    job_.poll();  // the pipe has no reader yet
    wait_for(-1, 0);
  }
}

StreamWriter::~StreamWriter() { ::close(handle_); }

void StreamWriter::write(std::string_view bytes) {
  while (!bytes.empty()) {
    job_.poll();
    const ssize_t count = ::write(handle_, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno == EAGAIN) {
      wait_for(handle_, POLLOUT);
    } else if (errno != EINTR) {
      fail(name_, "writing failed");
    }
  }
}

#else

Array<char> read_pipe(const fs::path&, const std::string& name, Job&) {
  throw FileError(name + ": pipes can't be read here");
}

StreamWriter::StreamWriter(const fs::path&, std::string name, Job& job) : name_(std::move(name)), job_(job) {
  throw FileError(name_ + ": pipes and devices can't be written here");
}

StreamWriter::~StreamWriter() = default;

void StreamWriter::write(std::string_view) {}

#endif

}  // namespace isimp::detail
