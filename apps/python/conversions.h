// SPDX-License-Identifier: MPL-2.0
// Conversions between Python objects and the kernel's types: NumPy arrays, parameter values, JSON,
// file names.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/apps/python/bindings.h"
#include "batten/core/eigen.h"

namespace batten::python {

/// Convert an array, or anything that NumPy can convert to one. They throw InputError, with a
/// message that starts with `what` and gives the found and the expected value. Accepted input:
///
///     points_from          n×3 integers or floats, finite
///     vector_from          three such numbers
///     numbers_from         n such numbers
///     indices_from         n integers from 0 to count - 1, or a mask of `count` booleans
///     faces_from           m×3 or m×4 integers, or m lists of 3 or more integers, not negative
///     optional_bool_from   True or False, or None: no value
///     names_from           texts, but not a single one
Points points_from(py::handle given, const std::string& what);
Vec3 vector_from(py::handle given, const std::string& what);
std::vector<double> numbers_from(py::handle given, const std::string& what);
std::vector<int> indices_from(py::handle given, const std::string& what, int count);
std::vector<std::vector<int>> faces_from(py::handle given, const std::string& what);

std::optional<bool> optional_bool_from(const py::object& given, const std::string& what);
std::vector<std::string> names_from(const py::iterable& given, const std::string& what);

/// Rows of a point matrix as vectors.
std::vector<Vec3> rows_of(const Points& points);

/// A read-only array that views memory of `owner` without copying, and keeps the owner alive.
/// `strides` are in bytes.
template <class Number>
py::array array_view(std::shared_ptr<const void> owner, const Number* data,
                     std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides) {
  const py::capsule base(new std::shared_ptr<const void>(std::move(owner)), [](void* kept) {
    delete static_cast<std::shared_ptr<const void>*>(kept);
  });
  py::array array(py::dtype::of<Number>(), std::move(shape), std::move(strides), data, base);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// The same for n contiguous rows of `columns` numbers each.
template <class Number>
py::array rows_view(std::shared_ptr<const void> owner, const Number* data, py::ssize_t rows,
                    py::ssize_t columns) {
  const auto size = static_cast<py::ssize_t>(sizeof(Number));
  return array_view(std::move(owner), data, {rows, columns}, {columns * size, size});
}

/// An n×3 array that takes ownership of a (column-major) point matrix.
py::array array_of(Points points);
/// An array of the three coordinates.
py::array array_of(const Vec3& vector);
/// One-dimensional arrays that take ownership of the numbers.
py::array array_of(std::vector<double> numbers);
py::array array_of(std::vector<int> numbers);
/// An m×3 array that takes ownership of the triangles.
py::array array_of(std::vector<std::array<int, 3>> triangles);

// Other objects.

/// Numbers by name, from a dict or None. Throws InputError for values that are not numbers.
std::vector<std::pair<std::string, double>> values_from(const py::object& given,
                                                        const std::string& what = "values");

/// Sets the parameter values in any kind of scene.
template <class AnyScene>
void set_values(AnyScene& scene, const py::object& given) {
  for (const auto& [name, value] : values_from(given)) scene.set(name, value, "values: ");
}

/// Converts a JSON text to Python dicts and lists.
py::object json_object(const std::string& text);

/// Converts a str or an os.PathLike to a file name. Throws InputError.
std::string path_from(const py::object& given);

}  // namespace batten::python
