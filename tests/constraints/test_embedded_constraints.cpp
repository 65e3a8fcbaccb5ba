// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

// The unit disc on a grid with legs h, its boundary fixed at points.
struct Disc {
  double h;
  int points;
  HermiteCurve rim = circle({0, 0}, 1, 1440);
  EmbeddedGrid grid;
  std::vector<double> t;
  SparseMatrix K;  // bending

  static EmbeddedGrid grid_for(double h, const Vec2& offset, const HermiteCurve& rim) {
    const int n = static_cast<int>(std::round(2 / h)) + 4;
    return {squares(Vec2(-1 - 2 * h, -1 - 2 * h) + h * offset, h, n, n), DomainLoops({{rim}})};
  }
  explicit Disc(double h_, TriangleElement kind = TriangleElement::HCT, Vec2 offset = {0.13, 0.29},
                double step = 0.7, SurfaceStiffness material = {})
      : h(h_),
        points(static_cast<int>(std::round(2 * pi / (step * h_)))),
        grid(grid_for(h_, offset, rim)),
        K(SurfaceAssembler(*grid.mesh, kind, grid.trim).stiffness(material)) {
    for (int k = 0; k < points; ++k) t.push_back(0.01 + 2 * pi * k / points);
  }
  ConstraintSet rows(const HermiteCurve& target, TriangleElement kind) const {
    ConstraintSet set(DofMap(*grid.mesh).count());
    EmbeddedLineConstraints(*grid.mesh, kind, *grid.locator, set).points("rim", rim, target, t);
    return set;
  }
  Surface solved(const HermiteCurve& target, TriangleElement kind = TriangleElement::HCT) const {
    const ConstraintSet set = rows(target, kind);
    return {grid.mesh, kind, ConstrainedSolver(set, K).solve(Points::Zero(set.dof_count(), 3)),
            grid.trim};
  }
  Vec3 at(const Surface& s, double u, double v) const {
    return s.position(grid.locator->locate({u, v}));
  }
  // Largest distance between surface and target, 20 samples between points.
  Vec3 gap(const Surface& s, const HermiteCurve& target) const {
    Vec3 largest = Vec3::Zero();
    for (int i = 0; i < 20 * points; ++i) {
      const double u = 2 * pi * i / (20 * points);
      const Vec3 c = rim.evaluate(u);
      largest = largest.cwiseMax((at(s, c.x(), c.y()) - target.evaluate(u)).cwiseAbs());
    }
    return largest;
  }
};

// Energy of z over the inside, from the surface's second derivatives.
double bending(const Surface& s, const Trim& trim, int coordinate = 2) {
  double sum = 0;
  for (int t = 0; t < s.mesh().triangle_count(); ++t) {
    const TriangleRule rule = trim.rule(t, s.kind() == TriangleElement::HCT ? 2 : 8);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const SurfaceJet j = s.jet({t, rule.L.row(p).transpose()});
      const double uu = j.x_uu[coordinate], uv = j.x_uv[coordinate], vv = j.x_vv[coordinate];
      sum += s.mesh().shape(t).area * rule.weights[p] * (uu * uu + 2 * uv * uv + vv * vv);
    }
  }
  return sum;
}

HermiteCurve wavy_rim() {
  return hermite(0, 2 * pi, 1440, true, [](double t, int order) {
    return order == 0 ? Vec3(std::cos(t), std::sin(t), 0.2 * std::cos(3 * t))
                      : Vec3(-std::sin(t), std::cos(t), -0.6 * std::sin(3 * t));
  });
}

