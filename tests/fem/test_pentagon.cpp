// SPDX-License-Identifier: MPL-2.0
// The pentagon: five triangles around a vertex, fixed corners, a uniform load.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/eigen.h"
#include "batten/fem/surface.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/test_data.h"

using namespace batten;

namespace {

std::shared_ptr<const ParametricMesh> pentagon() {
  std::vector<Vec2> vertices{{0, 0}};
  std::vector<ParametricMesh::Triangle> triangles;
  for (int k = 1; k <= 5; ++k) {
    const double angle = (90 + 72 * (k - 1)) * std::numbers::pi / 180;
    vertices.emplace_back(std::cos(angle), std::sin(angle));
    triangles.push_back({0, k, k % 5 + 1});
  }
  return std::make_shared<ParametricMesh>(vertices, triangles);
}

void fix_corners(const ParametricMesh& mesh, SurfaceConstraints& constraints) {
  for (int k = 1; k <= 5; ++k) {
    const Vec2& p = mesh.vertices()[k];
    constraints.point("corner " + std::to_string(k), k, Vec3(p.x(), p.y(), 0));
  }
}

TriangleElement kind_of(const std::string& name) {
  return name == "HCT" ? TriangleElement::HCT : TriangleElement::Z12;
}

Vec3 vector(const nlohmann::json& v) {
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}

// Twice the energy, qᵀK q - 2 Fᵀq, for some columns.
double energy(const SparseMatrix& K, const MatX& q, const MatX& F) {
  const MatX Kq = K.selfadjointView<Eigen::Lower>() * q;
  return q.cwiseProduct(Kq - 2 * F).sum();
}

}  // namespace

TEST_CASE("the loaded pentagon has the reference heights, slopes and energies",
          "[fem][convergence]") {
  const auto gold = batten_test::reference("pentagon.json");
  const auto mesh = pentagon();
  int cases = 0;
  for (const auto& expected : gold["cases"]) {
    if (expected["quadrature"] != "exact") continue;
    ++cases;
    const TriangleElement kind = kind_of(expected["element"]);
    const double alpha = expected["alpha"], beta = expected["beta"];
    INFO(expected["element"] << ", alpha " << alpha << ", beta " << beta);
    const SurfaceAssembler assembler(*mesh, kind);
    const DofMap& dofs = assembler.dofs();
    REQUIRE(dofs.count() == gold["ndof_per_coordinate"].get<int>());
    const SparseMatrix K = assembler.stiffness(SurfaceStiffness::isotropic(alpha, beta));
    const Points F = assembler.load(Vec3(0, 0, 1));
    CHECK(std::abs(F(dofs.vertex(0), 2) - expected["F_centre"].get<double>()) < 1e-13);

    ConstraintSet set(dofs.count());
    SurfaceConstraints constraints(*mesh, kind, set);
    fix_corners(*mesh, constraints);
    const Points q = solve_constrained(set, K, F);
    CHECK(std::abs(q(dofs.vertex(0), 2) - expected["centre_z"].get<double>()) < 1e-10);
    CHECK(std::abs(energy(K, q.col(2), F.col(2)) - expected["energy_z=XtKX-2FtX"].get<double>()) <
          1e-10);
    CHECK(std::abs(q(dofs.edge(mesh->edge_between(1, 2)), 2) -
                   expected["wn_z_edge(1,2)"].get<double>()) < 1e-10);
    CHECK(std::abs(q(dofs.edge(mesh->edge_between(0, 1)), 2)) < 1e-13);  // by symmetry
    for (int d = 0; d < 2; ++d)
      CHECK(std::abs(q(dofs.vertex(1, 1 + d), 2) -
                     expected["corner1_w_u,w_v of z"][d].get<double>()) < 1e-10);
    const Surface surface(mesh, kind, q);
    const Vec3 rim = surface.position({0, Vec3(0, 0.5, 0.5)});
    CHECK((rim - vector(expected["rim_edge_1_2_midpoint_xyz"])).norm() < 1e-10);

    const AffineReduction reduction(set);
    CHECK(reduction.free_count() == 23);
    const SparseMatrix reduced = reduction.reduce(K);
    CHECK(symmetric_eigenvalues(MatX(reduced))[0] ==
          Approx(expected["min_eig_Kff"].get<double>()).epsilon(2e-6));
  }
  CHECK(cases == 10);
}

