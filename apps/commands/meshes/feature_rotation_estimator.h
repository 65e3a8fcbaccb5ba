// How the sheet turns in an edit that does not say it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/io/report/deform_report.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/regions/iterative_deformer.h"

namespace batten {

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

}  // namespace batten
