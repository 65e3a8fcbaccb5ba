// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/pressure_operator.h"

#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;

namespace {

Points random_dofs(const ParametricMesh& mesh, unsigned seed) {
  Random random(seed);
  Points q(DofMap(mesh).count(), 3);
  for (long i = 0; i < q.rows(); ++i) q.row(i) = random.point();
  return q;
}

VecX random_weights(const ParametricMesh& mesh, unsigned seed) {
  Random random(seed);
  return VecX::NullaryExpr(mesh.triangle_count(), [&] { return random.between(0, 1); });
}

Points force(const PressureOperator& pressure, const Points& q, const VecX& weights = {},
             double value = 1) {
  Points F = Points::Zero(q.rows(), 3);
  pressure.add(q, weights, value, F);
  return F;
}

double difference(const Points& a, const Points& b) { return (a - b).norm() / b.norm(); }

// ∬ w N (x_u × x_v) by quadrature of the surface itself.
Points by_quadrature(const SurfaceAssembler& assembler, const Surface& surface,
                     const VecX& weights) {
  return assembler.load(
      [&](const Location& where, const Vec2&) -> Vec3 {
        return weights[where.triangle] * surface.jet(where).area_vector();
      },
      8);
}

struct TrimmedSquare {
  std::shared_ptr<const ParametricMesh> mesh =
      std::make_shared<ParametricMesh>(perturbed_square(7, 4));
  // Triangles outside stay in the mesh.
  std::shared_ptr<const Trim> trim =
      std::make_shared<Trim>(*mesh, DomainLoops({{circle({0.5, 0.45}, 0.33, 12)}}));
};

}  // namespace

TEST_CASE("the operator's load is the quadrature's, whole and trimmed", "[fem][loads]") {
  const TrimmedSquare square;
  const Points q = random_dofs(*square.mesh, 5);
  for (const bool trimmed : {false, true}) {
    const auto trim = trimmed ? square.trim : nullptr;
    const SurfaceAssembler assembler(*square.mesh, TriangleElement::HCT, trim);
    const PressureOperator pressure(*square.mesh, TriangleElement::HCT, trim);
    CHECK(difference(force(pressure, q), assembler.pressure_load(q)) < 1e-13);
    const VecX w = random_weights(*square.mesh, 6);
    const Surface surface(square.mesh, TriangleElement::HCT, q);
    CHECK(difference(force(pressure, q, w, -3), -3 * by_quadrature(assembler, surface, w)) < 1e-13);
    // Z12: with the accuracy of the quadrature rule.
    const SurfaceAssembler rational(*square.mesh, TriangleElement::Z12, trim);
    const PressureOperator of_z12(*square.mesh, TriangleElement::Z12, trim);
    CHECK(difference(force(of_z12, q), rational.pressure_load(q)) < 2e-6);
  }
}

TEST_CASE("the load of rational triangles is that of a rule without error", "[fem][loads]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(3, 4));
  const Surface surface(mesh, TriangleElement::Z12, random_dofs(*mesh, 5));
  Points expected = Points::Zero(surface.dofs().rows(), 3);
  const TriangleRule rule = six_duffy_rule(16);
  for (int t = 0; t < mesh->triangle_count(); ++t) {
    const C1Triangle element(TriangleElement::Z12, mesh->shape(t));
    const auto q = surface.triangle_dofs(t);
    const auto dof = surface.dof_map().triangle(*mesh, t);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Tabulation N = element.evaluate(rule.L.row(p).transpose());
      const Vec3 x_u = q.transpose() * N.col(kU), x_v = q.transpose() * N.col(kV);
      for (int a = 0; a < 12; ++a)
        expected.row(dof[a]) +=
            mesh->shape(t).area * rule.weights[p] * N(a, kW) * x_u.cross(x_v).transpose();
    }
  }
  const PressureOperator pressure(*mesh, TriangleElement::Z12);
  CHECK(difference(force(pressure, surface.dofs()), expected) < 1e-10);
}

TEST_CASE("loads add up, weights and values are factors", "[fem][loads]") {
  const auto mesh = perturbed_square(9, 1);
  const PressureOperator pressure(mesh, TriangleElement::HCT);
  const Points q = random_dofs(mesh, 2);
  const VecX ones = VecX::Ones(mesh.triangle_count()), w = random_weights(mesh, 3);
  CHECK(force(pressure, q, ones) == force(pressure, q));
  Points sum = force(pressure, q, w);
  pressure.add(q, ones - w, 1, sum);
  CHECK(difference(sum, force(pressure, q)) < 1e-14);
  CHECK(force(pressure, q, VecX::Zero(ones.size())).norm() == 0);
}

