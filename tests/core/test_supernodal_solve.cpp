// SPDX-License-Identifier: MPL-2.0
// The triangular solve behind SparseCholesky, on twenty matrices.
#include <Eigen/SparseCore>
#include <cmath>
#include <thread>

#include "batten/core/errors.h"
#include "batten/core/simd.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/core/solvers/supernodal_solve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/solver_matrices.h"
#include "batten/tests/support/thread_guard.h"

#ifdef BATTEN_TEST_CHOLMOD
#include "batten/tests/support/cholmod_solver.h"
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) void omp_set_max_active_levels(int);
#endif

using namespace batten_test;

namespace {

SparseCholesky factor_of(const BendingMatrix& problem) {
  SparseCholesky cholesky;
  cholesky.analyze(problem.K, problem.order);
  REQUIRE(cholesky.factorize(problem.K));
  return cholesky;
}

#ifdef BATTEN_TEST_CHOLMOD
// CHOLMOD's own solve with the values of our factor: the rounding of another factor, times the
// condition number, would hide the difference.
MatX solved_by_cholmod(const BendingMatrix& problem, const MatX& b) {
  const auto factor = make_supernodal_factor();
  factor->analyze(problem.K, problem.order, FactorReuse::once);
  REQUIRE(factor->factorize(problem.K).empty());
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
  CholmodSolver peer(problem.K, problem.order, problem.K.rows() < CholmodSolver::small);
  peer.analyze();
  peer.factorize();
  peer.set_factor_values(factor->values());
  peer.solve(b);
  return peer.solution();
}
#endif

// Bit by bit. (A failure does not print 100,000 rows.)
bool same(const MatX& a, const MatX& b) { return a == b; }

std::vector<int> every(int step, long n, int first = 0) {
  std::vector<int> rows;
  for (int i = first; i < n; i += step) rows.push_back(i);
  return rows;
}

MatX only(const MatX& b, const std::vector<int>& rows) {
  MatX result = MatX::Zero(b.rows(), b.cols());
  for (const int i : rows) result.row(i) = b.row(i);
  return result;
}

}  // namespace

TEST_CASE("twenty matrices: the solution is CHOLMOD's, with the same bits on any number of threads",
          "[core][cholesky]") {
  const std::vector<NamedMatrix> matrices = twenty_matrices();
  REQUIRE(matrices.size() == 20);
  const auto& [name, make] = matrices[GENERATE(range(0, 20))];
  INFO(name);
  const BendingMatrix problem = make();
  const SparseCholesky cholesky = factor_of(problem);
  const MatX b = random_columns(problem.K.rows(), 3);
  MatX x = b;
  {
    const ThreadGuard one(1);
    cholesky.solve_in_place(x);
  }
  CHECK(backward_error(problem.K, x, b) < 1e-14);
#ifdef BATTEN_TEST_CHOLMOD
  const MatX theirs = solved_by_cholmod(problem, b);
  CHECK((x - theirs).cwiseAbs().maxCoeff() <= 1e-12 * theirs.cwiseAbs().maxCoeff());
#endif
  for (const int threads : {2, 3, 7}) {
    const ThreadGuard several(threads);
    for (int again = 0; again < 3; ++again) CHECK(same(cholesky.solve(b), x));
  }
}

TEST_CASE("any number of right-hand sides, in any block of a larger matrix", "[core][cholesky]") {
  for (const BendingMatrix& problem :
       {clamped_bending(12), BendingMatrix{holed_sheet(400).normal, {}}}) {
    const SparseCholesky cholesky = factor_of(problem);
    const long n = problem.K.rows();
    const MatX b = random_columns(n, 19);
    MatX alone = b;
    for (long c = 0; c < b.cols(); ++c) cholesky.solve_in_place(alone.col(c));
    for (const long columns : {1, 2, 3, 4, 5, 7, 8, 9, 12, 13, 16, 19}) {
      MatX larger = MatX::Constant(n + 5, columns + 2, 7);
      larger.block(2, 1, n, columns) = b.leftCols(columns);
      cholesky.solve_in_place(larger.block(2, 1, n, columns));
      CHECK((larger.block(2, 1, n, columns) - alone.leftCols(columns)).cwiseAbs().maxCoeff() <=
            1e-13 * alone.cwiseAbs().maxCoeff());
      larger.block(2, 1, n, columns).setConstant(7);
      CHECK(same(larger, MatX::Constant(n + 5, columns + 2, 7)));
    }
    MatX none(n, 0);
    cholesky.solve_in_place(none);
  }
}

