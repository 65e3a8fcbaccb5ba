// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/python/conversions.h"

#include <cmath>
#include <limits>

#include "batten/core/errors.h"

namespace batten::python {
namespace {

std::string format_shape(const py::array& array) {
  std::string words;
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    words += (i ? "×" : "") + std::to_string(array.shape(i));
  return array.ndim() == 0 ? "a single value" : "an array of " + words;
}

/// Converts to an array whose dtype is of one of these kinds (NumPy's kind letters).
py::array array_from(py::handle given, const std::string& what, const std::string& kinds,
                     const std::string& expected) {
  const py::array array = py::array::ensure(given);
  if (!array)
    throw InputError(what + ": found rows of different lengths or no array, expected " + expected);
  if (kinds.find(array.dtype().kind()) == std::string::npos)
    throw InputError(what + ": found values of type '" +
                     std::string(py::str(array.dtype().attr("name"))) + "', expected " + expected);
  return array;
}

py::array_t<double> doubles_from(py::handle given, const std::string& what,
                                 const std::string& expected) {
  const py::array array = array_from(given, what, "fiu", expected);
  return py::array_t<double, py::array::forcecast>(array);
}

double finite(double value, const std::string& what, py::ssize_t row) {
  if (std::isfinite(value)) return value;
  throw InputError(what + ": found " + format_number(value) + " in row " + std::to_string(row) +
                   " (from 0), expected finite numbers");
}

/// Converts to an array of 64-bit integers.
py::array_t<long long> integers_from(py::handle given, const std::string& what,
                                     const std::string& expected) {
  py::array array = py::array::ensure(given);
  // NumPy gives [] the type float.
  if (array && array.size() == 0) return py::array_t<long long>(0);
  array = array_from(given, what, "iu", expected);
  return py::array_t<long long, py::array::forcecast>(array);
}

int integer_in_range(long long value, const std::string& what, long long count) {
  if (value < 0 || value >= count)
    throw InputError(what + ": found " + std::to_string(value) + ", expected 0 to " +
                     std::to_string(count - 1));
  return static_cast<int>(value);
}

template <class Number>
py::array list_view(std::vector<Number> numbers) {
  const auto owner = std::make_shared<const std::vector<Number>>(std::move(numbers));
  return array_view(owner, owner->data(), {static_cast<py::ssize_t>(owner->size())},
                    {static_cast<py::ssize_t>(sizeof(Number))});
}

}  // namespace

Points points_from(py::handle given, const std::string& what) {
  const std::string expected = "n×3 numbers, one point per row";
  const py::array_t<double> array = doubles_from(given, what, expected);
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw InputError(what + ": found " + format_shape(array) + ", expected " + expected);
  Points points(array.shape(0), 3);
  const auto at = array.unchecked<2>();
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    for (py::ssize_t j = 0; j < 3; ++j) points(i, j) = finite(at(i, j), what, i);
  return points;
}

std::vector<double> numbers_from(py::handle given, const std::string& what) {
  const std::string expected = "n numbers";
  const py::array_t<double> array = doubles_from(given, what, expected);
  if (array.ndim() != 1)
    throw InputError(what + ": found " + format_shape(array) + ", expected " + expected);
  std::vector<double> numbers;
  const auto at = array.unchecked<1>();
  for (py::ssize_t i = 0; i < array.shape(0); ++i) numbers.push_back(finite(at(i), what, i));
  return numbers;
}

Vec3 vector_from(py::handle given, const std::string& what) {
  const py::array_t<double> array = doubles_from(given, what, "three numbers");
  if (array.ndim() != 1 || array.shape(0) != 3)
    throw InputError(what + ": found " + format_shape(array) + ", expected three numbers");
  const auto at = array.unchecked<1>();
  return {finite(at(0), what, 0), finite(at(1), what, 1), finite(at(2), what, 2)};
}

std::vector<int> indices_from(py::handle given, const std::string& what, int count) {
  std::string expected = "whole numbers from 0";
  if (count < std::numeric_limits<int>::max())
    expected += ", or a mask of " + std::to_string(count);
  std::vector<int> indices;
  const py::array any = py::array::ensure(given);
  if (any && any.dtype().kind() == 'b') {
    if (any.ndim() != 1 || any.shape(0) != count)
      throw InputError(what + ": found " + format_shape(any) + " as a mask, expected " + expected);
    const py::array_t<bool> mask(any);
    for (int i = 0; i < count; ++i)
      if (mask.at(i)) indices.push_back(i);
    return indices;
  }
  const py::array_t<long long> array = integers_from(given, what, expected);
  if (array.ndim() != 1)
    throw InputError(what + ": found " + format_shape(array) + ", expected " + expected);
  const auto at = array.unchecked<1>();
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    indices.push_back(integer_in_range(at(i), what, count));
  return indices;
}

namespace {

/// One face from a list of at least three vertices.
std::vector<int> face_from(py::handle given, const std::string& what, const std::string& expected) {
  constexpr py::ssize_t fewest = 3;
  const py::array_t<long long> array = integers_from(given, what, expected);
  if (array.ndim() != 1 || array.shape(0) < fewest)
    throw InputError(what + ": found " + format_shape(array) + " for one face, expected " +
                     expected);
  std::vector<int> face;
  const auto at = array.unchecked<1>();
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    face.push_back(integer_in_range(at(i), what, 1LL << 31));
  return face;
}

}  // namespace

std::vector<std::vector<int>> faces_from(py::handle given, const std::string& what) {
  const std::string expected =
      "m×3 or m×4 whole numbers, or a list of faces, each a list of 3 or more whole numbers";
  constexpr py::ssize_t triangle = 3, quad = 4;
  const auto is_regular = [](const py::array& array) {
    return array && array.ndim() == 2 && (array.shape(1) == triangle || array.shape(1) == quad);
  };
  std::vector<std::vector<int>> faces;
  const bool is_list = py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given);
  if (is_list && !is_regular(py::array::ensure(given))) {
    for (const py::handle one : given) faces.push_back(face_from(one, what, expected));
    return faces;
  }
  const py::array_t<long long> array = integers_from(given, what, expected);
  if (!is_regular(array))
    throw InputError(what + ": found " + format_shape(array) + ", expected " + expected);
  const auto at = array.unchecked<2>();
  faces.assign(static_cast<size_t>(array.shape(0)),
               std::vector<int>(static_cast<size_t>(array.shape(1))));
  for (py::ssize_t i = 0; i < array.shape(0); ++i)
    for (py::ssize_t j = 0; j < array.shape(1); ++j)
      faces[static_cast<size_t>(i)][static_cast<size_t>(j)] =
          integer_in_range(at(i, j), what, 1LL << 31);
  return faces;
}

