// From a DeformProblem to numbered unknowns, soft rows and hard rows. Internal.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/constraints/affine_reduction.h"

namespace batten {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;
using RowPoints = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The vertices that take part, "dofs": those that move, and those held ones that a row of a moving
/// vertex reaches. Positions are relative to `origin`, so that large coordinates cost no digits.
struct DeformSystem {
  /// The problem is one that check() takes, with whole nodes.
  DeformSystem(const TriangleMesh& mesh, const DeformProblem& problem);

  /// What holds a vertex that is in no handle; kFree: nothing does.
  enum ConstraintSource { kFree = -4, kUnconnected = -3, kOutside = -2, kFixed = -1 };

  Vec3 origin;
  Points rest;                      ///< all vertices of the mesh, relative to origin
  std::vector<int> constrained_by;  ///< handle of each vertex of the mesh, or a Holder
  std::vector<int> vertex;          ///< vertex of each dof, ascending
  std::vector<int> dof;             ///< dof of each vertex, or -1
  int moving = 0;                   ///< dofs that are not held
  std::vector<std::string> notes;

  // Soft rows A p = b, those of curvature first; row r has the target scale · R(q) base.
  RowMatrix A;  ///< rows × dofs
  long curvature_rows = 0;
  RowPoints base;
  std::vector<int> rotates_with;  ///< dof, or -1
  std::vector<int> scaled_by;     ///< feature, or feature count + handle, or -1
  std::vector<int>
      linear_constraint_of_row;  ///< number of the LinearConstraint that the base comes from, or -1

  // Hard rows.
  struct Value {
    enum class Kind { Fixed, Handle, Feature, Row, CoincidentVertices } kind;
    int source;             ///< handle, feature, row
    int vertex, reference;  ///< Feature: vertex - reference
  };
  ConstraintSet positions, rotations;
  std::vector<Value> values;     ///< right-hand side of each row of `positions`
  std::vector<int> rotated_by;   ///< handle of each row of `rotations`, or -1: zero
  std::vector<int> feature_dof;  ///< a dof of each feature
  int feature_constraints = 0;

 private:
  void find_parts(const MeshTopology& topology);
  void order_features();
  void find_constrained(const MeshTopology& topology, const DeformProblem& problem);
  void number_dofs(const MeshTopology& topology, const DeformProblem& problem);
  void add_soft_rows(const TriangleMesh& mesh, const DeformProblem& problem);
  /// Vertices whose curvature the deformation may change.
  std::vector<int> curved_vertices(const MeshTopology& topology) const;
  void add_curvature_rows(const TriangleMesh& mesh, const std::vector<int>& vertices,
                          DeformProblem::Weighting weighting);
  /// Feature or handle whose scale the curvature at a vertex has, as scaled_by.
  int scale_of(int vertex) const;
  /// A soft row of a chain or of a LinearConstraint.
  struct SoftRow {
    std::vector<std::pair<int, double>> terms;  // dof, coefficient
    Vec3 base;
    int rotates_with, scaled_by, target;  // as above
  };
  std::vector<SoftRow> soft_constraint_rows(const DeformProblem& problem) const;
  void add_chain(const CharacterChain& chain, DeformProblem::Weighting weighting,
                 std::vector<SoftRow>& rows) const;
  void add_hard_rows(const MeshTopology& topology, const DeformProblem& problem);
  std::vector<std::vector<int>> feature_vertices_;  // sorted
  std::vector<int> feature_of_;                     // of each vertex, or -1
  /// Number of the part of the mesh that a vertex is in. What no edge joins, but a node or a
  /// feature, is one part; a vertex without triangles that is in no feature is a part of its own.
  std::vector<int> part_;
  int part_count_ = 0;
  /// Features that share vertices one after the other, each with a vertex to refer to: of the first
  /// the highest of all, of the others one that they share with an earlier one. Every row then
  /// eliminates its own vertex at once.
  std::vector<int> feature_order_, reference_;
};

/// K_q: the cotangent Laplacian of the dofs, lower triangle.
SparseMatrix laplacian_of(const DeformSystem& system, const TriangleMesh& mesh);


// The reduced least-squares problem. Internal.

/// The matrix B = A D, by rows.
RowMatrix reduced_matrix(const RowMatrix& A, const AffineReduction& reduction);

/// Lower triangle of Bᵀ B, column by column: for each row that meets the column, its entries from
/// there on. `rows` is B by rows. On all cores, the same bits on one.
SparseMatrix normal_matrix(const SparseMatrix& B, const RowMatrix& rows);

}  // namespace batten
