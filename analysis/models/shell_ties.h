// What makes one shell of the regions of a model.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_springs.h"
#include "batten/analysis/shell_section.h"
#include "batten/constraints/constraint_set.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Rows that hold exactly, and springs along embedded lines.
struct ShellTies {
  ConstraintSet constraints;
  ShellSprings springs;
};

/// Ties under which regions move as one shell along the lines that they share, "joined line NAME":
/// places and slopes along the line are the same, and so is the rotation ω about it,
///
///     ω = -(n · U_y - b/|x_t| n · U_t)/a,     y = a (τ × n) + b τ,  τ = x_t/|x_t|,
///
/// with y a direction into the region and U its displacement: moments are carried over creases as
/// over smooth joins, whatever their angle, also where three regions or more meet. Along `hinges`
/// regions share places and slopes only.
///
/// Of two runs these are rows: ω is the same at the vertices and in the middles of edges. Where a
/// region has the line embedded, springs along it tie places and ω, per length
///
///     α Q11 t/h  and  α Q11 t³/(12 h),     α = 1000, h the length of an element's edge,
///
/// so that they give a thousandth of what an element gives (Herrema, Johnson, Proserpio, Wu, Kiendl,
/// Hsu 2019: penalty coupling of Kirchhoff-Love shells on meshes that do not match). Everything is
/// on the dofs of the model; `shape`: absolute dofs; `sections`: one, or one for each region. Throws
/// InputError for a hinge that is no line of the model, or has one region only. Source:
/// docs/theory/shells.md.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const std::vector<ShellSection>& sections,
                     const std::vector<std::string>& hinges = {});

}  // namespace batten
