// SPDX-License-Identifier: MPL-2.0
// Linear system, right-hand sides and solution of a FormFeatureDeformer.
#pragma once

#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/deform/rotation_field.h"
#include "batten/mesh/deform/shape_estimate.h"

namespace batten {

/// The assembled and factored problem, and the numbers of the last edit.
struct FormFeatureData {
  FormFeatureData(const TriangleMesh& mesh, DeformProblem problem);

  void extract_constrained_columns();
  void couple_point_constraints();
  void set_targets(const DeformEdit& edit, const ShapeEstimate* estimate);
  /// Target of a LinearConstraint row before it is rotated.
  Vec3 unrotated_target(const DeformEdit& edit, long row) const;
  /// Curvature in the estimate. Returns false if the estimate does not know all vertices of the
  /// row.
  bool estimated_target(const ShapeEstimate& estimate, long row, Vec3& target) const;
  /// Best rotation of the one-ring of a dof in the estimate.
  Vec3 ring_rotation_vector(const ShapeEstimate& estimate, int dof) const;
  /// Applies the rotations of features and, with Use::Shape, of chains and linear constraints from
  /// the estimate.
  void apply_estimated_rotations(const ShapeEstimate& estimate);
  void check_estimate(const ShapeEstimate& estimate) const;
  /// Solves with the hard values, point constraints and targets that are currently set.
  const Points& solve(const DeformEdit& edit);
  void set_hard_values(const DeformEdit& edit);
  void set_point_constraints(const DeformEdit& edit);
  /// Changes y, the solution without point constraints, so that it satisfies them.
  void apply_point_constraints();
  void expand(const DeformEdit& edit);
  double scale_of(const DeformEdit& edit, int scaled_by) const;
  /// Target of point equation k, relative to the origin; a vector is not shifted.
  Vec3 constraint_origin(const DeformEdit& edit, size_t k) const {
    const VertexCombination& point = problem.point_constraints[constraint_of_equation[k]].point;
    const Vec3 place = edit.constraint_origins.empty()
                           ? point.at(mesh.points())
                           : edit.constraint_origins[constraint_of_equation[k]];
    return std::abs(point.sum()) < 0.5 ? place : Vec3(place - system.origin);
  }
  void add_point_equation(ConstraintSet& set, size_t k, double value) const;
  /// r = b - A x, with x the shape that has the free unknowns at rest. The solution, and its
  /// rounding errors, are then changes of the shape.
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
  RowMatrix A_constrained_columns;  // columns of A where d0 may be nonzero
  SparseCholesky factor;
  SchurComplementConstraints coupling;
  SparseMatrix constrained_points;          // free unknowns × point constraints: Dᵀ U
  std::vector<Vec3> equation_directions;    // direction of each point equation
  std::vector<int> constraint_of_equation;  // point constraint of each point equation
  double size;

  Points q, last_valid_q;     // logarithms, dofs × 3, of this edit and of the last successful one
  MatX rhs;                   // right-hand sides of the hard constraints
  VecX g;                     // right-hand sides of the point equations
  VecX multipliers;           // of the point equations in the last solution
  RowPoints b, r, rest_rows;  // rest_rows = B y_rest
  MatX y, y_rest, load, x;
  Points result;
  DeformEdit last;
  bool solved = false;                // result is the solution for `last`
  bool is_estimated = false;          // guided by an estimate
  bool can_correct = false;           // and y, b, d0 belong to it
  std::vector<int> rotated_features;  // features whose rotations the last estimate prescribed
};

}  // namespace batten
