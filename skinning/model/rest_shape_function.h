// Rest shapes of sessions as functions. A header of its own: sculpting/session calls such
// functions, skinning/shapes makes them.
#pragma once

#include <functional>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Input of a RestShapeFunction. All dofs are in absolute coordinates.
struct RestShapeInput {
  const ModelLayout& layout;
  const ConstraintSet& rows;  ///< current constraints of lines, offsets and others
  const Points& bent;         ///< the shape of least bending energy under these constraints
  /// The shape under these constraints that bends least from the first rest shape on this mesh. It
  /// is close to the desired shape and does not depend on the order of previous changes. No rows:
  /// this is the first call on this mesh.
  const Points& near;
  const Progress& progress;
};

/// Computes the rest shape of a session: the reference configuration of zero elastic energy, from
/// which loads, offsets and constraints bend the surface.
///
/// It need not satisfy the constraints. An empty result means that there is no rest shape: the
/// elastic energy is then that of the shape itself, as in thin-plate interpolation of the lines.
using RestShapeFunction = std::function<Points(const RestShapeInput&)>;

}  // namespace batten
