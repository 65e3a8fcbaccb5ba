// SPDX-License-Identifier: MPL-2.0
#include "batten/core/eigen.h"
#include "batten/elements/c1_triangle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "batten/core/errors.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;

namespace {

struct Draws : Random {
  using Random::Random;
  Vec12 dofs() {
    return Vec12::NullaryExpr([&] { return (*this)(); });
  }
  /// Barycentric coordinates at least `margin` away from edges and from the inner edges of HCT.
  Vec3 inside(double margin = 0.02) {
    for (;;) {
      Vec3 L(between(0, 1), between(0, 1), 0);
      L[2] = 1 - L[0] - L[1];
      const double spokes =
          std::min({std::abs(L[0] - L[1]), std::abs(L[1] - L[2]), std::abs(L[2] - L[0])});
      if (L.minCoeff() > margin && spokes > margin) return L;
    }
  }
  /// A triangle of size 1 with altitudes that are not too small, and any edge signs.
  TriangleShape triangle() {
    for (;;) {
      const Vec2 a((*this)(), (*this)()), b((*this)(), (*this)()), c((*this)(), (*this)());
      const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
      const double twice_area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
      if (twice_area < 0.2 * longest * longest || longest < 0.5) continue;
      return {a, b, c, {sign(), sign(), sign()}};
    }
  }
  double sign() { return engine() % 2 ? 1 : -1; }
};

// Unit normal of edge i, as used by the dof w_n.
Vec2 edge_normal(const TriangleShape& shape, int i) {
  const Vec2 t =
      shape.edge_sign[i] * (shape.vertex[(i + 2) % 3] - shape.vertex[(i + 1) % 3]).normalized();
  return {-t.y(), t.x()};
}

Vec3 middle_of_edge(int i) { return 0.5 * (Vec3::Unit((i + 1) % 3) + Vec3::Unit((i + 2) % 3)); }

// Dofs of a function given as uv → (w, w_u, w_v).
template <class Function>
Vec12 dofs_of(const TriangleShape& shape, const Function& f) {
  Vec12 q;
  for (int i = 0; i < 3; ++i) {
    q.segment<3>(3 * i) = f(shape.vertex[i]);
    const Vec3 at_middle = f(shape.point(middle_of_edge(i)));
    q[9 + i] = edge_normal(shape, i).dot(at_middle.tail<2>());
  }
  return q;
}

double power(double x, int e) { return e <= 0 ? 1 : x * power(x, e - 1); }

// (w, w_u, w_v, w_uu, w_uv, w_vv) of u^a v^b.
Eigen::Matrix<double, 6, 1> monomial(const Vec2& p, int a, int b) {
  const auto d = [](double x, int e, int order) {
    if (order > e) return 0.0;
    double factor = 1;
    for (int i = 0; i < order; ++i) factor *= e - i;
    return factor * power(x, e - order);
  };
  const double u = p.x(), v = p.y();
  Eigen::Matrix<double, 6, 1> m;
  m << d(u, a, 0) * d(v, b, 0), d(u, a, 1) * d(v, b, 0), d(u, a, 0) * d(v, b, 1),
      d(u, a, 2) * d(v, b, 0), d(u, a, 1) * d(v, b, 1), d(u, a, 0) * d(v, b, 2);
  return m;
}

Vec12 monomial_dofs(const TriangleShape& shape, int a, int b) {
  return dofs_of(shape, [&](const Vec2& p) { return Vec3(monomial(p, a, b).head<3>()); });
}

Eigen::Matrix<double, 6, 1> surface_at(const C1Triangle& element, const Vec12& q, const Vec3& L) {
  return element.evaluate(L).transpose() * q;
}

MatX matrix(const nlohmann::json& rows) {
  MatX m(rows.size(), rows[0].size());
  for (long i = 0; i < m.rows(); ++i)
    for (long j = 0; j < m.cols(); ++j) m(i, j) = rows[i][j];
  return m;
}

VecX vector(const nlohmann::json& entries) {
  VecX v(entries.size());
  for (long i = 0; i < v.size(); ++i) v[i] = entries[i];
  return v;
}

// A rule that is exact up to rounding for products of the functions and a linear coefficient.
TriangleRule fine_rule(TriangleElement kind) {
  return kind == TriangleElement::HCT ? split_triangle_rule(8) : six_duffy_rule(11);
}

// The matrix of the energy by quadrature of evaluate(), its definition.
Mat12 stiffness_by_quadrature(TriangleElement kind, const TriangleShape& shape,
                              const std::function<SurfaceStiffness(const Vec3&)>& material) {
  const TriangleRule rule = fine_rule(kind);
  const C1Triangle element(kind, shape);
  Mat12 K = Mat12::Zero();
  for (long p = 0; p < rule.weights.size(); ++p) {
    const Vec3 L = rule.L.row(p);
    const SurfaceStiffness m = material(L);
    const Tabulation N = element.evaluate(L);
    const auto gradient = N.middleCols<2>(kU);
    const auto hessian = N.middleCols<3>(kUU);
    const Vec3 beta(m.beta[0], 2 * m.beta[1], m.beta[2]);
    K += shape.area * rule.weights[p] *
         (gradient * m.alpha * gradient.transpose() +
          hessian * beta.asDiagonal() * hessian.transpose());
  }
  return K;
}

SurfaceStiffness anisotropic() {
  SurfaceStiffness m;
  m.alpha << 1, 0.25, 0.25, 2;
  m.beta << 1, 0.5, 3;
  return m;
}

TriangleShape gold_triangle() { return {{0.1, 0.2}, {1.3, 0.4}, {0.5, 1.1}}; }

}  // namespace

