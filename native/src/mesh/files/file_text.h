#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "isimp/core/array.h"
#include "isimp/core/errors.h"

namespace isimp::detail {

/// A path, or a part of one, as UTF-8 on every system: where path.string() has no letter for one it throws on Windows.
inline std::string utf8(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

/// A file's contents, and the name that errors carry.
struct FileText {
  std::string name;
  Array<char> bytes;

  [[nodiscard]] std::string_view text() const { return {bytes.data(), bytes.size()}; }

  [[noreturn]] void fail(const std::string& what) const { throw FileError(name + ": " + what); }
  /// Names the line of a place in `bytes`.
  [[noreturn]] void fail_at(const char* place, const std::string& what) const;
};

/// The words of a text, one after another, with spaces, tabs and line ends between them.
class Words {
 public:
  explicit Words(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}
  /// The next word; empty at the end.
  std::string_view next() {
    while (at_ != end_ && is_space(*at_)) ++at_;
    const char* begin = at_;
    while (at_ != end_ && !is_space(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  /// The text behind the last word, without the spaces around it.
  [[nodiscard]] std::string_view rest() const {
    const char *begin = at_, *end = end_;
    while (begin != end && is_space(*begin)) ++begin;
    while (begin != end && is_space(end[-1])) --end;
    return {begin, static_cast<std::size_t>(end - begin)};
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  const char* at_;
  const char* end_;
};

/// The lines of a text with any line ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  /// The next line without its end; false past the last one.
  bool next(std::string_view& line);
  /// The text behind the last returned line.
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// The number a word spells, NaN and infinity included ("nan", "-inf", "1.#QNAN"); nothing if it spells none.
std::optional<double> to_number(std::string_view word);
/// The whole number a word spells ("3", "-1", "3.0").
std::optional<std::int64_t> to_whole_number(std::string_view word);
/// A word in the form for error messages: quoted, unprintable bytes replaced, at most 24 characters.
std::string shown(std::string_view word);

}  // namespace isimp::detail
