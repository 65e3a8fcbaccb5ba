// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/affine_reduction.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

using Entries = std::vector<ConstraintSet::Entry>;
using CoupledEntries = std::vector<ConstraintSet::CoupledEntry>;

struct Draws : Random {
  using Random::Random;
  int below(int n) { return static_cast<int>(engine() % n); }
  MatX matrix(long rows, long columns) {
    return MatX::NullaryExpr(rows, columns, [&] { return (*this)(); });
  }
};

// Lower triangle of a random sparse positive definite matrix.
SparseMatrix random_stiffness(int n, Draws& random) {
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 6 + random());
    for (int k = 0; k < 4; ++k)
      if (const int j = random.below(n); j < i) entries.emplace_back(i, j, random());
  }
  SparseMatrix K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

MatX dense(const SparseMatrix& lower) {
  return SparseMatrix(lower.selfadjointView<Eigen::Lower>());
}

// diag(K, K, K) for [x; y; z], or K itself.
MatX stacked(const SparseMatrix& K, bool coupled) {
  const MatX one = dense(K);
  if (!coupled) return one;
  const long n = one.rows();
  MatX three = MatX::Zero(3 * n, 3 * n);
  for (int c = 0; c < 3; ++c) three.block(c * n, c * n, n, n) = one;
  return three;
}

std::string row_name(int i) { return "row " + std::to_string(i); }

// Random constraint equations, independent because each is dominated by a dof of its own.
ConstraintSet random_constraints(int n, int rows, int coupled_rows, Draws& random) {
  std::vector<int> own(n);
  std::iota(own.begin(), own.end(), 0);
  std::shuffle(own.begin(), own.end(), random.engine);
  ConstraintSet set(n);
  for (int r = 0; r < rows; ++r) {
    Entries entries{{own[r], 1.5 + 0.5 * random()}};
    for (int k = random.below(4); k > 0; --k) entries.push_back({random.below(n), 0.3 * random()});
    set.add(row_name(r), entries, random.point());
  }
  for (int r = 0; r < coupled_rows; ++r) {
    CoupledEntries entries{{own[rows + r], random.point().normalized()}};
    for (int k = random.below(3); k > 0; --k)
      entries.push_back({random.below(n), 0.2 * random.point()});
    set.add_coupled("coupled " + std::to_string(r), entries, random());
  }
  return set;
}

