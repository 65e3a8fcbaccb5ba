// SPDX-License-Identifier: MPL-2.0
// Whole problems with known solutions.
#include <cmath>
#include <numbers>

#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;

namespace {

using std::numbers::pi;
// Dofs of the boundary: all of them (clamped), or w and the slope along the sides of the square.
std::vector<char> fixed_dofs(const ParametricMesh& mesh, bool clamped) {
  const DofMap dofs(mesh);
  std::vector<char> fixed(dofs.count(), 0);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2& p = mesh.vertices()[v];
    const bool left_right = p.x() == 0 || p.x() == 1, top_bottom = p.y() == 0 || p.y() == 1;
    if (!left_right && !top_bottom) continue;
    fixed[dofs.vertex(v)] = 1;
    fixed[dofs.vertex(v, 1)] = clamped || top_bottom;
    fixed[dofs.vertex(v, 2)] = clamped || left_right;
  }
  if (clamped)
    for (int e = 0; e < mesh.edge_count(); ++e)
      if (mesh.edges()[e].boundary()) fixed[dofs.edge(e)] = 1;
  return fixed;
}

// K q = F with the fixed dofs at their values in q.
VecX solve(const SparseMatrix& K, VecX F, VecX q, const std::vector<char>& fixed) {
  std::vector<int> free_of(q.size(), -1), free;
  for (int d = 0; d < q.size(); ++d)
    if (fixed[d]) {
      continue;
    } else {
      free_of[d] = static_cast<int>(free.size());
      free.push_back(d);
      q[d] = 0;
    }
  F -= K.selfadjointView<Eigen::Lower>() * q;
  std::vector<Triplet> entries;
  for (int j = 0; j < K.outerSize(); ++j)
    for (SparseMatrix::InnerIterator it(K, j); it; ++it)
      if (!fixed[it.row()] && !fixed[j])
        entries.emplace_back(free_of[it.row()], free_of[j], it.value());
  SparseMatrix A(static_cast<long>(free.size()), static_cast<long>(free.size()));
  A.setFromTriplets(entries.begin(), entries.end());
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(A));
  q(free) = cholesky.solve(VecX(F(free)));
  return q;
}

// w = a(u) a(v), a = sin²(πu): derivatives of a, and f = w_uuuu + 2 w_uuvv + w_vvvv.
double a(double u, int order) {
  const double c = std::cos(2 * pi * u), s = std::sin(2 * pi * u);
  const double derivatives[5] = {0.5 * (1 - c), pi * s, 2 * pi * pi * c, -4 * std::pow(pi, 3) * s,
                                 -8 * std::pow(pi, 4) * c};
  return derivatives[order];
}
double biharmonic_load(const Vec2& p) {
  const double u = p.x(), v = p.y();
  return a(u, 4) * a(v, 0) + 2 * a(u, 2) * a(v, 2) + a(u, 0) * a(v, 4);
}

struct Errors {
  double L2 = 0, H1 = 0, H2 = 0;
};

// Errors are integrated by `rule`.
Errors solve_biharmonic(const ParametricMesh& mesh, TriangleElement kind,
                        const TriangleRule& rule) {
  const SurfaceAssembler assembler(mesh, kind);
  const Points F = assembler.load(
      [](const Location&, const Vec2& uv) { return Vec3(biharmonic_load(uv), 0, 0); });
  const SparseMatrix K = assembler.stiffness(SurfaceStiffness{});
  const VecX q = solve(K, F.col(0), VecX::Zero(F.rows()), fixed_dofs(mesh, true));

  Errors squares;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    const C1Triangle element(kind, shape);
    const auto map = assembler.dofs().triangle(mesh, t);
    Vec12 local;
    for (int d = 0; d < 12; ++d) local[d] = q[map[d]];
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p);
      const Vec2 at = shape.point(L);
      const double u = at.x(), v = at.y(), w = shape.area * rule.weights[p];
      Eigen::Matrix<double, 6, 1> d = element.evaluate(L).transpose() * local;
      d -= Eigen::Matrix<double, 6, 1>(a(u, 0) * a(v, 0), a(u, 1) * a(v, 0), a(u, 0) * a(v, 1),
                                       a(u, 2) * a(v, 0), a(u, 1) * a(v, 1), a(u, 0) * a(v, 2));
      squares.L2 += w * d[kW] * d[kW];
      squares.H1 += w * (d[kU] * d[kU] + d[kV] * d[kV]);
      squares.H2 += w * (d[kUU] * d[kUU] + 2 * d[kUV] * d[kUV] + d[kVV] * d[kVV]);
    }
  }
  return {std::sqrt(squares.L2), std::sqrt(squares.H1), std::sqrt(squares.H2)};
}

}  // namespace

TEST_CASE("the clamped biharmonic problem converges with orders 4, 3, 2 on perturbed meshes",
          "[fem][convergence]") {
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const TriangleRule rule =
        kind == TriangleElement::HCT ? split_triangle_rule(6) : six_duffy_rule(4);
    Errors before;
    for (const int n : {8, 16, 32}) {
      const Errors now = solve_biharmonic(perturbed_square(n, 2), kind, rule);
      if (n == 32) {
        CHECK(std::log2(before.L2 / now.L2) == Approx(4).margin(0.3));
        CHECK(std::log2(before.H1 / now.H1) == Approx(3).margin(0.3));
        CHECK(std::log2(before.H2 / now.H2) == Approx(2).margin(0.3));
      }
      before = now;
    }
  }
}

