// The shape that lines, constraints and loads make of a region or a whole model: one settled
// answer.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/fairing/energy.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/session/results.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

struct AppliedLoad {
  Load load;
  double value = 0;
};

struct StaticTask {
  std::vector<AppliedLoad> loads;
  std::vector<Constraint> constraints;  ///< goals of points as they say
  SurfaceStiffness material;            ///< alpha, beta, in the units below
  LoadUnits units = LoadUnits::Relative;
  bool hold_corners = false;  ///< instead of the lines
  double tolerance = 1e-12;   ///< as SessionOptions
  int most_iterations = 60;   ///< as SessionOptions
};

struct SculptResult {
  Points dofs;
  SurfaceEnergy energy;  ///< of the domain scaled to size 1; over size² in relative units
  int iterations = 0;
  double last_change = 0;  ///< of the last iteration, over the size
  std::vector<Reaction> reactions;
  double max_constraint_residual = 0;  ///< over all rows, over the size
  std::vector<ScanDistances> scans;    ///< of each Load::Scan
};

/// A SculptingSession without history that settles once: where loads act is looked for on the shape
/// under the constraints alone. Throws InputError on bad numbers; ConflictError; NoSolutionError
/// when the pressure is past its limit, with what was reached.
SculptResult sculpt(const ModelLayout& layout, const StaticTask& task,
                    const Progress& progress = {});

}  // namespace batten