// --- compared with reference values --------------------------------------------------------------

TEST_CASE("element matrices, loads and values are the reference numbers",
          "[elements][c1_triangle]") {
  const auto all = batten_test::reference("element_gold.json");
  const TriangleShape shape = gold_triangle();
  const auto weight = [](const Vec3& L) { return L[0] + 2 * L[1] + 3 * L[2]; };
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const auto& gold = all[name(kind)];
    const C1Triangle element(kind, shape);
    const auto isotropic = SurfaceStiffness::isotropic;
    CHECK(relative_error(element.stiffness(isotropic(1, 0)), matrix(gold["K_alphaI_beta0"])) <
          1e-12);
    CHECK(relative_error(element.stiffness(isotropic(0, 1)), matrix(gold["K_alpha0_beta111"])) <
          1e-12);
    CHECK(relative_error(element.stiffness(anisotropic()),
                         matrix(gold["K_general_alpha(1,.25,2)_beta(1,.5,3)"])) < 1e-12);
    CHECK(relative_error(element.mass(), matrix(gold["mass"])) < 1e-12);
    CHECK(relative_error(element.load(), vector(gold["load_f1"])) < 1e-12);

    // Variable coefficient: the reference matrix by an exact rule.
    const MatX varying = matrix(gold["K_linear_coeff alpha=c*I, beta=c*(1,1,1), c=L1+2L2+3L3"]);
    Mat12 K;
    variable_stiffness(
        TabulatedRule(kind,
                      kind == TriangleElement::HCT ? split_triangle_rule(6) : six_duffy_rule(6)),
        shape, [&](const Vec3& L) { return isotropic(weight(L), weight(L)); }, K.data());
    CHECK(relative_error(K, varying) < (kind == TriangleElement::HCT ? 1e-12 : 1e-7));

    Vec12 load = Vec12::Zero();
    const TriangleRule rule = fine_rule(kind);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec3 L = rule.L.row(p);
      load += shape.area * rule.weights[p] * weight(L) * element.evaluate(L).col(kW);
    }
    CHECK(relative_error(load, vector(gold["load_linear f=L1+2L2+3L3"])) < 1e-12);

    const Vec12 q = vector(all["point_eval_dofs"]);
    for (int p = 0; p < 4; ++p) {
      const Vec3 L = p == 3 ? Vec3::Constant(1.0 / 3) : vector(all["point_eval_barycentric"][p]);
      const VecX expected = vector(gold["point_eval [w,wu,wv,wuu,wuv,wvv]"][p]);
      CHECK(relative_error(surface_at(element, q, L), expected) < 1e-12);
    }
  }

  const C1Triangle hct(TriangleElement::HCT, shape);
  Eigen::Matrix<double, 12, 3> q;
  for (int c = 0; c < 3; ++c) q.col(c) = (1.0 - 2 * c) * vector(all["point_eval_dofs"]);
  for (int s = 0; s < 3; ++s) {
    const VecX net =
        vector(all["HCT"]["bezier_ordinates_for_point_eval_dofs"]["sub" + std::to_string(s + 1)]);
    for (int c = 0; c < 3; ++c)
      CHECK(relative_error(hct.bezier(s, q).col(c), (1.0 - 2 * c) * net) < 1e-12);
  }
}