TEST_CASE("vector registers of every width give the same solution", "[core][cholesky]") {
  for (const BendingMatrix& problem :
       {clamped_bending(12), BendingMatrix{holed_sheet(14600).normal, {}}}) {
    const SparseCholesky cholesky = factor_of(problem);
    const MatX b = random_columns(problem.K.rows(), 7);
    for (const int bits : {128, 256, 512}) {
      set_max_vector_bits(bits);
      for (const long columns : {3, 7}) {
        const MatX right = b.leftCols(columns);
        MatX x = right;
        {
          const ThreadGuard one(1);
          cholesky.solve_in_place(x);
        }
        CHECK(backward_error(problem.K, x, right) < 1e-14);
        const ThreadGuard two(2);
        CHECK(same(cholesky.solve(right), x));
      }
    }
    set_max_vector_bits(512);
  }
}

TEST_CASE("numbers change again and again, the analysis stays", "[core][cholesky]") {
  const BendingMatrix problem = clamped_bending(20);
  SparseCholesky cholesky = factor_of(problem);
  const MatX b = random_columns(problem.K.rows(), 3);
  const MatX first = cholesky.solve(b);
  SparseMatrix stiffer = problem.K;
  stiffer.coeffs() *= 4;
  SparseMatrix broken = problem.K;
  broken.coeffRef(40, 40) = -1;
  for (int round = 0; round < 3; ++round) {
    REQUIRE(cholesky.factorize(stiffer));
    CHECK(same(4 * cholesky.solve(b), first));  // multiplication by a power of 4 is exact
    REQUIRE_FALSE(cholesky.factorize(broken));
    CHECK_THROWS_AS(cholesky.solve(b), NoSolutionError);
    REQUIRE(cholesky.factorize(problem.K));
    CHECK(same(cholesky.solve(b), first));
  }
  // Other matrices in the same object, smaller and larger.
  for (const int n : {7, 30}) {
    const BendingMatrix other = clamped_bending(n);
    cholesky.analyze(other.K);
    CHECK_THROWS_AS(cholesky.solve(b), NoSolutionError);
    REQUIRE(cholesky.factorize(other.K));
    const MatX c = random_columns(other.K.rows(), 9);
    CHECK(backward_error(other.K, cholesky.solve(c), c) < 1e-14);
  }
  // A rejected analysis keeps the old factor.
  cholesky = factor_of(problem);
  CHECK_THROWS_AS(cholesky.analyze(SparseMatrix(3, 4)), InputError);
  CHECK(same(cholesky.solve(b), first));
}

TEST_CASE("a part of a solve gives the wanted rows of the whole, bit by bit", "[core][cholesky]") {
  const std::vector<BendingMatrix> problems = {
      clamped_bending(48),
      {holed_sheet(3300).normal, {}},
      {holed_sheet(14600).normal, {}},
      {disconnected(holed_sheet(500).normal, holed_sheet(900).normal), {}}};
  const BendingMatrix& problem = problems[GENERATE(range(0, 4))];
  const SparseCholesky cholesky = factor_of(problem);
  const long n = problem.K.rows();
  const MatX b = random_columns(n, 5);
  const auto all = std::nullopt;
  using Rows = std::optional<std::vector<int>>;
  const std::vector<Rows> choices = {all,
                                     std::vector<int>{},
                                     std::vector<int>{3},
                                     std::vector<int>{static_cast<int>(n) - 1},
                                     every(97, n),
                                     every(1, n / 9, 11),
                                     every(1, n, static_cast<int>(n) * 7 / 8)};
  for (const int threads : {1, 2}) {
    const ThreadGuard use(threads);
    for (const Rows& nonzero : choices)
      for (const Rows& wanted : choices) {
        const SolveSubset part = cholesky.subset(nonzero, wanted);
        const MatX right = nonzero ? only(b, *nonzero) : b;
        for (const long columns : {3, 5}) {
          const MatX whole = cholesky.solve(right.leftCols(columns));
          MatX x = right.leftCols(columns);
          cholesky.solve_in_place(part, x);
          if (wanted)
            CHECK(same(only(x, *wanted), only(whole, *wanted)));
          else
            CHECK(same(x, whole));
        }
        CHECK(part.entries <= 2 * cholesky.factor_entries());
      }
  }
  CHECK(cholesky.subset(all, all).entries == 2 * cholesky.factor_entries());
  CHECK(cholesky.subset(std::vector<int>{}, std::vector<int>{}).entries == 0);
  CHECK(cholesky.subset(std::vector<int>{5}, std::vector<int>{5}).entries <
        cholesky.factor_entries());
}