double difference(const MatX& a, const MatX& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Springs of stiffness 1 between neighbours: the chain itself is not supported.
SparseMatrix chain(int n) {
  std::vector<Triplet> entries;
  for (int i = 0; i + 1 < n; ++i) {
    entries.emplace_back(i, i, 1.0);
    entries.emplace_back(i + 1, i + 1, 1.0);
    entries.emplace_back(i + 1, i, -1.0);
  }
  SparseMatrix K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

std::vector<ConflictError::Conflict> conflicts_of(const ConstraintSet& set) {
  try {
    const AffineReduction reduction(set);
  } catch (const ConflictError& error) {
    return error.conflicts();
  }
  return {};
}

using Names = std::set<std::string>;
Names names_of(const ConflictError::Conflict& conflict) {
  return {conflict.names.begin(), conflict.names.end()};
}

}  // namespace

TEST_CASE("elimination has the solution of the saddle point system", "[constraints][reduction]") {
  for (unsigned seed = 1; seed <= 8; ++seed)
    for (const bool coupled : {false, true}) {
      INFO("seed " << seed << (coupled ? ", coupled" : ", uncoupled"));
      Draws random(seed);
      const int n = 40;
      const SparseMatrix K = random_stiffness(n, random);
      const Points F = random.matrix(n, 3);
      const ConstraintSet set = random_constraints(n, 9, coupled ? 8 : 0, random);
      REQUIRE(set.coupled() == coupled);
      const AffineReduction reduction(set);
      CHECK(reduction.coupled() == coupled);
      CHECK(reduction.redundant_count() == 0);
      CHECK(reduction.free_count() == (coupled ? 3 * n - 27 - 8 : n - 9));

      const Points x = solve_constrained(set, K, F);
      CHECK(difference(x, solve_kkt(set, K, F)) < 1e-9);
      CHECK(set.max_residual(x) < 1e-12);
      // Stationary: the residual force does no work on any admissible displacement.
      const Points r = reaction_forces(K, x, F);
      const MatX work =
          coupled ? MatX(reduction.D().transpose() * Eigen::Map<const VecX>(r.data(), r.size()))
                  : MatX(reduction.D().transpose() * r);
      CHECK(work.cwiseAbs().maxCoeff() < 1e-11);
      CHECK(r.cwiseAbs().maxCoeff() > 1e-3);
    }
}

TEST_CASE("the rows hold for every y, not only for the solution", "[constraints][reduction]") {
  for (const bool coupled : {false, true}) {
    Draws random(21);
    const int n = 30;
    const ConstraintSet set = random_constraints(n, 7, coupled ? 6 : 0, random);
    const AffineReduction reduction(set);
    for (int trial = 0; trial < 20; ++trial) {
      const MatX y = random.matrix(reduction.free_count(), coupled ? 1 : 3);
      const Points x = reduction.expand(y);
      REQUIRE(x.rows() == n);
      CHECK(set.max_residual(x) < 1e-12);
    }
    // x = D y + d0, stacked or by coordinates.
    const MatX y = random.matrix(reduction.free_count(), coupled ? 1 : 3);
    const MatX expected = MatX(reduction.D() * y + reduction.d0());
    const Points x = reduction.expand(y);
    CHECK(difference(Eigen::Map<const VecX>(x.data(), x.size()),
                     Eigen::Map<const VecX>(expected.data(), expected.size())) < 1e-15);
  }
}

TEST_CASE("the reduced system is D' K D and D' (F - K d0), symmetric and positive definite",
          "[constraints][reduction]") {
  for (unsigned seed = 31; seed < 35; ++seed)
    for (const bool coupled : {false, true}) {
      Draws random(seed);
      const int n = 25;
      const SparseMatrix K = random_stiffness(n, random);
      const Points F = random.matrix(n, 3);
      const ConstraintSet set = random_constraints(n, 6, coupled ? 5 : 0, random);
      const AffineReduction reduction(set);
      const MatX D = reduction.D();
      const MatX all = stacked(K, coupled);
      const MatX reduced = reduction.reduce(K);
      const MatX expected = D.transpose() * all * D;
      CHECK(difference(reduced, expected.triangularView<Eigen::Lower>()) < 1e-11);
      CHECK(MatX(reduced.triangularView<Eigen::StrictlyUpper>()).norm() == 0);
      CHECK(symmetric_eigenvalues(reduced)[0] > 0);

      const MatX right = coupled ? MatX(Eigen::Map<const VecX>(F.data(), F.size())) : MatX(F);
      CHECK(difference(reduction.reduce_load(K, F),
                       D.transpose() * (right - all * reduction.d0())) < 1e-11);
    }
}

TEST_CASE("fixed dofs delete rows and columns, nothing else", "[constraints][reduction]") {
  Draws random(41);
  const int n = 20;
  const SparseMatrix K = random_stiffness(n, random);
  ConstraintSet set(n);
  const std::vector<int> fixed{3, 7, 8, 19};
  for (const int d : fixed) set.fix("dof " + std::to_string(d), d, Vec3(d, -d, 0.5 * d));
  set.add("scaled", {{11, -4.0}}, Vec3(4, 8, 0));
  const AffineReduction reduction(set);
  std::vector<int> free;
  for (int d = 0; d < n; ++d)
    if (d != 11 && std::find(fixed.begin(), fixed.end(), d) == fixed.end()) free.push_back(d);
  REQUIRE(reduction.free_count() == static_cast<int>(free.size()));
  CHECK(reduction.D().nonZeros() == reduction.free_count());
  for (size_t c = 0; c < free.size(); ++c)
    CHECK(reduction.D().coeff(free[c], static_cast<long>(c)) == 1);
  const MatX expected = MatX(dense(K)(free, free)).triangularView<Eigen::Lower>();
  CHECK(MatX(reduction.reduce(K)) == expected);  // the same bits
  CHECK(reduction.d0().row(7) == Eigen::RowVector3d(7, -7, 3.5));
  CHECK(reduction.d0().row(11) == Eigen::RowVector3d(-1, -2, 0));
}

TEST_CASE("no constraints leave everything free, constraints on all dofs leave nothing",
          "[constraints][reduction]") {
  Draws random(42);
  const int n = 6;
  const SparseMatrix K = random_stiffness(n, random);
  const Points F = random.matrix(n, 3);
  const AffineReduction none{ConstraintSet(n)};
  CHECK(none.free_count() == n);
  CHECK(MatX(none.D()) == MatX::Identity(n, n));
  CHECK(none.d0().norm() == 0);
  const Points x = solve_constrained(ConstraintSet(n), K, F);
  CHECK(difference(dense(K) * x, F) < 1e-14);

  ConstraintSet all(n);
  for (int d = 0; d < n; ++d) all.fix("all", d, Vec3(d, 1, 2));
  CHECK(AffineReduction(all).free_count() == 0);
  const Points held = solve_constrained(all, K, F);
  for (int d = 0; d < n; ++d) CHECK(held.row(d) == Eigen::RowVector3d(d, 1, 2));
}

TEST_CASE("rows that others imply are dropped and counted, and change nothing",
          "[constraints][reduction]") {
  for (unsigned seed = 51; seed < 55; ++seed) {
    INFO("seed " << seed);
    Draws random(seed);
    const int n = 30, rows = 8;
    const SparseMatrix K = random_stiffness(n, random);
    const Points F = random.matrix(n, 3);
    ConstraintSet set = random_constraints(n, rows, 0, random);
    const Points x = solve_constrained(set, K, F);
    const auto given = set.constraints();
    for (int extra = 0; extra < 6; ++extra) {
      Entries entries;
      Vec3 value = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        const auto& row = given[random.below(rows)];
        const double s = random();
        for (const auto& e : row.entries) entries.push_back({e.dof, s * e.coefficient});
        value += s * row.value;
      }
      set.add("implied", entries, value);
    }
    CHECK(AffineReduction(set).redundant_count() == 6);
    CHECK(AffineReduction(set).free_count() == n - rows);
    CHECK(difference(solve_constrained(set, K, F), x) < 1e-11);
  }

  // A coupled equation implied by fixed dofs; a duplicate; an equation of zeros.
  ConstraintSet set(3);
  set.fix("point", 0, Vec3(1, 2, 3));
  set.add_coupled("plane", {{0, Vec3(1, 1, 1)}}, 6);
  CHECK(AffineReduction(set).redundant_count() == 1);
  set.add_coupled("normal", {{1, Vec3(0, 0, 2)}}, 0);
  set.add_coupled("normal again", {{1, Vec3(0, 0, -3)}}, 0);
  set.add_coupled("nothing", {{2, Vec3::Zero()}}, 0);
  CHECK(AffineReduction(set).redundant_count() == 3);
  CHECK(AffineReduction(set).free_count() == 9 - 3 - 1);
}

