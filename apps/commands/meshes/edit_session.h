// One edit of a mesh, factored once and solved repeatedly for changing values.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/regions/iterative_deformer.h"

namespace batten {

// Estimation of rotations that an edit does not prescribe.

class FeatureRotations;

/// Estimates how the sheet rotates in an edit. Factorizations are kept, so that other values of the
/// same edit cost solves only. The estimate from the sheet costs one solve and O(n) work (n
/// vertices), the dual and the nonlinear estimate cost some iterations.
class FeatureRotationEstimator {
 public:
  /// Keeps references to `prepared` and to `mesh` (the prepared mesh before the edit).
  FeatureRotationEstimator(const PreparedMesh& prepared, const TriangleMesh& mesh);
  ~FeatureRotationEstimator();

  /// Estimates the deformed shape, with a rotation per feature: the user's, else the mean rotation
  /// of its faces. Features that share vertices, or are coupled by a relation, have a common
  /// rotation. Empty if the rule uses the harmonic field and rotates no feature, or if no handle
  /// moves. All calls must pass a task with the same problem. `edit` receives statistics.
  std::optional<ShapeEstimate> estimate(const EditSpec& rule, const DeformTask& task,
                                        DeformReport::Edit& edit);

  /// Updates the rotations of the first `count` features to the mean rotation of the two adjacent
  /// rings of faces, in the shape `positions` computed with the current estimate. Unchanged are
  /// features with a prescribed rotation, without adjacent faces, or in parts held by connections
  /// only (which would oscillate). The result is the largest change in degrees; a few iterations
  /// converge.
  double update_from_adjacent_faces(const EditSpec& rule, const DeformTask& task, size_t count,
                                    const Points& positions, ShapeEstimate& estimate);

 private:
  ShapeEstimate featureless(const DeformTask& task);
  const PreparedMesh& prepared_;
  const TriangleMesh& mesh_;
  std::unique_ptr<FormFeatureDeformer> featureless_;  // the edit without features
  std::unique_ptr<IterativeDeformer> iterative_;
  std::vector<char> known_;  // vertices that featureless_ determines
  std::unique_ptr<FeatureRotations> own_, adjacent_;
  bool own_estimated_ = false;
};

/// One [[edit]] of the shape that the previous edit left. It is factored once; after that:
///
///     solve_preview()          a pair of triangular solves and O(n) work: features rotate like the
///                              adjacent sheet in the previous solution. Repeated calls with the
///                              same values converge; see is_at_rest()
///     solve_to_equilibrium()   iterates until the rotations converge, and corrects rounding; the
///                              result of `batten deform`
///
/// solve_to_equilibrium() gives bit-identical results, whatever was solved before. Exceptions name
/// the edit and its location in the scene.
class EditSession {
 public:
  /// Keeps references to the scene, `shared` and the mesh. Throws InputError for unknown names or
  /// an unsolvable problem, and NoSolutionError.
  EditSession(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
              VertexSelector& select, const PreparedMesh& prepared, const Points& before);

  /// Changes the values of the edit: translations, rotations and scales of handles, scales of
  /// features.
  void set(const EditSpec& rule);
  /// The edit with its current values.
  const EditSpec& rule() const { return rule_; }

  /// The shape during a drag. Throws the exceptions of solve_to_equilibrium(); the shape is then
  /// unchanged.
  const Points& solve_preview();
  /// True if features rotated by less than 0.05 degrees in the last solution.
  bool is_at_rest() const { return at_rest_; }
  /// The converged shape: all vertices, including attached nodes. `report` receives statistics.
  /// Throws InputError, ConflictError, NoSolutionError; the shape is then unchanged.
  const Points& solve_to_equilibrium(DeformReport::Edit& report);

  /// The shape before the edit.
  const Points& before() const { return mesh_.points(); }
  /// The shape of the last solve_preview() or solve_to_equilibrium().
  const Points& shape() const { return shape_; }
  /// The problem and the prescribed motion.
  const DeformTask& task() const { return task_; }
  /// Sentences about parts of the mesh that nothing moves or fixes.
  std::vector<std::string> notes() const { return deformer_->notes(); }

 private:
  template <class Function>
  void with_edit_context(const Function& f) const;
  void set_up();
  void keep_centres();
  void converge_rotations(std::optional<ShapeEstimate>& estimate, DeformReport::Edit& report);

  const DeformScene& scene_;
  EditSpec rule_;
  const SharedConstraints& shared_;
  const PreparedMesh& prepared_;
  const TriangleMesh mesh_;
  FeatureRotationEstimator rotations_;
  DeformTask task_;
  std::unique_ptr<FormFeatureDeformer> deformer_;
  bool centres_kept_ = false;  // deformer_ has constraints on the features' centres
  Points shape_;
  double set_up_s_ = 0;
  std::optional<ShapeEstimate> live_;  // of the last solution
  bool at_rest_ = true;
};

}  // namespace batten
