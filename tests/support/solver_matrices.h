// SPDX-License-Identifier: MPL-2.0
// Matrices similar to those that Batten factors, for tests and benchmarks of the solver.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten_test {

using namespace batten;

/// Least-squares equations of a deformed sheet: √Aᵢ · mean curvature at every vertex, A x ≈ b.
struct HoledSheet {
  SparseMatrix rows;      // one per vertex; columns are the free vertices
  SparseMatrix normal;    // rowsᵀ rows, the bilaplacian; lower triangle
  Points shape;           // of the columns
  std::vector<char> rim;  // columns on the boundary of a hole
};

/// A curved sheet with 5×4 round holes, triangulated, with about `vertices` vertices; its outer
/// boundary and one adjacent ring are fixed.
HoledSheet holed_sheet(int vertices);

/// Lower triangle of the bending stiffness of n×n squares of HCT triangles with a clamped boundary,
/// and the nested dissection of its unknowns.
struct BendingMatrix {
  SparseMatrix K;
  std::vector<int> order;
};
BendingMatrix clamped_bending(int n);

/// S A S with positive factors between 10^-digits and 10^digits on the diagonal of S, the same on
/// every machine.
SparseMatrix badly_scaled(const SparseMatrix& A, double digits);

/// A and B side by side on the diagonal.
SparseMatrix disconnected(const SparseMatrix& A, const SparseMatrix& B);

/// Twenty test matrices: sheets and bending, badly scaled, disconnected, tiny, diagonal, a chain,
/// dense.
struct NamedMatrix {
  std::string name;
  std::function<BendingMatrix()> make;  // an empty ordering: none is known
};
std::vector<NamedMatrix> twenty_matrices();

/// |Ax - b| / (|A| |x|), largest entries and row sums: rounding of one solve, independent of the
/// condition of A (lower triangle).
double backward_error(const SparseMatrix& A, const MatX& x, const MatX& b);

/// n × columns numbers in [-1, 1), the same on every machine.
MatX random_columns(long n, long columns, unsigned seed = 1);

}  // namespace batten_test
