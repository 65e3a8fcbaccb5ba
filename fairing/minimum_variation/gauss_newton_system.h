// SPDX-License-Identifier: MPL-2.0
// Normal equations of one Gauss-Newton step of minimum-variation fairing, and steps restricted to
// the surface normals.
#pragma once

#include <vector>

#include "batten/fairing/minimum_variation/block_reduction.h"
#include "batten/fairing/minimum_variation/curvature_variation_terms.h"
#include "batten/fem/element_pattern.h"
#include "batten/fem/surface.h"

namespace batten {

/// Assembles JᵀJ and Jᵀr for unknowns s of steps δ[x; y; z] = T s. Constructed once per sparsity
/// pattern of T.
class GaussNewtonSystem {
 public:
  /// `constraints`: matrix B of the constraints that are imposed by multipliers
  /// (AugmentedLagrangianConstraints).
  GaussNewtonSystem(const CurvatureVariationTerms& terms, const Surface& surface,
                    const RowMatrix& T, RowMatrix constraints);

  /// Assembles at the surface of the terms' last set_frames() and returns the functional. Results
  /// are bit-identical with one thread and with two.
  double assemble(const CurvatureVariationTerms& terms, const Surface& surface,
                  const DampingWeights& weights, const RowMatrix& T);
  /// Solves (JᵀJ) s = -Jᵀr under B s = 0. `cholesky`: the factor of matrix().
  VecX step(const SparseCholesky& cholesky) const;

  /// The matrix JᵀJ + Bᵀ w B.
  const SparseMatrix& matrix() const { return matrix_; }
  /// Jᵀr, which is half of the gradient of the functional.
  const VecX& gradient() const { return gradient_; }

 private:
  // An entry of T in one element: its index among the values of T, and the row and column in the
  // element.
  struct Entry {
    int value, row, column;
  };
  void update_penalty_weights();
  template <class Dofs>
  void add_element(const RowMatrix& T, const Dofs& dofs);
  // Computes the element matrix; the first time also its gradient and value.
  template <class Rows>
  void reduce(const Rows& rows, int element, const RowMatrix& T, bool first, double* K);

  RowMatrix constraints_;
  VecX penalty_weights_;  // penalty weights of the constraints; empty: not computed yet
  std::vector<Entry> entries_;
  std::vector<size_t> first_entry_;
  std::vector<int> starts_, unknowns_;
  ElementPattern pattern_;
  SparseMatrix matrix_;
  VecX gradient_;
  std::vector<double> values_, slopes_;  // slopes_: gradient entries in the order of unknowns_
};

// Steps of a surface along its own normals: one unknown per dof instead of three.

/// Steps δX = φ N that satisfy a reduction. φ has the dofs of a C1 function and N is the normal of
/// the surface with derivatives N_u, N_v:
///
///     δX = φ N,   δX_u = φ_u N + φ N_u,   δX_v = φ_v N + φ N_v    at vertices, likewise at edges.
///
/// Constrained dofs follow by D. Such steps hardly change how (u, v) runs over the shape. A dof has
/// no unknown if the constraints leave it no motion along the normal (for example a fixed normal).
class NormalVariation {
 public:
  /// `reduction` must outlive this object.
  NormalVariation(const BlockReduction& reduction, const Surface& start);

  int count() const { return count_; }
  /// Matrix T, 3n×count(), with δ[x; y; z] = T s. Its sparsity pattern is the same for every
  /// surface on the mesh of `start`.
  RowMatrix at(const Surface& surface) const;
  /// Transforms constraints of one coordinate into constraints on the unknowns of φ.
  RowMatrix reduced_rows(const RowMatrix& rows) const;

 private:
  // Coefficients of the unknowns in dof d of φ.
  template <class Put>
  void scalar_row(int dof, const Put& put) const;

  const BlockReduction& reduction_;
  std::vector<int> unknown_of_;  // index of the unknown of each dof of φ; -1: none
  int count_ = 0;
};

}  // namespace batten
