// Matrices like those that Batten factors in earnest, for tests and benchmarks of the solver.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten_test {

using namespace batten;

/// Least-squares rows of a deformed sheet: √Aᵢ · mean curvature at every vertex, A x ≈ b.
struct HoledSheet {
  SparseMatrix rows;      // one a vertex; columns are the vertices that may move
  SparseMatrix normal;    // rowsᵀ rows, the bilaplacian; lower triangle
  Points shape;           // of the columns
  std::vector<char> rim;  // columns on the rim of a hole
};

/// A curved sheet with 5×4 round holes, triangulated, about `vertices` of them; its outer boundary
/// and one ring beside it are held.
HoledSheet holed_sheet(int vertices);

/// Lower triangle of the bending stiffness of n×n squares of HCT triangles with a clamped rim, and
/// the nested dissection of its unknowns.
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

/// Twenty matrices that a solver must not stumble over: sheets and bending, badly scaled,
/// disconnected, tiny, diagonal, a chain, dense.
struct NamedMatrix {
  std::string name;
  std::function<BendingMatrix()> make;  // an empty order: none is known
};
std::vector<NamedMatrix> twenty_matrices();

/// |Ax - b| / (|A| |x|), largest entries and row sums: rounding of one solve, whatever the
/// condition of A (lower triangle).
double backward_error(const SparseMatrix& A, const MatX& x, const MatX& b);

/// n × columns numbers in [-1, 1), the same on every machine.
MatX random_columns(long n, long columns, unsigned seed = 1);

}  // namespace batten_test
