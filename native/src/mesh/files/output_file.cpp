#include "files/output_file.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "files/file_text.h"
#include "isimp/core/errors.h"

#ifndef _WIN32
#include <unistd.h>
#endif

namespace isimp::detail {
namespace {

namespace fs = std::filesystem;

constexpr int kMostDrafts = 1000;  // format: drafts of other programs next to a place
constexpr int kMostLinks = 40;     // format: in a row; more are a circle

/// The end of a chain of links, also if it does not exist.
fs::path end_of_links(fs::path place) {
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(place, error); ++i)
    place = place.parent_path() / fs::read_symlink(place, error);
  return place;
}

/// Makes an empty file where nothing exists, not even a dangling link, which would be followed.
/// \return false if it can't be made; errno is EEXIST if something exists
bool make_new(const fs::path& place) {
  errno = 0;
#ifdef _WIN32
  std::FILE* file = ::_wfopen(place.c_str(), L"wbx");
#else
  std::FILE* file = std::fopen(place.c_str(), "wbx");
#endif
  return file != nullptr && std::fclose(file) == 0;
}

bool is_read_only([[maybe_unused]] const fs::path& place, const fs::file_status& status) {
  constexpr fs::perms kWrite = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  if ((status.permissions() & kWrite) == fs::perms::none) return true;
#ifndef _WIN32
  return ::access(place.c_str(), W_OK) != 0;
#else
  return false;
#endif
}

}  // namespace

OutputFile::OutputFile(const fs::path& path, Job& job) : name_(utf8(path)), place_(end_of_links(path)) {
  std::error_code error;
  const fs::file_status before = fs::status(place_, error);
  if (fs::is_directory(before)) fail("it is a folder; give the name of a file");
  if (is_stream(before)) {
    stream_.emplace(place_, name_, job);
  } else {
    open_draft(before);
  }
}

void OutputFile::open_draft(const fs::file_status& before) {
  if (fs::exists(before) && is_read_only(place_, before)) fail("it is read-only, so it is not replaced");
  fs::path draft = place_;
  draft += ".part";  // next to its place, so that the move stays within one file system
  for (int i = 2; !make_new(draft); ++i) {
    if (errno != EEXIST || i > kMostDrafts)
      fail("it can't be written; check that its folder exists and that you may write there");
    draft.replace_extension(".part" + std::to_string(i));
  }
  draft_ = draft;
  out_.open(draft_, std::ios::binary);
  if (!out_) fail("it can't be written; check that its folder exists and that you may write there");
  std::error_code ignored;  // a file system without permissions has none to keep
  if (fs::exists(before)) fs::permissions(draft_, before.permissions(), ignored);
}

OutputFile::~OutputFile() {
  if (kept_ || stream_ || draft_.empty()) return;
  out_.close();
  std::error_code ignored;
  fs::remove(draft_, ignored);
}

void OutputFile::keep() {
  flush();
  if (stream_) return;
  out_.close();
  if (!out_) fail("writing failed; is the disk full?");
  std::error_code error;
  fs::rename(draft_, place_, error);
  if (error) fail("it can't be put in its place: " + error.message());
  kept_ = true;
}

void OutputFile::flush() {
  if (stream_) {
    stream_->write(buffer_);
  } else {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    if (!out_) fail("writing failed; is the disk full?");
  }
  buffer_.clear();
}

void OutputFile::fail(const std::string& what) const { throw FileError(name_ + ": " + what); }

}  // namespace isimp::detail
