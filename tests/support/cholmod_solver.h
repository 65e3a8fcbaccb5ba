// SPDX-License-Identifier: MPL-2.0
// Direct calls of CHOLMOD, for comparison.
#pragma once

#include <cholmod.h>

#include <algorithm>
#include <vector>

#include "batten/core/eigen.h"

namespace batten_test {

/// CHOLMOD as in its manual: supernodal LLᵀ, a solve with kept workspace.
class CholmodSolver {
 public:
  /// `A`: lower triangle, compressed; must outlive this object. `order` may be empty: AMD.
  /// Supernodes are merged by CHOLMOD's own rule, or by the one that Batten requests for small
  /// matrices: the factor then has the same pattern as Batten's.
  CholmodSolver(const batten::SparseMatrix& A, std::vector<int> order, bool joined_for_small)
      : order_(std::move(order)) {
    cholmod_start(&common_);
    if (joined_for_small) {
      const size_t columns[] = {16, 32, 64};
      const double zeros[] = {0.9, 0.2, 0.1};
      std::copy_n(columns, 3, common_.nrelax);
      std::copy_n(zeros, 3, common_.zrelax);
    }
    common_.nmethods = 1;
    common_.method[0].ordering = order_.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.final_ll = 1;
    matrix_.nrow = matrix_.ncol = static_cast<size_t>(A.rows());
    matrix_.nzmax = static_cast<size_t>(A.nonZeros());
    matrix_.p = const_cast<int*>(A.outerIndexPtr());
    matrix_.i = const_cast<int*>(A.innerIndexPtr());
    matrix_.x = const_cast<double*>(A.valuePtr());
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.sorted = matrix_.packed = 1;
  }
  CholmodSolver(const CholmodSolver&) = delete;
  ~CholmodSolver() {
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  void analyze() {
    cholmod_free_factor(&factor_, &common_);
    factor_ =
        cholmod_analyze_p(&matrix_, order_.empty() ? nullptr : order_.data(), nullptr, 0, &common_);
  }
  void factorize() { cholmod_factorize(&matrix_, factor_, &common_); }
  /// Replaces the numeric values by those of a factor with the same pattern, after factorize().
  void set_factor_values(const double* values) {
    std::copy_n(values, factor_->xsize, static_cast<double*>(factor_->x));
  }
  void solve(const batten::MatX& b) {
    cholmod_dense view{};
    view.nrow = view.d = static_cast<size_t>(b.rows());
    view.ncol = static_cast<size_t>(b.cols());
    view.nzmax = static_cast<size_t>(b.size());
    view.x = const_cast<double*>(b.data());
    view.xtype = CHOLMOD_REAL;
    cholmod_solve2(CHOLMOD_A, factor_, &view, nullptr, &x_, nullptr, &y_, &e_, &common_);
  }
  /// Of the last solve.
  batten::MatX solution() const {
    return Eigen::Map<const batten::MatX>(static_cast<const double*>(x_->x),
                                          static_cast<long>(x_->nrow), static_cast<long>(x_->ncol));
  }

  /// Below this number of unknowns, Batten's factor merges supernodes by its own rule.
  static constexpr long small = 20000;

 private:
  std::vector<int> order_;
  cholmod_common common_{};
  cholmod_sparse matrix_{};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
};

}  // namespace batten_test
