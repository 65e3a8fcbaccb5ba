// SPDX-License-Identifier: MPL-2.0
// Editor for a mesh with form features, whose linear system is factored once for many solutions.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "batten/mesh/attached/attached_nodes.h"
#include "batten/mesh/editing/feature_equilibrium.h"
#include "batten/mesh/editing/feature_rotation_estimator.h"

namespace batten {

/// Options of MeshEditor.
struct MeshEditorOptions {
  RotationMode rotation_mode = RotationMode::Estimated;
  /// True: each feature centre keeps the position that it would have if no feature were scaled, so
  /// that scaling one feature does not move the others.
  bool keep_centres = true;
  /// Centre of each feature, used by `keep_centres`, without entries for the connections of
  /// attached nodes. Empty: each centre is the mean of the vertices of the feature.
  std::vector<VertexCombination> centres;
  /// Largest displacement in the last iteration of the rotation modes Dual and Nonlinear, relative
  /// to the size of the mesh. With 1e-13, at two to three times the cost, the shape is a smooth
  /// function of the edit, as derivatives need it; the other modes always converge so far.
  double tolerance = 1e-6;
};

/// Statistics of MeshEditor::solve_to_equilibrium(). Times are in seconds.
struct MeshEditStatistics {
  FormFeatureDeformer::Counts counts;
  double largest_displacement = 0;  ///< largest displacement of a vertex, model units
  double hard_residual = 0;         ///< result of FormFeatureDeformer::hard_residual()
  double last_correction = 0;       ///< result of FormFeatureDeformer::correct()
  int iterations = 0;               ///< iterations of the rotation estimate; 0: no iteration
  bool converged = true;            ///< false: the rotation estimate did not converge
  double setup_seconds = 0, edit_seconds = 0;
};

/// Editor for one edit of a mesh: its features, handles and fixed vertices are given to the
/// constructor, and only the values of the edit (DeformEdit) change. The linear system is therefore
/// factored once. The editor combines a FormFeatureDeformer with estimated feature rotations,
/// feature centres that do not move when features are scaled, and attached nodes. There are two
/// kinds of solution:
///
///     solve_preview()          costs two pairs of triangular solves and O(n) work, for positions and
///                              for the rotation field. Features rotate by one step of Newton's
///                              method towards the equilibrium of their moments (FeatureEquilibrium).
///                              Repeated calls with the same edit converge; see is_at_rest()
///     solve_to_equilibrium()   takes such steps until the rotations change by less than 1e-9
///                              degrees, at most 100, and corrects rounding errors. The shape is therefore a smooth function of the edit (in
///                              the rotation modes Dual and Nonlinear, up to their tolerance)
///
/// The result of solve_to_equilibrium() does not depend on previous solutions.
///
///     const PreparedMesh prepared = prepare(shells);
///     DeformProblem problem = …;                         // features, handles, fixed vertices
///     const AttachedNodes attached(elements, prepared.mesh);
///     attached.add_to(problem);                          // optional: elements that are not shells
///     MeshEditor editor(prepared, prepared.mesh.points(), problem, {}, &attached);
///     editor.set({.handles = {{.translation = {0, 0, 10}}}});
///     const Points& after = editor.solve_to_equilibrium();
class MeshEditor {
 public:
  /// Creates an editor for the deformation problem `problem`, and factors its linear system. Keeps
  /// references to `prepared` and `attached`. `before`: positions of all vertices before the edit
  /// (n×3), for example the result of the previous edit. `attached`: nodes of non-shell elements;
  /// nullptr: none. Call attached->add_to(problem) after all other features have been added, so
  /// that the connections are the last features. Throws InputError if check() rejects the problem
  /// (deform_problem.h) or the number of centres is wrong, and NoSolutionError if a factorization
  /// fails.
  MeshEditor(const PreparedMesh& prepared, const Points& before, DeformProblem problem,
             MeshEditorOptions options = {}, const AttachedNodes* attached = nullptr);
  ~MeshEditor();
  MeshEditor(const MeshEditor&) = delete;
  MeshEditor& operator=(const MeshEditor&) = delete;

