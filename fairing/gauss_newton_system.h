// The equations of one Gauss-Newton step of the variation of curvature. Internal.
#pragma once

#include <vector>

#include "batten/fairing/augmented_lagrangian_constraints.h"
#include "batten/fairing/block_reduction.h"
#include "batten/fairing/variation_terms.h"
#include "batten/fem/element_pattern.h"

namespace batten {

/// JᵀJ and Jᵀr over the unknowns s of steps δ[x; y; z] = T s. Made once for a pattern of T.
class GaussNewtonSystem {
 public:
  /// `constraints`: B of rows that are held by multipliers (held_rows.h).
  GaussNewtonSystem(const CurvatureVariationTerms& terms, const Surface& surface,
                    const RowMatrix& T, RowMatrix constraints);

  /// At the surface of the terms' last set_frames(). Returns the functional. Same bits on one
  /// thread and two.
  double assemble(const CurvatureVariationTerms& terms, const Surface& surface,
                  const DampingWeights& weights, const RowMatrix& T);
  /// s with (JᵀJ) s = -Jᵀr that keeps the held rows; `cholesky` is the factor of matrix().
  VecX step(const SparseCholesky& cholesky) const;

  /// JᵀJ, and Bᵀ w B of the held rows.
  const SparseMatrix& matrix() const { return matrix_; }
  /// Half of the functional's slopes.
  const VecX& gradient() const { return gradient_; }

 private:
  // An entry of T in one element: its place among T's values, and the numbers of row and column in
  // the element.
  struct Entry {
    int value, row, column;
  };
  void update_penalty_weights();
  template <class Dofs>
  void add_element(const RowMatrix& T, const Dofs& dofs);
  // Writes the element's matrix, and its gradient and value the first time.
  template <class Rows>
  void reduce(const Rows& rows, int element, const RowMatrix& T, bool first, double* K);

  RowMatrix constraints_;
  VecX penalty_weights_;  // empty: not yet known
  std::vector<Entry> entries_;
  std::vector<size_t> first_entry_;
  std::vector<int> starts_, unknowns_;
  ElementPattern pattern_;
  SparseMatrix matrix_;
  VecX gradient_;
  std::vector<double> values_, slopes_;  // slopes_: along unknowns_
};

}  // namespace batten