TEST_CASE("the clamped biharmonic problem has the reference errors on the regular meshes",
          "[fem][convergence]") {
  const auto gold = batten_test::reference("convergence.json")["biharmonic"]["results"];
  // The reference integrated the errors of Z12 by this rule, which changes its H2 error by 2 %.
  const auto entries = batten_test::reference("triangle_rules.json")["rules"]["10"];
  const auto points = entries["npts"].get<long>();
  TriangleRule rule25{Points(points, 3), VecX(points)};
  for (long p = 0; p < points; ++p) {
    for (int i = 0; i < 3; ++i) rule25.L(p, i) = entries["L"][p][i];
    rule25.weights[p] = entries["w"][p];
  }
  for (const auto kind : kBothElements) {
    const TriangleRule rule = kind == TriangleElement::HCT ? split_triangle_rule(6) : rule25;
    const auto& runs = gold[kind == TriangleElement::HCT ? "HCT/diag/exact6" : "Z12/diag/duffy5"];
    for (const auto& run : runs) {
      const int n = run["n"];
      INFO(name(kind) << ", n = " << n);
      const Errors found = solve_biharmonic(ParametricMesh::unit_square(n), kind, rule);
      CHECK(found.L2 == Approx(run["L2"].get<double>()).epsilon(1e-4));
      CHECK(found.H1 == Approx(run["H1"].get<double>()).epsilon(1e-4));
      CHECK(found.H2 == Approx(run["H2"].get<double>()).epsilon(1e-4));
    }
  }
}

TEST_CASE("patch test: what the space holds is found exactly on a perturbed mesh",
          "[fem][convergence]") {
  const ParametricMesh mesh = perturbed_square(6, 3);
  const std::vector<char> fixed = fixed_dofs(mesh, true);
  SurfaceStiffness bend, both;
  bend.beta << 1, 0.5, 3;
  both.beta << 2, 2, 2;
  both.alpha << 1, 0.25, 0.25, 2;
  const VecX quadratic = dofs_of(mesh, [](const Vec2& p) {
    const double u = p.x(), v = p.y();
    return Vec3(u * u + u * v - 2 * v * v, 2 * u + v, u - 4 * v);
  });
  const VecX cubic = dofs_of(mesh, [](const Vec2& p) {
    const double u = p.x(), v = p.y();
    return Vec3(u * u * u - 2 * u * v * v + v * v * v, 3 * u * u - 2 * v * v,
                -4 * u * v + 3 * v * v);
  });
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    const auto error = [&](const SurfaceStiffness& material, const VecX& q, double f) {
      const Points F = assembler.load(Vec3(f, 0, 0));
      const VecX found = solve(assembler.stiffness(material), F.col(0), q, fixed);
      return (found - q).cwiseAbs().maxCoeff();
    };
    CHECK(error(bend, quadratic, 0) < 1e-10);
    CHECK(error(bend, cubic, 0) < 1e-10);
    // -(a11 w_uu + 2 a12 w_uv + a22 w_vv) of the quadratic.
    CHECK(error(both, quadratic, -(2 + 0.5 - 8)) < 1e-10);
    CHECK(error(both, quadratic, 0) > 1e-3);
  }
}

// The energy of a plate is D ∬ (w_uu² + w_vv² + 2ν w_uu w_vv + 2(1-ν) w_uv²), ours with beta = D
// D ∬ (w_uu² + 2 w_uv² + w_vv²). They differ by 2νD ∬ (w_uu w_vv - w_uv²), the integral of
// det ∇∇w = ½ ∮ (w_u dw_v - w_v dw_u): for functions with continuous gradients it depends on the
// gradient along the boundary only. It is zero there on clamped sides; on a straight simply
// supported side the gradient is a multiple of one fixed normal, so the form w_u dw_v - w_v dw_u
// vanishes too. Hence the same discrete solution, for all ν.
TEST_CASE("square plates under uniform load have Timoshenko's deflection in the middle",
          "[fem][convergence]") {
  const auto gold = batten_test::reference("convergence.json")["plates"];
  for (const auto kind : kBothElements)
    for (const bool clamped : {false, true}) {
      const std::string support = clamped ? "clamped" : "ss";
      const std::string rule = kind == TriangleElement::HCT ? "HCT/exact/" : "Z12/duffy5/";
      int run = 0;
      for (const int n : {2, 4, 8, 16}) {
        INFO(name(kind) << ", " << support << ", n = " << n);
        const ParametricMesh mesh = ParametricMesh::unit_square(n);
        const SurfaceAssembler assembler(mesh, kind);
        const Points F = assembler.load(Vec3(1, 0, 0));
        const VecX q = solve(assembler.stiffness(SurfaceStiffness{}), F.col(0),
                             VecX::Zero(F.rows()), fixed_dofs(mesh, clamped));
        const int middle = (n / 2) * (n + 1) + n / 2;
        const double w = q[assembler.dofs().vertex(middle)];
        CHECK(w == Approx(gold["results"][rule + support][run++].get<double>()).epsilon(1e-5));
        if (n == 16) CHECK(w == Approx(gold["timoshenko"][support].get<double>()).epsilon(1e-3));
      }
    }
}
