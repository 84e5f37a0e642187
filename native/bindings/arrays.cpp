#include "arrays.h"

#include <cstring>
#include <string>
#include <utility>

#include "isimp/core/errors.h"

namespace isimp::bindings {
namespace {

/// `object` as numpy sees it, in this machine's byte order.
/// \throws InvalidInput  unless it has `dimensions`, the second of them 3, and numbers of 4 or 8 bytes of a `kind`
py::array read_array(const py::object& object, py::ssize_t dimensions, char kind, const std::string& wanted) {
  const auto array = py::array::ensure(object);
  if (!array) throw InvalidInput(wanted + ", got a " + std::string(py::str(py::type::of(object).attr("__name__"))));
  const py::dtype type = array.dtype();
  const bool shape_fits = array.ndim() == dimensions && (dimensions == 1 || array.shape(1) == 3);
  if (!shape_fits || type.kind() != kind || (type.itemsize() != 4 && type.itemsize() != 8))
    throw InvalidInput(wanted + ", got shape " + std::string(py::str(array.attr("shape"))) + " and " +
                       std::string(py::str(type)));
  if (type.byteorder() == '=') return array;
  return py::array(array.attr("astype")(type.attr("newbyteorder")("=")));
}

template <class T>
T number_at(const char* address) {
  T number;
  std::memcpy(&number, address, sizeof(T));  // a field of a packed record may lie anywhere
  return number;
}

template <class Number, class Row, class Take>
std::vector<Row> copy_rows(const py::array& array, Take take) {
  std::vector<Row> rows(static_cast<std::size_t>(array.shape(0)));
  const auto* data = static_cast<const char*>(array.data());
  const py::ssize_t down = array.strides(0), right = array.strides(1);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      rows[i][k] =
          take(number_at<Number>(data + static_cast<py::ssize_t>(i) * down + static_cast<py::ssize_t>(k) * right), i);
  return rows;
}

}  // namespace

std::vector<Vec3> read_vertices(const py::object& vertices) {
  const py::array array =
      read_array(vertices, 2, 'f', "vertices must be an array of shape (V, 3) and float32 or float64");
  if (array.itemsize() == 4)
    return copy_rows<float, Vec3>(array, [](float x, std::size_t) { return static_cast<double>(x); });
  return copy_rows<double, Vec3>(array, [](double x, std::size_t) { return x; });
}

std::vector<Triangle> read_triangles(const py::object& triangles, std::size_t vertex_count) {
  const py::array array =
      read_array(triangles, 2, 'i', "triangles must be an array of shape (F, 3) and int32 or int64");
  if (array.itemsize() == 4)
    return copy_rows<std::int32_t, Triangle>(array, [](std::int32_t v, std::size_t) { return v; });
  return copy_rows<std::int64_t, Triangle>(array, [&](std::int64_t v, std::size_t face) {
    if (!std::in_range<std::int32_t>(v))
      throw InvalidInput("face " + std::to_string(face) + " uses vertex " + std::to_string(v) + ", but there are " +
                         std::to_string(vertex_count) + " vertices");
    return static_cast<std::int32_t>(v);
  });
}

std::vector<std::int32_t> read_indices(const py::object& indices, const std::string& name, const std::string& shape) {
  const py::array array =
      read_array(indices, 1, 'i', name + " must be an array of shape " + shape + " and int32 or int64");
  const auto* data = static_cast<const char*>(array.data());
  std::vector<std::int32_t> result(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const char* address = data + static_cast<py::ssize_t>(i) * array.strides(0);
    const std::int64_t value =
        array.itemsize() == 4 ? number_at<std::int32_t>(address) : number_at<std::int64_t>(address);
    if (!std::in_range<std::int32_t>(value))
      throw InvalidInput(name + "[" + std::to_string(i) + "] is " + std::to_string(value) + ", which no index can be");
    result[i] = static_cast<std::int32_t>(value);
  }
  return result;
}

}  // namespace isimp::bindings