TEST_CASE("coefficients of one dof in one row add up", "[constraints][reduction]") {
  ConstraintSet set(4);
  set.add("twice", {{2, 1.5}, {2, 0.5}}, Vec3(4, 2, 0));
  set.add("difference", {{0, 1.0}, {1, -1.0}, {3, 1.0}, {3, -1.0}}, Vec3(1, 1, 1));
  const AffineReduction reduction(set);
  CHECK(reduction.free_count() == 2);
  const Points x = reduction.expand(MatX::Ones(2, 3));
  CHECK((x.row(2) - Eigen::RowVector3d(2, 1, 0)).norm() < 1e-15);
  CHECK((x.row(0) - x.row(1) - Eigen::RowVector3d(1, 1, 1)).norm() < 1e-15);
  CHECK(x(3, 0) == 1);  // free
}

TEST_CASE("a conflict names exactly the constraints that take part, with the amount",
          "[constraints][reduction]") {
  {
    ConstraintSet set(6);
    set.fix("left", 0, Vec3(1, 0, 0));
    set.fix("bystander", 4, Vec3(9, 9, 9));
    set.fix("right", 1, Vec3(2, 0, 0));
    set.add("seam", {{0, 1.0}, {1, 1.0}}, Vec3(5, 0, 0));
    const auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 1);
    CHECK(names_of(conflicts[0]) == Names{"left", "right", "seam"});
    CHECK(conflicts[0].amount == Approx(2));
  }
  {
    // Two independent contradictions: both are reported.
    ConstraintSet set(6);
    set.fix("a", 0, Vec3(0, 0, 1));
    set.fix("b", 0, Vec3(0, 0, 1.25));
    set.fix("c", 3, Vec3(0, 7, 0));
    set.fix("d", 3, Vec3(0, 4, 0));
    set.fix("e", 5, Vec3(0, 4, 0));
    auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 2);
    if (names_of(conflicts[0]).count("a") == 0) std::swap(conflicts[0], conflicts[1]);
    CHECK(names_of(conflicts[0]) == Names{"a", "b"});
    CHECK(conflicts[0].amount == Approx(0.25));
    CHECK(names_of(conflicts[1]) == Names{"c", "d"});
    CHECK(conflicts[1].amount == Approx(3));
  }
  {
    // Coupled compared with uncoupled; the y of "other" has no effect.
    ConstraintSet set(3);
    set.fix("point", 0, Vec3(1, 2, 3));
    set.fix("other", 1, Vec3(0, 0, 0));
    set.add_coupled("plane", {{0, Vec3(0, 0, 2)}, {1, Vec3(1, 0, 0)}}, 10);
    const auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 1);
    CHECK(names_of(conflicts[0]) == Names{"other", "plane", "point"});
    CHECK(conflicts[0].amount == Approx(4));
  }
  {
    ConstraintSet set(2);
    set.add("impossible", {}, Vec3(0, 1, 0));
    set.fix("fine", 1, Vec3::Zero());
    const auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 1);
    CHECK(names_of(conflicts[0]) == Names{"impossible"});
  }
}

