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

}  // namespace batten
