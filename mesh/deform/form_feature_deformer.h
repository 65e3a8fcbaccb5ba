// Interactive mesh deformation that keeps the shape of form features exactly [Masuda2006].
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

// Estimate of the deformed shape, as guidance for FormFeatureDeformer.

/// A shape that another deformer computed for the same edit without features. It provides the
/// rotation of the surface where the rotations of the handles alone do not determine it.
struct ShapeEstimate {
  Points positions;         ///< n×3
  std::vector<char> known;  ///< per vertex: nonzero if its position is valid; empty: all are
  enum class Use {
    /// Only the rotations of features are used; the rotation field is harmonic between them,
    /// handles and fixed vertices, and rotates the curvature of the rest shape.
    Rotations,
    Shape  ///< curvature is that of the estimate: without features the result is the estimate
  } use = Use::Rotations;
  /// Rotation of each feature; none: that of the harmonic field. Features that share vertices must
  /// have the same rotation. Features with TranslationOnly or with handle or fixed vertices ignore
  /// these rotations.
  std::vector<std::optional<Mat3>> feature_rotations;
};

struct FormFeatureData;

/// Form-feature preserving deformation [Masuda2006]. Mean-curvature vectors δ_i = L(p_i⁰) are kept
/// in the least-squares sense and rotate with a smooth field of rotations. Handles, fixed vertices
/// and form features are satisfied exactly:
///
///     min ½ |A p - b|²   subject to   C p = d
///
///     rows of A p = b:   w_i L(p_i) = w_i R(q_i) s δ_i,   L(p_i) = (L_c p)_i / (2 A_i)
///     w_i = √A_i (or 1)
///     s   = scale of the feature or handle that vertex i belongs to, otherwise 1
///
/// L_c, A_i: see mesh/differential_operators.h, of the undeformed mesh. The logarithms q_i of the
/// rotations form a harmonic field. It has q = 0 on fixed vertices and on features that keep their
/// direction, the rotation of the handle on handles, and one q per free feature. The field is
/// linear in the handle rotations, so the weights of each handle are computed once and an edit
/// needs no solve for rotations.
///
/// Hard constraints are eliminated (AffineReduction): a feature of any size leaves three unknowns,
/// its translation. x, y and z share one factorization. Point constraints (on a plane, on a line)
/// couple x, y and z. There are few of them; they are imposed by a Schur complement on that factor
/// and a final projection, exactly to rounding.
///
/// Redundant constraints are dropped. Features that share vertices merge, features that touch a
/// handle move with it, features that touch the fixed region stay. If that is impossible, a
/// ConflictError names the contradicting constraints. It is never thrown at construction, since it
/// depends on the edit.
///
/// Cost: one sparse Cholesky factorization at construction. An edit costs one pair of triangular
/// solves and a few sparse products, without allocation. Memory: the factor, and one number per
/// participating vertex and handle. A soft linear constraint over k vertices adds k² matrix
/// entries, so means of hundreds of vertices should be features or point constraints.
class FormFeatureDeformer {
 public:
  /// Throws InputError (see check() in deform_problem.h; a chain with coincident neighbours) or
  /// NoSolutionError (the factorization fails).
  FormFeatureDeformer(const TriangleMesh& mesh, DeformProblem problem);
  ~FormFeatureDeformer();
  FormFeatureDeformer(FormFeatureDeformer&&) noexcept;
  FormFeatureDeformer& operator=(FormFeatureDeformer&&) noexcept;

  /// Positions of all vertices after the edit, which is always applied to the undeformed mesh.
  /// Throws InputError (missing or non-finite numbers, a scale not above 0) or ConflictError;
  /// positions() is then unchanged.
  const Points& deform(const DeformEdit& edit);
  /// The same, guided by an estimate V' of the shape. The rotations of its features replace those
  /// of the field, which costs a factorization of the Laplacian. With Use::Shape, the rows are
  /// A p = s A V' wherever the estimate is known ([Hu2012], eq. 5, with the right-hand side of the
  /// estimate). Also throws InputError if sizes do not match or numbers are not finite, and
  /// NoSolutionError.
  const Points& deform(const DeformEdit& edit, const ShapeEstimate& estimate);
  /// Performs one step of iterative refinement after deform(), for example when the mouse is
  /// released. It recovers the accuracy that the normal equations lose, since they square the
  /// condition number (refine_least_squares). Costs about as much as deform(). Returns the largest
  /// change of a coordinate relative to the mesh size. Throws InputError if there was no successful
  /// deform() before.
  double correct();

  const Points& positions() const;
  /// Rotation vectors of the field of the last edit, n×3.
  Points rotation_logs() const;
  /// Largest constraint violation of positions(), see the free function hard_residual(). It is
  /// measured with the problem as stated, not with the rows of the solver.
  double hard_residual() const;

  const TriangleMesh& mesh() const;
  const DeformProblem& problem() const;
  /// Notes in plain sentences about parts of the mesh without constraints, which stay.
  const std::vector<std::string>& notes() const;

  /// Sizes of the linear system, for reports.
  struct Counts {
    int moving = 0;            ///< vertices whose positions are solved for
    int unknowns = 0;          ///< free unknowns per coordinate after the reduction
    int soft_equations = 0;    ///< rows of A, per coordinate
    int hard_constraints = 0;  ///< rows of C, per coordinate, features included
    /// Rows of C that belong to features, per coordinate.
    int feature_constraints = 0;
    int redundant_count = 0;  ///< redundant rows of C
    int point_equations = 0;  ///< equations of point constraints
    /// Number of nonzeros of the Cholesky factor.
    long factor_entries = 0;
  };
  Counts counts() const;

  /// The problem of an edit as explicit matrices, for verification. Minimise ½|A x - b|² over the
  /// positions x (k×3) of the k `vertices`, relative to `origin`, subject to `constraints`.
  /// Redundant constraints are omitted.
  struct ProblemMatrices {
    std::vector<int> vertices;
    Vec3 origin;
    Eigen::SparseMatrix<double, Eigen::RowMajor, int> A;
    Points b;
    ConstraintSet constraints;
  };
  ProblemMatrices problem_matrices(const DeformEdit& edit);

 private:
  std::unique_ptr<FormFeatureData> data_;
};

/// Largest violation of the hard constraints of a problem at positions p (n×3), relative to the
/// mesh size. `logs`: logarithms of the rotation field (n×3). Covers vertices that are fixed or
/// outside the region, handles, features (compared with their best-fitting similarity of the
/// prescribed scale), point constraints and hard linear constraints.
double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs);

}  // namespace batten
