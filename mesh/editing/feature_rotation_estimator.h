// Estimation of the rotations of features that an edit does not prescribe.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/regions/iterative_deformer.h"

namespace batten {

/// How rotations are determined where no handle prescribes them. Features and curvature rotate
/// accordingly.
enum class RotationMode {
  Estimated,  ///< features rotate as the sheet at their location, deformed without them
  Dual,       ///< from a preliminary shape computed with dual Laplacian vectors
  /// From a preliminary as-rigid-as-possible (ARAP) shape [SorkineAlexa2007]; for large rotations.
  Nonlinear,
  Harmonic  ///< handle rotations, interpolated harmonically
};

/// A rotation that is prescribed for a feature instead of being estimated.
struct PrescribedRotation {
  int feature = 0;  ///< index into DeformProblem::features
  Mat3 rotation = Mat3::Identity();
};

/// Estimates how the sheet, and with it the form features of a problem, rotate in an edit.
/// Factorizations are kept, so that other values of the same edit cost solves only: one solve and
/// O(n) work (n vertices) for RotationMode::Estimated, some iterations for Dual and Nonlinear.
///
/// The rotation of a feature is the first of these: the prescribed one; no rotation if its kind is
/// TranslationOnly; that of its handle; no rotation if it has a fixed vertex; the area-weighted mean
/// rotation of its faces in the preliminary shape (mean_rotation()). Features that share vertices or
/// a group of DeformProblem::shared_rotations have a common rotation. Source: [Hu2012], eq. 11.
class FeatureRotationEstimator {
 public:
  /// Keeps references to all arguments. `prepared`: the polygons of the mesh, for the dual mode.
  /// `mesh`: the mesh before the edit. `problem` must have passed check(); its linear constraints
  /// may change later, as they do not take part in the estimate.
  FeatureRotationEstimator(const PreparedMesh& prepared, const TriangleMesh& mesh,
                           const DeformProblem& problem, RotationMode mode);
  ~FeatureRotationEstimator();
  FeatureRotationEstimator(const FeatureRotationEstimator&) = delete;
  FeatureRotationEstimator& operator=(const FeatureRotationEstimator&) = delete;

  /// Estimates the deformed shape, with a rotation per feature. Empty if no rotation is prescribed
  /// and nothing has to be estimated: in the harmonic mode, or if no handle moves. Of several
  /// rotations that are prescribed for features with a common rotation the last one applies.
  /// Throws InputError (a feature index out of range) and what the deformers throw.
  std::optional<ShapeEstimate> estimate(const DeformEdit& edit,
                                        std::span<const PrescribedRotation> prescribed = {});

  /// Updates the rotations of the first `count` features to the mean rotation of the two adjacent
  /// rings of faces, in the shape `positions` computed with the current estimate. Unchanged are
  /// features with a prescribed rotation, without adjacent faces, or in parts held by connections
  /// only (which would oscillate). The result is the largest change in degrees; a few iterations
  /// converge.
  double update_from_adjacent_faces(const DeformEdit& edit,
                                    std::span<const PrescribedRotation> prescribed, int count,
                                    const Points& positions, ShapeEstimate& estimate);

  /// Number of iterations of the last estimate() in the dual or nonlinear mode, otherwise 0.
  int iterations() const { return iterations_; }
  /// False if the iterations of the last estimate() did not converge.
  bool converged() const { return converged_; }

 private:
  class Rotations;  // of all features, in a given shape
  ShapeEstimate featureless(const DeformEdit& edit);
  const PreparedMesh& prepared_;
  const TriangleMesh& mesh_;
  const DeformProblem& problem_;
  RotationMode mode_;
  std::unique_ptr<FormFeatureDeformer> featureless_;  // the edit without features
  std::unique_ptr<IterativeDeformer> iterative_;
  std::vector<char> known_;  // vertices that featureless_ determines
  std::unique_ptr<Rotations> own_, adjacent_;
  bool own_estimated_ = false;
  int iterations_ = 0;
  bool converged_ = true;
};

}  // namespace batten