TEST_CASE("among many rows, a false combination names the rows it is made of",
          "[constraints][reduction]") {
  for (unsigned seed = 61; seed < 69; ++seed) {
    INFO("seed " << seed);
    Draws random(seed);
    const int n = 50, rows = 15;
    ConstraintSet set = random_constraints(n, rows, 0, random);
    const auto given = set.constraints();
    Entries entries;
    Vec3 value(0, 0.5, 0);  // the inconsistent value
    Names expected{"false"};
    for (const int r : {2, 5, 11}) {
      const double s = 1 + 0.5 * random();
      for (const auto& e : given[r].entries) entries.push_back({e.dof, s * e.coefficient});
      value += s * given[r].value;
      expected.insert(row_name(r));
    }
    set.add("false", entries, value);
    const auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 1);
    CHECK(names_of(conflicts[0]) == expected);
    CHECK(conflicts[0].amount > 0);
  }
}

TEST_CASE("rows in other units are the same rows", "[constraints][reduction]") {
  for (const bool coupled : {false, true}) {
    Draws random(71);
    const int n = 30;
    const ConstraintSet set = random_constraints(n, 7, coupled ? 5 : 0, random);
    ConstraintSet scaled(n);
    int i = 0;
    const auto unit = [&] { return i++ % 2 ? 1e8 : -1e-8; };
    for (const auto& row : set.constraints()) {
      const double s = unit();
      Entries entries = row.entries;
      for (auto& e : entries) e.coefficient *= s;
      scaled.add(set.names()[row.name], entries, s * row.value);
    }
    for (const auto& row : set.coupled_constraints()) {
      const double s = unit();
      CoupledEntries entries = row.entries;
      for (auto& e : entries) e.coefficient *= s;
      scaled.add_coupled(set.names()[row.name], entries, s * row.value);
    }
    const AffineReduction one(set), other(scaled);
    REQUIRE(one.free_count() == other.free_count());
    CHECK(difference(one.D(), other.D()) < 1e-11 * MatX(one.D()).cwiseAbs().maxCoeff());
    CHECK(difference(one.d0(), other.d0()) < 1e-11 * one.d0().cwiseAbs().maxCoeff());
  }
  // A conflict is independent of the unit, and is reported in the unit of its equation.
  for (const double s : {1e-8, 1.0, 1e8}) {
    ConstraintSet set(2);
    set.fix("a", 0, Vec3(1, 0, 0));
    set.add("b", {{0, s}, {1, 0.0}}, s * Vec3(1.5, 0, 0));
    const auto conflicts = conflicts_of(set);
    REQUIRE(conflicts.size() == 1);
    CHECK(conflicts[0].amount == Approx(0.5 * s));
  }
}

