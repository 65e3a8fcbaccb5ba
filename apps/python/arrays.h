// Arrays of numpy from and to the kernel's numbers.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/python/bindings.h"
#include "batten/core/eigen.h"

namespace batten::python {

/// The numbers of an array or of anything that numpy makes one of. Throws InputError that begins with
/// `what` and says what was found and what was expected:
///
///     points      n×3, whole or floating-point numbers, finite
///     vector      three such numbers
///     numbers     n such numbers
///     indices     n whole numbers from 0 to count-1, or a mask of `count` truth values
///     triangles   m×3 whole numbers, not below 0
///     truth       True or False, or None: not said
Points points_from(py::handle given, const std::string& what);
Vec3 vector_from(py::handle given, const std::string& what);
std::vector<double> numbers_from(py::handle given, const std::string& what);
std::vector<int> indices_from(py::handle given, const std::string& what, int count);
std::vector<std::array<int, 3>> triangles_from(py::handle given, const std::string& what);

std::optional<bool> optional_bool_from(const py::object& given, const std::string& what);

/// Rows of a point matrix.
std::vector<Vec3> rows_of(const Points& points);

/// An array on memory that `owner` keeps: nothing is copied, and the array keeps the owner. It cannot
/// be written to. `strides` in bytes.
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

/// The same for n rows of `columns` numbers that lie one row after the other.
template <class Number>
py::array rows_view(std::shared_ptr<const void> owner, const Number* data, py::ssize_t rows,
                    py::ssize_t columns) {
  const auto size = static_cast<py::ssize_t>(sizeof(Number));
  return array_view(std::move(owner), data, {rows, columns}, {columns * size, size});
}

/// An n×3 array of a point matrix (column after column in memory), which it takes over.
py::array array_of(Points points);
/// An array of numbers, which it takes over.
py::array array_of(std::vector<double> numbers);
py::array array_of(std::vector<int> numbers);
/// An array of triangles, m×3, which it takes over.
py::array array_of(std::vector<std::array<int, 3>> triangles);

}  // namespace batten::python
