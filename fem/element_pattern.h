// SPDX-License-Identifier: MPL-2.0
// Sparsity pattern of assembled symmetric matrices, with a precomputed scatter of element matrices.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"

namespace batten {

/// Sparsity pattern (lower triangle) of a list of elements; built once and used for all matrices
/// over these elements.
///
/// Parallel assembly gives bit-identical results for any number of threads: every matrix entry
/// belongs to one thread, which adds its contributions in the order of the elements.
class ElementPattern {
 public:
  /// Sparsity pattern of elements with `per_element` dofs each. `dofs`: global dof indices of all
  /// elements, one element after the other.
  ElementPattern(int dof_count, int per_element, std::vector<int> dofs);
  /// Sparsity pattern of elements with different numbers of dofs: element e has the dofs
  /// dofs[starts[e]] … dofs[starts[e+1] - 1].
  ElementPattern(int dof_count, std::vector<int> starts, std::vector<int> dofs);

  int element_count() const { return isize(starts_) - 1; }
  /// Number of dofs of an element.
  int size_of(int element) const { return starts_[element + 1] - starts_[element]; }

  /// Zero matrix with this sparsity pattern (lower triangle).
  SparseMatrix zero() const;

  /// Sums the element matrices into `matrix`, which must have this sparsity pattern and is first
  /// set to zero. `element(e, K)` writes the symmetric matrix of element e into K, size_of(e)²
  /// doubles. It is called from several threads, and more than once for elements at the border
  /// between the ranges of two threads. Reports the stage "assembly" to the current ProgressScope.
  void assemble(const std::function<void(int element, double* K)>& element,
                SparseMatrix& matrix) const;

 private:
  struct Part {
    std::vector<int> elements;  // ascending
    std::vector<char> shared;   // some entries belong to another part
  };
  // Appends a column with the given rows to the pattern. On return, `place` holds for each of these
  // dofs the index of its entry in the matrix values.
  void append_column(const std::vector<int>& rows, std::vector<int>& place);
  // Stores the positions of the entries of element e in the column of its dof b, from the positions
  // of the rows of that column.
  void locate_entries(int e, int b, const std::vector<int>& place);
  std::vector<Part> split(int parts) const;
  // Part that accumulates the column of a dof. Elements that add no new dofs, such as edges listed
  // after their triangles, are not counted.
  int owner(int dof, int parts) const;

  std::vector<int> starts_, dofs_;
  std::vector<long> first_pair_;    // of each element, in position_
  int largest_ = 0;                 // dofs of the largest element
  std::vector<int> position_;       // [element][pair a ≥ b] → index into the matrix values
  std::vector<int> column_, row_;   // pattern: column starts, rows
  std::vector<int> first_element_;  // first element of each dof
  int first_elements_ = 1;          // elements that add new dofs come before this one
};

}  // namespace batten
