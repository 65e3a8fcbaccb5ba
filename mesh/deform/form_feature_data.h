// What FormFeatureDeformer consists of. Internal.
#pragma once

#include <cmath>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/deform/rotation_field.h"
#include "batten/mesh/deform/shape_estimate.h"

namespace batten {

struct FormFeatureData {
  FormFeatureData(const TriangleMesh& mesh, DeformProblem problem);

  void extract_constrained_columns();
  void couple_point_constraints();
  void set_targets(const DeformEdit& edit, const ShapeEstimate* estimate);
  /// The target of a LinearConstraint's row, before it turns.
  Vec3 unrotated_target(const DeformEdit& edit, long row) const;
  /// Curvature in the estimate, where it knows all vertices of the row.
  bool estimated_target(const ShapeEstimate& estimate, long row, Vec3& target) const;
  /// Turns of features, curvature, lines and rows in the estimate.
  Vec3 ring_rotation_vector(const ShapeEstimate& estimate, int dof) const;
  void apply_estimated_rotations(const ShapeEstimate& estimate);
  void check_estimate(const ShapeEstimate& estimate) const;
  /// Solves with hard values, guides and targets as they are set.
  const Points& solve(const DeformEdit& edit);
  void set_hard_values(const DeformEdit& edit);
  void set_point_constraints(const DeformEdit& edit);
  void expand(const DeformEdit& edit);
  double scale_of(const DeformEdit& edit, int scaled_by) const;
  /// Where coupling row k wants its point, relative to the origin; a vector as it is.
  Vec3 constraint_origin(const DeformEdit& edit, size_t k) const {
    const VertexCombination& point = problem.point_constraints[constraint_of_equation[k]].point;
    const Vec3 place = edit.constraint_origins.empty()
                           ? point.at(mesh.points())
                           : edit.constraint_origins[constraint_of_equation[k]];
    return std::abs(point.sum()) < 0.5 ? place : Vec3(place - system.origin);
  }
  void add_point_equation(ConstraintSet& set, size_t k, double value) const;
  /// r = b - A x, x the shape with the free unknowns at rest: the solution is then a change of shape,
  /// and so are its errors.
  void start_residual();
  /// load = Bᵀ r.
  void reduce_residual();
  Vec3 rotation_vector_at(int dof) const { return q.row(dof).transpose(); }

  TriangleMesh mesh;
  DeformProblem problem;
  DeformSystem system;
  AffineReduction positions;
  RotationField rotations;
  SparseMatrix B;                   // A D
  RowMatrix A_constrained_columns;  // the columns of A where d0 may be other than zero
  SparseCholesky factor;
  SchurComplementConstraints coupling;
  std::vector<Vec3> equation_directions;    // of each coupling row
  std::vector<int> constraint_of_equation;  // guided point of each coupling row
  double size;

  Points q, last_valid_q;     // logarithms, dofs × 3, of this edit and of the last good one
  MatX rhs;                   // right-hand sides of the hard rows
  VecX g;                     // of the coupling rows
  RowPoints b, r, rest_rows;  // rest_rows = B y_rest
  MatX y, y_rest, load, x;
  Points result;
  DeformEdit last;
  bool solved = false;       // result is the answer to `last`
  bool can_correct = false;  // and so are y, b, d0
};

}  // namespace batten
