#include "batten/sculpting/statics/static_sculpt.h"

#include "batten/sculpting/session/session.h"

namespace batten {

SculptResult sculpt(const ModelLayout& layout, const StaticTask& task, const Progress& progress) {
  SessionOptions options;
  options.material = task.material;
  options.isotropic_alpha = options.isotropic_beta = false;
  options.units = task.units;
  options.hold_corners = task.hold_corners;
  options.tolerance = task.tolerance;
  options.most_iterations = task.most_iterations;
  options.history_bytes = 0;
  options.expected = Expected::one_factor;
  SculptingSession session(layout, options, progress);
  const Points alone = session.dofs();
  for (const Constraint& constraint : task.constraints) session.add(constraint);
  for (const AppliedLoad& applied : task.loads)
    session.add(applied.load, {{.name = applied.load.name, .value = applied.value}});
  const Answer answer = session.settle();
  return {session.dofs(),
          session.energy(),
          answer.iterations,
          answer.change,
          session.reactions(),
          session.residual(),
          session.scan_distances(alone)};
}

}  // namespace batten