TEST_CASE("heights are proportional to the load", "[fem][convergence]") {
  const auto mesh = pentagon();
  for (const auto kind : {TriangleElement::HCT, TriangleElement::Z12}) {
    const SurfaceAssembler assembler(*mesh, kind);
    ConstraintSet set(assembler.dofs().count());
    SurfaceConstraints constraints(*mesh, kind, set);
    fix_corners(*mesh, constraints);
    const ConstrainedSolver solver(set, assembler.stiffness(SurfaceStiffness::isotropic(1, 0.1)));
    const Points one = solver.solve(assembler.load(Vec3(0, 0, 1)));
    const Points seven = solver.solve(assembler.load(Vec3(0, 0, 7)));
    CHECK((7 * one.col(2) - seven.col(2)).cwiseAbs().maxCoeff() < 1e-14);
    CHECK((one.leftCols<2>() - seven.leftCols<2>()).cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("the pentagon with a held normal and a held tangent has the reference shape",
          "[fem][convergence]") {
  const auto gold = batten_test::reference("constraint_example.json");
  const auto mesh = pentagon();
  for (const char* name : {"Z12", "HCT"}) {
    INFO(name);
    const auto& expected = gold[name];
    const TriangleElement kind = kind_of(name);
    const SurfaceAssembler assembler(*mesh, kind);
    const DofMap& dofs = assembler.dofs();
    const SparseMatrix K =
        assembler.stiffness(SurfaceStiffness::isotropic(expected["alpha"], expected["beta"]));
    const Points F = assembler.load(Vec3(0, 0, expected["p"]));

    ConstraintSet set(dofs.count());
    SurfaceConstraints constraints(*mesh, kind, set);
    fix_corners(*mesh, constraints);
    const Vec3 n = vector(expected["n_centre"]), tau = vector(expected["tau_vertex1"]);
    constraints.normal("centre", 0, n);
    constraints.tangent("corner 1", 1, {0, -1}, tau);
    CHECK(static_cast<int>(3 * set.constraints().size() + set.coupled_constraints().size()) ==
          expected["n_constraints"].get<int>());
    const AffineReduction reduction(set);
    CHECK(reduction.free_count() == expected["n_free"].get<int>());
    CHECK(reduction.redundant_count() == 0);

    const Points q = solve_constrained(set, K, F);
    const auto row = [&](int dof) { return Vec3(q.row(dof)); };
    CHECK((row(dofs.vertex(0)) - vector(expected["centre_xyz"])).norm() < 1e-9);
    CHECK((row(dofs.vertex(0, 1)) - vector(expected["centre_Xu"])).norm() < 1e-9);
    CHECK((row(dofs.vertex(0, 2)) - vector(expected["centre_Xv"])).norm() < 1e-9);
    CHECK((row(dofs.vertex(1, 2)) - vector(expected["vertex1_Xv"])).norm() < 1e-9);
    CHECK(energy(K, q, F) == Approx(expected["energy XtAX-2FtX"].get<double>()).epsilon(1e-9));

    const SurfaceJet centre = Surface(mesh, kind, q).jet({0, Vec3::Unit(0)});
    CHECK(centre.normal().cross(n).norm() < 1e-14);
    CHECK(row(dofs.vertex(1, 2)).normalized().cross(tau).norm() < 1e-14);
    CHECK((q - solve_kkt(set, K, F)).cwiseAbs().maxCoeff() < 1e-11);
  }
}