TEST_CASE("Z12's reference tensors are the integrals of the paper's raw functions",
          "[elements][c1_triangle]") {
  // Row r: the reference dofs of raw function r, computed analytically. raw = C N̂, so that S_raw =
  // C Ŝ Cᵀ.
  Mat12 C;
  const auto gradients = [](const Vec3& L) {
    Eigen::Matrix<double, 9, 3> g = Eigen::Matrix<double, 9, 3>::Zero();
    const int pairs[6][2] = {{0, 1}, {0, 2}, {1, 2}, {1, 0}, {2, 0}, {2, 1}};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      g(i, i) = 1 + 2 * L[i] * (L[j] + L[k]) - L[j] * L[j] - L[k] * L[k];
      g(i, j) = L[i] * L[i] - 2 * L[i] * L[j];
      g(i, k) = L[i] * L[i] - 2 * L[i] * L[k];
    }
    for (int f = 0; f < 6; ++f) {
      const int i = pairs[f][0], j = pairs[f][1], k = 3 - i - j;
      g(3 + f, i) = 2 * L[i] * L[j] + 0.5 * L[j] * L[k];
      g(3 + f, j) = L[i] * L[i] + 0.5 * L[i] * L[k];
      g(3 + f, k) = 0.5 * L[i] * L[j];
    }
    return g;
  };
  C.setZero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto at_vertex = gradients(Vec3::Unit(i));
    C(i, 3 * i) = 1;
    C.block<9, 1>(0, 3 * i + 1) = at_vertex.col(j) - at_vertex.col(i);
    C.block<9, 1>(0, 3 * i + 2) = at_vertex.col(k) - at_vertex.col(i);
    const auto at_middle = gradients(middle_of_edge(i));
    C.block<9, 1>(0, 9 + i) = at_middle * (Vec3::Unit(i) - middle_of_edge(i));
    C(9 + i, 9 + i) = 0.25;  // ∂e_i/∂L_i = L_j L_k on edge i, and zero on the other two
  }
  const auto gold = batten_test::reference("z12_reference_tensors.json");
  const ReferenceTensors& T = reference_tensors(TriangleElement::Z12);
  const auto check = [&](int tensor, MatX expected, bool mixed) {
    if (mixed) expected += MatX(expected.transpose());
    const Mat12 S = Eigen::Map<const Mat12>(T.stiffness[tensor]);
    INFO("tensor " << tensor);
    CHECK(relative_error(C * S * C.transpose(), expected) < 1e-12);
  };
  check(0, matrix(gold["stretch"]["11"]), false);
  check(1, matrix(gold["stretch"]["12"]), true);
  check(2, matrix(gold["stretch"]["22"]), false);
  check(3, matrix(gold["bend"]["11_11"]), false);
  check(4, matrix(gold["bend"]["12_12"]), false);
  check(5, matrix(gold["bend"]["22_22"]), false);
  check(6, matrix(gold["bend"]["11_12"]), true);
  check(7, matrix(gold["bend"]["11_22"]), true);
  check(8, matrix(gold["bend"]["12_22"]), true);
  CHECK(relative_error(C * T.mass * C.transpose(), matrix(gold["mass"])) < 1e-12);
}

// --- the functions ------------------------------------------------------------------------------

TEST_CASE("positions, jets and reference dofs of many coordinates are the functions' sums",
          "[elements][c1_triangle]") {
  Draws draw(11);
  for (const TriangleElement kind : {TriangleElement::HCT, TriangleElement::Z12})
    for (int i = 0; i < 50; ++i) {
      const C1Triangle triangle(kind, draw.triangle());
      Eigen::Matrix<double, 12, 3> q;
      q << draw.dofs(), draw.dofs(), draw.dofs();
      CHECK((triangle.pull_back(q) - triangle.pull_back_matrix() * q).norm() < 1e-13);
      for (const Vec3& L : {draw.inside(), Vec3(1, 0, 0), Vec3(0.5, 0.5, 0)}) {
        const Eigen::Matrix<double, 3, kDerivatives> sum = q.transpose() * triangle.evaluate(L);
        CHECK((triangle.jet(L, q) - sum).norm() < 1e-12 * (1 + sum.norm()));
        CHECK((triangle.position(L, q) - sum.col(kW)).norm() < 1e-13 * (1 + sum.norm()));
      }
    }
}

