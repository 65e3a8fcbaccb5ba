// SPDX-License-Identifier: MPL-2.0
// The numeric factorization behind SparseCholesky: properties of its values.
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "batten/core/simd.h"
#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/solver_matrices.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;

namespace {

// Lower triangle of a grid of nodes with some unknowns each, coupled to all nodes within a
// distance; diagonally dominant.
SparseMatrix grid(int wide, int high, int dofs, int reach) {
  std::mt19937 random(7);
  std::vector<Triplet> entries;
  const int most = (2 * reach + 1) * (2 * reach + 1) * dofs;
  for (int a = 0; a < wide * high; ++a)
    for (int b = 0; b <= a; ++b) {
      if (std::abs(a / wide - b / wide) > reach || std::abs(a % wide - b % wide) > reach) continue;
      for (int i = 0; i < dofs; ++i)
        for (int j = 0; j < (a == b ? i + 1 : dofs); ++j)
          entries.emplace_back(
              a * dofs + i, b * dofs + j,
              a == b && i == j ? most : static_cast<int>(random() % 2001) * 1e-3 - 1);
    }
  SparseMatrix A(wide * high * dofs, wide * high * dofs);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

// Each row has some entries at random positions.
SparseMatrix scattered(int n, int a_row) {
  std::mt19937 random(n);
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 4.0 * a_row + 1);
    for (int k = 0; k < a_row && i > 0; ++k)
      entries.emplace_back(i, static_cast<int>(random() % i), random() % 2 ? 1 : -1);
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end(), [](double, double b) { return b; });
  VecX sums = VecX::Ones(n);
  for (int c = 0; c < n; ++c)
    for (SparseMatrix::InnerIterator e(A, c); e; ++e)
      if (e.row() != c) sums[c] += std::abs(e.value()), sums[e.row()] += std::abs(e.value());
  for (int i = 0; i < n; ++i) A.coeffRef(i, i) = sums[i];
  return A;
}

// The last `heads` unknowns are coupled to all, the others only to themselves.
SparseMatrix arrow(int n, int heads) {
  std::mt19937 random(5);
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, i < n - heads ? 2 : n * heads);
    for (int h = std::max(n - heads, i + 1); h < n; ++h)
      entries.emplace_back(h, i, static_cast<int>(random() % 2001) * 1e-3 - 1);
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix halves(int n) {
  SparseMatrix A(n, n);
  for (int i = 0; i < n; ++i) A.insert(i, i) = i + 0.5;
  return A;
}

std::vector<SparseMatrix> matrices() {
  std::vector<SparseMatrix> all = {halves(1),
                                   halves(77),
                                   arrow(300, 1),
                                   arrow(500, 37),
                                   scattered(50, 2),
                                   scattered(900, 3),
                                   grid(40, 31, 1, 1),
                                   grid(17, 23, 3, 2),
                                   grid(40, 40, 3, 3),
                                   grid(12, 9, 12, 1),
                                   disconnected(grid(9, 9, 3, 1), scattered(200, 2)),
                                   clamped_bending(16).K};
  for (const int n : {2, 7, 8, 9, 15, 16, 17, 24, 25, 33, 95, 96, 97, 200, 1000})
    all.push_back(grid(1, 1, n, 1));  // dense
  return all;
}

void make(SupernodalFactor& factor, const SparseMatrix& A) {
  factor.analyze(A, {}, FactorReuse::once);
  REQUIRE(factor.factorize(A).empty());
}

