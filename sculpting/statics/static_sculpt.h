// Makes the shape at rest of a region or a whole model under lines, constraints and loads.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/session/session_results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// A load that acts, with the value of its parameter.
struct AppliedLoad {
  Load load;
  double value = 0;
};

/// One load case: what acts, and how it is solved.
struct StaticTask {
  std::vector<AppliedLoad> loads;
  std::vector<Constraint> constraints;  ///< the goal of a point is Point::goal
  SurfaceStiffness material;            ///< alpha, beta, in the units below
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< holds the corners only, instead of the lines
  double tolerance = 1e-12;       ///< as SessionOptions
  int max_iterations = 60;        ///< as SessionOptions
};

/// The shape, and what was measured on it.
struct SculptResult {
  Points dofs;
  SurfaceEnergy energy;  ///< on the domain scaled to size 1; over size² in relative units
  int iterations = 0;
  double last_change = 0;  ///< change of the shape in the last iteration, over the size
  std::vector<Reaction> reactions;
  double max_constraint_residual = 0;  ///< largest residual of all rows, over the size
  std::vector<PointCloudDistances>
      scans;  ///< one for each Load::PointCloudSprings; before: the lines alone
};

/// Settles a SculptingSession that keeps no history. Places of loads are looked for on the shape
/// under lines and constraints, those of each constraint under the lines and the constraints before
/// it. Throws InputError on bad numbers, ConflictError, and NoSolutionError when the pressure is
/// past its limit, with the values that were reached.
SculptResult sculpt(const ModelLayout& layout, const StaticTask& task,
                    const Progress& progress = {});

}  // namespace batten
