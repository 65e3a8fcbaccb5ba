// Deformation of a triangle mesh whose form features keep their shape exactly.
#pragma once

#include <memory>
#include <string>
#include <vector>
#include <optional>

#include "batten/constraints/constraint_set.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/core/eigen.h"

namespace batten {

// A deformed shape that an edit with features may follow.

/// A shape that another deformer found for the same edit, without features: it has turned the sheet
/// where the handles' turns alone do not say how it turns.
struct ShapeEstimate {
  Points positions;         ///< n×3
  std::vector<char> known;  ///< vertices that it knows the places of; empty: all
  enum class Use {
    Rotations,  ///< only its features' turns count: the field is harmonic between them, the handles and
                ///< what is fixed, and turns the curvature of the rest shape
    Shape       ///< curvature is the estimate's own: without features the result is the estimate
  } use = Use::Rotations;
  /// The turn of each feature, the same for features that share vertices; none: as the harmonic field
  /// has it. Those that handles or fixed vertices hold, or that keep their direction, do as these say.
  std::vector<std::optional<Mat3>> feature_rotations;
};


struct FormFeatureData;

/// Masuda, Yoshioka, Furukawa 2006: mean-curvature vectors δ_i = L(p_i⁰) are kept in the
/// least-squares sense while they turn with a smooth field of rotations; handles, fixed vertices
/// and form features hold exactly:
///
///     min ½ |A p - b|²   subject to   C p = d
///
///     rows of A p = b:   w_i L(p_i) = w_i R(q_i) s δ_i,   L(p_i) = (L_c p)_i / (2 A_i)
///     w_i = √A_i (or 1)
///     s   = scale of the feature or handle that vertex i belongs to, otherwise 1
///
/// L_c, A_i: mesh/differential_operators.h, of the mesh as it was given. The logarithms q_i of the rotations are
/// the harmonic field with q = 0 on fixed vertices and on features that keep their direction, q =
/// turn on handles, and one q for each free feature. It is linear in the turns of the handles, so
/// that each handle's weight is solved for once and an edit costs no solve for rotations.
///
/// Hard constraints are eliminated (AffineReduction): a feature of any size leaves three unknowns,
/// its translation. x, y and z share one factor. Rows of guided points (on a plane, on a line) mix
/// them; there are few, and they are satisfied by the Schur complement on that factor and a
/// projection after it, exactly to rounding.
///
/// Redundant constraints are dropped. Features that share vertices merge, features that touch a
/// handle go with it, features that touch the fixed region stay. Where that is impossible the
/// ConflictError names those that contradict each other: at construction never, for it depends on
/// the edit.
///
/// Cost: one sparse Cholesky factor at construction; an edit is one pair of triangular solves and a
/// few sparse products, without allocation. Memory: the factor, and one number for each vertex that
/// takes part and each handle. A row over k vertices of their own fills k² entries of the matrix:
/// means of hundreds of vertices belong into a feature or a guide.
class FormFeatureDeformer {
 public:
  /// Throws InputError (check() in deform_problem.h; a chain whose vertices coincide).
  /// NoSolutionError when the factorization fails.
  FormFeatureDeformer(const TriangleMesh& mesh, DeformProblem problem);
  ~FormFeatureDeformer();
  FormFeatureDeformer(FormFeatureDeformer&&) noexcept;
  FormFeatureDeformer& operator=(FormFeatureDeformer&&) noexcept;

  /// All vertices after the edit. Every edit starts from the mesh as it was given. Throws
  /// InputError (numbers missing, not finite, a scale not above 0) and ConflictError; the positions
  /// then stay as they were.
  const Points& deform(const DeformEdit& edit);
  /// The same with an estimate V' of the shape: its features' turns stand for the field's, which
  /// costs a factor of the Laplacian; with Use::Shape, where it is known, rows are A p = s A V' (Hu,
  /// Song, Cao 2012, eq. 5 with the estimate's own right side). Throws InputError too when sizes do
  /// not fit or numbers are not finite, NoSolutionError.
  const Points& deform(const DeformEdit& edit, const ShapeEstimate& estimate);
  /// One correction step after deform(), for the moment the mouse is released: the normal equations
  /// square the condition number (refine_least_squares). Costs about one more deform(). Returns
  /// the largest change of a coordinate over the size of the mesh. Throws InputError when there was
  /// no deform() before it, or the last one failed.
  double correct();

  const Points& positions() const;
  /// Logarithms q_i of the rotations of the last edit, n×3.
  Points rotation_logs() const;
  /// Largest violation in positions(), hard_residual() below: measured from the problem as it was
  /// stated, not from the solver's rows.
  double hard_residual() const;

  const TriangleMesh& mesh() const;
  const DeformProblem& problem() const;
  /// Parts of the mesh that nothing moves or holds, in sentences; they stay.
  const std::vector<std::string>& notes() const;

  struct Counts {
    int moving = 0;            ///< vertices whose position is solved for
    int unknowns = 0;          ///< free unknowns of one coordinate, after the reduction
    int soft_equations = 0;    ///< rows of A for one coordinate
    int hard_constraints = 0;  ///< rows of C for one coordinate, features included
    int feature_constraints = 0;
    int redundant_count = 0;  ///< hard rows that others imply
    int point_equations = 0;  ///< rows of guided points
    long factor_entries = 0;
  };
  Counts counts() const;

  /// The problem of an edit as plain data, for checking: minimise ½|A x - b|² over the positions x
  /// (k×3) of the k vertices listed, relative to `origin`, subject to the constraints. Redundant
  /// rows are left out.
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

/// Largest violation of what the problem states at positions p (n×3) with the field's logarithms
/// (n×3): a fixed vertex or one outside the region, a handle, a feature against its own best
/// similarity of the stated scale, a guided point, a hard row; over the size of the mesh.
double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs);

}  // namespace batten
