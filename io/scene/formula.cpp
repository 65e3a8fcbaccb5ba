// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/formula.h"

#include <vtkExprTkFunctionParser.h>
#include <vtkNew.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
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

/// The end of the number, name or symbol that begins at text[i].
size_t end_of_token(const std::string& text, size_t i) {
  const auto is_digit = [&](size_t k) {
    return k < text.size() && std::isdigit(static_cast<unsigned char>(text[k]));
  };
  size_t end = i + 1;
  if (starts_name(text[i])) {
    while (end < text.size() && in_name(text[end])) ++end;
  } else if (is_digit(i) || text[i] == '.') {
    while (is_digit(end) || (end < text.size() && text[end] == '.')) ++end;
    const size_t sign = end + 1 < text.size() && (text[end + 1] == '+' || text[end + 1] == '-');
    if (end < text.size() && (text[end] == 'e' || text[end] == 'E') && is_digit(end + 1 + sign))
      for (end += 1 + sign; is_digit(end);) ++end;
  }
  return end;
}

/// The formula as the parser reads it, which ignores spaces. Refuses names that are no coordinate or
/// function, operands without an operator between them, and symbols of statements: ExprTk is a
/// language with loops and assignments.
std::string checked(const std::string& text, const std::vector<std::string>& known) {
  const std::string symbols = "+-*/%^(),<>=!?: \t";
  std::string result;
  bool after_operand = false;
  for (size_t i = 0; i < text.size();) {
    const size_t end = end_of_token(text, i);
    const std::string token = text.substr(i, end - i);
    const bool is_name = starts_name(text[i]);
    const bool is_operand =
        is_name || std::isdigit(static_cast<unsigned char>(text[i])) || text[i] == '.';
    if (is_name && std::find(known.begin(), known.end(), token) == known.end())
      throw InputError("found '" + token + "' in the formula '" + text + "', expected " +
                       expected_one_of(token, known));
    if ((!is_operand && symbols.find(text[i]) == std::string::npos) ||
        text.compare(i, 2, ":=") == 0)
      throw InputError("found '" + token + "' in the formula '" + text +
                       "', expected numbers, x, y, z, operators and functions");
    i = end;
    if (token == " " || token == "\t") continue;
    const bool joins = token == "and" || token == "or";
    if (is_operand && !joins && after_operand)
      throw InputError("found '" + token + "' in the formula '" + text +
                       "', expected an operator before it, such as '*'");
    result += token == "and" ? "&" : token == "or" ? "|" : token;
    after_operand = (is_operand && !joins && token != "not") || token == ")";
  }
  return result;
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
  Parser(const std::string& text, const std::string& without_spaces,
         std::vector<std::pair<std::string, PointField>> fields)
      : fields_(std::move(fields)) {
    for (const char* name : {"x", "y", "z"}) parser_->SetScalarVariableValue(name, 0);
    for (const auto& [name, field] : fields_) parser_->SetScalarVariableValue(name, 0);
    parser_->SetScalarVariableValue("pi", std::numbers::pi);
    parser_->SetReplaceInvalidValues(1);
    parser_->SetReplacementValue(std::numeric_limits<double>::quiet_NaN());
    VtkMessageCapture messages;
    parser_->SetFunction(without_spaces.c_str());
    if (!parser_->IsScalarResult())
      throw InputError("found the formula '" + text + "', expected a formula of x, y, z" +
                       reason_of(messages.first_error()));
  }
  double at(const Vec3& p) {
    for (int c = 0; c < 3; ++c) parser_->SetScalarVariableValue(c, p[c]);
    for (int k = 0; k < isize(fields_); ++k)
      parser_->SetScalarVariableValue(3 + k, fields_[static_cast<size_t>(k)].second.at(p));
    return parser_->GetScalarResult();
  }

 private:
  vtkNew<vtkExprTkFunctionParser> parser_;
  std::vector<std::pair<std::string, PointField>> fields_;
};

Formula::Formula(const std::string& text, const NamedFields& fields) : text_(text) {
  std::vector<std::string> known = known_names();
  for (const auto& [name, field] : fields) known.push_back(name);
  const std::string without_spaces = checked(text, known);
  std::vector<std::pair<std::string, PointField>> used;
  for (size_t i = 0; i < without_spaces.size();) {
    const size_t end = end_of_token(without_spaces, i);
    const auto field = fields.find(without_spaces.substr(i, end - i));
    const auto is_used = [&](const auto& one) { return one.first == field->first; };
    if (field != fields.end() && std::none_of(used.begin(), used.end(), is_used))
      used.emplace_back(*field);
    i = end;
  }
  parser_ = std::make_shared<Parser>(text, without_spaces, std::move(used));
}

bool Formula::is_field_name(const std::string& name) {
  const auto& known = known_names();
  return !name.empty() && starts_name(name[0]) && std::all_of(name.begin(), name.end(), in_name) &&
         std::find(known.begin(), known.end(), name) == known.end();
}

double Formula::operator()(const Vec3& x) const {
  const double value = parser_->at(x);
  if (std::isfinite(value)) return value;
  throw InputError("the formula '" + text_ + "' has no finite value at " + format_point(x));
}

}  // namespace batten