TEST_CASE("a partial solve visits only the supernodes that it needs", "[core][cholesky]") {
  const SparseMatrix A = holed_sheet(3300).normal;
  const auto factor = make_supernodal_factor();
  factor->analyze(A, {}, FactorReuse::once);
  REQUIRE(factor->factorize(A).empty());
  SupernodalSolve solve(factor->pattern(), factor->order());
  solve.pack(factor->values());
  const SupernodalPattern L = factor->pattern();
  for (const int unknown : {0, 700, 2100}) {
    const std::vector<int> alone = {unknown};
    const SolveSubset part = solve.subset(alone, alone);
    MatX x = MatX::Zero(A.rows(), 3);
    x.row(unknown).setOnes();
    solve.solve(part, x);
    // Supernodes that are not visited are unchanged, even next to visited ones.
    long unvisited = 0, changed = 0;
    for (int s = 0; s < L.count; ++s)
      for (int i = L.columns[s]; i < L.columns[s + 1] && !part.forward[s]; ++i) {
        ++unvisited;
        changed += !x.row(factor->order()[i]).isZero(0);
      }
    CHECK(unvisited > A.rows() / 2);
    CHECK(changed == 0);
    CHECK(part.forward == part.backward);
  }
}

TEST_CASE("trees are cut in chunks for threads where that pays, and only there",
          "[core][cholesky]") {
  const ThreadGuard use(2);
  const auto cut = [](const SparseMatrix& A) {
    const auto factor = make_supernodal_factor();
    factor->analyze(A, {}, FactorReuse::once);
    REQUIRE(factor->factorize(A).empty());
    const SupernodalSolve solve(factor->pattern(), factor->order());
    return std::pair(solve.chunk_count(), solve.threads_for(solve.entries()));
  };
  const int two = std::min(2, core_count());
  const auto [sheet, sheet_threads] = cut(holed_sheet(14600).normal);
  CHECK(sheet >= 24);
  CHECK(sheet_threads == two);
  CHECK(cut(holed_sheet(2000).normal).second == 1);
  const auto [one, one_thread] = cut([] {
    const MatX B = MatX::Constant(1200, 1200, 1) + 1200 * MatX::Identity(1200, 1200);
    return SparseMatrix(MatX(B.triangularView<Eigen::Lower>()).sparseView());
  }());
  CHECK(one == 1);
  CHECK(one_thread == 1);
  // A long strip: one path of the elimination tree, which cannot be split among threads.
  std::vector<Triplet> entries;
  const int length = 20000, width = 6;
  for (int i = 0; i < length * width; ++i) {
    entries.emplace_back(i, i, 5.0);
    if (i % width) entries.emplace_back(i, i - 1, -1.0);
    if (i >= width) entries.emplace_back(i, i - width, -1.0);
  }
  SparseMatrix strip(length * width, length * width);
  strip.setFromTriplets(entries.begin(), entries.end());
  CHECK(cut(strip).first < 200);
}

TEST_CASE("factors made at the same time in two threads have the bits of one made alone",
          "[core][cholesky]") {
  const SparseMatrix A = holed_sheet(14600).normal;
  const MatX b = random_columns(A.rows(), 1);
  const auto solution = [&] {  // in any thread: no assertions in here
    SparseCholesky cholesky;
    cholesky.analyze(A);
    return cholesky.factorize(A) ? cholesky.solve(b) : MatX();
  };
  const MatX x = solution();
  REQUIRE(x.size() == b.size());
  MatX other;
  std::thread beside([&] { other = solution(); });
  for (int round = 0; round < 3; ++round) CHECK(same(solution(), x));
  beside.join();
  CHECK(same(other, x));
}