  /// Sets the values of the edit and the prescribed rotations of features. Call this function
  /// before the first solution. Throws NoSolutionError if a factorization fails. Invalid values are
  /// detected by the next solution, which throws InputError.
  void set(DeformEdit edit, std::vector<PrescribedRotation> prescribed = {});

  /// Sets a preliminary shape of the mesh (n×3), from which the rotations of features and the
  /// curvature are taken in place of the rotation mode: see
  /// FeatureRotationEstimator::estimate_from(). It holds for all later solutions; nullopt: the
  /// rotation mode holds again.
  void set_estimate(std::optional<Points> shape) { given_ = std::move(shape); }

  /// Computes the positions of all vertices quickly, for display during a drag. Of the
  /// nodes of non-shell elements, only those of rigid elements, bushings and bolts move; the others
  /// move in solve_to_equilibrium(). Throws the exceptions of solve_to_equilibrium(). After an
  /// exception, the shape is unchanged.
  const Points& solve_preview();
  /// True if the feature rotations changed by less than 0.05 degrees in the last solve_preview().
  bool is_at_rest() const { return at_rest_; }
  /// Computes the converged positions of all vertices, including attached nodes. Coordinates that
  /// changed only by rounding errors are reset to their values before the edit. Throws InputError
  /// if check() rejects the edit (deform_problem.h) or the feature of a prescribed rotation is out
  /// of range, ConflictError if constraints contradict each other, and NoSolutionError if a
  /// factorization fails. After an exception, the shape is unchanged.
  const Points& solve_to_equilibrium();
  /// Statistics of the last solve_to_equilibrium().
  const MeshEditStatistics& statistics() const { return statistics_; }

  /// The mesh before the edit.
  const TriangleMesh& mesh() const { return mesh_; }
  /// Vertex positions of the last solution (n×3); initially the positions before the edit.
  const Points& shape() const { return shape_; }
  /// The deformation problem. After a solution with scaled features, the last entries of
  /// DeformProblem::rows keep the centres of the features.
  const DeformProblem& problem() const { return problem_; }
  /// The edit that was passed to the last set().
  const DeformEdit& edit() const { return edit_; }
  /// Sizes of the linear system.
  FormFeatureDeformer::Counts counts() const { return deformer_->counts(); }
  /// Messages for the user about parts of the mesh that do not move, because they have no
  /// constraints.
  const std::vector<std::string>& notes() const { return deformer_->notes(); }

 private:
  void set_up();
  std::vector<char> related_features() const;
  void fix_centres(const Points& unscaled);
  std::optional<ShapeEstimate> estimate();
  double update_rotations(ShapeEstimate& estimate);
  void converge_rotations(const DeformEdit& edit, std::optional<ShapeEstimate>& estimate);

  const TriangleMesh mesh_;
  const AttachedNodes* attached_;
  MeshEditorOptions options_;
  DeformProblem problem_;
  DeformEdit edit_;
  std::vector<PrescribedRotation> prescribed_;
  int own_features_ = 0;  // number of features without connections
  size_t own_rows_ = 0;   // number of linear constraints without those of centres
  FeatureRotationEstimator rotations_;
  std::unique_ptr<FormFeatureDeformer> deformer_;
  std::unique_ptr<FeatureEquilibrium> equilibrium_;  // of deformer_; null: not computed
  bool centres_kept_ = false;  // deformer_ has constraints on the features' centres
  Points shape_;
  MeshEditStatistics statistics_;
  double setup_seconds_ = 0;
  std::optional<Points> given_;        // set_estimate()
  std::optional<ShapeEstimate> live_;  // of the last solution
  bool at_rest_ = true;
};

}  // namespace batten