TEST_CASE("each function is 1 in its own dof and 0 in the eleven others",
          "[elements][c1_triangle]") {
  Draws random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    for (const auto kind : kBothElements) {
      const C1Triangle element(kind, shape);
      Mat12 dofs;
      for (int i = 0; i < 3; ++i) {
        dofs.middleCols<3>(3 * i) = element.evaluate(Vec3::Unit(i)).leftCols<3>();
        dofs.col(9 + i) =
            element.evaluate(middle_of_edge(i)).middleCols<2>(kU) * edge_normal(shape, i);
      }
      INFO(name(kind) << ", triangle " << trial);
      CHECK((dofs - Mat12::Identity()).cwiseAbs().maxCoeff() < 1e-13);
    }
  }
}

TEST_CASE("both triangles hold all cubics with their derivatives, and not all quartics",
          "[elements][c1_triangle]") {
  Draws random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    for (const auto kind : kBothElements) {
      INFO(name(kind) << ", triangle " << trial);
      const C1Triangle element(kind, shape);
      double cubic = 0, quartic = 0;
      for (int sample = 0; sample < 5; ++sample) {
        const Vec3 L = random.inside();
        for (int a = 0; a <= 4; ++a)
          for (int b = 0; a + b <= 4; ++b) {
            const auto expected = monomial(shape.point(L), a, b);
            const auto found = surface_at(element, monomial_dofs(shape, a, b), L);
            double& worst = a + b < 4 ? cubic : quartic;
            worst = std::max(worst, (found - expected).cwiseAbs().maxCoeff());
          }
      }
      CHECK(cubic < 1e-11);
      CHECK(quartic > 1e-3);
    }
  }
}

TEST_CASE("derivatives are those of the functions, by central differences",
          "[elements][c1_triangle]") {
  Draws random(3);
  constexpr double step = 1e-6;
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    const Vec12 q = random.dofs();
    const Vec3 L = random.inside(0.03);
    const Vec2 p = shape.point(L);
    for (const auto kind : kBothElements) {
      INFO(name(kind) << ", triangle " << trial);
      const C1Triangle element(kind, shape);
      const auto at = [&](double u, double v) {
        return surface_at(element, q, shape.barycentric(p + Vec2(u, v)));
      };
      const Vec3 by_u = ((at(step, 0) - at(-step, 0)) / (2 * step)).head<3>();
      const Vec3 by_v = ((at(0, step) - at(0, -step)) / (2 * step)).head<3>();
      const auto here = surface_at(element, q, L);
      const double size = here.cwiseAbs().maxCoeff();
      CHECK(std::abs(by_u[kW] - here[kU]) < 1e-8 * size);
      CHECK(std::abs(by_v[kW] - here[kV]) < 1e-8 * size);
      CHECK(std::abs(by_u[kU] - here[kUU]) < 1e-7 * size);
      CHECK(std::abs(by_u[kV] - here[kUV]) < 1e-7 * size);
      CHECK(std::abs(by_v[kU] - here[kUV]) < 1e-7 * size);
      CHECK(std::abs(by_v[kV] - here[kVV]) < 1e-7 * size);
    }
  }
}