std::optional<bool> optional_bool_from(const py::object& given, const std::string& what) {
  if (given.is_none()) return {};
  if (given.ptr() == Py_True || given.ptr() == Py_False) return given.ptr() == Py_True;
  throw InputError(what + ": found " + std::string(py::repr(given)) + ", expected True or False");
}

std::vector<std::string> names_from(const py::iterable& given, const std::string& what) {
  if (py::isinstance<py::str>(given))
    throw InputError(what + ": found a single text, expected a list of names");
  std::vector<std::string> names;
  for (const py::handle name : given) names.push_back(py::str(name));
  return names;
}

std::vector<Vec3> rows_of(const Points& points) {
  std::vector<Vec3> rows;
  for (long i = 0; i < points.rows(); ++i) rows.emplace_back(points.row(i).transpose());
  return rows;
}

py::array array_of(Points points) {
  const auto owner = std::make_shared<const Points>(std::move(points));
  const auto size = static_cast<py::ssize_t>(sizeof(double));
  return array_view(owner, owner->data(), {owner->rows(), 3}, {size, owner->rows() * size});
}

py::array array_of(const Vec3& vector) {
  return array_of(std::vector<double>{vector.x(), vector.y(), vector.z()});
}

py::array array_of(std::vector<double> numbers) { return list_view(std::move(numbers)); }

py::array array_of(std::vector<int> numbers) { return list_view(std::move(numbers)); }

py::array array_of(std::vector<std::array<int, 3>> triangles) {
  const auto owner = std::make_shared<const std::vector<std::array<int, 3>>>(std::move(triangles));
  return rows_view(owner, owner->empty() ? nullptr : owner->front().data(),
                   static_cast<py::ssize_t>(owner->size()), 3);
}

std::vector<std::pair<std::string, double>> values_from(const py::object& given,
                                                        const std::string& what) {
  std::vector<std::pair<std::string, double>> values;
  if (given.is_none()) return values;
  if (!py::isinstance<py::dict>(given))
    throw InputError(what + ": found " + std::string(py::repr(given)) +
                     ", expected a dict of numbers such as {\"swell\": 250}");
  for (const auto& [name, value] : given.cast<py::dict>()) {
    const std::string text = py::str(name);
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred()) {
      PyErr_Clear();
      throw InputError(what + "['" + text + "']: found " + std::string(py::repr(value)) +
                       ", expected a number");
    }
    values.emplace_back(text, number);
  }
  return values;
}

py::object json_object(const std::string& text) {
  return py::module_::import("json").attr("loads")(text);
}

std::string path_from(const py::object& given) {
  try {
    return py::str(py::module_::import("os").attr("fspath")(given));
  } catch (const py::error_already_set&) {
    throw InputError("found " + std::string(py::repr(given)) + ", expected a file name");
  }
}

}  // namespace batten::python