TEST_CASE("new right-hand sides keep D, and a kept factor serves every load",
          "[constraints][reduction]") {
  Draws random(81);
  const int n = 30;
  const SparseMatrix K = random_stiffness(n, random);
  const ConstraintSet set = random_constraints(n, 5, 4, random);
  ConstraintSet moved(n);
  for (const auto& row : set.constraints())
    moved.add(set.names()[row.name], row.entries, row.value + random.point());
  for (const auto& row : set.coupled_constraints())
    moved.add_coupled(set.names()[row.name], row.entries, row.value + random());
  CHECK(MatX(AffineReduction(moved).D()) == MatX(AffineReduction(set).D()));

  const ConstrainedSolver solver(set, K);
  CHECK(difference(dense(solver.K()), dense(K)) == 0);
  CHECK(solver.reduction().free_count() == AffineReduction(set).free_count());
  for (int load = 0; load < 3; ++load) {
    const Points F = random.matrix(n, 3);
    CHECK(difference(solver.solve(F), solve_kkt(set, K, F)) < 1e-9);
  }
}

TEST_CASE("reactions balance the load, each with its constraint's name",
          "[constraints][reduction]") {
  // A chain of 5 nodes fixed at its ends, pulled at node 1: 3/4 and 1/4 by the lever rule.
  const SparseMatrix K = chain(5);
  Points F = Points::Zero(5, 3);
  F.row(1) << 4, 0, -8;
  for (const double unit : {1.0, 1e6, -1e-6}) {
    INFO("row times " << unit);
    ConstraintSet set(5);
    set.fix("first", 0, Vec3::Zero());
    set.add("last", {{4, unit}}, Vec3::Zero());
    const Points x = solve_constrained(set, K, F);
    const Points r = reaction_forces(K, x, F);
    CHECK(r.middleRows(1, 3).cwiseAbs().maxCoeff() < 1e-14);
    CHECK((r.row(0) + Eigen::RowVector3d(3, 0, -6)).norm() < 1e-14);
    const auto named = named_reactions(set, r);
    REQUIRE(named.size() == 2);
    CHECK(named[0].name == "first");
    CHECK(named[1].name == "last");
    Points sum = Points::Zero(5, 3);
    for (const auto& reaction : named) sum += reaction.forces;
    CHECK(difference(sum, r) < 1e-12);
    CHECK((named[0].forces.row(0) + Eigen::RowVector3d(3, 0, -6)).norm() < 1e-12);
    CHECK((named[1].forces.row(4) + Eigen::RowVector3d(1, 0, -2)).norm() < 1e-12);
  }

  // Coupled: a plane with normal n reacts along n only.
  const Vec3 n = Vec3(1, 2, 2) / 3;
  ConstraintSet set(5);
  set.fix("first", 0, Vec3::Zero());
  set.add_coupled("plane", {{4, 5 * n}}, 0);
  const Points x = solve_constrained(set, K, F);
  const Points r = reaction_forces(K, x, F);
  CHECK(std::abs(x.row(4).dot(n)) < 1e-14);
  CHECK(Vec3(r.row(4)).cross(n).norm() < 1e-13);
  const auto named = named_reactions(set, r);
  REQUIRE(named.size() == 2);
  CHECK((named[1].forces.row(4) - r.row(4)).norm() < 1e-12);
  CHECK((named[0].forces.row(0) - r.row(0)).norm() < 1e-12);
  // All forces on the chain, loads and reactions, add up to zero.
  CHECK((r + F).colwise().sum().norm() < 1e-13);
}