TEST_CASE("systems that cannot be solved are refused with the reason", "[core][cholesky]") {
  const BendingMatrix problem = clamped_bending(6);
  SparseCholesky cholesky;
  MatX b = MatX::Ones(problem.K.rows(), 1);
  CHECK_THROWS_AS(cholesky.solve(b), NoSolutionError);
  CHECK_THROWS_AS(cholesky.subset(std::nullopt, std::nullopt), NoSolutionError);
  cholesky = factor_of(problem);
  MatX shorter = b.topRows(5);
  CHECK_THROWS_AS(cholesky.solve_in_place(shorter), InputError);
  // The same number of entries, one at another position.
  SparseMatrix moved = problem.K;
  moved.prune([&](long row, long column, double) { return row != 40 || column != 39; });
  const bool was_there = moved.nonZeros() < problem.K.nonZeros();
  REQUIRE(was_there);
  moved.coeffRef(problem.K.rows() - 1, 0) = 1e-3;
  REQUIRE(moved.nonZeros() == problem.K.nonZeros());
  CHECK_THROWS_AS(cholesky.factorize(moved), InputError);
  SparseMatrix denser = problem.K;
  denser.coeffRef(problem.K.rows() - 1, 0) = 1e-3;
  denser.makeCompressed();
  CHECK_THROWS_AS(cholesky.factorize(denser), InputError);
  CHECK_THROWS_AS(cholesky.subset(std::vector<int>{-1}, std::nullopt), InputError);
  CHECK_THROWS_AS(cholesky.subset(std::nullopt, std::vector<int>{static_cast<int>(b.rows())}),
                  InputError);
  const SolveSubset part = cholesky.subset(std::vector<int>{0}, std::nullopt);
  const BendingMatrix other = clamped_bending(9);
  SparseCholesky another = factor_of(other);
  MatX c = MatX::Ones(other.K.rows(), 1);
  CHECK_THROWS_AS(another.solve_in_place(part, c), InputError);
  another.analyze(problem.K);  // the same matrix, another ordering
  REQUIRE(another.factorize(problem.K));
  CHECK_THROWS_AS(another.solve_in_place(part, b), InputError);

  std::vector<int> order = problem.order;
  order.pop_back();
  CHECK_THROWS_AS(cholesky.analyze(problem.K, order), InputError);
  order.push_back(order.front());
  CHECK_THROWS_AS(cholesky.analyze(problem.K, order), InputError);
  order.back() = static_cast<int>(b.rows());
  CHECK_THROWS_AS(cholesky.analyze(problem.K, order), InputError);

  CHECK_THROWS_AS(refine_least_squares(cholesky, problem.K, MatX(3, 1), b), InputError);
  CHECK_THROWS_AS(refine_least_squares(cholesky, problem.K, b, c), InputError);

  SparseCholesky empty = std::move(cholesky);
  empty.analyze(SparseMatrix(0, 0));
  REQUIRE(empty.factorize(SparseMatrix(0, 0)));
  CHECK(empty.solve(MatX(0, 3)).size() == 0);
  MatX nothing(0, 2);
  CHECK(refine_least_squares(empty, SparseMatrix(4, 0), MatX::Ones(4, 2), nothing) == 0);

  SparseCholesky without_entries;  // all zero
  CHECK_FALSE(without_entries.factorize(SparseMatrix(4, 4)));
  CHECK(without_entries.message().find("not positive definite (pivot of unknown") !=
        std::string::npos);
}

TEST_CASE("a matrix with padding between its columns is the same matrix", "[core][cholesky]") {
  const BendingMatrix problem = clamped_bending(8);
  SparseMatrix loose = problem.K;
  loose.uncompress();
  loose.reserve(Eigen::VectorXi::Constant(loose.cols(), 3));
  REQUIRE_FALSE(loose.isCompressed());
  SparseCholesky cholesky;
  cholesky.analyze(loose, problem.order);
  REQUIRE(cholesky.factorize(loose));
  const MatX b = random_columns(loose.rows(), 2);
  CHECK(same(cholesky.solve(b), factor_of(problem).solve(b)));
  REQUIRE(cholesky.factorize(problem.K));
  CHECK(same(cholesky.solve(b), factor_of(problem).solve(b)));
}