TEST_CASE("two triangles join with one tangent plane, whatever their kinds and vertex order",
          "[elements][c1_triangle]") {
  Draws random(4);
  double worst = 0, smallest_with_wrong_sign = 1;
  for (int trial = 0; trial < 50; ++trial) {
    // A convex quadrilateral around the origin, cut along 0-2, with random vertex numbers.
    std::vector<Vec2> corners;
    for (int k = 0; k < 4; ++k) {
      const double angle = 1.57 * k + random.between(-0.3, 0.3), r = random.between(0.6, 1.4);
      corners.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    std::vector<int> number{0, 1, 2, 3};
    std::shuffle(number.begin(), number.end(), random.engine);
    std::vector<Vec2> vertices(4);
    for (int k = 0; k < 4; ++k) vertices[number[k]] = corners[k];
    const int turn = static_cast<int>(random.engine() % 3);
    ParametricMesh::Triangle left{number[0], number[1], number[2]};
    ParametricMesh::Triangle right{number[2], number[3], number[0]};
    std::rotate(left.begin(), left.begin() + turn, left.end());
    const ParametricMesh mesh(vertices, {left, right});
    const DofMap dofs(mesh);
    const VecX q = VecX::NullaryExpr(dofs.count(), [&] { return random(); });
    const auto& edge = mesh.edges()[mesh.edge_between(number[0], number[2])];
    REQUIRE_FALSE(edge.boundary());

    for (const auto first : kBothElements)
      for (const auto second : kBothElements) {
        const TriangleElement kinds[2] = {first, second};
        for (const bool wrong_sign : {false, true}) {
          double jump = 0;
          for (int sample = 0; sample <= 10; ++sample) {
            Vec3 value[2];
            for (int side = 0; side < 2; ++side) {
              const int t = edge.triangle[side], i = edge.local[side];
              TriangleShape shape = mesh.shape(t);
              if (wrong_sign && side == 1) shape.edge_sign[i] *= -1;
              const int low = mesh.edge_sign(t, i) > 0 ? (i + 1) % 3 : (i + 2) % 3;
              Vec3 L = Vec3::Zero();
              L[low] = 1 - sample / 10.0;
              L[3 - i - low] = sample / 10.0;
              Vec12 local;
              const auto map = dofs.triangle(mesh, t);
              for (int a = 0; a < 12; ++a) local[a] = q[map[a]];
              value[side] = surface_at(C1Triangle(kinds[side], shape), local, L).head<3>();
            }
            jump = std::max(jump, (value[0] - value[1]).cwiseAbs().maxCoeff());
          }
          if (wrong_sign)
            smallest_with_wrong_sign = std::min(smallest_with_wrong_sign, jump);
          else
            worst = std::max(worst, jump);
        }
      }
  }
  CHECK(worst < 1e-12);
  CHECK(smallest_with_wrong_sign > 1e-3);  // the property fails with the wrong sign
}

TEST_CASE("HCT and Z12 have the same value and gradient on all three edges",
          "[elements][c1_triangle]") {
  Draws random(5);
  double edges = 0, interior = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    const Vec12 q = random.dofs();
    const C1Triangle hct(TriangleElement::HCT, shape), z12(TriangleElement::Z12, shape);
    const auto difference = [&](const Vec3& L) {
      return (surface_at(hct, q, L) - surface_at(z12, q, L)).head<3>().cwiseAbs().maxCoeff();
    };
    for (int i = 0; i < 3; ++i)
      for (int sample = 0; sample <= 8; ++sample) {
        Vec3 L = Vec3::Zero();
        L[(i + 1) % 3] = 1 - sample / 8.0;
        L[(i + 2) % 3] = sample / 8.0;
        edges = std::max(edges, difference(L));
      }
    interior = std::max(interior, difference(random.inside()));
  }
  CHECK(edges < 1e-12);
  CHECK(interior > 1e-4);  // the two elements differ
}

TEST_CASE("HCT is C1 across its spokes", "[elements][c1_triangle]") {
  Draws random(6);
  double worst = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    const C1Triangle element(TriangleElement::HCT, shape);
    const Vec12 q = random.dofs();
    for (int i = 0; i < 3; ++i) {
      const double s = random.between(0.35, 0.95);  // from the centroid (1/3) to vertex i (1)
      Vec3 L = Vec3::Constant((1 - s) / 2), aside = Vec3::Zero();
      L[i] = s;
      aside[(i + 1) % 3] = 1e-10;
      aside[(i + 2) % 3] = -1e-10;
      const auto one = surface_at(element, q, L + aside), other = surface_at(element, q, L - aside);
      worst = std::max(worst, (one - other).head<3>().cwiseAbs().maxCoeff());
    }
  }
  CHECK(worst < 1e-7);  // distance of the two points times second derivatives of about 100
}

TEST_CASE("Z12 at its vertices is finite, continuous and has the limit along the bisector",
          "[elements][c1_triangle]") {
  Draws random(7);
  for (int trial = 0; trial < 20; ++trial) {
    const TriangleShape shape = random.triangle();
    const C1Triangle element(TriangleElement::Z12, shape);
    for (int i = 0; i < 3; ++i) {
      const Tabulation vertex = element.evaluate(Vec3::Unit(i));
      REQUIRE(vertex.allFinite());
      for (const double r : {1e-6, 1e-9, 1e-11, 1e-13, 1e-16, 1e-300}) {
        INFO("distance " << r);
        Vec3 bisector = Vec3::Constant(r), edge = Vec3::Zero();
        bisector[i] = 1 - 2 * r;
        edge[i] = 1 - r;
        edge[(i + 1) % 3] = r;
        const Tabulation near = element.evaluate(bisector), on_edge = element.evaluate(edge);
        REQUIRE(near.allFinite());
        REQUIRE(on_edge.allFinite());
        const double size = vertex.cwiseAbs().maxCoeff();
        CHECK((near - vertex).leftCols<3>().cwiseAbs().maxCoeff() < 10 * (r + 1e-15) * size);
        CHECK((on_edge - vertex).leftCols<3>().cwiseAbs().maxCoeff() < 10 * (r + 1e-15) * size);
        CHECK((near - vertex).cwiseAbs().maxCoeff() < 20 * (r + 1e-5) * size);
      }
    }
  }
}