TEST_CASE("without its boundary, the load is the derivative of the volume", "[fem][loads]") {
  for (const auto kind : kBothElements) {
    const auto mesh = perturbed_square(5, 8);
    const PressureOperator pressure(mesh, kind);
    const Points x = random_dofs(mesh, 9);
    Points d = random_dofs(mesh, 10);
    for (const auto& edge : mesh.edges())
      if (edge.boundary())
        for (const int v : {edge.low, edge.high}) d.middleRows<3>(3 * v).setZero();
    // The volume is a cubic in h: this difference is its derivative.
    const auto at = [&](double h) { return pressure.volume(x + h * d); };
    const double slope = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / 12;
    const double tolerance = kind == TriangleElement::HCT ? 1e-11 : 1e-8;
    CHECK(slope == Approx(force(pressure, x).cwiseProduct(d).sum()).epsilon(tolerance));
  }
}

TEST_CASE("volumes in closed form, of sheets and of a sector of a tube", "[fem][loads]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(4, 3));
  const PressureOperator pressure(*mesh, TriangleElement::HCT);
  const auto sheet = [&](double a, double b) {
    return interpolated(mesh, TriangleElement::HCT,
                        [=](const Vec2& p) {
                          return SurfaceJet{{p.x(), p.y(), a * p.x() * p.y() + b},
                                            {1, 0, a * p.y()},
                                            {0, 1, a * p.x()},
                                            {},
                                            {},
                                            {}};
                        })
        .dofs();
  };
  CHECK(pressure.volume(sheet(0, 0.7)) == Approx(0.7 / 3).epsilon(1e-14));
  // x·(x_u × x_v) = b - a u v.
  CHECK(pressure.volume(sheet(2, 0.7)) == Approx((0.7 - 0.5) / 3).epsilon(1e-13));
  VecX half(mesh->triangle_count());
  double area = 0;
  for (int t = 0; t < mesh->triangle_count(); ++t) {
    half[t] = t % 2;
    area += half[t] * mesh->shape(t).area;
  }
  CHECK(pressure.volume(sheet(0, 0.7), half) == Approx(0.7 * area / 3).epsilon(1e-14));

  // A circle of area πr² in the trim: the cone over it with height h.
  const TrimmedSquare square;
  const PressureOperator trimmed(*square.mesh, TriangleElement::HCT, square.trim);
  const Points flat = interpolated(square.mesh, TriangleElement::HCT, [](const Vec2& p) {
                        return SurfaceJet{{p.x(), p.y(), 1.5}, {1, 0, 0}, {0, 1, 0}, {}, {}, {}};
                      }).dofs();
  CHECK(trimmed.volume(flat) == Approx(1.5 * square.trim->area() / 3).epsilon(1e-12));
}

TEST_CASE("far from the origin the load keeps its digits", "[fem][loads]") {
  const auto mesh = perturbed_square(6, 2);
  const PressureOperator pressure(mesh, TriangleElement::HCT);
  Points q = random_dofs(mesh, 4);
  const Points near = force(pressure, q);
  for (int v = 0; v < mesh.vertex_count(); ++v) q.row(3 * v) += Vec3(1e6, -2e6, 3e6).transpose();
  CHECK(difference(force(pressure, q), near) < 1e-8);
}

TEST_CASE("the operator gives the same bits on any number of threads, and asks for no memory",
          "[fem][loads]") {
  const TrimmedSquare small;
  const auto large = std::make_shared<ParametricMesh>(perturbed_square(40, 7));
  const auto cut = std::make_shared<Trim>(*large, DomainLoops({{circle({0.5, 0.5}, 0.4, 12)}}));
  for (const auto& trim : {std::shared_ptr<const Trim>(), std::shared_ptr<const Trim>(cut)}) {
    const PressureOperator pressure(*large, TriangleElement::HCT, trim);
    const Points q = random_dofs(*large, 8);
    const VecX w = random_weights(*large, 9);
    Points one, F = Points::Zero(q.rows(), 3);
    double volume = 0;
    for (const int threads : {1, 2, 3}) {
      const ThreadGuard guard(threads);
      pressure.add(q, w, 2, F);  // starts the threads
      const ScopedOpCount work;
      F.setZero();
      pressure.add(q, w, 2, F);
      if (counts_allocations()) CHECK(work.of(OpCounter::Allocation) == 0);
      if (threads == 1) {
        one = F;
        volume = pressure.volume(q, w);
      }
      CHECK(F == one);
      CHECK(pressure.volume(q, w) == volume);
    }
  }
}

TEST_CASE("different wrong counts are reported differently", "[fem][loads]") {
  const auto mesh = ParametricMesh::unit_square(2);
  const PressureOperator pressure(mesh, TriangleElement::HCT);
  const Points q = random_dofs(mesh, 1);
  Points F = Points::Zero(q.rows(), 3), few = Points::Zero(3, 3);
  CHECK_THROWS_AS(pressure.add(few, {}, 1, F), InputError);
  CHECK_THROWS_AS(pressure.add(q, {}, 1, few), InputError);
  CHECK_THROWS_AS(pressure.add(q, VecX::Ones(3), 1, F), InputError);
  CHECK_THROWS_AS(pressure.volume(q, VecX::Ones(3)), InputError);
}
