// The pattern of an assembled symmetric matrix and the places where element entries go.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"

namespace batten {

/// Built once for a list of elements, used for every matrix over them. Holds the lower triangle.
/// Filling it on several threads gives the same bits as on one: every entry belongs to one thread,
/// which adds its contributions in the order of the elements.
class ElementPattern {
 public:
  /// dofs: `per_element` global dofs of each element, one element after the other.
  ElementPattern(int dof_count, int per_element, std::vector<int> dofs);
  /// Elements of different sizes: element e has dofs[starts[e]] … dofs[starts[e+1] - 1].
  ElementPattern(int dof_count, std::vector<int> starts, std::vector<int> dofs);

  int element_count() const { return isize(starts_) - 1; }
  int size_of(int element) const { return starts_[element + 1] - starts_[element]; }

  /// A matrix of this pattern with zero entries.
  SparseMatrix zero() const;

  /// Adds up the elements' matrices into `matrix`, which must have this pattern and is set to zero
  /// first. `element(e, K)` writes the symmetric matrix of element e, size_of(e)² doubles; it is
  /// called from several threads, and more than once for elements that threads share.
  void assemble(const std::function<void(int element, double* K)>& element,
                SparseMatrix& matrix) const;

 private:
  struct Part {
    std::vector<int> elements;  // ascending
    std::vector<char> shared;   // some entries belong to another part
  };
  // place: of each of these dofs, then, in the matrix values.
  void append_column(const std::vector<int>& rows, std::vector<int>& place);
  // Those of element e in the column of its dof b, from the places of the column's rows.
  void locate_entries(int e, int b, const std::vector<int>& place);
  std::vector<Part> split(int parts) const;
  // The part that adds up the column of a dof. Elements that bring no new dof, such as edges after
  // their triangles, do not count.
  int owner(int dof, int parts) const;

  std::vector<int> starts_, dofs_;
  std::vector<long> first_pair_;    // of each element, in position_
  int largest_ = 0;                 // dofs of an element
  std::vector<int> position_;       // [element][pair a ≥ b] → index into the matrix values
  std::vector<int> column_, row_;   // pattern: column starts, rows
  std::vector<int> first_element_;  // of each dof
  int first_elements_ = 1;          // those that bring new dofs come before this one
};

}  // namespace batten
