// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/dense_algebra.h"

#include <Eigen/LU>
#include <Eigen/QR>

namespace batten {

MatX solve_dense(const MatX& A, const MatX& b) { return A.fullPivLu().solve(b); }

MatX null_space(const MatX& C) {
  const Eigen::ColPivHouseholderQR<MatX> qr(C.transpose());
  const MatX Q = qr.householderQ() * MatX::Identity(C.cols(), C.cols());
  return Q.rightCols(C.cols() - qr.rank());
}

}  // namespace batten
