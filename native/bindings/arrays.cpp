#include "arrays.h"

#include <cstring>
#include <limits>
#include <string>

#include "isimp/core/errors.h"

namespace isimp::bindings {
namespace {

/// `array` as numpy sees it. \throws InvalidInput  unless it is (any, 3) of one of two kinds of number
py::array read_rows(const py::object& object, const std::string& name, const std::string& wanted, char kind) {
  const std::string must = name + " must be an array of " + wanted + ", got ";
  const auto array = py::array::ensure(object);
  if (!array) throw InvalidInput(must + "a " + std::string(py::str(py::type::of(object).attr("__name__"))));
  const py::dtype type = array.dtype();
  if (array.ndim() != 2 || array.shape(1) != 3 || type.kind() != kind || (type.itemsize() != 4 && type.itemsize() != 8))
    throw InvalidInput(must + "shape " + std::string(py::str(array.attr("shape"))) + " and " +
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
  const py::array array = read_rows(vertices, "vertices", "shape (V, 3) and float32 or float64", 'f');
  if (array.itemsize() == 4)
    return copy_rows<float, Vec3>(array, [](float x, std::size_t) { return static_cast<double>(x); });
  return copy_rows<double, Vec3>(array, [](double x, std::size_t) { return x; });
}

std::vector<Triangle> read_triangles(const py::object& triangles, std::size_t vertex_count) {
  const py::array array = read_rows(triangles, "triangles", "shape (F, 3) and int32 or int64", 'i');
  if (array.itemsize() == 4)
    return copy_rows<std::int32_t, Triangle>(array, [](std::int32_t v, std::size_t) { return v; });
  return copy_rows<std::int64_t, Triangle>(array, [&](std::int64_t v, std::size_t face) {
    using Limits = std::numeric_limits<std::int32_t>;
    if (v < Limits::min() || v > Limits::max())
      throw InvalidInput("face " + std::to_string(face) + " uses vertex " + std::to_string(v) + ", but there are " +
                         std::to_string(vertex_count) + " vertices");
    return static_cast<std::int32_t>(v);
  });
}

}  // namespace isimp::bindings
