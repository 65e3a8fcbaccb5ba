// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/python/toml_values.h"

#include <cmath>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/scene/scene_text.h"

namespace batten::python {

void refuse_setting(py::handle given, const std::string& what, const std::string& expected) {
  throw InputError(what + ": found " + std::string(py::repr(given)) + ", expected " + expected);
}

std::string toml_key(py::handle given, const std::string& what) {
  if (!py::isinstance<py::str>(given)) refuse_setting(given, what, "a key that is a text");
  const std::string key = py::str(given);
  const bool bare = !key.empty() && key.find_first_not_of(
                                        "abcdefghijklmnopqrstuvwxyz"
                                        "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                        "0123456789_-") == std::string::npos;
  return bare ? key : SceneText::toml_value(key);
}

std::string toml_from(py::handle given, const std::string& what, int depth) {
  constexpr int deepest = 16;
  if (depth > deepest) throw InputError(what + ": found too many nested lists, expected fewer");
  if (py::isinstance<py::bool_>(given)) return given.ptr() == Py_True ? "true" : "false";
  if (py::isinstance<py::int_>(given)) {
    int overflow = 0;
    const long long value = PyLong_AsLongLongAndOverflow(given.ptr(), &overflow);
    if (overflow) refuse_setting(given, what, "a number of at most 64 bits");
    return std::to_string(value);
  }
  if (py::isinstance<py::float_>(given)) {
    const double value = PyFloat_AsDouble(given.ptr());
    if (!std::isfinite(value)) refuse_setting(given, what, "a finite number");
    return SceneText::toml_value(value);
  }
  if (py::isinstance<py::str>(given)) return SceneText::toml_value(std::string(py::str(given)));
  if (py::isinstance<py::dict>(given)) {
    std::string text;
    for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(given)) {
      const std::string key = toml_key(name, what);
      text +=
          (text.empty() ? "" : ", ") + key + " = " + toml_from(value, what + "." + key, depth + 1);
    }
    return text.empty() ? "{}" : "{ " + text + " }";
  }
  if (py::isinstance<py::list>(given) || py::isinstance<py::tuple>(given)) {
    std::vector<std::string> texts;
    for (const py::handle item : py::reinterpret_borrow<py::sequence>(given))
      texts.push_back(toml_from(item, what + "[" + std::to_string(texts.size()) + "]", depth + 1));
    return SceneText::list(texts);
  }
  if (py::hasattr(given, "dtype") && py::hasattr(given, "tolist"))
    return toml_from(given.attr("tolist")(), what, depth + 1);
  refuse_setting(given, what, "a number, a text, a list or a dict");
}

}  // namespace batten::python