// L as a sparse matrix, its lower triangle.
SparseMatrix unpacked(SupernodalFactor& factor) {
  const SupernodalPattern L = factor.pattern();
  std::vector<Triplet> entries;
  for (int s = 0; s < L.count; ++s) {
    const int rows = L.row_starts[s + 1] - L.row_starts[s];
    for (int c = L.columns[s]; c < L.columns[s + 1]; ++c)
      for (int i = c - L.columns[s]; i < rows; ++i)
        entries.emplace_back(L.rows[L.row_starts[s] + i], c,
                             factor.values()[L.value_starts[s] + (c - L.columns[s]) * rows + i]);
  }
  SparseMatrix result(L.columns[L.count], L.columns[L.count]);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

// Largest entry of L Lᵀ - P A Pᵀ over the largest of A.
double product_error(const SparseMatrix& A, SupernodalFactor& factor) {
  const SparseMatrix L = unpacked(factor);
  std::vector<int> place(A.rows());
  for (int i = 0; i < A.rows(); ++i) place[factor.order()[i]] = i;
  std::vector<Triplet> entries;
  for (int c = 0; c < A.cols(); ++c)
    for (SparseMatrix::InnerIterator e(A, c); e; ++e)
      entries.emplace_back(std::max(place[e.row()], place[c]), std::min(place[e.row()], place[c]),
                           e.value());
  SparseMatrix permuted(A.rows(), A.cols());
  permuted.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix product = L * SparseMatrix(L.transpose());
  const SparseMatrix difference = SparseMatrix(product.triangularView<Eigen::Lower>()) - permuted;
  return difference.coeffs().cwiseAbs().maxCoeff() / A.coeffs().cwiseAbs().maxCoeff();
}

bool same(const SparseMatrix& a, const SparseMatrix& b) {
  return a.nonZeros() == b.nonZeros() &&
         std::memcmp(a.valuePtr(), b.valuePtr(), a.nonZeros() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("L Lᵀ is the permuted matrix, on registers of every width and from every library",
          "[core][cholesky]") {
  for (const SparseMatrix& A : matrices()) {
    INFO(A.rows() << " unknowns, " << A.nonZeros() << " entries");
    for (const int bits : {128, 256, 512}) {
      set_max_vector_bits(bits);
      const auto factor = make_supernodal_factor();
      make(*factor, A);
      CHECK(product_error(A, *factor) < 1e-14);
    }
    set_max_vector_bits(512);
    for (const CholeskyLibrary library : cholesky_libraries().subspan(1)) {
      const auto factor = make_supernodal_factor(library);
      make(*factor, A);
      CHECK(product_error(A, *factor) < 1e-14);
    }
  }
}

TEST_CASE("a factor has the same bits on any number of threads, again and again",
          "[core][cholesky]") {
  for (const SparseMatrix& A :
       {grid(40, 40, 3, 3), grid(1, 1, 1000, 1), grid(20, 20, 12, 1), arrow(3000, 200),
        disconnected(grid(60, 60, 3, 1), grid(30, 30, 3, 2)), holed_sheet(14600).normal}) {
    INFO(A.rows() << " unknowns, " << A.nonZeros() << " entries");
    const auto factor = make_supernodal_factor();
    factor->analyze(A, {}, FactorReuse::once);
    const auto numbers = [&](int threads) {
      const ThreadGuard use(threads);
      REQUIRE(factor->factorize(A).empty());
      return unpacked(*factor);
    };
    const SparseMatrix alone = numbers(1);
    for (const int threads : {2, 2, 3, 2}) CHECK(same(numbers(threads), alone));
    const auto another = make_supernodal_factor();
    make(*another, A);
    CHECK(same(unpacked(*another), alone));
  }
}

TEST_CASE("of several pivots that fail the first in the order of elimination is named",
          "[core][cholesky]") {
  const SparseMatrix A = grid(40, 40, 3, 3);
  const auto factor = make_supernodal_factor();
  make(*factor, A);
  const std::vector<int> order(factor->order(), factor->order() + A.rows());
  const int n = static_cast<int>(A.rows());
  for (const std::vector<int>& rows : std::vector<std::vector<int>>{
           {0}, {n - 1}, {n / 2, n / 3}, {n - 5, 40}, {n - 200, n - 199}, {2000, 3000, 4000}}) {
    SparseMatrix broken = A;
    for (const int row : rows)
      broken.coeffRef(order[row], order[row]) = row % 2 ? -1 : std::nan("");
    const int first = order[*std::min_element(rows.begin(), rows.end())];
    for (const int threads : {1, 2, 2, 2}) {
      const ThreadGuard use(threads);
      CHECK(factor->factorize(broken) == not_positive_definite(first));
    }
  }
  CHECK(factor->factorize(A).empty());
  CHECK(product_error(A, *factor) < 1e-14);
}
