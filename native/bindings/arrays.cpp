#include "arrays.h"

#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "isimp/core/errors.h"

namespace isimp::bindings {
namespace {

/// `object` as a numpy array, in this machine's byte order.
/// \throws InvalidInput  unless it is (n, columns), or (n) for no columns, of one of the `kinds` of numbers: integers
///                       ("iu") of any size, "f" of 4 or 8 bytes
py::array read_array(const py::object& object, py::ssize_t columns, std::string_view kinds, const std::string& wanted) {
  const auto array = py::array::ensure(object);
  if (!array) throw InvalidInput(wanted + ", got a " + std::string(py::str(py::type::of(object).attr("__name__"))));
  const py::dtype type = array.dtype();
  const bool shape_fits = columns == 0 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns;
  const bool kind_fits = kinds.find(type.kind()) != kinds.npos;
  if (!shape_fits || !kind_fits || (type.kind() == 'f' && type.itemsize() != 4 && type.itemsize() != 8))
    throw InvalidInput(wanted + ", got shape " + std::string(py::str(array.attr("shape"))) + " and " +
                       std::string(py::str(type)));
  if (type.byteorder() == '=' || type.itemsize() == 1) return array;
  return py::array(array.attr("astype")(type.attr("newbyteorder")("=")));
}

template <class T>
T number_at(const char* address) {
  T number;
  std::memcpy(&number, address, sizeof(T));  // a field of a packed record may lie anywhere
  return number;
}

/// The numbers of an array row by row, each converted by `take(number, row)`.
template <class Number, class Take>
void for_each(const py::array& array, Take take) {
  const auto* data = static_cast<const char*>(array.data());
  const py::ssize_t columns = array.ndim() == 1 ? 1 : array.shape(1);
  const py::ssize_t down = array.strides(0), right = array.ndim() == 1 ? 0 : array.strides(1);
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    for (py::ssize_t k = 0; k < columns; ++k)
      take(number_at<Number>(data + i * down + k * right), static_cast<std::size_t>(i), static_cast<std::size_t>(k));
}

/// Calls take(value, row, column) with the numbers of a floating-point array.
template <class Take>
void for_each_real(const py::array& array, Take take) {
  if (array.itemsize() == 4)
    for_each<float>(array, take);
  else
    for_each<double>(array, take);
}

/// Calls take(value, row, column) with the numbers of an array of indices.
/// \throws InvalidInput  by `refuse`
template <class Take, class Refuse>
void for_each_index(const py::array& array, Take take, Refuse refuse) {
  const auto each = [&](auto zero) {
    for_each<decltype(zero)>(array, [&](auto value, std::size_t row, std::size_t column) {
      if (!std::in_range<std::int32_t>(value)) throw InvalidInput(refuse(std::to_string(value), row));
      take(static_cast<std::int32_t>(value), row, column);
    });
  };
  const bool is_signed = array.dtype().kind() == 'i';
  switch (array.itemsize()) {
    case 1:
      return is_signed ? each(std::int8_t{}) : each(std::uint8_t{});
    case 2:
      return is_signed ? each(std::int16_t{}) : each(std::uint16_t{});
    case 4:
      return is_signed ? each(std::int32_t{}) : each(std::uint32_t{});
    default:
      return is_signed ? each(std::int64_t{}) : each(std::uint64_t{});
  }
}

std::size_t rows_of(const py::array& array) { return static_cast<std::size_t>(array.shape(0)); }

/// Whether the numbers lie one after another, row by row, aligned for their type.
bool is_packed(const py::array& array) {
  constexpr int kPacked = int{py::array::c_style} | int{py::detail::npy_api::NPY_ARRAY_ALIGNED_};  // format
  return (array.flags() & kPacked) == kPacked;
}

/// Sets points from packed numbers.
template <class T>
void convert(const T* numbers, std::vector<Vec3>& points, const Threads& threads) {
  threads.run(static_cast<std::int32_t>(points.size()), [&](std::int32_t, std::int32_t begin, std::int32_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        points[i][static_cast<Eigen::Index>(k)] = static_cast<double>(numbers[3 * i + k]);
  });
}

}  // namespace

std::vector<Vec3> read_points(const py::object& points, const std::string& name, const std::string& shape,
                              const Threads& threads) {
  const py::array array =
      read_array(points, 3, "f", name + " must be an array of shape " + shape + " and float32 or float64");
  std::vector<Vec3> rows(rows_of(array));
  if (is_packed(array) && rows.size() <= INT32_MAX) {
    if (array.itemsize() == sizeof(float))
      convert(static_cast<const float*>(array.data()), rows, threads);
    else
      convert(static_cast<const double*>(array.data()), rows, threads);
    return rows;
  }
  for_each_real(array, [&](double x, std::size_t i, std::size_t k) { rows[i][static_cast<Eigen::Index>(k)] = x; });
  return rows;
}

std::vector<Triangle> read_triangles(const py::object& triangles, std::size_t vertex_count) {
  const py::array array = read_array(triangles, 3, "iu", "triangles must be an array of shape (F, 3) and integers");
  if (array.dtype().kind() == 'i' && array.itemsize() == sizeof(std::int32_t) && is_packed(array)) {
    const auto* first = static_cast<const Triangle*>(array.data());
    return {first, first + rows_of(array)};  // every number fits: copied as it is, without initialising the memory
                                             // first
  }
  std::vector<Triangle> rows(rows_of(array));
  for_each_index(
      array, [&](std::int32_t v, std::size_t i, std::size_t k) { rows[i][k] = v; },
      [&](const std::string& v, std::size_t i) {
        return "face " + std::to_string(i) + " uses vertex " + v + ", but there are " + std::to_string(vertex_count) +
               " vertices";
      });
  return rows;
}

std::vector<std::array<std::int32_t, 2>> read_pairs(const py::object& pairs, const std::string& name) {
  const py::array array = read_array(pairs, 2, "iu", name + " must be an array of shape (K, 2) and integers");
  std::vector<std::array<std::int32_t, 2>> rows(rows_of(array));
  for_each_index(
      array, [&](std::int32_t v, std::size_t i, std::size_t k) { rows[i][k] = v; },
      [&](const std::string& v, std::size_t i) {
        return name + "[" + std::to_string(i) + "] names " + v + ", which no index can be";
      });
  return rows;
}

std::vector<std::int32_t> read_indices(const py::object& indices, const std::string& name, const std::string& shape) {
  const py::array array = read_array(indices, 0, "iu", name + " must be an array of shape " + shape + " and integers");
  std::vector<std::int32_t> result(rows_of(array));
  for_each_index(
      array, [&](std::int32_t v, std::size_t i, std::size_t) { result[i] = v; },
      [&](const std::string& v, std::size_t i) {
        return name + "[" + std::to_string(i) + "] is " + v + ", which no index can be";
      });
  return result;
}

std::vector<double> read_numbers(const py::object& numbers, const std::string& name, const std::string& shape) {
  const py::array array =
      read_array(numbers, 0, "f", name + " must be an array of shape " + shape + " and float32 or float64");
  std::vector<double> result(rows_of(array));
  for_each_real(array, [&](double x, std::size_t i, std::size_t) { result[i] = x; });
  return result;
}

Vec3 read_direction(const py::object& direction, const std::string& name) {
  py::array given = py::module_::import("numpy").attr("asarray")(direction);
  if (given.dtype().kind() == 'i' || given.dtype().kind() == 'u') given = given.attr("astype")("float64");
  const std::vector<double> numbers = read_numbers(given, name, "(3,)");
  if (numbers.size() != 3) throw InvalidInput(name + " must have 3 numbers, got " + std::to_string(numbers.size()));
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace isimp::bindings
