// One edit of a mesh, set up once and done as often as its numbers change.
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

// How the sheet turns in an edit that does not say it.

class FeatureRotations;

/// Finds how the sheet turns in one edit. What it factors on the way is kept, so that other numbers of the
/// same edit cost solves alone: one and a mesh's length of work for turns that are found, rounds for the
/// dual and the nonlinear estimate.
class FeatureRotationEstimator {
 public:
  /// `prepared` and `mesh`, the prepared one in the shape before the edit, must stay.
  FeatureRotationEstimator(const PreparedMesh& prepared, const TriangleMesh& mesh);
  ~FeatureRotationEstimator();

  /// An estimate of the deformed shape, with a turn for each feature: the user's, otherwise the mean of
  /// its faces' rotations; features that share vertices or turn alike have one. None where the rule
  /// asks for the harmonic field and turns no feature, or where no handle moves. The task's problem is
  /// the same in each call. `edit` gets what it took.
  std::optional<ShapeEstimate> estimate(const EditSpec& rule, const DeformTask& task,
                                        DeformReport::Edit& edit);

  /// Turns the first `count` features by the mean rotation of the two rings of faces beside them in
  /// the shape `positions` that was found with the estimate's turns; those that are told how to turn,
  /// have no faces beside them, or lie in parts that only connections hold (these would swing) stay.
  /// Returns the largest change, degrees: it settles in a few rounds.
  double update_from_adjacent_faces(const EditSpec& rule, const DeformTask& task, size_t count,
                                    const Points& positions, ShapeEstimate& estimate);

 private:
  ShapeEstimate featureless(const DeformTask& task);
  const PreparedMesh& prepared_;
  const TriangleMesh& mesh_;
  std::unique_ptr<FormFeatureDeformer> featureless_;  // the edit without features
  std::unique_ptr<IterativeDeformer> iterative_;
  std::vector<char> known_;  // vertices that plain_ knows
  std::unique_ptr<FeatureRotations> own_, adjacent_;
  bool own_estimated_ = false;
};


/// One [[edit]] on the shape that the edit before left. Factors are made once; after that
///
///     solve_preview()   a pair of triangular solves and a mesh's length of work: features turn as the sheet
///                beside them did in the answer before. Answers to the same numbers settle in a few;
///                `is_at_rest()` says when
///     solve_to_equilibrium()   the rounds until that rests, and the correction of roundings: what `batten deform`
///                gives
///
/// solve_to_equilibrium() gives the same bits whatever was answered before it. Messages of what is thrown name the
/// edit and its place in the scene.
class EditSession {
 public:
  /// The scene, what is kept and the mesh must stay. Throws InputError: a name that cannot be found, what no
  /// deformer can take; NoSolutionError.
  EditSession(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
              VertexSelector& select, const PreparedMesh& prepared, const Points& before);

  /// The same edit with other numbers: shifts, turns and scales of handles, scales of features.
  void set(const EditSpec& rule);
  const EditSpec& rule() const { return rule_; }

  /// The shape in a drag. Throws as solve_to_equilibrium() does; the shape then stays.
  const Points& solve_preview();
  /// Whether features turned by less than 0.05 degrees in the last answer.
  bool is_at_rest() const { return at_rest_; }
  /// The shape at rest: all vertices, with what hangs on them. `report` gets what it took. Throws
  /// InputError, ConflictError, NoSolutionError; the shape then stays.
  const Points& solve_to_equilibrium(DeformReport::Edit& report);

  const Points& before() const { return mesh_.points(); }
  /// The shape of the last solve_preview() or solve_to_equilibrium().
  const Points& shape() const { return shape_; }
  const DeformTask& task() const { return task_; }
  /// Parts of the mesh that nothing moves or holds, in sentences.
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
  bool centres_kept_ = false;  // rows of deformer_ hold the features' centres
  Points shape_;
  double set_up_s_ = 0;
  std::optional<ShapeEstimate> live_;  // of the last answer
  bool at_rest_ = true;
};

}  // namespace batten
