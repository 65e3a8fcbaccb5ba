// SPDX-License-Identifier: MPL-2.0
// Assembles a DeformProblem: numbering of unknowns, soft rows and hard constraints.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/constraint_set.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;
using RowPoints = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Dofs and constraint equations of a DeformProblem. The dofs are the vertices that move, and the
/// constrained vertices that occur in a row of a moving vertex. Positions are relative to `origin`,
/// so that large coordinates do not cost digits.
struct DeformSystem {
  /// `problem` must have passed check() and expand_to_nodes().
  DeformSystem(const TriangleMesh& mesh, const DeformProblem& problem);

  /// Source of the constraint of a vertex that is in no handle; kFree: unconstrained, kUnconnected:
  /// in a part without constraints, kOutside: outside the region of interest.
  enum ConstraintSource { kFree = -4, kUnconnected = -3, kOutside = -2, kFixed = -1 };

  Vec3 origin;
  Points rest;                      ///< all vertices of the mesh, relative to origin
  std::vector<int> constrained_by;  ///< per mesh vertex: its handle, or a ConstraintSource
  std::vector<int> vertex;          ///< vertex of each dof, ascending
  std::vector<int> dof;             ///< dof of each vertex, or -1
  int moving = 0;                   ///< number of dofs that are unconstrained
  std::vector<std::string> notes;

  // Soft rows A p = b, the curvature rows first. Row r has the target scale · R(q) base.
  RowMatrix A;  ///< rows × dofs
  long curvature_rows = 0;
  RowPoints base;
  std::vector<int> rotates_with;  ///< dof whose rotation applies to the row, or -1
  std::vector<int> scaled_by;     ///< feature, or feature count + handle, or -1: not scaled
  std::vector<int>
      linear_constraint_of_row;  ///< index of the LinearConstraint that defines the base, or -1

  // Hard constraints.
  struct Value {
    enum class Kind { Fixed, Handle, Feature, Row, CoincidentVertices } kind;
    int source;             ///< index of the handle, feature or linear constraint; otherwise -1
    int vertex, reference;  ///< Feature: the row is vertex - reference
  };
  ConstraintSet positions, rotations;
  std::vector<Value> values;     ///< kind of right-hand side of each row of `positions`
  std::vector<int> rotated_by;   ///< handle of each row of `rotations`, or -1: zero
  std::vector<int> feature_dof;  ///< one dof of each feature
  int feature_constraints = 0;

 private:
  void find_parts(const MeshTopology& topology, const DeformProblem& problem);
  void order_features();
  void find_constrained(const MeshTopology& topology, const DeformProblem& problem);
  void number_dofs(const MeshTopology& topology, const DeformProblem& problem);
  void add_soft_rows(const TriangleMesh& mesh, const DeformProblem& problem);
  /// Vertices at which the deformation may change the curvature.
  std::vector<int> curved_vertices(const MeshTopology& topology) const;
  void add_curvature_rows(const TriangleMesh& mesh, const std::vector<int>& vertices,
                          DeformProblem::Weighting weighting);
  /// One row for each edge between two triangles at which the deformation may change the slope.
  void add_hinge_rows(const TriangleMesh& mesh, DeformProblem::Weighting weighting);
  void add_hinge_row(const TriangleMesh& mesh, const std::array<int, 4>& hinge,
                     DeformProblem::Weighting weighting);
  /// Feature or handle that scales the curvature at a vertex, encoded as in scaled_by.
  int scale_of(int vertex) const;
  /// A soft row of a chain or of a LinearConstraint.
  struct SoftRow {
    std::vector<std::pair<int, double>> terms;  // dof, coefficient
    Vec3 base;
    int rotates_with, scaled_by, target;  // as the members above; target: as
                                          // linear_constraint_of_row
  };
  std::vector<SoftRow> soft_constraint_rows(const DeformProblem& problem) const;
  void add_chain(const CharacterChain& chain, DeformProblem::Weighting weighting,
                 std::vector<SoftRow>& rows) const;
  void add_hard_rows(const MeshTopology& topology, const DeformProblem& problem);
  void add_tied_rotations(const DeformProblem& problem);
  std::vector<std::vector<int>> feature_vertices_;  // sorted
  std::vector<int> feature_of_;                     // per vertex, or -1
  /// Index of the part of the mesh that each vertex belongs to. Components joined by a node or a
  /// feature are one part. A vertex without triangles that is in no feature is a part of its own.
  std::vector<int> part_;
  int part_count_ = 0;
  /// Order of the features such that those that share vertices follow each other, and a reference
  /// vertex for each. The reference of the first one is its highest vertex; each further one refers
  /// to a vertex shared with an earlier one. Every row can then eliminate its own vertex
  /// immediately.
  std::vector<int> feature_order_, reference_;
};

/// K_q: the cotangent Laplacian of the dofs, lower triangle.
SparseMatrix laplacian_of(const DeformSystem& system, const TriangleMesh& mesh);

// Normal equations of the reduced least-squares problem.

/// The matrix B = A D in row-major order.
RowMatrix reduced_matrix(const RowMatrix& A, const AffineReduction& reduction);

/// Lower triangle of Bᵀ B. Column c sums, over the rows of B that meet it, their entries from
/// column c on. `rows`: B in row-major order. Parallel, with bit-identical results for any number
/// of threads.
SparseMatrix normal_matrix(const SparseMatrix& B, const RowMatrix& rows);

}  // namespace batten
