// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/sparse_cholesky.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <memory>

#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/solvers/distributed_solver.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// Lower triangle of a random sparse matrix with a dominant diagonal.
SparseMatrix random_spd(int n, unsigned seed) {
  Random random(seed);
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 12 + random());
    for (int k = 0; k < 4; ++k) {
      const int j = static_cast<int>(random.engine() % n);
      if (j < i) entries.emplace_back(i, j, random());
    }
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix lower(const MatX& A) {
  return SparseMatrix(MatX(A.triangularView<Eigen::Lower>()).sparseView());
}

// (-1, 2, -1) of the second difference with n unknowns; both ends fixed unless `free`.
MatX second_difference(int n, bool free) {
  MatX A = MatX::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    A(i, i) = free && (i == 0 || i == n - 1) ? 1 : 2;
    if (i > 0) A(i, i - 1) = A(i - 1, i) = -1;
  }
  return A;
}

double residual(const SparseMatrix& A, const MatX& x, const MatX& b) {
  return (A.selfadjointView<Eigen::Lower>() * x - b).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("A x = b is solved to rounding, for one right-hand side and for many",
          "[core][cholesky]") {
  for (const int n : {1, 2, 3, 50, 600}) {
    const SparseMatrix A = random_spd(n, n);
    SparseCholesky cholesky;
    cholesky.analyze(A);
    REQUIRE(cholesky.factorize(A));
    CHECK(cholesky.message().empty());
    CHECK(cholesky.factor_entries() >= n);
    Random random(7);
    for (const int columns : {1, 3, 20}) {
      const MatX b = MatX::NullaryExpr(n, columns, [&] { return random(); });
      const MatX x = cholesky.solve(b);
      REQUIRE(x.rows() == n);
      REQUIRE(x.cols() == columns);
      CHECK(residual(A, x, b) < 1e-14 * (1 + std::sqrt(n)));
      // Columns are independent of each other.
      for (int c = 0; c < columns; ++c)
        CHECK((cholesky.solve(b.col(c)) - x.col(c)).cwiseAbs().maxCoeff() < 1e-14);
    }
  }
}

TEST_CASE("only the lower triangle is read", "[core][cholesky]") {
  const SparseMatrix A = random_spd(30, 4);
  SparseMatrix with_rubbish = A;
  with_rubbish.coeffRef(2, 17) = 1e6;
  with_rubbish.coeffRef(0, 29) = -1e6;
  with_rubbish.makeCompressed();
  const VecX b = VecX::LinSpaced(30, -1, 1);
  SparseCholesky one, other;
  one.analyze(A);
  other.analyze(with_rubbish);
  REQUIRE(one.factorize(A));
  REQUIRE(other.factorize(with_rubbish));
  CHECK((one.solve(b) - other.solve(b)).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("new numbers in the same pattern need no new analysis", "[core][cholesky]") {
  SparseMatrix A = random_spd(80, 11);
  SparseCholesky cholesky;
  cholesky.analyze(A);
  REQUIRE(cholesky.factorize(A));
  const VecX b = VecX::Ones(80);
  const MatX first = cholesky.solve(b);
  A.coeffs() *= 4;
  REQUIRE(cholesky.factorize(A));
  CHECK((4 * cholesky.solve(b) - first).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("solving twice gives the same bits", "[core][cholesky]") {
  const SparseMatrix A = random_spd(300, 5);
  const MatX b = MatX::Ones(300, 3);
  SparseCholesky one, other;
  one.analyze(A);
  other.analyze(A);
  REQUIRE(one.factorize(A));
  REQUIRE(other.factorize(A));
  CHECK(one.solve(b) == one.solve(b));
  CHECK(one.solve(b) == other.solve(b));
}

TEST_CASE("a matrix that is not positive definite is reported, not thrown, and can be mended",
          "[core][cholesky]") {
  SparseCholesky cholesky;
  const auto fails = [&](const MatX& dense) {
    const SparseMatrix A = lower(dense);
    cholesky.analyze(A);
    const bool ok = cholesky.factorize(A);
    UNSCOPED_INFO(cholesky.message());
    return !ok && cholesky.message().find("not positive definite") != std::string::npos;
  };
  CHECK(fails(second_difference(40, true)));  // constants have zero energy: singular
  MatX indefinite = second_difference(40, false);
  indefinite(13, 13) = -1;
  CHECK(fails(indefinite));
  CHECK(fails(MatX::Constant(1, 1, -2)));
  CHECK(fails((MatX(2, 2) << 1, 2, 2, 1).finished()));

  MatX isolated = MatX::Identity(9, 9);
  isolated(5, 5) = -1;
  CHECK(fails(isolated));
  CHECK(cholesky.message().find("unknown 5") != std::string::npos);

  // Singularity is invariant under scaling of the unknowns.
  const VecX scale = VecX::NullaryExpr(40, [](auto i) { return i % 2 ? 1e6 : 1e-6; });
  CHECK(fails(scale.asDiagonal() * second_difference(40, true) * scale.asDiagonal()));
  const SparseMatrix stiff =
      lower(scale.asDiagonal() * second_difference(40, false) * scale.asDiagonal());
  cholesky.analyze(stiff);
  CHECK(cholesky.factorize(stiff));

  // The same object and pattern with regular values.
  const SparseMatrix bad = lower(second_difference(40, true));
  const SparseMatrix good = lower(second_difference(40, false));
  cholesky.analyze(bad);
  REQUIRE_FALSE(cholesky.factorize(bad));
  REQUIRE(cholesky.factorize(good));
  CHECK(cholesky.message().empty());
  const VecX b = VecX::Ones(40);
  CHECK(residual(good, cholesky.solve(b), b) < 1e-12);
}

TEST_CASE("numbers that are not finite are no factor", "[core][cholesky]") {
  MatX A = second_difference(20, false);
  A(7, 7) = std::nan("");
  const SparseMatrix sparse = lower(A);
  SparseCholesky cholesky;
  cholesky.analyze(sparse);
  CHECK_FALSE(cholesky.factorize(sparse));
  CHECK_FALSE(cholesky.message().empty());
}

TEST_CASE("a matrix that is not square is an input error", "[core][cholesky]") {
  SparseCholesky cholesky;
  CHECK_THROWS_AS(cholesky.analyze(SparseMatrix(3, 4)), InputError);
  CHECK_THROWS_AS(cholesky.factorize(SparseMatrix(4, 3)), InputError);
}

TEST_CASE("a factor moves with its numbers", "[core][cholesky]") {
  const SparseMatrix A = random_spd(25, 3);
  const VecX b = VecX::Ones(25);
  SparseCholesky first;
  first.analyze(A);
  REQUIRE(first.factorize(A));
  const MatX x = first.solve(b);
  SparseCholesky second(std::move(first));
  CHECK(second.solve(b) == x);
  SparseCholesky third;
  third = std::move(second);
  CHECK(third.solve(b) == x);
  const std::string backend = SparseCholesky::backend();
  CHECK((backend == "CHOLMOD" || backend == "Eigen"));
}

TEST_CASE("a factor that memory cannot hold is refused before its numbers", "[core][cholesky]") {
  if (std::string(SparseCholesky::backend()) != "CHOLMOD") return;
  // All are coupled only to the first one; eliminating it first gives a full factor.
  constexpr int n = 6000;
  std::vector<Triplet> entries;
  std::vector<int> order;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, n);
    if (i > 0) entries.emplace_back(i, 0, 1);
    order.push_back(i);
  }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  struct NoLimit {
    ~NoLimit() { set_memory_limit(0); }
  } afterwards;
  SparseCholesky cholesky;
  set_memory_limit(1e8);
  CHECK_THROWS_WITH(
      cholesky.analyze(A, order),
      Catch::Matchers::Contains("the Cholesky factor of 6000 unknowns needs 288 MB of memory"));
  cholesky.analyze(A);  // reversed, it is as sparse as A
  REQUIRE(cholesky.factorize(A));
  set_memory_limit(0);
  CHECK_NOTHROW(cholesky.analyze(A, order));
}

TEST_CASE("the library of a factorization is chosen at run time", "[core][cholesky]") {
  const auto libraries = cholesky_libraries();
  REQUIRE(!libraries.empty());
  CHECK(libraries.back() == CholeskyLibrary::Eigen);
  const int n = 400;
  const SparseMatrix A = random_spd(n, 5);
  Random random(3);
  const MatX b = MatX::NullaryExpr(n, 3, [&] { return random(); });
  for (const CholeskyLibrary library : libraries) {
    INFO(library_name(library));
    const std::unique_ptr<LinearSolverBackend> solver = std::make_unique<SparseCholesky>(library);
    CHECK(!solver->has_pattern_of(A));
    solver->analyze(A, {});
    CHECK(solver->has_pattern_of(A));
    for (const double scale : {1.0, 3.0}) {
      REQUIRE(solver->factorize(scale * A));
      CHECK(solver->message().empty());
      MatX x = b;
      solver->solve_in_place(x);
      CHECK(residual(A, scale * x, b) < 1e-13);
    }
    CHECK(!solver->factorize(-1 * A));
    CHECK(!solver->message().empty());
  }
  if (libraries.front() != CholeskyLibrary::Cholmod)
    CHECK_THROWS_AS(SparseCholesky(CholeskyLibrary::Cholmod), InputError);
}

namespace {

// A module of one process, which records its calls.
struct FakeModule {
  static inline std::map<int, MatX> matrices;
  static inline int ends = 0;
  static const char* start(BattenDistributed* module) {
    ends = 0;
    *module = {0, 2, [] {}, factorize, solve, [](int id) { matrices.erase(id); }, [] { ++ends; }};
    return nullptr;
  }
  static const char* factorize(int id, int n, const int* outer, const int* inner,
                               const double* values) {
    MatX A = MatX::Zero(n, n);
    for (int c = 0; c < n; ++c)
      for (int k = outer[c]; k < outer[c + 1]; ++k) A(c, inner[k]) = A(inner[k], c) = values[k];
    matrices[id] = A;
    return A(0, 0) > 0 ? nullptr : "the first pivot is not positive";
  }
  static const char* solve(int id, double* b, int k) {
    if (k > 3) return "too many right-hand sides";
    const MatX& A = matrices.at(id);
    Eigen::Map<MatX> x(b, A.rows(), k);
    x = A.ldlt().solve(MatX(x));
    return nullptr;
  }
};

}  // namespace

TEST_CASE("a distributed solver passes whole systems to its module", "[core][cholesky]") {
  const int n = 60;
  SparseMatrix A = random_spd(n, 9);
  A.coeffRef(n - 1, 0) = 0.5;  // leaves gaps between the columns
  const SparseMatrix full = A.selfadjointView<Eigen::Lower>();
  Random random(2);
  const MatX b = MatX::NullaryExpr(2 * n, 3, [&] { return random(); });
  {
    MpiProcesses processes(FakeModule::start);
    CHECK(processes.size() == 2);
    CHECK(!processes.is_worker());
    const BackendFactory make = processes.solvers();
    const auto one = make(), two = make();
    REQUIRE(one->factorize(A));
    CHECK(one->has_pattern_of(full));
    REQUIRE(two->factorize(2 * full));
    CHECK(FakeModule::matrices.size() == 2);
    MatX x = b;
    one->solve_in_place(x.topRows(n));  // rows that are not contiguous
    two->solve_in_place(x.bottomRows(n));
    CHECK(residual(A, x.topRows(n), b.topRows(n)) < 1e-13);
    CHECK(residual(A, 2 * x.bottomRows(n), b.bottomRows(n)) < 1e-13);
    MatX four = MatX::Zero(n, 4);
    CHECK_THROWS_AS(one->solve_in_place(four), NoSolutionError);
    CHECK(!two->factorize(-1 * A));
    CHECK(two->message() == "the first pivot is not positive");
  }
  CHECK(FakeModule::matrices.empty());
  CHECK(FakeModule::ends == 1);
  CHECK_THROWS_AS(MpiProcesses([](BattenDistributed*) { return "no MPI"; }), InputError);
}
