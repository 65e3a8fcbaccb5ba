// SPDX-License-Identifier: MPL-2.0
// Constraints of a Deformer as Python objects: OnPlane, OnLine, Chain, LinearConstraint.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "batten/apps/python/bindings.h"
#include "batten/scenes/mesh.h"

namespace batten::python {

/// Convert a dict {name: constraint}. `count`: number of vertices of the mesh. They throw InputError
/// for an object of another type, and for vertices that the mesh does not have.
std::vector<std::variant<OnPlane, OnLine>> constraints_from(const py::dict& given, int count);
std::vector<CharacterChain> chains_from(const py::dict& given, int count);
std::vector<LinearConstraint> linear_constraints_from(const py::dict& given, int count);

/// The inverses of these functions.
py::dict dict_of(const std::vector<std::variant<OnPlane, OnLine>>& constraints);
py::dict dict_of(const std::vector<CharacterChain>& chains);
py::dict dict_of(const std::vector<LinearConstraint>& constraints);

}  // namespace batten::python
