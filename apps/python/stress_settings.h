// SPDX-License-Identifier: MPL-2.0
// Settings of stress analyses from Python values.
#pragma once

#include <string>

#include "batten/apps/python/bindings.h"
#include "batten/scenes/stress_data.h"

namespace batten::python {

/// The arguments of stress() and Session.stress() as the text of [stress]. Arguments that are None,
/// 0 or empty are left out. Throws InputError that begins with the argument.
detail::StressTable stress_table_from(const py::object& material, const py::object& thickness,
                                      const py::object& supports, const py::object& loads,
                                      const py::object& yield_stress, int modes, int buckling,
                                      const std::string& settings);

}  // namespace batten::python
