// SPDX-License-Identifier: MPL-2.0
// Interactive mesh deformation that keeps the shape of form features exactly [Masuda2006].
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/deform/feature_stiffness.h"
#include "batten/mesh/deform/shape_estimate.h"

namespace batten {

struct FormFeatureData;
class FeatureMoments;

/// Form-feature preserving deformation [Masuda2006]. The mean-curvature vectors δ_i = L(p_i⁰) of
/// the undeformed mesh are kept in the least-squares sense and rotate with a smooth rotation field.
/// The constraints of handles, fixed vertices and form features are satisfied exactly:
///
///     min ½ |A p - b|²   subject to   C p = d
///
///     rows of A p = b:   w_i L(p_i) = w_i R(q_i) s δ_i,   L(p_i) = (L_c p)_i / (2 A_i)
///     w_i = √A_i, or 1 for Weighting::Uniform
///     s   = scale of the feature or handle to which vertex i belongs, otherwise 1
///
/// The cotangent Laplacian L_c and the mixed areas A_i of the undeformed mesh are defined in
/// mesh/differential_operators.h. The rotation vectors q_i of the rotations R(q_i) form a harmonic
/// field. It is 0 on fixed vertices and on features of kind TranslationOnly, equals the rotation
/// vector of the handle on handles, and has a single value per free feature. Since the field is
/// linear in the handle rotations, the weights of each handle are computed only once, and an edit
/// needs no solve for rotations.
///
/// Hard constraints are eliminated (AffineReduction): a feature of any size has only three
/// unknowns, its translation. x, y and z share one factorization. Point constraints couple x, y and
/// z; they are imposed exactly to rounding, by a Schur complement and a final projection.
///
/// Redundant constraints are dropped. Features that share vertices move as one feature, features
/// that share vertices with a handle move with the handle, and features with a fixed vertex do not
/// move. If constraints contradict each other, deform() throws a ConflictError that names them. The
/// constructor cannot detect contradictions, since they depend on the edit.
///
/// Cost: one sparse Cholesky factorization at construction. An edit costs one pair of triangular
/// solves and a few sparse products, without allocation. Memory: the factor, and one number per
/// moving vertex and handle. A soft linear constraint on k vertices adds k² matrix entries; use a
/// feature or a point constraint for the mean of hundreds of vertices.
class FormFeatureDeformer {
 public:
  /// Sets up and factors the linear system. Throws InputError if check() rejects the problem
  /// (deform_problem.h) or consecutive vertices of a character chain coincide, and NoSolutionError
  /// if the factorization fails.
  FormFeatureDeformer(const TriangleMesh& mesh, DeformProblem problem);
  ~FormFeatureDeformer();
  FormFeatureDeformer(FormFeatureDeformer&&) noexcept;
  FormFeatureDeformer& operator=(FormFeatureDeformer&&) noexcept;

  /// Applies an edit to the undeformed mesh (not to the result of the previous edit), and returns
  /// the positions of all vertices. Throws InputError if numbers are missing or not finite or a
  /// scale is not above 0, and ConflictError if constraints contradict each other. After an
  /// exception, positions() is unchanged.
  const Points& deform(const DeformEdit& edit);
  /// Applies an edit to the undeformed mesh, guided by an estimate of the deformed shape. The
  /// features get the rotations of the estimate instead of harmonically interpolated ones, which
  /// costs a factorization of the Laplacian for each new set of rotated features. With Use::Shape,
  /// the curvature of the estimate (times the scale) is kept at all vertices whose estimate is
  /// known ([Hu2012], eq. 5, with the right-hand side of the estimate). Throws the exceptions of
  /// deform(edit), InputError if sizes of the estimate do not match or numbers are not finite, and
  /// NoSolutionError if the factorization fails.
  const Points& deform(const DeformEdit& edit, const ShapeEstimate& estimate);
  /// Performs one step of iterative refinement after deform(), for example when the user releases
  /// the mouse. The step corrects rounding errors of the normal equations, which square the
  /// condition number (see refine_least_squares()). Costs about as much as deform(). Returns the
  /// largest change of a coordinate, relative to the mesh size. Throws InputError if no call of
  /// deform() has succeeded before.
  double correct();

