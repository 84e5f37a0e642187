#pragma once

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace isimp {

/// Leaves new elements uninitialised instead of setting them to zero.
template <class T>
struct Unset : std::allocator<T> {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  template <class U>
  struct rebind {            // NOLINT(readability-identifier-naming): the standard names it
    using other = Unset<U>;  // NOLINT(readability-identifier-naming)
  };
  template <class U>
  void construct(U* /*at*/) noexcept {}
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    std::construct_at(at, std::forward<Args>(args)...);
  }
};

/// A vector whose resize(n) initialises nothing: each thread then writes its part first, and so they share the page
/// faults.
template <class T>
using Array = std::vector<T, Unset<T>>;

}  // namespace isimp
