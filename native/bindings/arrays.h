#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "isimp/core/types.h"

namespace isimp::bindings {

namespace py = pybind11;

/// (V, 3) float32 or float64 with any strides, copied. \throws InvalidInput  another shape or kind of number
std::vector<Vec3> read_vertices(const py::object& vertices);

/// (F, 3) int32 or int64 with any strides, copied.
/// \throws InvalidInput  another shape or kind of number; an index that is out of the range of int32: the message
///                       names the face, and `vertex_count` as how many there are
std::vector<Triangle> read_triangles(const py::object& triangles, std::size_t vertex_count);

/// A read-only numpy array over memory of `owner`, which it keeps alive: (n) for numbers, (n, 3) for Vec3 and Triangle.
template <class T>
py::array view(std::span<const T> items, py::handle owner) {
  py::array array;
  const auto n = static_cast<py::ssize_t>(items.size());
  if constexpr (std::is_same_v<T, Vec3>) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    array = py::array_t<double>({n, py::ssize_t{3}}, reinterpret_cast<const double*>(items.data()), owner);
  } else if constexpr (std::is_same_v<T, Triangle>) {
    array = py::array_t<std::int32_t>({n, py::ssize_t{3}}, reinterpret_cast<const std::int32_t*>(items.data()), owner);
  } else {
    array = py::array_t<T>(n, items.data(), owner);
  }
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

template <class T>
py::array view(const std::vector<T>& items, py::handle owner) {
  return view(std::span<const T>(items), owner);
}

/// What a property is made of that shows memory of its object, given a member or a member function.
template <class Class, class Member>
auto viewer(Member Class::*member) {
  return [member](const py::object& self) { return view(std::invoke(member, self.cast<const Class&>()), self); };
}

}  // namespace isimp::bindings
