// Linear rows on all three coordinates of a surface: [x; y; z] = D y + d0. Internal.
#pragma once

#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/eigen.h"

namespace batten {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// AffineReduction with the coordinates one after the other, whether the rows couple them or not.
class BlockReduction {
 public:
  /// Throws ConflictError.
  explicit BlockReduction(const ConstraintSet& constraints);
  /// The same rows where some dofs (of each coordinate) keep the values that the surface nearest to
  /// `start`, n×3, has: unknowns that they depend on are left out.
  BlockReduction(const BlockReduction& all, const Points& start, const std::vector<char>& frozen);

  /// 3n×m.
  const RowMatrix& D() const { return D_; }
  /// Dofs of one coordinate, n.
  int dof_count() const { return static_cast<int>(D_.rows()) / 3; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// The row of [x; y; z] behind each free unknown.
  const std::vector<int>& free_rows() const { return free_rows_; }
  /// Whether the unknowns are three times those of one coordinate, one coordinate after the other.
  bool coupled() const { return coupled_; }

  /// The free unknowns of these dofs, n×3.
  VecX free_part(const Points& x) const;
  /// D y + d0, n×3.
  Points expand(const VecX& y) const;

 private:
  bool coupled_;
  RowMatrix D_;
  VecX d0_;
  std::vector<int> free_rows_;
};

}  // namespace batten
