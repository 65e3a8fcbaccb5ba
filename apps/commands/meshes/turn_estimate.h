// How the sheet turns in an edit that does not say it.
#pragma once

#include <optional>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/deform/form_feature_deformer.h"

namespace batten {

/// An estimate of the deformed shape, with a turn for each feature: the user's, otherwise the mean of
/// its faces' rotations; features that share vertices or turn alike have one. None where the rule asks
/// for the harmonic field and turns no feature, or where no handle moves. `mesh` is
/// the prepared one in its present shape. `edit` gets what it took.
std::optional<ShapeEstimate> estimate_for(const EditRule& rule, const Task& task,
                                          const PreparedMesh& prepared, const TriangleMesh& mesh,
                                          DeformReport::Edit& edit);

/// Turns the first `leaning` features by the mean rotation of the two rings of faces beside them in the
/// shape `positions` that was found with the estimate's turns; those that are told how to turn, have no
/// faces beside them, or lie in parts that only connections hold (these would swing) stay. Returns the largest change, degrees: it settles in a few rounds.
double lean_on(const EditRule& rule, const Task& task, size_t leaning, const TriangleMesh& mesh,
               const Points& positions, ShapeEstimate& estimate);

}  // namespace batten
