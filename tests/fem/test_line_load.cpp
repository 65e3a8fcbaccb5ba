// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface_assembler.h"

#include "batten/core/errors.h"
#include "batten/fem/surface.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// Position dofs of a coordinate: the load of a rigid motion.
VecX ones(const ParametricMesh& mesh) {
  VecX one = VecX::Zero(DofMap(mesh).count());
  for (int v = 0; v < mesh.vertex_count(); ++v) one[DofMap(mesh).vertex(v)] = 1;
  return one;
}

VecX cubic(const ParametricMesh& mesh) {
  return dofs_of(mesh, [](const Vec2& p) {
    const double u = p.x(), v = p.y();
    return Vec3(u * u * v - v * v * v + u, 2 * u * v + 1, u * u - 3 * v * v);
  });
}

// ∫ f(c) |X'| dt, segment by segment.
template <class Function>
double integral(const HermiteCurve& pcurve, const HermiteCurve& curve, const Function& f) {
  static const SegmentRule gauss = gauss_legendre(16);
  double sum = 0;
  for (int s = 0; s < pcurve.segment_count(); ++s)
    for (long g = 0; g < gauss.s.size(); ++g) {
      const CurveMesh::SegmentPoint at{s, gauss.s[g]};
      sum += gauss.weights[g] * pcurve.mesh().length(s) * f(pcurve.evaluate(at)) *
             curve.evaluate(at, 1).norm();
    }
  return sum;
}

HermiteCurve in_space(const HermiteCurve& pcurve) {
  Points dofs = pcurve.dofs();
  const double scale = 3;
  dofs *= scale;
  for (int i = 0; i < pcurve.node_count(); ++i)
    dofs(pcurve.mesh().slope_out(i), 2) = 0.4 * std::sin(i);
  return {pcurve.mesh(), dofs};
}

}  // namespace

TEST_CASE("a line load sums to its length, and its work on cubics is the line integral",
          "[fem][loads]") {
  for (const auto kind : kBothElements)
    for (const int n : {3, 8, 17}) {
      const ParametricMesh mesh = perturbed_square(n, 3);
      const TriangleLocator locator(mesh);
      const HermiteCurve pcurve = circle({0.5, 0.48}, 0.4, 9), curve = in_space(pcurve);
      const VecX F = line_load(mesh, kind, locator, pcurve, curve);
      CHECK(F.dot(ones(mesh)) ==
            Approx(integral(pcurve, curve, [](const Vec3&) { return 1.0; })).epsilon(1e-9));
      CHECK(F.dot(cubic(mesh)) == Approx(integral(pcurve, curve, [](const Vec3& c) {
                                    return c.x() * c.x() * c.y() - std::pow(c.y(), 3) + c.x();
                                  })).epsilon(1e-9));
    }
}

TEST_CASE("a line load on any surface is the integral along the curve, to 1e-8", "[fem][loads]") {
  Random random(5);
  for (const auto kind : kBothElements) {
    const ParametricMesh mesh = perturbed_square(6, 4);
    const TriangleLocator locator(mesh);
    const HermiteCurve pcurve = circle({0.52, 0.5}, 0.37, 9), curve = in_space(pcurve);
    const VecX q = VecX::NullaryExpr(DofMap(mesh).count(), [&] { return random(); });
    // Many single points: the midpoint rule on a closed curve.
    const int n = 200000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double t = 2 * pi * (i + 0.5) / n;
      const Location on = locator.locate(pcurve.evaluate(t).head<2>());
      const Vec12 N = C1Triangle(kind, mesh.shape(on.triangle)).evaluate(on.L).col(kW);
      const auto dof = DofMap(mesh).triangle(mesh, on.triangle);
      double w = 0;
      for (int a = 0; a < 12; ++a) w += N[a] * q[dof[a]];
      sum += 2 * pi / n * w * curve.evaluate(t, 1).norm();
    }
    INFO(name(kind));
    CHECK(line_load(mesh, kind, locator, pcurve, curve).dot(q) ==
          Approx(sum).epsilon(1e-8).margin(1e-8));
  }
}