TEST_CASE("the Bezier ordinates of HCT are the same surface", "[elements][c1_triangle]") {
  Draws random(8);
  const int index[10][3] = {{3, 0, 0}, {0, 3, 0}, {0, 0, 3}, {2, 1, 0}, {1, 2, 0},
                            {0, 2, 1}, {0, 1, 2}, {1, 0, 2}, {2, 0, 1}, {1, 1, 1}};
  const double factorial[4] = {1, 1, 2, 6};
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    const C1Triangle element(TriangleElement::HCT, shape);
    Eigen::Matrix<double, 12, 3> q;
    q << random.dofs(), random.dofs(), random.dofs();
    for (int sub = 0; sub < 3; ++sub) {
      const auto net = element.bezier(sub, q);
      Vec3 local(random.between(0.05, 1), random.between(0.05, 1), random.between(0.05, 1));
      local /= local.sum();
      Vec3 L = Vec3::Constant(local[2] / 3), x = Vec3::Zero();
      L[(sub + 1) % 3] += local[0];
      L[(sub + 2) % 3] += local[1];
      for (int m = 0; m < 10; ++m) {
        double bernstein = 6;
        for (int v = 0; v < 3; ++v)
          bernstein *= power(local[v], index[m][v]) / factorial[index[m][v]];
        x += bernstein * net.row(m).transpose();
      }
      const Vec3 expected = q.transpose() * element.evaluate(L).col(kW);
      CHECK((x - expected).cwiseAbs().maxCoeff() < 1e-14);
    }
    // The control nets of two sub-triangles have the same bits in the row along their inner edge.
    for (int s = 0; s < 3; ++s) {
      const auto here = element.bezier(s, q), next = element.bezier((s + 1) % 3, q);
      const std::pair<int, int> shared[] = {{1, 0}, {5, 8}, {6, 7}, {2, 2}};
      for (const auto& [a, b] : shared) CHECK(here.row(a) == next.row(b));
    }
  }
  const C1Triangle rational(TriangleElement::Z12, gold_triangle());
  CHECK_THROWS_AS(rational.bezier(0, Eigen::Matrix<double, 12, 3>::Zero()), InputError);
}

// --- the matrices -------------------------------------------------------------------------------

TEST_CASE("stiffness, mass and load are the integrals of the functions",
          "[elements][c1_triangle]") {
  Draws random(9);
  for (int trial = 0; trial < 10; ++trial) {
    const TriangleShape shape = random.triangle();
    for (const auto kind : kBothElements) {
      INFO(name(kind) << ", triangle " << trial);
      const C1Triangle element(kind, shape);
      const Mat12 K = element.stiffness(anisotropic());
      CHECK(relative_error(K, stiffness_by_quadrature(
                                  kind, shape, [](const Vec3&) { return anisotropic(); })) < 1e-12);
      CHECK(relative_error(K, K.transpose()) < 1e-14);
      Mat12 M = Mat12::Zero();
      Vec12 F = Vec12::Zero();
      const TriangleRule rule = fine_rule(kind);
      for (long p = 0; p < rule.weights.size(); ++p) {
        const Vec12 N = element.evaluate(rule.L.row(p).transpose()).col(kW);
        M += shape.area * rule.weights[p] * N * N.transpose();
        F += shape.area * rule.weights[p] * N;
      }
      CHECK(relative_error(element.mass(), M) < 1e-12);
      CHECK(relative_error(element.load(), F) < 1e-12);
    }
  }
}

