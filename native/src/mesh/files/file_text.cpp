#include "files/file_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#ifdef ISIMP_FAST_FLOAT
#include <fast_float/fast_float.h>
#endif

namespace isimp::detail {
namespace {

/// Replaces std::from_chars, which some standard libraries lack for numbers with a point. Both round correctly.
auto from_characters(const char* begin, const char* end, double& value) {
#ifdef ISIMP_FAST_FLOAT
  return fast_float::from_chars(begin, end, value);
#else
  return std::from_chars(begin, end, value);
#endif
}

}  // namespace

void FileText::fail_at(const char* place, const std::string& what) const {
  const auto line = 1 + std::count(bytes.data(), std::min(place, bytes.data() + bytes.size()), '\n');
  fail("line " + std::to_string(line) + ": " + what);
}

bool Lines::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  line = rest_.substr(0, end);
  const bool two = end + 1 < rest_.size() && rest_[end] == '\r' && rest_[end + 1] == '\n';
  rest_.remove_prefix(std::min(end + (two ? 2 : 1), rest_.size()));
  return true;
}

std::optional<double> to_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  if (word.empty()) return {};
  double value = 0;
  const auto [end, error] = from_characters(word.data(), word.data() + word.size(), value);
  const std::string_view rest(end, static_cast<std::size_t>(word.data() + word.size() - end));
  if (error == std::errc::invalid_argument) return {};
  if (!rest.empty()) {  // NaN and infinity of some Windows programs: 1.#QNAN, -1.#IND, 1.#INF
    if (!rest.starts_with('#') && !rest.starts_with('(')) return {};
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (error == std::errc::result_out_of_range) {
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    return tiny ? 0.0 : std::numeric_limits<double>::infinity();
  }
  return value;
}

std::optional<std::int64_t> to_whole_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc() && end == word.data() + word.size()) return value;
  const std::optional<double> number = to_number(word);
  if (!number || !(std::abs(*number) < 1e15) || *number != std::floor(*number)) return {};
  return static_cast<std::int64_t>(*number);
}

std::string shown(std::string_view word) {
  constexpr std::size_t kShown = 24;  // format
  std::string result = "\"";
  for (const char c : word.substr(0, kShown)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (word.size() > kShown ? "...\"" : "\"");
}

}  // namespace isimp::detail
