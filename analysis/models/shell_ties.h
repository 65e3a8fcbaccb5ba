// Rows that make one shell of the regions of a model.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Returns the rows, "joined line NAME", under which regions move as one shell along the lines that
/// they share: places and slopes along the line are the same, and so is the rotation ω about it,
///
///     ω = -(n · U_y - b/|x_t| n · U_t)/a,     y = a (τ × n) + b τ,  τ = x_t/|x_t|,
///
/// with y a direction into the region and U its displacement: moments are carried over creases as
/// over smooth joins, whatever their angle, also where three regions or more meet. Along `hinges`
/// regions share places and slopes only. ω is the same at the vertices and in the middles of edges
/// of two runs; where a region has the line embedded, places and ω are the same on the average of
/// each hat. The set is coupled, on the dofs of the model; `shape`: absolute dofs. Throws InputError
/// for a hinge that is no line of the model, or has one region only. Source: docs/theory/shells.md.
ConstraintSet shell_ties(const ModelLayout& model, const Points& shape,
                         const std::vector<std::string>& hinges = {});

}  // namespace batten
