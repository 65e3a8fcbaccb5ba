// Steps of a surface along its own normals, one unknown for each dof instead of three. Internal.
#pragma once

#include <vector>

#include "batten/fairing/block_reduction.h"
#include "batten/fem/surface.h"

namespace batten {

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
