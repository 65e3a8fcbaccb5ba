// SPDX-License-Identifier: MPL-2.0
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

/// How the rotations of features and of the surface are determined if no handle prescribes them.
enum class RotationMode {
  /// Features rotate like the surface around them in a shape computed without features. MeshEditor
  /// then rotates them into equilibrium (FeatureEquilibrium).
  Estimated,
  Dual,  ///< rotations of a preliminary shape that DualLaplacianDeformer computes
  /// Rotations of a preliminary as-rigid-as-possible (ARAP) shape [SorkineAlexa2007]; for large
  /// rotations.
  Nonlinear,
  Harmonic  ///< harmonic interpolation of the handle rotations, without a preliminary shape
};

/// Rotation prescribed for a feature, which replaces the estimated rotation.
struct PrescribedRotation {
  int feature = 0;  ///< index into DeformProblem::features
  Mat3 rotation = Mat3::Identity();
};

/// Estimates the rotations of the surface and of the form features in an edit. Factorizations are
/// kept, so further edits of the same problem need no factorization: RotationMode::Estimated costs
/// one solve and O(n) work for n vertices, Dual and Nonlinear cost some iterations.
///
/// The rotation of a feature is the first that applies: the prescribed rotation; no rotation if the
/// feature is of kind TranslationOnly; the rotation of a handle that shares vertices with the
/// feature; no rotation if the feature has a fixed vertex; the area-weighted mean rotation of the
/// faces of the feature in the preliminary shape (mean_rotation()). Features that share vertices or
/// belong to the same group of DeformProblem::shared_rotations have a common rotation. Reference:
/// [Hu2012], eq. 11.
class FeatureRotationEstimator {
 public:
  /// Creates an estimator for the edits of one problem. Keeps references to `prepared`, `mesh` and
  /// `problem`. `prepared`: provides the polygons of the mesh for RotationMode::Dual. `mesh`: the
  /// mesh before the edit. `problem` must be valid, see check() in deform_problem.h. The linear
  /// constraints of the problem are ignored, so they may change later. `tolerance`: that of
  /// DualLaplacianOptions and ArapOptions.
  FeatureRotationEstimator(const PreparedMesh& prepared, const TriangleMesh& mesh,
                           const DeformProblem& problem, RotationMode mode,
                           double tolerance = 1e-6);
  ~FeatureRotationEstimator();
  FeatureRotationEstimator(const FeatureRotationEstimator&) = delete;
  FeatureRotationEstimator& operator=(const FeatureRotationEstimator&) = delete;

  /// Estimates the deformed shape and the rotation of each feature. The result is empty if no
  /// rotation is prescribed and nothing must be estimated: for RotationMode::Harmonic, or if nothing
  /// moves. `pulled`: constraints of the edit move the mesh, even if no handle does
  /// (RotationMode::Estimated then begins with unrotated features). If several rotations are
  /// prescribed for features with a common rotation, the last one applies. Throws InputError if a feature index is out of range, and the exceptions of
  /// the deformer that computes the preliminary shape.
  std::optional<ShapeEstimate> estimate(const DeformEdit& edit,
                                        std::span<const PrescribedRotation> prescribed = {},
                                        bool pulled = false);

  /// The estimate that a given shape of the whole mesh (n×3) is, such as a fit to a scan: features
  /// rotate like their own faces in it, and its curvature is kept. Throws InputError if a feature
  /// index is out of range.
  ShapeEstimate estimate_from(const Points& shape, const DeformEdit& edit,
                              std::span<const PrescribedRotation> prescribed = {});

  /// Bodies of the first `count` features whose rotations FeatureEquilibrium finds, numbered from 0:
  /// features that share vertices or a rotation belong to the same body. -1: the rotation of the
  /// feature follows from a handle, a fixed vertex or `prescribed`, `estimate` contains none, or the
  /// features of the body are chains of edges with free ends, which have no stiffness about their own
  /// axes. Features after the first `count` belong only to bodies of the others.
  std::vector<int> bodies(std::span<const PrescribedRotation> prescribed, int count,
                          const ShapeEstimate& estimate) const;

  /// Number of iterations of the last estimate(); 0 for RotationMode::Estimated and Harmonic.
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
  double tolerance_;
  std::unique_ptr<FormFeatureDeformer> featureless_;  // the edit without features
  std::unique_ptr<IterativeDeformer> iterative_;
  std::vector<char> known_;  // vertices that featureless_ determines
  std::unique_ptr<Rotations> own_, given_;
  bool own_estimated_ = false;
  int iterations_ = 0;
  bool converged_ = true;
};

}  // namespace batten
