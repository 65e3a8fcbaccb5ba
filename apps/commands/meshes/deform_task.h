// Makes the problem that is solved from the words of a deform scene.
#pragma once

#include <vector>
#include <optional>
#include <string>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/meshes/attached_nodes.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fairness.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

// What all edits of a deform scene have in common.

/// A line of vertices and its curve, which drives the mesh. Lengths are in model units.
struct MeshCurve {
  std::string name;
  std::vector<int> vertices;
  HermiteCurve curve;         ///< the curve, faired and shaped by its loads
  std::vector<Vec3> targets;  ///< the place on the curve where each vertex goes
  Deviation fairing;          ///< deviation of the vertices from the faired curve, without loads
  double wavelength = 0;      ///< wavelength of the fairing
  Fairness before, after;     ///< fairness of the line as it is, and of the curve
  double largest_shift = 0;   ///< largest displacement of a vertex by the loads
};

/// What all edits of a scene have in common: features, guides, chains and rows.
struct SharedConstraints {
  std::vector<FormFeature> features;
  const AttachedNodes* attached = nullptr;         ///< its connections are features, too
  std::vector<VertexCombination> centres;          ///< of each feature
  std::vector<std::vector<int>> shared_rotations;  ///< features that turn alike
  std::vector<PointConstraint> point_constraints;
  std::vector<std::optional<Vec3>> through;  // GuideSpec::through of each guide
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  std::vector<MeshCurve> curves;
  std::vector<std::string> notes;       // what the user should know
  std::vector<std::vector<int>> lines;  // vertices of chains and curves, for pictures; a closed
                                        // line ends with its first vertex
};


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
