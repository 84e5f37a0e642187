#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::detail {

/// A set of numbers in [0, n) that finds the next one after another at once: bits, with a bit a word above them.
class IndexSet {
 public:
  /// None of the numbers in [0, n).
  void reset(std::int32_t n) {
    std::size_t words = static_cast<std::size_t>(n), count = 0;
    do {
      words = (words + 63) / 64;
      if (levels_.size() == count) levels_.emplace_back();
      levels_[count++].assign(words, 0);
    } while (words > 1);
    levels_.resize(count);
  }
  void insert(std::int32_t i) {
    for (auto& level : levels_) {
      level[static_cast<std::size_t>(i >> 6)] |= std::uint64_t{1} << (i & 63);
      i >>= 6;
    }
  }
  void erase(std::int32_t i) {
    for (auto& level : levels_) {
      std::uint64_t& word = level[static_cast<std::size_t>(i >> 6)];
      word &= ~(std::uint64_t{1} << (i & 63));
      if (word != 0) return;
      i >>= 6;
    }
  }
  /// The least number of at least `from`, else the least of all; kNone if there is none.
  [[nodiscard]] std::int32_t next(std::int32_t from) const {
    const std::int32_t found = least(from);
    return found != kNone || from == 0 ? found : least(0);
  }

 private:
  [[nodiscard]] std::int32_t least(std::int32_t from) const {
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      const auto at = static_cast<std::size_t>(from >> 6);
      if (at >= levels_[k].size()) return kNone;
      const std::uint64_t rest = levels_[k][at] >> (from & 63);
      if (rest != 0) return down(k, from + std::countr_zero(rest));
      from = static_cast<std::int32_t>(at) + 1;  // the word after this one
    }
    return kNone;
  }
  /// The least number under bit i of a level.
  [[nodiscard]] std::int32_t down(std::size_t level, std::int32_t i) const {
    while (level-- > 0) i = i * 64 + std::countr_zero(levels_[level][static_cast<std::size_t>(i)]);
    return i;
  }

  std::vector<std::vector<std::uint64_t>> levels_;
};

}  // namespace isimp::detail
