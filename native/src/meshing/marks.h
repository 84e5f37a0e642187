#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

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

}  // namespace isimp::meshing