  /// Derivative of positions() in a direction: their rate if the numbers of the last edit change at
  /// the given rates. Exact to rounding; costs about as much as deform(). Throws InputError if no
  /// deform() without an estimate has succeeded, a size is wrong, or a rate is not finite.
  Points tangent(const DeformEditRates& rates);
  /// Derivatives of the sum of `weights` · positions() with respect to the numbers of the last edit:
  /// the adjoint of tangent(). `weights`: n×3. One pair of triangular solves for all numbers. Throws
  /// as tangent() does.
  DeformEditRates gradient(const Points& weights);

  /// First moments of the forces on each feature in the last solution, 3×3 matrices stacked to 3F×3
  /// for F features. If feature f rotates by δω, its rows i of A p change by δω × c_i, with the levers
  /// c_i = (A t)_i of the displacement t that the rotation causes. With g = A p - b,
  ///
  ///     T_f = Σ_i c_i g_iᵀ + Σ_k c_k (λ_k n_k)ᵀ      (k: point constraints with multipliers λ_k)
  ///     M_f = (T_23 - T_32, T_31 - T_13, T_12 - T_21) = Σ c × force
  ///
  /// The moment M_f is the derivative of the energy ½ |A p - b|² with respect to the rotation, with b
  /// constant and all other unknowns in equilibrium. It vanishes if the forces of the surface on the
  /// feature are in equilibrium. Throws InputError if no call of deform() has succeeded before. Cost:
  /// O(vertices next to features); allocates memory in the first call only.
  const Points& feature_moments();
  /// Derivatives of feature_moments() in the undeformed shape if bodies of features rotate, as far as
  /// the last estimate prescribed their rotations. `body`: per feature, the body to which it belongs,
  /// 0 … m-1; -1: the feature does not rotate. Cost: a solve with 3 right-hand sides per body, at most
  /// 256. Throws InputError if the last deform() had no estimate, or `body` has a wrong size.
  FeatureStiffness feature_stiffness(std::span<const int> body);

  const Points& positions() const;
  /// Rotation field of the last edit: one rotation vector (unit axis times angle in radians) per
  /// vertex, n×3.
  Points rotation_logs() const;
  /// Largest violation of a hard constraint by positions(), relative to the mesh size; see the free
  /// function hard_residual(). It is computed from the constraints of the problem, independently of
  /// the factored linear system.
  double hard_residual() const;

  const TriangleMesh& mesh() const;
  const DeformProblem& problem() const;
  /// Messages for the user about parts of the mesh that do not move, because they have no
  /// constraints.
  const std::vector<std::string>& notes() const;

  /// Sizes of the linear system, for reports. Numbers of equations and unknowns are per coordinate.
  struct Counts {
    int moving = 0;               ///< number of vertices whose positions are unknown
    int unknowns = 0;             ///< free unknowns after elimination of hard constraints
    int soft_equations = 0;       ///< number of least-squares equations
    int hard_constraints = 0;     ///< number of hard constraint equations, including features
    int feature_constraints = 0;  ///< number of hard constraint equations of features
    int redundant_count = 0;      ///< number of hard constraint equations dropped as redundant
    int point_equations = 0;      ///< equations of point constraints, for x, y and z together
    /// Number of nonzeros of the Cholesky factor of the system matrix.
    long factor_entries = 0;
  };
  Counts counts() const;

  /// Explicit matrices of the least-squares problem of an edit, for verification: minimise ½|A x -
  /// b|² subject to `constraints`. The unknowns x (k×3) are the positions of the k `vertices`
  /// relative to `origin`. Redundant constraints are omitted.
  struct ProblemMatrices {
    std::vector<int> vertices;
    Vec3 origin;
    Eigen::SparseMatrix<double, Eigen::RowMajor, int> A;
    Points b;
    ConstraintSet constraints;
  };
  ProblemMatrices problem_matrices(const DeformEdit& edit);

 private:
  FeatureMoments& moments();
  std::unique_ptr<FormFeatureData> data_;
  std::unique_ptr<FeatureMoments> moments_;  // created by the first feature_moments()
};

/// Largest violation of the hard constraints of a problem at the vertex positions p (n×3), relative
/// to the mesh size. `logs`: rotation vectors of the rotation field (n×3). The constraints are
/// those of vertices that are fixed or outside the region of interest, handles, features (compared
/// with their best-fitting similarity of the prescribed scale), point constraints and hard linear
/// constraints.
double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs);

}  // namespace batten
