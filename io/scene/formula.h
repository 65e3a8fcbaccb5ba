// SPDX-License-Identifier: MPL-2.0
// Formulas of the coordinates in scenes.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "batten/core/eigen.h"
#include "batten/io/vtk/point_field.h"

namespace batten {

/// Named fields, which formulas may use like coordinates.
using NamedFields = std::map<std::string, PointField>;

/// A formula of the coordinates x, y, z of a point, such as "9.81e-6 * max(0, 120 - z)", and of the
/// values of fields.
///
/// Operators: + - * / % ^, comparisons, `and`, `or`, `not`, `condition ? a : b`. Functions: abs, acos,
/// asin, atan, atan2, ceil, cos, cosh, exp, floor, hypot, if, log, log10, max, min, mod, pow, round,
/// sgn, sin, sinh, sqrt, tan, tanh; angles in radians. Constant: pi. VTK's ExprTk parser evaluates the
/// formula in about 0.1 µs. Copies share the parser: use them in one thread at a time.
class Formula {
 public:
  /// Parses a formula. Throws InputError with what was found and what is expected.
  explicit Formula(const std::string& text, const NamedFields& fields = {});
  /// Whether a name can be that of a field: letters, digits and '_', not that of a coordinate or
  /// function.
  static bool is_field_name(const std::string& name);

  /// The value at the point x. Throws InputError if it is not a finite number, and as
  /// PointField::at().
  double operator()(const Vec3& x) const;
  const std::string& text() const { return text_; }

 private:
  class Parser;
  std::string text_;
  std::shared_ptr<Parser> parser_;
};

}  // namespace batten
