// The equations of one Gauss-Newton step of the variation of curvature. Internal.
#pragma once

#include <vector>

#include "batten/fairing/minimum_variation/block_reduction.h"
#include "batten/fairing/minimum_variation/curvature_variation_terms.h"
#include "batten/fem/element_pattern.h"
#include "batten/fem/surface.h"

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


// Steps of a surface along its own normals, one unknown for each dof instead of three. Internal.

/// The steps δX = φ N that keep the rows of a reduction: φ has the dofs of a C1 function, N is the
/// normal of the surface with slopes N_u, N_v,
///
///     δX = φ N,   δX_u = φ_u N + φ N_u,   δX_v = φ_v N + φ N_v    at vertices, likewise at edges,
///
/// and dofs that the rows bind follow by D. How (u, v) runs over the shape hardly changes. Where
/// rows leave a dof no way along the normal (a normal that is given), it has no unknown.
class NormalVariation {
 public:
  /// The reduction must outlive it.
  NormalVariation(const BlockReduction& reduction, const Surface& start);

  int count() const { return count_; }
  /// T, 3n×count(), with δ[x; y; z] = T s. The same pattern for every surface of the start's mesh.
  RowMatrix at(const Surface& surface) const;
  /// The same rows on φ, by its unknowns, for rows of one coordinate.
  RowMatrix reduced_rows(const RowMatrix& rows) const;

 private:
  // The factors of the unknowns in dof d of φ.
  template <class Put>
  void scalar_row(int dof, const Put& put) const;

  const BlockReduction& reduction_;
  std::vector<int> unknown_of_;  // of each dof of φ, or -1
  int count_ = 0;
};

}  // namespace batten