TEST_CASE("energies of polynomials are their integrals", "[elements][c1_triangle]") {
  // On the triangle (0,0), (1,0), (0,1): ∬ u^a v^b = a! b! / (a+b+2)!.
  const TriangleShape shape({0, 0}, {1, 0}, {0, 1}, {1, -1, 1});
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const C1Triangle element(kind, shape);
    const Vec12 u2 = monomial_dofs(shape, 2, 0), uv = monomial_dofs(shape, 1, 1),
                u3 = monomial_dofs(shape, 3, 0), one = monomial_dofs(shape, 0, 0);
    SurfaceStiffness m;
    m.beta << 5, 7, 11;
    const Mat12 K = element.stiffness(m);
    CHECK(u2.dot(K * u2) == Approx(5 * 4 * 0.5).epsilon(1e-12));
    CHECK(uv.dot(K * uv) == Approx(2 * 7 * 0.5).epsilon(1e-12));
    CHECK(u3.dot(K * u3) == Approx(5 * 36 / 12.0).epsilon(1e-12));
    CHECK(std::abs(u2.dot(K * uv)) < 1e-12);
    SurfaceStiffness stretch;
    stretch.beta.setZero();
    stretch.alpha << 2, 0.5, 0.5, 3;
    // uv: w_u = v, w_v = u.
    CHECK(uv.dot(element.stiffness(stretch) * uv) ==
          Approx((2 + 3) / 12.0 + 2 * 0.5 / 24).epsilon(1e-12));
    CHECK(one.dot(element.mass() * one) == Approx(0.5).epsilon(1e-14));
    CHECK(one.dot(element.mass() * u3) == Approx(6.0 / 120).epsilon(1e-12));
    CHECK(u2.dot(element.mass() * u3) == Approx(120.0 / 5040).epsilon(1e-12));
    CHECK(u3.dot(element.load()) == Approx(6.0 / 120).epsilon(1e-12));
  }
}

TEST_CASE("stretching costs nothing for constants only, bending for linear functions only",
          "[elements][c1_triangle]") {
  Draws random(10);
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    for (const auto kind : kBothElements) {
      INFO(name(kind) << ", triangle " << trial);
      const C1Triangle element(kind, shape);
      const auto check = [&](const Mat12& K, int zero_modes) {
        const VecX values = symmetric_eigenvalues(K);
        CHECK(std::abs(values[0]) < 1e-13 * values[11]);
        if (zero_modes > 0) CHECK(std::abs(values[zero_modes - 1]) < 1e-13 * values[11]);
        CHECK(values[zero_modes] > 1e-6 * values[11]);
      };
      const Mat12 stretching = element.stiffness(SurfaceStiffness::isotropic(1, 0));
      const Mat12 bending = element.stiffness(SurfaceStiffness::isotropic(0, 1));
      check(stretching, 1);
      check(bending, 3);
      const double size = bending.cwiseAbs().maxCoeff();
      CHECK((stretching * monomial_dofs(shape, 0, 0)).norm() < 1e-12 * size);
      CHECK((bending * monomial_dofs(shape, 0, 0)).norm() < 1e-12 * size);
      CHECK((bending * monomial_dofs(shape, 1, 0)).norm() < 1e-12 * size);
      CHECK((bending * monomial_dofs(shape, 0, 1)).norm() < 1e-12 * size);
      CHECK(symmetric_eigenvalues(element.mass())[0] > 0);
    }
  }
}

TEST_CASE("both triangles carry a constant load in the same way", "[elements][c1_triangle]") {
  Draws random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const TriangleShape shape = random.triangle();
    const Vec12 hct = C1Triangle(TriangleElement::HCT, shape).load();
    const Vec12 z12 = C1Triangle(TriangleElement::Z12, shape).load();
    CHECK(relative_error(hct, z12) < 1e-13);
    CHECK(std::abs(hct[0] + hct[3] + hct[6] - shape.area) < 1e-14);
    // ∬ E_i = s_i A/180 with s_i = ±4 altitude_i.
    for (int i = 0; i < 3; ++i) {
      const double altitude = 2 * shape.area / std::hypot(shape.b[i], shape.c[i]);
      CHECK(z12[9 + i] ==
            Approx(shape.edge_sign[i] * 4 * altitude * shape.area / 180).epsilon(1e-12));
    }
  }
}

// --- frames, scales, errors ---------------------------------------------------------------------