TEST_CASE("reactions of redundant rows still add up", "[constraints][reduction]") {
  Draws random(91);
  const int n = 20;
  const SparseMatrix K = random_stiffness(n, random);
  const Points F = random.matrix(n, 3);
  ConstraintSet set(n);
  set.fix("a", 4, Vec3(1, 1, 1));
  set.fix("a again", 4, Vec3(1, 1, 1));
  set.add("pair", {{7, 1.0}, {9, -2.0}}, Vec3(0, 1, 0));
  const Points r = reaction_forces(K, solve_constrained(set, K, F), F);
  const auto named = named_reactions(set, r);
  REQUIRE(named.size() == 3);
  Points sum = Points::Zero(n, 3);
  for (const auto& reaction : named) sum += reaction.forces;
  CHECK(difference(sum, r) < 1e-9);
  CHECK(difference(named[0].forces, named[1].forces) < 1e-3);  // minimum norm: shared equally
}

TEST_CASE("systems without a solution are reported", "[constraints][reduction]") {
  const SparseMatrix K = chain(6);
  const Points F = Points::Ones(6, 3);
  CHECK_THROWS_AS(solve_constrained(ConstraintSet(6), K, F), NoSolutionError);
  ConstraintSet differences(6);
  differences.add("distance", {{0, 1.0}, {5, -1.0}}, Vec3(1, 0, 0));
  CHECK_THROWS_AS(solve_constrained(differences, K, F), NoSolutionError);
  CHECK_THROWS_AS(ConstrainedSolver(differences, K), NoSolutionError);
  ConstraintSet twice(6);
  twice.fix("a", 0, Vec3::Zero());
  twice.fix("a", 0, Vec3::Zero());
  CHECK_THROWS_AS(solve_kkt(twice, K, F), NoSolutionError);
  ConstraintSet held(6);
  held.fix("a", 0, Vec3::Zero());
  CHECK_NOTHROW(solve_constrained(held, K, F));
}