// The inside of the unit circle by chords: each sub-triangle in 4^level leaves, which are cut where
// bisection finds the circle. An independent second-order quadrature.
TriangleRule chord_rule(const TriangleShape& shape, int level, int degree) {
  using Corners = std::array<Vec2, 3>;
  const auto inside = [](const Vec2& p) { return p.squaredNorm() - 1 - 1e-12 < 0; };
  const auto crossing = [&](Vec2 in, Vec2 out) {
    for (int i = 0; i < 60; ++i) {
      const Vec2 middle = 0.5 * (in + out);
      (inside(middle) ? in : out) = middle;
    }
    return Vec2(0.5 * (in + out));
  };
  std::vector<Corners> leaves, pieces;
  const Vec2 centroid = shape.point(Vec3::Constant(1.0 / 3));
  for (int s = 0; s < 3; ++s)
    leaves.push_back({shape.vertex[(s + 1) % 3], shape.vertex[(s + 2) % 3], centroid});
  for (int l = 0; l < level; ++l) {
    std::vector<Corners> finer;
    for (const auto& [a, b, c] : leaves) {
      const Vec2 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
      for (const Corners& leaf : {Corners{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(leaf);
    }
    leaves = finer;
  }
  for (const Corners& leaf : leaves) {
    std::vector<Vec2> polygon;
    for (int i = 0; i < 3; ++i) {
      const Vec2 &p = leaf[i], &q = leaf[(i + 1) % 3];
      if (inside(p)) polygon.push_back(p);
      if (inside(p) != inside(q)) polygon.push_back(inside(p) ? crossing(p, q) : crossing(q, p));
    }
    for (size_t i = 1; i + 1 < polygon.size(); ++i)
      pieces.push_back({polygon[0], polygon[i], polygon[i + 1]});
  }
  const TriangleRule in_piece = symmetric_triangle_rule(degree);
  const long n = in_piece.weights.size();
  TriangleRule rule{Points(n * static_cast<long>(pieces.size()), 3),
                    VecX(n * static_cast<long>(pieces.size()))};
  long row = 0;
  for (const auto& [a, b, c] : pieces) {
    const Vec2 d = b - a, e = c - a;
    const double area = 0.5 * (d.x() * e.y() - d.y() * e.x());
    for (long p = 0; p < n; ++p, ++row) {
      const Vec3 L = in_piece.L.row(p);
      rule.L.row(row) = shape.barycentric(L[0] * a + L[1] * b + L[2] * c);
      rule.weights[row] = in_piece.weights[p] * area / shape.area;
    }
  }
  return rule;
}

}  // namespace

TEST_CASE("a disc on a grid that ignores its boundary: reference numbers, by chords as stored",
          "[constraints][embedded]") {
  struct Gold {
    double h;
    int points, triangles, dofs;
    double area, energy, z, centre;
  };
  const Gold gold[] = {
      {1 / 4., 36, 130, 453, 3.14128721, 3.88082877, 0.016707359, 0.0781192520},
      {1 / 8., 72, 460, 1499, 3.14151049, 3.87786533, 0.016935365, 0.0781254474},
      {1 / 16., 144, 1722, 5393, 3.14157387, 3.87762096, 0.016954311, 0.0781251852}};
  for (const Gold& g : gold) {
    const Disc d(g.h);
    const ParametricMesh& mesh = *d.grid.mesh;
    CHECK(d.points == g.points);
    CHECK(mesh.triangle_count() == g.triangles);
    CHECK(DofMap(mesh).count() == g.dofs);
    std::vector<Triplet> entries, of_inside;
    Points F = Points::Zero(g.dofs, 3);
    double area = 0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const TriangleShape shape = mesh.shape(t);
      const C1Triangle element(TriangleElement::HCT, shape);
      const TriangleRule rule = chord_rule(shape, 2, 2), for_load = chord_rule(shape, 2, 4);
      Mat12 inside;
      variable_stiffness(
          TabulatedRule(TriangleElement::HCT, rule), shape,
          [](const Vec3&) { return SurfaceStiffness{}; }, inside.data());
      const Mat12 K = inside + 1e-6 * (element.stiffness(SurfaceStiffness{}) - inside);
      const auto dof = DofMap(mesh).triangle(mesh, t);
      for (int a = 0; a < 12; ++a)
        for (int b = 0; b < 12; ++b)
          if (dof[a] >= dof[b]) {
            entries.emplace_back(dof[a], dof[b], K(a, b));
            of_inside.emplace_back(dof[a], dof[b], inside(a, b));
          }
      for (long p = 0; p < for_load.weights.size(); ++p) {
        const Vec12 N = element.evaluate(for_load.L.row(p)).col(kW);
        for (int a = 0; a < 12; ++a) F(dof[a], 2) += shape.area * for_load.weights[p] * N[a];
      }
      area += shape.area * rule.weights.sum();
    }
    SparseMatrix K(g.dofs, g.dofs), K_inside(g.dofs, g.dofs);
    K.setFromTriplets(entries.begin(), entries.end());
    K_inside.setFromTriplets(of_inside.begin(), of_inside.end());
    CHECK(area == Approx(g.area).epsilon(3e-9));
    const Points zero = Points::Zero(g.dofs, 3);
    const Points q = ConstrainedSolver(d.rows(wavy_rim(), TriangleElement::HCT), K).solve(zero);
    CHECK(q.col(2).dot(K_inside.selfadjointView<Eigen::Lower>() * q.col(2)) ==
          Approx(g.energy).epsilon(3e-9));
    const Surface wavy(d.grid.mesh, TriangleElement::HCT, q);
    CHECK(d.at(wavy, 0.5, 0.2).z() == Approx(g.z).margin(1e-9));
    const Points w = ConstrainedSolver(d.rows(d.rim, TriangleElement::HCT), K).solve(F);
    CHECK(d.at(Surface(d.grid.mesh, TriangleElement::HCT, w), 0, 0).z() ==
          Approx(g.centre).margin(2e-10));
  }
}

TEST_CASE(
    "a disc on a grid that ignores its boundary: exact cuts, both elements, against the plate",
    "[constraints][embedded]") {
  // Δ²w = 0 with w = 0.2 cos 3t and w_rr = 0 on the boundary.
  const auto exact = [](double u, double v) {
    const double r = std::hypot(u, v), t = std::atan2(v, u);
    return 0.2 * (10 * r * r * r - 3 * std::pow(r, 5)) / 7 * std::cos(3 * t);
  };
  for (const TriangleElement kind : kBothElements) {
    std::vector<double> errors, gaps, energies;
    for (const double h : {1 / 4., 1 / 8., 1 / 16.}) {
      const Disc d(h, kind);
      const Surface s = d.solved(wavy_rim(), kind);
      CHECK(d.grid.trim->area() == Approx(pi).epsilon(1e-9));
      double squares = 0;
      for (int t = 0; t < s.mesh().triangle_count(); ++t) {
        const TriangleRule rule = d.grid.trim->rule(t, 6);
        for (long p = 0; p < rule.weights.size(); ++p) {
          const Vec3 L = rule.L.row(p);
          const Vec2 uv = s.mesh().shape(t).point(L);
          squares += s.mesh().shape(t).area * rule.weights[p] *
                     std::pow(s.position({t, L}).z() - exact(uv.x(), uv.y()), 2);
        }
      }
      errors.push_back(std::sqrt(squares));
      gaps.push_back(d.gap(s, wavy_rim()).z());
      energies.push_back(bending(s, *d.grid.trim) / 3.8776229324 - 1);
    }
    INFO(name(kind) << " gaps " << gaps[0] << " " << gaps[1] << " " << gaps[2] << " L2 "
                    << errors[0] << " " << errors[1] << " " << errors[2] << " energy "
                    << energies[0] << " " << energies[1] << " " << energies[2]);
    const double table[3][3] = {
        {2.7e-4, 2.2e-5, 3.4e-6}, {2.3e-4, 2.4e-5, 1.8e-6}, {8e-4, 6e-5, 1e-5}};
    for (size_t i = 0; i < 3; ++i) {
      CHECK(gaps[i] <= 1.2 * table[0][i]);
      CHECK(errors[i] <= 1.2 * table[1][i]);
      CHECK(std::abs(energies[i]) <= (kind == TriangleElement::HCT ? 1.7 : 2.5) * table[2][i]);
    }
  }
}

TEST_CASE("affine data on embedded curves are reproduced exactly, whatever the grid",
          "[constraints][embedded]") {
  for (const TriangleElement kind : kBothElements)
    for (const double h : {1 / 4., 1 / 8., 1 / 16.}) {
      const Disc d(h, kind);
      const HermiteCurve tilted = hermite(0, 2 * pi, 1440, true, [](double t, int order) {
        const Vec3 c =
            order == 0 ? Vec3(std::cos(t), std::sin(t), 0) : Vec3(-std::sin(t), std::cos(t), 0);
        return Vec3(c.x() - 0.2 * c.y() + (order ? 0 : 3), 0.4 * c.y(), 0.3 * c.x() + c.y());
      });
      const Surface s = d.solved(tilted, kind);
      CHECK(d.gap(s, tilted).maxCoeff() < 1e-12);
      for (const int coordinate : {0, 1, 2}) CHECK(bending(s, *d.grid.trim, coordinate) < 1e-15);
    }
}

TEST_CASE("a boundary with another speed, and a star: gaps decrease, Jacobians stay above zero",
          "[constraints][embedded]") {
  const HermiteCurve faster = hermite(0, 2 * pi, 1440, true, [](double t, int order) {
    const double a = t + 0.3 * std::sin(t), slope = 1 + 0.3 * std::cos(t);
    return order == 0 ? Vec3(std::cos(a), std::sin(a), 0)
                      : Vec3(-slope * std::sin(a), slope * std::cos(a), 0);
  });
  const HermiteCurve star = hermite(0, 2 * pi, 1440, true, [](double t, int order) {
    const double r = 1 + 0.25 * std::cos(5 * t), r1 = -1.25 * std::sin(5 * t);
    return order == 0
               ? Vec3(r * std::cos(t), r * std::sin(t), 0)
               : Vec3(r1 * std::cos(t) - r * std::sin(t), r1 * std::sin(t) + r * std::cos(t), 0);
  });
  struct Case {
    const HermiteCurve* target;
    double gap[3], jacobian[3];
  };
  const Case cases[] = {{&faster, {5.0e-5, 4.6e-6, 7.1e-7}, {0.5425, 0.5425, 0.5425}},
                        {&star, {2.4e-3, 2.3e-4, 2.6e-5}, {0.143, 0.151, 0.154}}};
  for (const Case& c : cases)
    for (size_t i = 0; i < 3; ++i) {
      const Disc d(std::pow(0.5, 2 + static_cast<double>(i)));
      const Surface s = d.solved(*c.target);
      double gap = 0, smallest = 1e9;
      for (int k = 0; k < 20 * d.points; ++k) {
        const double u = 2 * pi * k / (20 * d.points);
        const Vec3 p = d.rim.evaluate(u), x = d.at(s, p.x(), p.y());
        // Distance from the circle; for the star, at the same parameter.
        gap = std::max(
            gap, c.target == &faster ? std::abs(x.norm() - 1) : (x - c.target->evaluate(u)).norm());
      }
      for (int t = 0; t < s.mesh().triangle_count(); ++t) {
        const TriangleRule rule = d.grid.trim->rule(t, 4);
        for (long p = 0; p < rule.weights.size(); ++p)
          if (rule.weights[p] > 0)
            smallest = std::min(smallest, s.jet({t, rule.L.row(p).transpose()}).area_vector().z());
      }
      INFO((c.target == &faster ? "faster " : "star ") << i << " gap " << gap << " J " << smallest);
      CHECK(gap <= 1.2 * c.gap[i]);
      CHECK(smallest >= 0.9 * c.jacobian[i]);
    }
}

TEST_CASE("forty grids, shifted at random: full rank, the same gaps, at one step and at half",
          "[constraints][embedded]") {
  Random random(11);
  for (int trial = 0; trial < 40; ++trial) {
    const Vec2 offset(random.between(0, 1), random.between(0, 1));
    const Disc d(1 / 8., trial % 4 == 3 ? TriangleElement::Z12 : TriangleElement::HCT, offset);
    const TriangleElement kind = trial % 4 == 3 ? TriangleElement::Z12 : TriangleElement::HCT;
    const AffineReduction reduction(d.rows(wavy_rim(), kind));
    CHECK(reduction.redundant_count() == 0);
    double largest = 0;
    const SparseMatrix& D = reduction.D();
    for (int k = 0; k < D.outerSize(); ++k)
      for (SparseMatrix::InnerIterator it(D, k); it; ++it)
        largest = std::max(largest, std::abs(it.value()));
    const Surface s = d.solved(wavy_rim(), kind);
    INFO("offset " << offset.transpose() << ", largest of D " << largest);
    CHECK(largest <= 2);
    CHECK(d.gap(s, wavy_rim()).z() <= 4e-5);
    CHECK(d.grid.trim->area() == Approx(pi).epsilon(1e-9));
  }
}

TEST_CASE("a plate supported at its boundary under a load, stretched too, and clamped by hats",
          "[constraints][embedded]") {
  for (const TriangleElement kind : kBothElements)
    for (const double h : {1 / 8., 1 / 16.}) {
      const Disc d(h, kind);
      const SurfaceAssembler assembler(*d.grid.mesh, kind, d.grid.trim);
      // Supported: Δ²w = 1, w = w_rr = 0: 5/64 in the middle.
      const Points F = assembler.load(Vec3(0, 0, 1));
      const Surface plate(d.grid.mesh, kind, ConstrainedSolver(d.rows(d.rim, kind), d.K).solve(F));
      CHECK(d.at(plate, 0, 0).z() == Approx(5 / 64.).epsilon(1e-4));
      // Clamped: 1/64.
      ConstraintSet clamped = d.rows(d.rim, kind);
      EmbeddedLineConstraints(*d.grid.mesh, kind, *d.grid.locator, clamped)
          .slope("clamp", d.rim, d.t, [](double) { return Vec3(0, 0, 0); });
      ConstraintSet flat(clamped.dof_count());
      for (const auto& row : clamped.constraints()) flat.add("rim", row.entries, Vec3::Zero());
      const Surface held(d.grid.mesh, kind, ConstrainedSolver(flat, d.K).solve(F));
      INFO(name(kind) << " h " << h << " error " << d.at(held, 0, 0).z() * 64 - 1);
      CHECK(std::abs(d.at(held, 0, 0).z() * 64 - 1) <= (h > 0.1 ? 4e-4 : 1e-4));
      // With stretching: Δ²w - 20 Δw = 1 has w = A + B I0(kr) - r²/80, k² = 20.
      const double alpha = 20, k = std::sqrt(alpha);
      const double B =
          1 / (2 * alpha * alpha) / (std::cyl_bessel_i(0, k) - std::cyl_bessel_i(1, k) / k);
      const double centre = 1 / (4 * alpha) - B * (std::cyl_bessel_i(0, k) - 1);
      const Disc stretched(h, kind, {0.4, 0.1}, 0.7, SurfaceStiffness::isotropic(alpha, 1));
      const SurfaceAssembler on_it(*stretched.grid.mesh, kind, stretched.grid.trim);
      const Surface drum(stretched.grid.mesh, kind,
                         ConstrainedSolver(stretched.rows(d.rim, kind), stretched.K)
                             .solve(on_it.load(Vec3(0, 0, 1))));
      INFO("drum " << stretched.at(drum, 0, 0).z() / centre - 1);
      CHECK(stretched.at(drum, 0, 0).z() == Approx(centre).epsilon(1e-4));
    }
}