TEST_CASE("a run along element edges loads the edges' dofs only", "[fem][loads]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(4);
  const TriangleLocator locator(mesh);
  Points ends(2, 3), slopes(2, 3);
  ends << 0, 0.5, 0, 1, 0.5, 0;
  slopes << 1, 0, 0, 1, 0, 0;
  const HermiteCurve pcurve({0, 1}, ends, slopes);
  const VecX F = line_load(mesh, TriangleElement::HCT, locator, pcurve, pcurve);
  CHECK(F.dot(ones(mesh)) == Approx(1).epsilon(1e-14));
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const bool on = mesh.vertices()[v].y() == 0.5;
    const bool end = mesh.vertices()[v].x() == 0 || mesh.vertices()[v].x() == 1;
    CHECK(F[3 * v] == Approx(on ? (end ? 0.125 : 0.25) : 0).margin(1e-14));
    CHECK(std::abs(F[3 * v + 2]) < 1e-14);
  }
}

TEST_CASE("a curve and a pcurve over different intervals are refused", "[fem][loads]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(4);
  const HermiteCurve pcurve = circle({0.5, 0.5}, 0.3, 8);
  CHECK_THROWS_AS(line_load(mesh, TriangleElement::HCT, TriangleLocator(mesh), pcurve,
                            pcurve.with_scaled_parameter(2)),
                  InputError);
}

TEST_CASE("weights of triangles: 1 everywhere is the constant load, and parts add up",
          "[fem][loads]") {
  Random random(6);
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(6, 4));
  const auto trim = std::make_shared<Trim>(*mesh, DomainLoops({{circle({0.5, 0.5}, 0.4, 12)}}));
  for (const auto kind : kBothElements)
    for (const auto& cut : {std::shared_ptr<const Trim>(), std::shared_ptr<const Trim>(trim)}) {
      const SurfaceAssembler assembler(*mesh, kind, cut);
      const VecX w = VecX::NullaryExpr(mesh->triangle_count(), [&] { return random(); });
      CHECK(assembler.load(VecX(VecX::Ones(w.size()))) == assembler.load(Vec3(1, 2, 3)).col(0));
      double sum = 0;
      for (int t = 0; t < w.size(); ++t)
        sum += w[t] * mesh->shape(t).area * (cut ? cut->area_fraction(t) : 1);
      CHECK(assembler.load(w).dot(ones(*mesh)) == Approx(sum).epsilon(1e-12));
      CHECK_THROWS_AS(assembler.load(VecX(VecX::Ones(3))), InputError);

      // Measured on the surface: on a plane that is sheared and scaled by 6, six times as much.
      const auto plane = [](const Vec2& p) {
        return SurfaceJet{{2 * p.x() + p.y(), 3 * p.y(), 0}, {2, 0, 0}, {1, 3, 0}, {}, {}, {}};
      };
      const VecX heavy = assembler.area_load(interpolated(mesh, kind, plane)),
                 unit = assembler.load(Vec3(1, 0, 0)).col(0);
      CHECK((heavy - 6 * unit).norm() <
            (kind == TriangleElement::HCT ? 1e-13 : 1e-5) * heavy.norm());
      const auto bowl = [](const Vec2& p) {
        return SurfaceJet{{p.x(), p.y(), p.x() * p.x()}, {1, 0, 2 * p.x()}, {0, 1, 0}, {}, {}, {}};
      };
      const Surface plain = interpolated(mesh, kind, bowl);
      const Surface surface(plain.shared_mesh(), kind, plain.dofs(), cut);
      CHECK(assembler.area_load(surface).dot(ones(*mesh)) == Approx(surface.area()).epsilon(1e-7));
      const auto other = std::make_shared<ParametricMesh>(ParametricMesh::unit_square(2));
      CHECK_THROWS_AS(assembler.area_load(interpolated(other, kind, bowl)), InputError);
    }
}
