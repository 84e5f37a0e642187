#include "files/file_parts.h"

#include <algorithm>

namespace isimp::detail {
namespace {

constexpr std::size_t kPart = std::size_t{1} << 18;  // bytes: a millisecond of text
constexpr std::size_t kLongestLine = 32 * kPart;
constexpr std::size_t kLook = 256;  // bytes to search for the end of a line

}  // namespace

FileParts::Reader::Reader(const FileParts& parts) : parts_(parts) {
  if (parts.is_held_) return;
  in_.open(parts.path_, std::ios::binary);
  if (!in_) parts.file_.fail("it can't be opened; check that you may read it");
}

std::string_view FileParts::Reader::bytes(std::size_t begin, std::size_t end) {
  if (parts_.is_held_) return parts_.file_.text().substr(begin, end - begin);
  if (buffer_.size() < end - begin) buffer_ = Array<char>(end - begin + kPart / 8);  // a resize would copy the old one
  in_.seekg(static_cast<std::streamoff>(begin));
  if (!in_.read(buffer_.data(), static_cast<std::streamsize>(end - begin)))
    parts_.file_.fail("it can't be read to its end");
  return {buffer_.data(), end - begin};
}

std::vector<std::size_t> line_parts(const FileParts& parts, std::size_t begin, Job& job) {
  FileParts::Reader reader(parts);
  std::vector<std::size_t> edges{begin};
  while (edges.back() < parts.size()) {
    job.poll();
    std::size_t at = std::min(edges.back() + kPart, parts.size());  // the byte before it may be a line feed
    for (bool found = at == parts.size(); !found;) {
      const std::size_t from = at - 1, to = std::min(from + kLook, parts.size());
      const std::size_t feed = reader.bytes(from, to).find('\n');
      found = feed != std::string_view::npos || to == parts.size();
      at = feed != std::string_view::npos ? from + feed + 1 : to + (found ? 0 : 1);
      if (at - edges.back() > kLongestLine) return {};
    }
    edges.push_back(at);
  }
  return edges;
}

}  // namespace isimp::detail
