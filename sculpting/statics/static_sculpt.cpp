#include "batten/sculpting/statics/static_sculpt.h"

#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

SculptResult sculpt(const ModelLayout& layout, const StaticTask& task, const Progress& progress) {
  SessionOptions options;
  options.material = task.material;
  options.isotropic_alpha = options.isotropic_beta = false;
  options.units = task.units;
  options.fix_corners_only = task.fix_corners_only;
  options.tolerance = task.tolerance;
  options.max_iterations = task.max_iterations;
  options.history_bytes = 0;
  options.factor_reuse = FactorReuse::once;
  SculptingSession session(layout, options, progress);
  const Points alone = session.dofs();
  for (const Constraint& constraint : task.constraints) session.add(constraint);
  for (const AppliedLoad& applied : task.loads)
    session.add(applied.load, {{.name = applied.load.name, .value = applied.value}});
  const SolveReport report = session.solve_to_equilibrium();
  return {session.dofs(),
          session.energy(),
          report.iterations,
          report.change,
          session.reactions(),
          session.residual(),
          session.scan_distances(alone)};
}

}  // namespace batten