TEST_CASE("constraint sets keep rows and names and refuse wrong numbers",
          "[constraints][reduction]") {
  ConstraintSet set(5);
  CHECK_FALSE(set.coupled());
  set.fix("corner", 1, Vec3(1, 2, 3));
  set.add("rim", {{0, 1.0}, {2, -1.0}}, Vec3::Zero());
  set.add("corner", {{4, 2.0}}, Vec3::Ones());
  CHECK_FALSE(set.coupled());
  set.add_coupled("plane", {{3, Vec3(0, 0, 1)}}, 7);
  CHECK(set.coupled());
  CHECK(set.dof_count() == 5);
  CHECK(set.names() == std::vector<std::string>{"corner", "rim", "plane"});
  REQUIRE(set.constraints().size() == 3);
  CHECK(set.constraints()[2].name == 0);
  REQUIRE(set.coupled_constraints().size() == 1);
  CHECK(set.coupled_constraints()[0].name == 2);

  Points q = Points::Zero(5, 3);
  q.row(1) << 1, 2, 3;
  q.row(4) << 0.5, 0.5, 0.5;
  q(3, 2) = 7;
  CHECK(set.max_residual(q) == 0);
  q(2, 1) = 0.125;
  CHECK(set.max_residual(q) == 0.125);
  q(3, 2) = 8;
  CHECK(set.max_residual(q) == 1);

  const double nan = std::nan("");
  CHECK_THROWS_AS(set.fix("x", 5, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(set.fix("x", -1, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(set.fix("x", 0, Vec3(0, nan, 0)), InputError);
  CHECK_THROWS_AS(set.add("x", {{0, nan}}, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(set.add("x", {{0, 1.0}, {7, 1.0}}, Vec3::Zero()), InputError);
  CHECK_THROWS_AS(set.add_coupled("x", {{9, Vec3::Ones()}}, 0), InputError);
  CHECK_THROWS_AS(set.add_coupled("x", {{0, Vec3(0, 0, nan)}}, 0), InputError);
  CHECK_THROWS_AS(set.add_coupled("x", {{0, Vec3::Ones()}}, INFINITY), InputError);
  CHECK(set.constraints().size() == 3);  // rejected equations leave no trace
  CHECK(set.coupled_constraints().size() == 1);
}

TEST_CASE("conflicts: the amount is in the row's own units, the smallest ones are named",
          "[constraints][reduction]") {
  const auto amount = [](double value) {
    ConstraintSet set(2);
    set.add("a", {{0, 2.0}, {1, 4.0}}, {2, 0, 0});
    set.add("b", {{0, 5.0}, {1, 10.0}}, {value, 0, 0});
    try {
      AffineReduction reduction(set);
      CHECK(reduction.redundant_count() == 1);
      CHECK(reduction.redundant() == std::vector<int>{1});
    } catch (const ConflictError& e) {
      CHECK(e.conflicts()[0].names == std::vector<std::string>{"a", "b"});
      return e.conflicts()[0].amount;
    }
    return 0.0;
  };
  CHECK(amount(5) == 0);
  CHECK(amount(7.5) == Approx(2.5));
  CHECK(amount(5 + 1e-7) == Approx(1e-7));
  CHECK(amount(5 + 1e-12) == 0);
}

TEST_CASE("right-hand sides change without a new elimination", "[constraints][reduction]") {
  ConstraintSet set(4);
  set.add("a", {{0, 2.0}, {1, 1.0}}, {1, 2, 3});
  set.add("b", {{1, 3.0}, {2, -1.0}}, {0, 1, 0});
  set.add("a + b", {{0, 2.0}, {1, 4.0}, {2, -1.0}}, {1, 3, 3});
  AffineReduction reduction(set);
  REQUIRE(reduction.redundant_count() == 1);
  const MatX before = reduction.d0();
  MatX right(3, 3);
  right << 4, 5, 6, -1, 2, 7, 3, 7, 13;
  reduction.set_rhs(right);
  ConstraintSet changed(4);
  for (int r = 0; r < 3; ++r)
    changed.add(set.names()[set.constraints()[r].name], set.constraints()[r].entries,
                right.row(r).transpose());
  const AffineReduction fresh(changed);
  CHECK(reduction.d0() == fresh.d0());
  CHECK(reduction.particular_solution(right) == fresh.d0());
  right(2, 1) += 0.5;
  CHECK_THROWS_AS(reduction.set_rhs(right), ConflictError);
  CHECK(reduction.d0() == fresh.d0());
  reduction.set_values(set);
  CHECK(reduction.d0() == before);
  CHECK_THROWS_AS(reduction.set_rhs(MatX::Zero(2, 3)), InputError);
  CHECK_THROWS_AS(reduction.set_values(ConstraintSet(5)), InputError);
}
