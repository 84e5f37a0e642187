// Numpy arrays to spans and vectors of the engine, and back without a copy.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "isimp/core/threads.h"
#include "isimp/core/types.h"

namespace isimp::bindings {

namespace py = pybind11;

/// (n, 3) float32 or float64 with any strides, copied; `name` and `shape` are for the message. The threads share the
/// copying where there are no gaps between the rows.
/// \throws InvalidInput  another shape or kind of number
std::vector<Vec3> read_points(const py::object& points, const std::string& name, const std::string& shape,
                              const Threads& threads = Threads(1));
inline std::vector<Vec3> read_vertices(const py::object& vertices, const Threads& threads = Threads(1)) {
  return read_points(vertices, "vertices", "(V, 3)", threads);
}

/// (F, 3) integers with any strides, copied.
/// \throws InvalidInput  another shape or kind of number; an index that is out of the range of int32: the message
///                       names the face, and `vertex_count` as how many there are
std::vector<Triangle> read_triangles(const py::object& triangles, std::size_t vertex_count);

/// (K, 2) integers with any strides, copied.
/// \throws InvalidInput  as above
std::vector<std::array<std::int32_t, 2>> read_pairs(const py::object& pairs, const std::string& name);

/// (n) integers with any strides, copied.
/// \throws InvalidInput  as above; `shape` is for the message
std::vector<std::int32_t> read_indices(const py::object& indices, const std::string& name, const std::string& shape);

/// (n) float32 or float64 with any strides, copied.
/// \throws InvalidInput  as above
std::vector<double> read_numbers(const py::object& numbers, const std::string& name, const std::string& shape);

/// A numpy array over memory that `owner` keeps alive.
template <class T>
py::array array_over(std::span<const T> items, py::handle owner) {
  const auto n = static_cast<py::ssize_t>(items.size());
  if constexpr (std::is_same_v<T, Vec3>) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    return py::array_t<double>({n, py::ssize_t{3}}, reinterpret_cast<const double*>(items.data()), owner);
  } else if constexpr (std::is_same_v<T, Triangle>) {
    return py::array_t<std::int32_t>({n, py::ssize_t{3}}, reinterpret_cast<const std::int32_t*>(items.data()), owner);
  } else if constexpr (std::is_same_v<T, std::array<std::int32_t, 2>>) {
    return py::array_t<std::int32_t>({n, py::ssize_t{2}}, reinterpret_cast<const std::int32_t*>(items.data()), owner);
  } else {
    return py::array_t<T>(n, items.data(), owner);
  }
}

/// A writable numpy array that owns the memory of a vector: (n), (n, 3) for Vec3 and Triangle, or (n, 2) for pairs.
template <class T, class Allocator>
py::array owned(std::vector<T, Allocator>&& items) {
  using Items = std::vector<T, Allocator>;
  auto* kept = new Items(std::move(items));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Items*>(memory); });
  return array_over(std::span<const T>(*kept), owner);
}

/// A read-only numpy array over memory of `owner`, which it keeps alive: (n) for numbers, (n, 3) for Vec3 and Triangle.
template <class T>
py::array view(std::span<const T> items, py::handle owner) {
  py::array array = array_over(items, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

template <class T>
py::array view(const std::vector<T>& items, py::handle owner) {
  return view(std::span<const T>(items), owner);
}

/// The getter of a property of `Self` that shows its memory, for a member or a member function.
template <class Self, class Member>
auto viewer(Member member) {
  return [member](const py::object& self) { return view(std::invoke(member, self.cast<const Self&>()), self); };
}

/// Three numbers.
/// \throws InvalidInput  another number of them, or another kind
Vec3 read_direction(const py::object& direction, const std::string& name);

}  // namespace isimp::bindings
