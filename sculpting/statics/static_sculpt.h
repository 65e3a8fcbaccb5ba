// Static solve: equilibrium shape of a region or model under lines, constraints and loads.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// A load together with the value of its parameter.
struct AppliedLoad {
  Load load;
  double value = 0;
};

/// One load case: loads, constraints, material, and solver settings.
struct StaticTask {
  std::vector<AppliedLoad> loads;
  std::vector<Constraint> constraints;  ///< the goal of a point constraint is Point::goal
  SurfaceStiffness material;            ///< alpha and beta in the units below
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< true: constrains only the corners instead of the lines
  double tolerance = 1e-12;       ///< convergence tolerance, see SessionOptions
  int max_iterations = 60;        ///< maximum number of iterations, see SessionOptions
};

/// Equilibrium shape and its measurements.
struct SculptResult {
  Points dofs;
  /// Elastic energy on the domain scaled to size 1; in relative units over size².
  SurfaceEnergy energy;
  int iterations = 0;
  double last_change = 0;  ///< change of the shape in the last iteration, relative to the size
  std::vector<Reaction> reactions;
  /// Largest residual of all constraints, relative to the size.
  double max_constraint_residual = 0;
  std::vector<PointCloudDistances>
      /// One entry per Load::PointCloudSprings; "before" is the shape under the lines alone.
      scans;
};

/// Computes the equilibrium shape of one load case with a SculptingSession that keeps no history.
///
/// Points of application of loads are located on the shape under lines and constraints. Those of
/// each constraint are located on the shape under the lines and the previous constraints. Throws
/// InputError for invalid numbers, ConflictError for contradictory constraints, and
/// NoSolutionError, with the values reached, if the pressure exceeds its limit load.
SculptResult sculpt(const ModelLayout& layout, const StaticTask& task,
                    const Progress& progress = {});

}  // namespace batten
