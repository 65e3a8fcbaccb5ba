// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/formula.h"

#include <vtkExprTkFunctionParser.h>
#include <vtkNew.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/vtk/vtk_message_capture.h"

namespace batten {
namespace {

const std::vector<std::string>& known_names() {
  static const std::vector<std::string> names = {
      "x",     "y",   "z",     "pi",    "abs",  "acos", "asin",  "atan", "atan2", "ceil", "cos",
      "cosh",  "exp", "floor", "hypot", "if",   "log",  "log10", "max",  "min",   "mod",  "pow",
      "round", "sgn", "sin",   "sinh",  "sqrt", "tan",  "tanh",  "and",  "or",    "not"};
  return names;
}

bool starts_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool in_name(char c) { return starts_name(c) || std::isdigit(static_cast<unsigned char>(c)); }

/// Refuses names that are no coordinate or function, and symbols of statements: ExprTk is a language
/// with loops and assignments.
void check_symbols(const std::string& text) {
  const std::string permitted = "0123456789.+-*/%^(), <>=!?:\t";
  for (size_t i = 0; i < text.size();) {
    const bool of_number =
        i > 0 && (std::isdigit(static_cast<unsigned char>(text[i - 1])) || text[i - 1] == '.');
    if ((text[i] == 'e' || text[i] == 'E') && of_number) {  // an exponent
      ++i;
    } else if (starts_name(text[i])) {
      size_t end = i;
      while (end < text.size() && in_name(text[end])) ++end;
      const std::string name = text.substr(i, end - i);
      const auto& known = known_names();
      if (std::find(known.begin(), known.end(), name) == known.end())
        throw InputError("found '" + name + "' in the formula '" + text + "', " +
                         expected_one_of(name, known));
      i = end;
    } else if (permitted.find(text[i]) == std::string::npos || text.compare(i, 2, ":=") == 0) {
      throw InputError("found '" + text.substr(i, 1) + "' in the formula '" + text +
                       "', expected numbers, x, y, z, operators and functions");
    } else {
      ++i;
    }
  }
}

/// The first message of the parser without its codes.
std::string reason_of(std::string message) {
  const size_t first = message.find(" - ");
  if (first == std::string::npos) return "";
  message = message.substr(first + 3);
  return ": " + message.substr(0, message.find_first_of("\t\n"));
}

}  // namespace

class Formula::Parser {
 public:
  explicit Parser(const std::string& text) {
    for (const char* name : {"x", "y", "z"}) parser_->SetScalarVariableValue(name, 0);
    parser_->SetScalarVariableValue("pi", std::numbers::pi);
    parser_->SetReplaceInvalidValues(1);
    parser_->SetReplacementValue(std::numeric_limits<double>::quiet_NaN());
    VtkMessageCapture messages;
    parser_->SetFunction(text.c_str());
    if (!parser_->IsScalarResult())
      throw InputError("found the formula '" + text + "', expected a formula of x, y, z" +
                       reason_of(messages.first_error()));
  }
  double at(const Vec3& p) {
    for (int c = 0; c < 3; ++c) parser_->SetScalarVariableValue(c, p[c]);
    return parser_->GetScalarResult();
  }

 private:
  vtkNew<vtkExprTkFunctionParser> parser_;
};

Formula::Formula(const std::string& text) : text_(text) {
  check_symbols(text);
  parser_ = std::make_shared<Parser>(text);
}

double Formula::operator()(const Vec3& x) const {
  const double value = parser_->at(x);
  if (std::isfinite(value)) return value;
  throw InputError("the formula '" + text_ + "' has no finite value at " + format_point(x));
}

}  // namespace batten
