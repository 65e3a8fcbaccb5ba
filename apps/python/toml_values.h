// SPDX-License-Identifier: MPL-2.0
// TOML text of Python values, for settings that scenes read.
#pragma once

#include <string>

#include "batten/apps/python/bindings.h"

namespace batten::python {

/// Throws InputError "WHAT: found …, expected …".
[[noreturn]] void refuse_setting(py::handle given, const std::string& what,
                                 const std::string& expected);

/// A key of a table: a text, with quotes if TOML needs them. Throws InputError for other objects.
std::string toml_key(py::handle given, const std::string& what);

/// TOML text, on one line, of numbers, texts, lists and dicts of Python and NumPy. `what`: name of
/// the value in messages. Throws InputError for other objects, and for numbers that are not finite.
std::string toml_from(py::handle given, const std::string& what, int depth = 0);

}  // namespace batten::python
