#include "batten/io/cad/corner_twists.h"

#include <Eigen/Geometry>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/sparse_cholesky.h"

namespace batten {
namespace {

/// Rows of the least squares, one after the other: coefficients of the unknowns, right-hand sides.
struct TwistEquations {
  std::vector<Triplet> entries;
  std::vector<double> rhs;
  int count() const { return isize(rhs); }
  void set(int unknown, double value) { entries.emplace_back(count(), unknown, value); }
  void close(double value) { rhs.push_back(value); }
};

/// n' + c n × t + B t = 0 for both ends, in a frame of the corner's plane; B = (p q; q r).
void add_corner(TwistEquations& equations, const std::vector<JoinEnd>& ends,
                const TwistCorner& corner, int p) {
  const JoinEnd& first = ends[corner.ends[0]];
  const Vec3 e1 = first.along, e2 = corner.sign[0] * first.normal.cross(e1);
  for (const size_t k : {0, 1}) {
    const JoinEnd& end = ends[corner.ends[k]];
    const Vec3 slope = corner.sign[k] * end.slope,
               across = corner.sign[k] * end.normal.cross(end.along);
    const Vec2 t = Vec2(end.along.dot(e1), end.along.dot(e2));
    for (const int row : {0, 1}) {
      const Vec3& e = row == 0 ? e1 : e2;
      equations.set(corner.ends[k], across.dot(e));
      equations.set(p + row, t.x());
      equations.set(p + row + 1, t.y());
      equations.close(-slope.dot(e));
    }
  }
}

}  // namespace

std::vector<double> matching_twists(const std::vector<JoinEnd>& ends,
                                    const std::vector<TwistCorner>& corners) {
  TwistEquations equations;
  for (size_t k = 0; k < corners.size(); ++k)
    add_corner(equations, ends, corners[k], isize(ends) + 3 * static_cast<int>(k));
  const int unknowns = isize(ends) + 3 * isize(corners);
  constexpr double small = 1e-2;
  for (int k = 0; k < unknowns; ++k) {
    equations.set(k, k < isize(ends) ? small : 1e-4 * small);
    equations.close(0);
  }
  SparseMatrix A(equations.count(), unknowns);
  A.setFromTriplets(equations.entries.begin(), equations.entries.end());
  MatX x =
      A.transpose() * Eigen::Map<const Eigen::VectorXd>(equations.rhs.data(), equations.count());
  const SparseMatrix K = SparseMatrix(A.transpose() * A).triangularView<Eigen::Lower>();
  SparseCholesky cholesky;
  cholesky.analyze(K);
  if (!cholesky.factorize(K)) return std::vector<double>(ends.size(), 0.0);
  cholesky.solve_in_place(x);
  return {x.data(), x.data() + ends.size()};
}

}  // namespace batten
