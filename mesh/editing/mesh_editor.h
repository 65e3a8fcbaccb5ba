// One edit of a mesh with form features, factored once and solved repeatedly.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "batten/mesh/attached/attached_nodes.h"
#include "batten/mesh/editing/feature_rotation_estimator.h"

namespace batten {

/// Options of MeshEditor.
struct MeshEditorOptions {
  RotationMode rotation_mode = RotationMode::Estimated;
  /// True: features that are not scaled keep the position that they would have without any scaling,
  /// so that scaling one feature moves no other.
  bool keep_centres = true;
  /// Centres of the features, in their order, for `keep_centres`; connections of attached nodes have
  /// none. Empty: the mean of the vertices of each feature.
  std::vector<VertexCombination> centres;
};

/// Statistics of MeshEditor::solve_to_equilibrium(). Times are in seconds.
struct MeshEditStatistics {
  FormFeatureDeformer::Counts counts;
  double largest_displacement = 0;  ///< of a vertex, model units
  double hard_residual = 0;         ///< see FormFeatureDeformer::hard_residual()
  double last_correction = 0;       ///< see FormFeatureDeformer::correct()
  int iterations = 0;               ///< iterations of the rotation estimate; 0: not used
  bool converged = true;            ///< the rotation estimate converged
  double setup_seconds = 0, edit_seconds = 0;
};

/// One edit of a mesh: FormFeatureDeformer with estimated rotations of features, centres that
/// scaling does not move, and attached nodes. It is factored once; after that:
///
///     solve_preview()          a pair of triangular solves and O(n) work: features rotate like the
///                              adjacent sheet in the previous solution. Repeated calls with the
///                              same values converge; see is_at_rest()
///     solve_to_equilibrium()   iterates until the rotations change by less than 0.05 degrees, at
///                              most 20 times, and corrects rounding
///
/// solve_to_equilibrium() gives bit-identical results, whatever was solved before.
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
  /// Keeps references to `prepared` and `attached`. `before`: positions of all vertices before the
  /// edit (n×3), such as the result of the previous edit. `attached`: nodes of other elements; its
  /// add_to() must have been called for the problem, last of all, so that connections are its last
  /// features. nullptr: none. Throws InputError (see check() in deform_problem.h; a wrong number of
  /// centres) and NoSolutionError.
  MeshEditor(const PreparedMesh& prepared, const Points& before, DeformProblem problem,
             MeshEditorOptions options = {}, const AttachedNodes* attached = nullptr);
  ~MeshEditor();
  MeshEditor(const MeshEditor&) = delete;
  MeshEditor& operator=(const MeshEditor&) = delete;

  /// Sets the values of the edit, and rotations that are prescribed for features. Call it before
  /// the first solution. Throws NoSolutionError if a factorization fails; wrong values are reported
  /// by the next solution.
  void set(DeformEdit edit, std::vector<PrescribedRotation> prescribed = {});

  /// The shape during a drag, without the nodes that attached nodes move. Throws the exceptions of
  /// solve_to_equilibrium(); the shape is then unchanged.
  const Points& solve_preview();
  /// True if features rotated by less than 0.05 degrees in the last solution.
  bool is_at_rest() const { return at_rest_; }
  /// The converged shape: all vertices, attached nodes included. Coordinates that changed by
  /// rounding only keep their bits. Throws InputError (see check() in deform_problem.h; a feature of
  /// a prescribed rotation out of range), ConflictError, NoSolutionError; the shape is then
  /// unchanged.
  const Points& solve_to_equilibrium();
  /// Statistics of the last solve_to_equilibrium().
  const MeshEditStatistics& statistics() const { return statistics_; }

  /// The mesh before the edit.
  const TriangleMesh& mesh() const { return mesh_; }
  /// The shape of the last solution; initially that before the edit.
  const Points& shape() const { return shape_; }
  /// The problem. After a solution with scaled features, its last linear constraints are those of
  /// the centres.
  const DeformProblem& problem() const { return problem_; }
  /// The values of the edit.
  const DeformEdit& edit() const { return edit_; }
  /// Notes in plain sentences about parts of the mesh that nothing moves or fixes.
  const std::vector<std::string>& notes() const { return deformer_->notes(); }

 private:
  void set_up();
  void fix_centres(const Points& unscaled);
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
  bool centres_kept_ = false;  // deformer_ has constraints on the features' centres
  Points shape_;
  MeshEditStatistics statistics_;
  double setup_seconds_ = 0;
  std::optional<ShapeEstimate> live_;  // of the last solution
  bool at_rest_ = true;
};

}  // namespace batten
