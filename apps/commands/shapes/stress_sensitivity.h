// How stresses answer to the parameters of a scene.
#pragma once

#include "batten/apps/commands/shapes/shape_files.h"

namespace batten {

/// For each parameter that changes the shape: the derivatives of the largest displacement (at its
/// place, along its direction) and of the compliance (the work of the loads) of every case, into
/// report.stress->sensitivities. One adjoint solve a case and, for each parameter, two shapes and
/// two stiffnesses on the same mesh, no factor of the shell. Parameters of [[fair]], driven ones and
/// those that can move to neither side are passed over.
void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress);

}  // namespace batten
