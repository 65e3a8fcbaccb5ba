// Translates a deform scene to deformation problems.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/mesh/attached/attached_nodes.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/sculpting/curves/sculpted_curve.h"

namespace batten {

// Data that all edits of a deform scene share.

/// A chain of vertices with the curve that drives it.
struct MeshCurve {
  std::string name;
  std::vector<int> vertices;
  SculptedCurve shape;
};

/// Constraints that all edits of a scene share: features, guides, chains and linear constraints.
struct SharedConstraints {
  std::vector<FormFeature> features;
  const AttachedNodes* attached = nullptr;         ///< its connections are features, too
  std::vector<VertexCombination> centres;          ///< centre of each feature
  std::vector<std::vector<int>> shared_rotations;  ///< groups of features that rotate equally
  std::vector<PointConstraint> point_constraints;
  std::vector<std::optional<Vec3>> through;  // GuideSpec::through of each guide
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  std::vector<MeshCurve> curves;
  std::vector<std::string> notes;       // remarks for the user
  std::vector<std::vector<int>> lines;  // vertices of chains and curves, for pictures; closed
                                        // chains repeat the first vertex
};

/// Largest distance of the vertices, at positions p (n×3), from the curve.
double distance_from(const MeshCurve& curve, const Points& p);

/// Collects the shared constraints. Throws InputError, with the location, for unknown names.
SharedConstraints gather_shared_constraints(const DeformScene& scene, VertexSelector& select,
                                            const AttachedNodes& attached,
                                            const TriangleMesh& mesh);

/// The problem of one edit and its prescribed motion.
struct DeformTask {
  DeformProblem problem;
  DeformEdit edit;
};

/// The prescribed motion of an edit. `mesh`: result of the previous edit. Throws InputError, with
/// the location, for an unknown feature or guide.
DeformEdit edit_of(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
                   const DeformProblem& problem, const TriangleMesh& mesh);

/// Creates the task of one edit. `mesh`: result of the previous edit. Throws InputError, with the
/// location, for an unknown name.
DeformTask make_deform_task(const DeformScene& scene, const EditSpec& rule,
                            const SharedConstraints& shared, VertexSelector& select,
                            const TriangleMesh& mesh);

}  // namespace batten