TEST_CASE("numbers that are not finite are no factor, wherever they are", "[core][cholesky]") {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
    for (const int where : {0, 1, 7, 24, 25, 49}) {
      // Two decoupled chains.
      std::vector<Triplet> entries;
      for (int i = 0; i < 50; ++i) {
        entries.emplace_back(i, i, i == where ? bad : 2.0);
        if (i % 25) entries.emplace_back(i, i - 1, -1.0);
      }
      SparseMatrix A(50, 50);
      A.setFromTriplets(entries.begin(), entries.end());
      SparseCholesky cholesky;
      cholesky.analyze(A);
      INFO(bad << " at " << where);
      CHECK_FALSE(cholesky.factorize(A));
      CHECK_FALSE(cholesky.message().empty());
    }
}

TEST_CASE("a pivot of nothing but rounding is none", "[core][cholesky]") {
  SparseMatrix A(2, 2);
  A.insert(0, 0) = 1;
  A.insert(1, 0) = 1;
  A.insert(1, 1) = 1 + 4e-16;
  SparseCholesky cholesky;
  cholesky.analyze(A);
  CHECK_FALSE(cholesky.factorize(A));
  CHECK(cholesky.message().find("not positive definite") != std::string::npos);
}

TEST_CASE("an order for many factorizations has no more entries than AMD's", "[core][cholesky]") {
  const SparseMatrix A = holed_sheet(14600).normal;
  SparseCholesky quick, thorough;
  quick.analyze(A);
  thorough.analyze(A, FactorReuse::many);
  REQUIRE(quick.factorize(A));
  REQUIRE(thorough.factorize(A));
  if (SparseCholesky::backend() == std::string("CHOLMOD"))
    CHECK(thorough.factor_entries() < 0.95 * static_cast<double>(quick.factor_entries()));
  const long entries = thorough.factor_entries();
  thorough.analyze(A);  // the thorough ordering is not kept
  REQUIRE(thorough.factorize(A));
  CHECK(thorough.factor_entries() == quick.factor_entries());
  thorough.analyze(A, FactorReuse::many);
  REQUIRE(thorough.factorize(A));
  CHECK(thorough.factor_entries() == entries);
  const MatX b = random_columns(A.rows(), 2);
  CHECK(backward_error(A, thorough.solve(b), b) < 1e-14);
}

TEST_CASE("the least-squares residual corrects what the normal equations lost",
          "[core][cholesky]") {
  for (const int vertices : {3300, 14600}) {
    const HoledSheet sheet = holed_sheet(vertices);
    SparseCholesky cholesky;
    cholesky.analyze(sheet.normal);
    REQUIRE(cholesky.factorize(sheet.normal));
    const MatX truth = sheet.shape, b = sheet.rows * truth;
    const auto error = [&](const MatX& x) {
      return (x - truth).cwiseAbs().maxCoeff() / truth.cwiseAbs().maxCoeff();
    };
    const MatX right = sheet.rows.transpose() * b;
    const MatX solved = cholesky.solve(right);
    const MatX refined =
        solved + cholesky.solve(right - sheet.normal.selfadjointView<Eigen::Lower>() * solved);
    MatX corrected = solved;
    const double change = refine_least_squares(cholesky, sheet.rows, b, corrected);
    INFO(error(solved) << " refined " << error(refined) << " corrected " << error(corrected));
    CHECK(error(corrected) < 5e-14);
    CHECK(error(solved) > 10 * error(corrected));
    CHECK(error(refined) > 10 * error(corrected));
    CHECK_THAT(change, Catch::Matchers::WithinRel(error(solved), 0.1));

    // A right-hand side that is far from the range of A: its residual contains no information about
    // x.
    MatX far = random_columns(sheet.rows.rows(), 3);
    for (int again = 0; again < 3; ++again) {
      MatX near = cholesky.solve(sheet.rows.transpose() * far);
      far -= sheet.rows * near;
    }
    far *= b.norm() / far.norm();
    MatX x = cholesky.solve(sheet.rows.transpose() * (b + far));
    refine_least_squares(cholesky, sheet.rows, b + far, x);
    refine_least_squares(cholesky, sheet.rows, b + far, x);
    INFO(error(x));
    CHECK(error(x) < 1e-10);
  }
}
