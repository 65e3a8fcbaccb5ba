// SPDX-License-Identifier: MPL-2.0
// Signatures of the functions of the module, as inspect.signature() and editors read them, and
// messages about keyword arguments that a function does not have.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "batten/apps/python/bindings.h"
#include "batten/core/errors.h"

namespace batten::python {
namespace {

/// The arguments in the text between the parentheses of a signature: "a: int, b: str = 'x, y'".
std::vector<std::string> split_arguments(const std::string& text) {
  std::vector<std::string> parts;
  std::string part;
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote)
      quote = c == quote ? 0 : quote;
    else if (c == '\'' || c == '"')
      quote = c;
    else if (std::strchr("([{", c))
      ++depth;
    else if (std::strchr(")]}", c))
      --depth;
    if (c == ',' && depth == 0 && !quote) {
      parts.push_back(part);
      part.clear();
    } else if (!(part.empty() && c == ' ')) {
      part += c;
    }
  }
  if (!part.empty()) parts.push_back(part);
  return parts;
}

/// An argument without its type: "b='x, y'".
std::string without_type(const std::string& argument) {
  const size_t colon = argument.find(':');
  if (colon == std::string::npos) return argument;
  std::string text = argument.substr(0, colon);
  const size_t equals = argument.find(" = ", colon);
  if (equals == std::string::npos) return text;
  std::string value = argument.substr(equals + 3);
  if (value == "inf" || value == "-inf") value.replace(value.size() - 3, 3, "1e999");
  return text + "=" + value;
}

/// The docstring that pybind11 wrote, "f(a: int) -> str\n\nText", as Python parses it: "f(a)\n--\n\nText".
std::string with_text_signature(const std::string& doc) {
  const size_t open = doc.find('('), end = doc.find('\n');
  const std::string line = doc.substr(0, end);
  const size_t close = line.rfind(") -> ");
  if (open == std::string::npos || close == std::string::npos || close < open) return doc;
  std::string text = line.substr(0, open + 1);
  bool first = true;
  for (const std::string& argument : split_arguments(line.substr(open + 1, close - open - 1))) {
    text +=
        (first ? "" : ", ") + (argument.starts_with("self:") ? "$self" : without_type(argument));
    first = false;
  }
  size_t words = end == std::string::npos ? doc.size() : doc.find_first_not_of('\n', end);
  if (words == std::string::npos) words = doc.size();
  return text + ")\n--\n\n" + doc.substr(words);
}

/// pybind11's entry point of all functions, which the following function calls.
PyCFunctionWithKeywords dispatcher = nullptr;

/// Message about the first keyword that no overload has; empty if there is none.
std::string unknown_keyword(const py::detail::function_record& function, const py::dict& keywords) {
  std::vector<std::string> names;
  for (const auto* overload = &function; overload; overload = overload->next) {
    if (overload->has_kwargs) return "";
    for (const py::detail::argument_record& argument : overload->args)
      if (argument.name && std::strcmp(argument.name, "self") != 0) names.push_back(argument.name);
  }
  const std::string name = std::strcmp(function.name, "__init__") == 0
                               ? py::str(function.scope.attr("__name__")).cast<std::string>()
                               : function.name;
  for (const auto& [key, value] : keywords) {
    const std::string keyword = py::str(key);
    if (std::find(names.begin(), names.end(), keyword) != names.end()) continue;
    std::string expected;
    for (const std::string& one : names) expected += (expected.empty() ? "" : ", ") + one;
    return name + "() got an unexpected keyword argument '" + keyword + "', expected " +
           (names.empty() ? "none" : expected) + did_you_mean(keyword, names);
  }
  return "";
}

/// Calls a function of pybind11; replaces its TypeError, which lists types of C++, if a keyword is
/// unknown.
PyObject* call_function(PyObject* self, PyObject* arguments, PyObject* keywords) {
  PyObject* result = dispatcher(self, arguments, keywords);
  if (result || !keywords || !PyErr_ExceptionMatches(PyExc_TypeError)) return result;
  py::error_already_set raised;  // clears the error, for the calls below
  const auto* function = static_cast<const py::detail::function_record*>(
      PyCapsule_GetPointer(self, PyCapsule_GetName(self)));
  const std::string message =
      unknown_keyword(*function, py::reinterpret_borrow<py::dict>(keywords));
  if (message.empty())
    raised.restore();
  else
    PyErr_SetString(PyExc_TypeError, message.c_str());
  return nullptr;
}

void name_unknown_keywords(PyMethodDef& definition) {
  const auto method =
      reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(definition.ml_meth));
  if (!dispatcher) dispatcher = method;
  if (dispatcher == method)
    definition.ml_meth =
        reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call_function));
}

void give_signature(PyObject* function) {
  if (PyInstanceMethod_Check(function)) function = PyInstanceMethod_Function(function);
  if (!PyCFunction_Check(function)) return;
  PyMethodDef* definition = reinterpret_cast<PyCFunctionObject*>(function)->m_ml;
  name_unknown_keywords(*definition);
  if (!definition->ml_doc || std::strstr(definition->ml_doc, "Overloaded function.")) return;
  // pybind11 releases the docstring by free().
  char* doc = strdup(with_text_signature(definition->ml_doc).c_str());
  std::free(const_cast<char*>(definition->ml_doc));
  definition->ml_doc = doc;
}

}  // namespace

void give_signatures(py::handle scope) {
  const py::dict members(scope.attr("__dict__"));
  for (const auto& [name, member] : members) {
    give_signature(member.ptr());
    if (PyType_Check(member.ptr()) && !PyExceptionClass_Check(member.ptr()))
      give_signatures(member);
  }
}

}  // namespace batten::python
