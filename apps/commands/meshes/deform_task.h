// Makes the problem that is solved from the words of a deform scene.
#pragma once

#include <vector>

#include "batten/apps/commands/meshes/shared_constraints.h"
#include "batten/apps/commands/meshes/vertex_selector.h"

namespace batten {

/// Fairs and loads the curve of a [[curve]]. Throws InputError with the place in the scene.
MeshCurve shape_curve(const DeformScene& scene, const CurveSpec& rule, VertexSelector& select,
                      const TriangleMesh& mesh);

/// The largest distance of the vertices, at positions p (n×3), from the curve.
double distance_from(const MeshCurve& curve, const Points& p);

/// Collects what all edits have in common. Throws InputError with the place of what cannot be
/// found.
SharedConstraints gather_shared_constraints(const DeformScene& scene, VertexSelector& select,
                                            const AttachedNodes& attached,
                                            const TriangleMesh& mesh);

/// The problem of one edit and how it moves.
struct DeformTask {
  DeformProblem problem;
  DeformEdit edit;
};

/// How one edit moves what its problem has: the numbers of the rule. `mesh` is the result of the edit
/// before. Throws InputError with the place of a feature or guide that is not there.
DeformEdit edit_of(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
                   const DeformProblem& problem, const TriangleMesh& mesh);

/// The task with the centres of all features where they are at `unscaled`, positions without any
/// scale of a feature: scaling one then moves no other.
DeformTask with_fixed_centres(DeformTask task, const SharedConstraints& shared,
                              const Points& unscaled);

/// Makes the task of one edit. `mesh` is the result of the edit before. Throws InputError with the
/// place of a name that cannot be found.
DeformTask make_deform_task(const DeformScene& scene, const EditSpec& rule,
                            const SharedConstraints& shared, VertexSelector& select,
                            const TriangleMesh& mesh);

}  // namespace batten
