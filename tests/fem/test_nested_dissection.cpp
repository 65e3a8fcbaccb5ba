// SPDX-License-Identifier: MPL-2.0
// Nested dissection: an ordering of all dofs that keeps the factor sparse.
#include "batten/fem/parametric_mesh.h"

#include <algorithm>
#include <numeric>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

TEST_CASE("the dissection order holds every dof once", "[fem][ordering]") {
  for (const int n : {1, 2, 7, 16}) {
    const ParametricMesh mesh = perturbed_square(n, 4);
    std::vector<int> order = nested_dissection_order(mesh);
    std::sort(order.begin(), order.end());
    std::vector<int> all(DofMap(mesh).count());
    std::iota(all.begin(), all.end(), 0);
    CHECK(order == all);
  }
}

TEST_CASE("the order changes the fill, not the solution", "[fem][ordering]") {
  const ParametricMesh mesh = perturbed_square(40, 5);
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  const SparseMatrix K = assembler.stiffness(SurfaceStiffness{});
  const ConstraintSet set = clamped_boundary(mesh);
  const Points F = assembler.load(Vec3(1, -2, 3));
  const Points amd = ConstrainedSolver(set, K).solve(F);
  const Points dissected = ConstrainedSolver(set, K, nested_dissection_order(mesh)).solve(F);
  CHECK((amd - dissected).norm() < 1e-10 * amd.norm());

  const AffineReduction reduction(set);
  const SparseMatrix reduced = reduction.reduce(K);
  const std::vector<int> order = reduction.ordering_of_free(nested_dissection_order(mesh));
  REQUIRE(static_cast<int>(order.size()) == reduction.free_count());
  const auto entries = [&](const std::vector<int>& given) {
    SparseCholesky cholesky;
    cholesky.analyze(reduced, given);
    REQUIRE(cholesky.factorize(reduced));
    return static_cast<double>(cholesky.factor_entries());
  };
  std::vector<int> natural(order.size());
  std::iota(natural.begin(), natural.end(), 0);
  CHECK(entries(order) < 1.25 * entries({}));
  if (SparseCholesky::backend() == std::string("CHOLMOD"))
    CHECK(entries(order) < 0.6 * entries(natural));
}

TEST_CASE("an order of the wrong size is refused", "[fem][ordering]") {
  SparseMatrix A(3, 3);
  A.setIdentity();
  SparseCholesky cholesky;
  CHECK_THROWS_AS(cholesky.analyze(A, {0, 1}), InputError);
}

TEST_CASE("a coordinate without load and values stays exactly zero", "[fem][ordering]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(6);
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  const Points q =
      solve_constrained(clamped_boundary(mesh), assembler.stiffness(SurfaceStiffness{}),
                        assembler.load(Vec3(0, 0, 1)));
  CHECK(q.leftCols(2).isZero(0));
  CHECK(q.col(2).maxCoeff() > 1e-4);
}

TEST_CASE("pressure on a plane is a uniform load along its normal, on any surface it closes up",
          "[fem][ordering]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(5, 6));
  for (const auto kind : kBothElements) {
    const SurfaceAssembler assembler(*mesh, kind);
    const auto plane = [](const Vec2& p) {
      return SurfaceJet{{2 * p.x(), 3 * p.y(), p.x()}, {2, 0, 1}, {0, 3, 0}, {}, {}, {}};
    };
    const Points q = interpolated(mesh, kind, plane).dofs();
    const Vec3 area_vector = Vec3(2, 0, 1).cross(Vec3(0, 3, 0));
    CHECK((assembler.pressure_load(q) - assembler.load(area_vector)).cwiseAbs().maxCoeff() < 1e-8);
    // The resultant depends only on the boundary: bumps inside do not change it.
    Points bumpy = q;
    Random random(8);
    std::vector<char> rim(mesh->vertex_count(), 0);
    for (const auto& e : mesh->edges())
      if (e.boundary()) rim[e.low] = rim[e.high] = 1;
    for (int v = 0; v < mesh->vertex_count(); ++v)
      if (!rim[v]) bumpy.row(3 * v) += 0.2 * random.point().transpose();
    Vec3 resultant = Vec3::Zero();
    const Points F = assembler.pressure_load(bumpy);
    for (int v = 0; v < mesh->vertex_count(); ++v) resultant += F.row(3 * v);
    CHECK((resultant - area_vector).norm() < (kind == TriangleElement::HCT ? 1e-12 : 1e-6));
  }
}
