#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace isimp::meshing {

/// A set of indices in [0, n) that is emptied in O(1). Memory that it never needs it never touches, so that one of the
/// mesh's size costs nothing until it is used.
class Marks {
 public:
  explicit Marks(std::size_t n) : stamp_(static_cast<std::uint32_t*>(std::calloc(n + 1, sizeof(std::uint32_t)))) {
    if (!stamp_) throw std::bad_alloc();
  }
  void clear() { ++now_; }
  /// \return whether `i` is new to the set
  bool add(std::int32_t i) {
    const bool fresh = stamp_[i] != now_;
    stamp_[i] = now_;
    return fresh;
  }
  [[nodiscard]] bool has(std::int32_t i) const { return stamp_[i] == now_; }

 private:
  struct Free {
    void operator()(std::uint32_t* p) const { std::free(p); }
  };
  std::unique_ptr<std::uint32_t[], Free> stamp_;  // zeroed by the system, page by page as they are used
  std::uint32_t now_ = 1;
};

/// A set of indices in [0, n), a bit each.
class Bits {
 public:
  explicit Bits(std::size_t n) : words_(n / 64 + 1, 0) {}
  void add(std::int32_t i) { words_[static_cast<std::size_t>(i) / 64] |= bit(i); }
  void remove(std::int32_t i) { words_[static_cast<std::size_t>(i) / 64] &= ~bit(i); }
  [[nodiscard]] bool has(std::int32_t i) const { return (words_[static_cast<std::size_t>(i) / 64] & bit(i)) != 0; }
  /// The lowest from `i` on, -1 where there is none.
  [[nodiscard]] std::int64_t next(std::int64_t i) const {
    std::size_t at = static_cast<std::size_t>(i) / 64;
    if (at >= words_.size()) return -1;
    std::uint64_t word = words_[at] & (~std::uint64_t{0} << (static_cast<std::size_t>(i) % 64));
    while (word == 0) {
      if (++at == words_.size()) return -1;
      word = words_[at];
    }
    return static_cast<std::int64_t>(64 * at) + std::countr_zero(word);
  }

 private:
  static std::uint64_t bit(std::int32_t i) { return std::uint64_t{1} << (static_cast<std::size_t>(i) % 64); }
  std::vector<std::uint64_t> words_;
};

}  // namespace isimp::meshing
