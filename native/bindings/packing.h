// Members of a class as values that Python can pickle.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "isimp/core/errors.h"
#include "isimp/core/types.h"

namespace isimp::bindings {

namespace py = pybind11;

/// Whether a vector of these is packed as its bytes.
template <class T>
inline constexpr bool kPlain = std::is_trivially_copyable_v<T> || std::is_same_v<T, Vec3>;

inline py::object pack(bool value) { return py::bool_(value); }
inline py::object pack(double value) { return py::float_(value); }
inline py::object pack(std::int32_t value) { return py::int_(value); }
inline py::object pack(std::int64_t value) { return py::int_(value); }

template <class T, class Allocator>
requires kPlain<T> py::object pack(const std::vector<T, Allocator>& items) {
  return py::bytes(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
}

template <class... T>
py::tuple pack_all(const T&... values) {
  return py::make_tuple(pack(values)...);
}

[[noreturn]] inline void refuse_pickle() {
  throw InvalidInput("the pickle is damaged, or of another version of isimp");
}

template <class T>
requires std::is_arithmetic_v<T>
void unpack(py::handle packed, T& value) { value = packed.cast<T>(); }

template <class T, class Allocator>
requires kPlain<T>
void unpack(py::handle packed, std::vector<T, Allocator>& items) {
  const auto bytes = packed.cast<std::string_view>();
  if (!PyBytes_Check(packed.ptr()) || bytes.size() % sizeof(T) != 0) refuse_pickle();
  items.resize(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(items.data()), bytes.data(), bytes.size());
}

/// Fills values from the result of pack_all().
template <class... T>
void unpack_all(const py::tuple& packed, T&... values) {
  if (packed.size() != sizeof...(T)) refuse_pickle();
  try {
    std::size_t at = 0;
    (unpack(packed[at++], values), ...);
  } catch (const py::cast_error&) {
    refuse_pickle();
  }
}

}  // namespace isimp::bindings