TEST_CASE("a rigid motion of the triangle moves the surface with it", "[elements][c1_triangle]") {
  Draws random(12);
  for (int trial = 0; trial < 20; ++trial) {
    const TriangleShape shape = random.triangle();
    const Mat2 R = Eigen::Rotation2Dd(3 * random()).toRotationMatrix();
    const Vec2 shift(random(), random());
    const TriangleShape moved(R * shape.vertex[0] + shift, R * shape.vertex[1] + shift,
                              R * shape.vertex[2] + shift, shape.edge_sign);
    const Vec12 q = random.dofs();
    Vec12 turned = q;
    for (int i = 0; i < 3; ++i) turned.segment<2>(3 * i + 1) = R * q.segment<2>(3 * i + 1);
    const Vec3 L = random.inside();
    const auto isotropic = SurfaceStiffness::isotropic(0.3, 1.2);
    for (const auto kind : kBothElements) {
      INFO(name(kind) << ", triangle " << trial);
      const C1Triangle before(kind, shape), after(kind, moved);
      const auto w = surface_at(before, q, L), x = surface_at(after, turned, L);
      const double size = w.cwiseAbs().maxCoeff();
      CHECK(std::abs(w[kW] - x[kW]) < 1e-13 * size);
      CHECK((R * w.segment<2>(kU) - x.segment<2>(kU)).norm() < 1e-13 * size);
      Mat2 H, G;
      H << w[kUU], w[kUV], w[kUV], w[kVV];
      G << x[kUU], x[kUV], x[kUV], x[kVV];
      CHECK((R * H * R.transpose() - G).norm() < 1e-13 * size);
      const double energy = q.dot(before.stiffness(isotropic) * q);
      CHECK(turned.dot(after.stiffness(isotropic) * turned) == Approx(energy).epsilon(1e-12));
    }
  }
}

TEST_CASE("a triangle of any size is the same triangle in other units", "[elements][c1_triangle]") {
  Draws random(13);
  for (const double scale : {1e8, 1e-8})
    for (int trial = 0; trial < 10; ++trial) {
      const TriangleShape shape = random.triangle();
      const TriangleShape scaled(scale * shape.vertex[0], scale * shape.vertex[1],
                                 scale * shape.vertex[2], shape.edge_sign);
      Vec12 unit = Vec12::Constant(1 / scale);  // q of the scaled triangle: slopes per length
      for (int i = 0; i < 3; ++i) unit[3 * i] = 1;
      const Vec12 q = random.dofs(), p = q.cwiseProduct(unit);
      const Vec3 L = random.inside();
      for (const auto kind : kBothElements) {
        INFO(name(kind) << ", scale " << scale);
        const C1Triangle before(kind, shape), after(kind, scaled);
        auto w = surface_at(before, q, L), x = surface_at(after, p, L);
        x.segment<2>(kU) *= scale;
        x.segment<3>(kUU) *= scale * scale;
        CHECK(relative_error(x, w) < 1e-13);
        const auto energy = [](const C1Triangle& t, const Vec12& d, double alpha, double beta) {
          return d.dot(t.stiffness(SurfaceStiffness::isotropic(alpha, beta)) * d);
        };
        CHECK(energy(after, p, 1, 0) == Approx(energy(before, q, 1, 0)).epsilon(1e-12));
        CHECK(scale * scale * energy(after, p, 0, 1) ==
              Approx(energy(before, q, 0, 1)).epsilon(1e-12));
        CHECK(p.dot(after.mass() * p) ==
              Approx(scale * scale * q.dot(before.mass() * q)).epsilon(1e-12));
        CHECK(p.dot(after.load()) == Approx(scale * scale * q.dot(before.load())).epsilon(1e-11));
      }
    }
}

TEST_CASE("barycentric coordinates and points are each other's inverse, outside too",
          "[elements][c1_triangle]") {
  Draws random(14);
  for (int trial = 0; trial < 50; ++trial) {
    const TriangleShape shape = random.triangle();
    const Vec2 p(3 * random(), 3 * random());
    const Vec3 L = shape.barycentric(p);
    CHECK(std::abs(L.sum() - 1) < 1e-13);
    CHECK((shape.point(L) - p).norm() < 1e-13);
    for (int i = 0; i < 3; ++i)
      CHECK((shape.barycentric(shape.vertex[i]) - Vec3::Unit(i)).norm() < 1e-14);
  }
}

TEST_CASE("triangles that are none are input errors", "[elements][c1_triangle]") {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  CHECK_NOTHROW(TriangleShape({0, 0}, {1, 0}, {0, 1}));
  CHECK_THROWS_AS(TriangleShape({0, 0}, {0, 1}, {1, 0}), InputError);  // clockwise
  CHECK_THROWS_AS(TriangleShape({0, 0}, {1, 1}, {2, 2}), InputError);  // on one line
  CHECK_THROWS_AS(TriangleShape({0, 0}, {0, 0}, {1, 0}), InputError);
  for (const double bad : {nan, inf, -inf}) {
    CHECK_THROWS_AS(TriangleShape({bad, 0}, {1, 0}, {0, 1}), InputError);
    CHECK_THROWS_AS(TriangleShape({0, 0}, {bad, 0}, {0, 1}), InputError);
    CHECK_THROWS_AS(TriangleShape({0, 0}, {1, 0}, {0, bad}), InputError);
  }
}
