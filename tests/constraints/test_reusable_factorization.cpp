// SPDX-License-Identifier: MPL-2.0
// Constraints added and removed with a kept factor: equal to solving with the same constraints at
// once.
#include "batten/constraints/reusable_factorization.h"

#include <random>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// A clamped plate with random functionals on its dofs.
struct LivePlate {
  ParametricMesh mesh = perturbed_square(6, 3);
  SurfaceAssembler assembler{mesh, TriangleElement::HCT};
  SparseMatrix K = assembler.stiffness(SurfaceStiffness::isotropic(1, 0.1));
  ConstraintSet rim = clamped_boundary(mesh);
  std::shared_ptr<const AffineReduction> reduction = std::make_shared<AffineReduction>(rim);
  ReusableFactorization system{reduction, K, {}};
  Points F = assembler.load(Vec3(1, -2, 3));
  std::mt19937 random{7};

  int n() const { return assembler.dofs().count(); }
  SparseMatrix functionals(int count) {
    std::uniform_int_distribution<int> dof(0, n() - 1);
    std::normal_distribution<double> value;
    std::vector<Triplet> entries;
    for (int k = 0; k < count; ++k)
      for (int i = 0; i < 12; ++i) entries.emplace_back(dof(random), k, value(random));
    SparseMatrix A(n(), count);
    A.setFromTriplets(entries.begin(), entries.end());
    return A;
  }
  Vec3 direction() {
    std::normal_distribution<double> value;
    return Vec3(value(random), value(random), value(random)).normalized();
  }
  SparseMatrix reduced(const SparseMatrix& A) const {
    return SparseMatrix(reduction->D().transpose()) * A;
  }
  Points solve(const SchurComplementConstraints& coupling, VecX g, const SparseMatrix& A,
               const std::vector<SchurComplementConstraints::Constraint>& rows) {
    MatX rhs(static_cast<long>(rim.constraints().size()), 3), y(system.free_count(), 3);
    for (long r = 0; r < rhs.rows(); ++r)
      rhs.row(r) = rim.constraints()[static_cast<size_t>(r)].value;
    const Points e = reduction->particular_solution(rhs);
    const MatX ae = A.transpose() * e;
    for (size_t r = 0; r < rows.size(); ++r) g[static_cast<long>(r)] -= rows[r].evaluate(ae);
    system.start_load(rhs, y);
    system.add_load(F, y);
    system.solve(y);
    coupling.apply(y, g);
    Points x(n(), 3);
    system.expand(y, e, x);
    return x;
  }
};

double size_of(const SparseMatrix& A, int k) { return A.col(k).norm(); }

}  // namespace

TEST_CASE("hard rows on a kept factor equal the saddle point system",
          "[constraints][factorization]") {
  LivePlate p;
  const SparseMatrix A = p.functionals(9);
  std::vector<SchurComplementConstraints::Constraint> rows;
  ConstraintSet all = p.rim;
  VecX g = VecX::Random(7);
  const auto entries = [&](int point, const Vec3& n) {
    std::vector<ConstraintSet::CoupledEntry> list;
    for (SparseMatrix::InnerIterator it(A, point); it; ++it)
      list.push_back({static_cast<int>(it.row()), it.value() * n});
    return list;
  };
  for (int k = 0; k < 6; ++k) rows.push_back({k, p.direction(), size_of(A, k)});
  // A functional whose direction differs from dof to dof.
  rows.push_back({6, Vec3::UnitX(), 1, false, {{7, Vec3::UnitY()}, {8, p.direction()}}});
  for (size_t r = 0; r < rows.size(); ++r) {
    std::vector<ConstraintSet::CoupledEntry> list;
    rows[r].terms([&](int point, const Vec3& n) {
      const auto more = entries(point, n);
      list.insert(list.end(), more.begin(), more.end());
    });
    all.add_coupled("row " + std::to_string(r), list, g[static_cast<long>(r)]);
  }
  const SchurComplementConstraints coupling(p.system.factor(), p.reduced(A), rows);
  const Points x = p.solve(coupling, g, A, rows);
  const Points expected = solve_kkt(all, p.K, p.F);
  CHECK((x - expected).cwiseAbs().maxCoeff() < 1e-9 * expected.cwiseAbs().maxCoeff());
  CHECK(all.max_residual(x) < 1e-12);
}

TEST_CASE("soft rows equal springs in the matrix, whatever their stiffness",
          "[constraints][factorization]") {
  LivePlate p;
  const SparseMatrix A = p.functionals(3);
  const VecX g = VecX::Random(9);
  for (const double k : {0.0, 1e-3, 1.0, 1e6}) {
    std::vector<SchurComplementConstraints::Constraint> rows;
    for (int point = 0; point < 3; ++point)
      for (int c = 0; c < 3; ++c) rows.push_back({point, Vec3::Unit(c), size_of(A, point), true});
    SchurComplementConstraints coupling(p.system.factor(), p.reduced(A), rows);
    coupling.set_stiffness(VecX::Constant(9, k));
    const Points x = p.solve(coupling, g, A, rows);
    // K + k A Aᵀ, F + k A g.
    const SparseMatrix springs = A * SparseMatrix(A.transpose());
    const SparseMatrix stiff = p.K + k * SparseMatrix(springs.triangularView<Eigen::Lower>());
    Points F = p.F;
    for (int point = 0; point < 3; ++point)
      F += k * VecX(A.col(point)) * g.segment<3>(3 * point).transpose();
    const Points expected = solve_constrained(p.rim, stiff, F);
    CHECK((x - expected).cwiseAbs().maxCoeff() < 1e-7 * expected.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("hard and soft rows together equal springs under constraints",
          "[constraints][factorization]") {
  LivePlate p;
  const SparseMatrix A = p.functionals(4);
  std::vector<SchurComplementConstraints::Constraint> rows;
  VecX g = VecX::Random(6);
  ConstraintSet all = p.rim;
  for (int point = 0; point < 3; ++point) {
    rows.push_back({point, p.direction(), size_of(A, point)});
    std::vector<ConstraintSet::CoupledEntry> list;
    for (SparseMatrix::InnerIterator it(A, point); it; ++it)
      list.push_back({static_cast<int>(it.row()), it.value() * rows.back().direction});
    all.add_coupled("row " + std::to_string(point), list, g[point]);
  }
  for (int c = 0; c < 3; ++c) rows.push_back({3, Vec3::Unit(c), size_of(A, 3), true});
  const double k = 5;
  SchurComplementConstraints coupling(p.system.factor(), p.reduced(A), rows);
  coupling.set_stiffness(VecX::Constant(3, k));
  const Points x = p.solve(coupling, g, A, rows);
  const SparseMatrix a = A.col(3);
  const SparseMatrix springs = a * SparseMatrix(a.transpose());
  const Points F = p.F + k * VecX(a) * g.tail<3>().transpose();
  const Points expected =
      solve_kkt(all, p.K + k * SparseMatrix(springs.triangularView<Eigen::Lower>()), F);
  CHECK((x - expected).cwiseAbs().maxCoeff() < 1e-8 * expected.cwiseAbs().maxCoeff());
  CHECK(all.max_residual(x) < 1e-12);
}

TEST_CASE("solves that are known already are taken over, bit for bit",
          "[constraints][factorization]") {
  LivePlate p;
  const SparseMatrix A = p.functionals(5), first = A.leftCols(3);
  std::vector<SchurComplementConstraints::Constraint> rows;
  for (int k = 0; k < 5; ++k) rows.push_back({k, p.direction(), size_of(A, k)});
  const SchurComplementConstraints older(p.system.factor(), p.reduced(first),
                                         {rows.begin(), rows.begin() + 3});
  const SchurComplementConstraints fresh(p.system.factor(), p.reduced(A), rows);
  const SchurComplementConstraints grown(p.system.factor(), p.reduced(A), rows, older,
                                         {0, 1, 2, -1, -1});
  const VecX g = VecX::Random(5);
  CHECK(p.solve(fresh, g, A, rows) == p.solve(grown, g, A, rows));
}

TEST_CASE("a hard row that others imply is left out, and contradicted when it does not fit",
          "[constraints][factorization]") {
  LivePlate p;
  SparseMatrix A = p.functionals(2);
  std::vector<SchurComplementConstraints::Constraint> rows{{0, Vec3::UnitZ(), size_of(A, 0)},
                                                           {1, Vec3::UnitZ(), size_of(A, 1)},
                                                           {0, Vec3::UnitZ(), size_of(A, 0)}};
  const SchurComplementConstraints coupling(p.system.factor(), p.reduced(A), rows);
  CHECK(coupling.independent() == std::vector<int>{0, 1});
  CHECK(coupling.redundant() == std::vector<int>{2});
  CHECK(coupling.contradiction(Vec3(1, 2, 1)).first < 1e-12);
  CHECK(coupling.contradiction(Vec3(1, 2, 1.5)).first == Approx(0.5));
  CHECK(coupling.contradiction(Vec3(1, 2, 1.5)).second == 2);
}

TEST_CASE("rows that follow from those before are left out wherever they stand",
          "[constraints][factorization]") {
  LivePlate p;
  constexpr int points = 12;
  const SparseMatrix A = p.functionals(points);
  std::vector<SchurComplementConstraints::Constraint> rows;
  VecX g(40);
  std::vector<int> free, implied;
  std::uniform_int_distribution<int> one(0, 39);
  std::normal_distribution<double> value;
  for (int k = 0; k < 40; ++k) {
    // Every third equation is a sum of two previous ones.
    if (k >= 5 && k % 3 == 2) {
      const int i = one(p.random) % k, j = (i + 1) % k;
      const double a = value(p.random), b = value(p.random);
      SchurComplementConstraints::Constraint row{rows[i].point, a * rows[i].direction, 1};
      for (const auto& t : rows[i].further_terms)
        row.further_terms.push_back({t.point, a * t.direction});
      rows[j].terms([&](int point, const Vec3& n) { row.further_terms.push_back({point, b * n}); });
      rows.push_back(row);
      g[k] = a * g[i] + b * g[j];
      implied.push_back(k);
    } else {
      rows.push_back({static_cast<int>(free.size()) % points, p.direction(), 1e-3});
      g[k] = value(p.random);
      free.push_back(k);
    }
  }
  const SchurComplementConstraints coupling(p.system.factor(), p.reduced(A), rows);
  CHECK(coupling.independent() == free);
  CHECK(coupling.redundant() == implied);
  CHECK(coupling.contradiction(g).first < 1e-10);
  const Points x = p.solve(coupling, g, A, rows);
  const MatX ax = A.transpose() * x;
  for (int k = 0; k < 40; ++k) CHECK(rows[k].evaluate(ax) == Approx(g[k]).margin(1e-9));
  for (const int k : implied) {
    VecX other = g;
    other[k] += 0.25;
    CHECK(coupling.contradiction(other).first >= 0.25 - 1e-9);
  }
}

TEST_CASE("more rows than unknowns: those that fit are kept", "[constraints][factorization]") {
  SparseMatrix one(1, 1);
  one.insert(0, 0) = 4;
  SparseCholesky factor;
  factor.analyze(one);
  REQUIRE(factor.factorize(one));
  SparseMatrix U(1, 1);
  U.insert(0, 0) = 2;
  std::vector<SchurComplementConstraints::Constraint> rows;
  for (const double z : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0})
    rows.push_back({0, Vec3(1, z, z * z), 2 * Vec3(1, z, z * z).norm()});
  const SchurComplementConstraints coupling(factor, U, rows);
  CHECK(coupling.independent() == std::vector<int>{0, 1, 2});
  VecX g(7);
  for (int k = 0; k < 7; ++k) g[k] = rows[k].direction.dot(Vec3(3, -1, 0.5));
  CHECK(coupling.contradiction(g).first < 1e-12);
  MatX y = MatX::Zero(1, 3);
  coupling.apply(y, g);
  CHECK((y - 0.5 * MatX(Vec3(3, -1, 0.5).transpose())).norm() < 1e-12);
}

TEST_CASE("a live system takes other numbers, and stays as it was when they are no material",
          "[constraints][factorization]") {
  LivePlate p;
  const SparseMatrix softer = p.assembler.stiffness(SurfaceStiffness::isotropic(0.5, 0.05));
  const auto solved = [&] {
    MatX y(p.system.free_count(), 3);
    p.system.start_load(MatX::Zero(static_cast<long>(p.rim.constraints().size()), 3), y);
    p.system.add_load(p.F, y);
    p.system.solve(y);
    return y;
  };
  const MatX stiff = solved();
  CHECK_THROWS_AS(p.system.set_matrix(-1.0 * p.K), NoSolutionError);
  CHECK(solved() == stiff);
  p.system.set_matrix(softer);
  CHECK((solved() - 2 * stiff).cwiseAbs().maxCoeff() < 1e-12 * stiff.cwiseAbs().maxCoeff());
  CHECK_THROWS_AS(p.system.set_matrix(SparseMatrix(p.n(), p.n())), InputError);
}
