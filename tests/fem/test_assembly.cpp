// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface_assembler.h"

#include "batten/fem/curve_assembler.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;

namespace {

// A square mesh with inner vertices moved by up to 20 %, and random numbering.
ParametricMesh shuffled_square(int n, unsigned seed) {
  const ParametricMesh square = ParametricMesh::unit_square(n);
  Random random(seed);
  std::vector<int> number(square.vertex_count());
  for (int v = 0; v < square.vertex_count(); ++v) number[v] = v;
  std::shuffle(number.begin(), number.end(), random.engine);
  std::vector<Vec2> vertices(number.size());
  for (int v = 0; v < square.vertex_count(); ++v) {
    Vec2 p = square.vertices()[v];
    for (int d = 0; d < 2; ++d)
      if (p[d] > 0 && p[d] < 1) p[d] += 0.2 / n * random();
    vertices[number[v]] = p;
  }
  std::vector<ParametricMesh::Triangle> triangles = square.triangles();
  for (auto& t : triangles) t = {number[t[0]], number[t[1]], number[t[2]]};
  std::shuffle(triangles.begin(), triangles.end(), random.engine);
  return {vertices, triangles};
}

MatX dense(const SparseMatrix& lower) {
  return SparseMatrix(lower.selfadjointView<Eigen::Lower>());
}

double energy(const SparseMatrix& lower, const VecX& q) {
  return q.dot(VecX(lower.selfadjointView<Eigen::Lower>() * q));
}

bool same_bits(const SparseMatrix& a, const SparseMatrix& b) {
  return a.nonZeros() == b.nonZeros() &&
         std::memcmp(a.valuePtr(), b.valuePtr(), sizeof(double) * a.nonZeros()) == 0;
}

bool same_bits(const Points& a, const Points& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

SurfaceStiffness anisotropic(double scale = 1) {
  SurfaceStiffness m;
  m.alpha << 1, 0.25, 0.25, 2;
  m.beta << 1, 0.5, 3;
  m.alpha *= scale;
  m.beta *= scale;
  return m;
}

std::vector<SurfaceStiffness> one_for_each(const ParametricMesh& mesh) {
  std::vector<SurfaceStiffness> materials;
  for (int t = 0; t < mesh.triangle_count(); ++t) materials.push_back(anisotropic(1 + t % 7));
  return materials;
}

}  // namespace

TEST_CASE("an assembled matrix is the sum of its elements' matrices, in the lower triangle",
          "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(4, 1);
  const DofMap dofs(mesh);
  const std::vector<SurfaceStiffness> materials = one_for_each(mesh);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    MatX constant = MatX::Zero(dofs.count(), dofs.count());
    MatX varying = constant, mass = constant;
    Points load = Points::Zero(dofs.count(), 3);
    const Vec3 f(1, -2, 3);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const C1Triangle element(kind, mesh.shape(t));
      const auto map = dofs.triangle(mesh, t);
      const Mat12 Kc = element.stiffness(anisotropic());
      const Mat12 Kv = element.stiffness(materials[t]), M = element.mass();
      const Vec12 F = element.load();
      for (int a = 0; a < 12; ++a) {
        load.row(map[a]) += F[a] * f.transpose();
        for (int b = 0; b < 12; ++b) {
          constant(map[a], map[b]) += Kc(a, b);
          varying(map[a], map[b]) += Kv(a, b);
          mass(map[a], map[b]) += M(a, b);
        }
      }
    }
    SparseMatrix K = assembler.pattern();
    assembler.stiffness(anisotropic(), K);
    CHECK(relative_error(dense(K), constant) < 1e-14);
    CHECK(same_bits(K, assembler.stiffness(anisotropic())));
    for (int j = 0; j < K.outerSize(); ++j)
      for (SparseMatrix::InnerIterator it(K, j); it; ++it) CHECK(it.row() >= j);
    assembler.stiffness(materials, K);  // overwrites old values
    CHECK(relative_error(dense(K), varying) < 1e-14);
    CHECK(relative_error(dense(assembler.mass()), mass) < 1e-14);
    CHECK(relative_error(assembler.load(f), load) < 1e-14);
  }
}

TEST_CASE("the mass of 1 is the area, and a constant load is the mass times 1", "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(5, 2);
  const VecX one = dofs_of(mesh, [](const Vec2&) { return Vec3(1, 0, 0); });
  const VecX u2v = dofs_of(mesh, [](const Vec2& p) {
    return Vec3(p.x() * p.x() * p.y(), 2 * p.x() * p.y(), p.x() * p.x());
  });
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    const SparseMatrix M = assembler.mass();
    CHECK(std::abs(energy(M, one) - 1) < 1e-14);
    CHECK(std::abs(energy(M, u2v) - 1.0 / 15) < 1e-14);
    const Vec3 f(2, -1, 0.5);
    const VecX total = M.selfadjointView<Eigen::Lower>() * one;
    CHECK(relative_error(assembler.load(f), total * f.transpose()) < 1e-13);
    CHECK(std::abs(u2v.dot(assembler.load(Vec3(1, 0, 0)).col(0)) - 1.0 / 6) < 1e-14);
  }
}

TEST_CASE("energies of global polynomials are their integrals over the square", "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(3, 3);
  const VecX uv2 = dofs_of(mesh, [](const Vec2& p) {
    return Vec3(p.x() * p.y() * p.y(), p.y() * p.y(), 2 * p.x() * p.y());
  });
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    SurfaceStiffness bend, stretch;
    bend.beta << 2, 3, 5;
    stretch.beta.setZero();
    stretch.alpha << 2, 0.5, 0.5, 3;
    // w = u v²: w_uv = 2v, w_vv = 2u.
    CHECK(energy(assembler.stiffness(bend), uv2) ==
          Approx(2 * 3 * 4 / 3.0 + 5 * 4 / 3.0).epsilon(1e-12));
    CHECK(energy(assembler.stiffness(stretch), uv2) ==
          Approx(2 / 5.0 + 2 * 0.5 * 2 / 8.0 + 3 * 4 / 9.0).epsilon(1e-12));
  }
}

TEST_CASE("one material given once, for each triangle, or as a function is the same material",
          "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(6, 4);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    const SparseMatrix constant = assembler.stiffness(anisotropic());
    SparseMatrix K = assembler.pattern();
    assembler.stiffness(std::vector<SurfaceStiffness>(mesh.triangle_count(), anisotropic()), K);
    CHECK(same_bits(K, constant));
    assembler.stiffness([](const Vec2&) { return anisotropic(); }, K);
    CHECK(relative_error(dense(K), dense(constant)) <
          (kind == TriangleElement::HCT ? 1e-13 : 5e-6));

    const Vec3 f(1, 2, 3);
    const Points varying = assembler.load([&](const Location&, const Vec2&) { return f; });
    CHECK(relative_error(varying, assembler.load(f)) <
          (kind == TriangleElement::HCT ? 1e-13 : 1e-6));
  }
}

TEST_CASE("a material that varies weights the energy where it is", "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(4, 5);
  const VecX half_u2 =
      dofs_of(mesh, [](const Vec2& p) { return Vec3(0.5 * p.x() * p.x(), p.x(), 0); });
  const VecX v = dofs_of(mesh, [](const Vec2& p) { return Vec3(p.y(), 0, 1); });
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const double tolerance = kind == TriangleElement::HCT ? 1e-12 : 1e-6;
    const SurfaceAssembler assembler(mesh, kind);
    SparseMatrix K = assembler.pattern();
    assembler.stiffness(
        [](const Vec2& p) { return SurfaceStiffness::isotropic(0, p.x() * p.x() + 3 * p.y()); }, K);
    CHECK(energy(K, half_u2) == Approx(1.0 / 3 + 1.5).epsilon(tolerance));
    assembler.stiffness(
        [](const Vec2& p) { return SurfaceStiffness::isotropic(p.x() * p.y() * p.y(), 0); }, K);
    CHECK(energy(K, v) == Approx(1.0 / 6).epsilon(tolerance));
  }
}

TEST_CASE("a varying load is evaluated at its position, and acts on the surface there",
          "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(4, 6);
  const VecX u3 = dofs_of(
      mesh, [](const Vec2& p) { return Vec3(p.x() * p.x() * p.x(), 3 * p.x() * p.x(), 0); });
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const SurfaceAssembler assembler(mesh, kind);
    std::vector<char> agree(mesh.triangle_count(), 1);
    const Points F = assembler.load([&](const Location& where, const Vec2& uv) {
      if ((mesh.shape(where.triangle).point(where.L) - uv).norm() > 1e-14)
        agree[where.triangle] = 0;
      return Vec3(uv.x(), uv.y() * uv.y(), 1);
    });
    CHECK(std::count(agree.begin(), agree.end(), 1) == mesh.triangle_count());
    const double tolerance = kind == TriangleElement::HCT ? 1e-12 : 1e-7;
    CHECK(u3.dot(F.col(0)) == Approx(1.0 / 5).epsilon(tolerance));
    CHECK(u3.dot(F.col(1)) == Approx(1.0 / 12).epsilon(tolerance));
    CHECK(u3.dot(F.col(2)) == Approx(1.0 / 4).epsilon(tolerance));

    // The work of a point force is force · displacement at its point.
    const Location where{7, Vec3(0.2, 0.5, 0.3)};
    const Vec2 p = mesh.shape(7).point(where.L);
    const Points P = assembler.point_load(where, Vec3(2, 0, -1));
    CHECK(u3.dot(P.col(0)) == Approx(2 * std::pow(p.x(), 3)).epsilon(1e-12));
    CHECK(P.col(1).norm() == 0);
    CHECK(u3.dot(P.col(2)) == Approx(-std::pow(p.x(), 3)).epsilon(1e-12));
  }
}

TEST_CASE("matrices and loads have the same bits on one, two and three threads",
          "[fem][assembly]") {
  const ThreadGuard guard;
  const ParametricMesh mesh = shuffled_square(32, 7);
  const std::vector<SurfaceStiffness> materials = one_for_each(mesh);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    std::vector<SparseMatrix> reference;
    std::vector<Points> reference_loads;
    for (const int threads : {1, 2, 3}) {
      set_thread_count(threads);
      const SurfaceAssembler assembler(mesh, kind);
      std::vector<SparseMatrix> matrices(4, assembler.pattern());
      assembler.stiffness(anisotropic(), matrices[0]);
      assembler.stiffness(materials, matrices[1]);
      assembler.stiffness(
          [](const Vec2& p) { return SurfaceStiffness::isotropic(p.x(), 1 + p.y()); }, matrices[2]);
      matrices[3] = assembler.mass();
      const std::vector<Points> loads{assembler.load(Vec3(1, 2, 3)),
                                      assembler.load([](const Location&, const Vec2& p) {
                                        return Vec3(std::sin(p.x()), p.y(), 1);
                                      })};
      if (threads == 1) {
        reference = matrices;
        reference_loads = loads;
      }
      for (size_t m = 0; m < matrices.size(); ++m) CHECK(same_bits(matrices[m], reference[m]));
      for (size_t l = 0; l < loads.size(); ++l) CHECK(same_bits(loads[l], reference_loads[l]));
    }
  }
  std::vector<double> parameters;
  CurveAssembler::Coefficient stiffness;
  for (int i = 0; i < 3000; ++i) {
    parameters.push_back(i + 0.3 * std::sin(i));
    if (i > 0) stiffness.emplace_back(2 + std::cos(i - 1), 2 + std::cos(i));
  }
  const CurveAssembler curve{CurveMesh(parameters)};
  SparseMatrix one = curve.pattern(), three = curve.pattern();
  set_thread_count(1);
  curve.stiffness(stiffness, stiffness, one);
  set_thread_count(3);
  curve.stiffness(stiffness, stiffness, three);
  CHECK(same_bits(one, three));
}

TEST_CASE("an exception in a material reaches the caller", "[fem][assembly]") {
  const ParametricMesh mesh = shuffled_square(24, 8);
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  SparseMatrix K = assembler.pattern();
  const SurfaceAssembler::MaterialField bad = [](const Vec2& p) {
    if (p.x() > 0.5) throw InputError("no material here");
    return SurfaceStiffness{};
  };
  CHECK_THROWS_AS(assembler.stiffness(bad, K), InputError);
}

TEST_CASE("wrong counts and foreign matrices are input errors", "[fem][assembly]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(2),
                       other = ParametricMesh::unit_square(3);
  const SurfaceAssembler assembler(mesh, TriangleElement::HCT);
  SparseMatrix K = assembler.pattern();
  CHECK_THROWS_AS(assembler.stiffness(std::vector<SurfaceStiffness>(7), K), InputError);
  SparseMatrix foreign = SurfaceAssembler(other, TriangleElement::HCT).pattern();
  CHECK_THROWS_AS(assembler.stiffness(SurfaceStiffness{}, foreign), InputError);
  SparseMatrix empty;
  CHECK_THROWS_AS(assembler.stiffness(SurfaceStiffness{}, empty), InputError);

  const CurveAssembler curve{CurveMesh({0, 1, 2, 3})};
  SparseMatrix C = curve.pattern();
  CHECK_THROWS_AS(curve.stiffness({1, 2}, {1}, C), InputError);
  CHECK_THROWS_AS(curve.mass({1, 2}), InputError);
  CHECK_THROWS_AS(curve.stiffness({1}, {}, C), InputError);
  CHECK_THROWS_AS(curve.load(Points::Zero(2, 3)), InputError);
}

// --- curves -------------------------------------------------------------------------------------

namespace {

// Solves K q = F with some dofs fixed at zero.
VecX solve_with_fixed(const SparseMatrix& K, const VecX& F, const std::vector<int>& fixed) {
  std::vector<int> free;
  for (int d = 0; d < K.rows(); ++d)
    if (std::find(fixed.begin(), fixed.end(), d) == fixed.end()) free.push_back(d);
  const MatX all = dense(K);
  const SparseMatrix A = MatX(all(free, free)).sparseView();
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(A));
  VecX q = VecX::Zero(K.rows());
  q(free) = cholesky.solve(VecX(F(free)));
  return q;
}

}  // namespace

TEST_CASE("an assembled curve is the sum of its segments, with coefficients linear between nodes",
          "[fem][assembly]") {
  const std::vector<double> u{-1, -0.2, 0.1, 1.5}, alpha{1, 2, 3, 5}, beta{4, 3, 2, 7};
  const CurveAssembler assembler{CurveMesh(u)};
  REQUIRE(assembler.mesh().dof_count() == 8);
  CurveAssembler::Coefficient stretching, bending;
  for (int s = 0; s < 3; ++s) {
    stretching.emplace_back(alpha[s], alpha[s + 1]);
    bending.emplace_back(beta[s], beta[s + 1]);
  }
  MatX expected = MatX::Zero(8, 8), mass = expected;
  Points load = Points::Zero(8, 3);
  Points f(4, 3);
  f << 1, 0, 2, -1, 3, 2, 0, 1, 2, 5, -2, 2;
  for (int s = 0; s < 3; ++s) {
    const HermiteSegment segment(u[s + 1] - u[s]);
    expected.block<4, 4>(2 * s, 2 * s) +=
        segment.stretching({alpha[s], alpha[s + 1]}) + segment.bending({beta[s], beta[s + 1]});
    mass.block<4, 4>(2 * s, 2 * s) += segment.mass();
    for (int c = 0; c < 3; ++c) load.block<4, 1>(2 * s, c) += segment.load({f(s, c), f(s + 1, c)});
  }
  SparseMatrix K = assembler.pattern();
  assembler.stiffness(stretching, bending, K);
  CHECK(relative_error(dense(K), expected) < 1e-15);
  CHECK(relative_error(dense(assembler.mass()), mass) < 1e-15);
  CHECK(relative_error(assembler.load(f), load) < 1e-15);
  // One value is used for every segment.
  assembler.stiffness(CurveAssembler::Coefficient(3, 2.0), CurveAssembler::Coefficient(3, 0.5), K);
  CHECK(relative_error(dense(assembler.stiffness({2}, {0.5})), dense(K)) < 1e-15);
}

TEST_CASE("beams and strings have the closed-form solutions at their nodes", "[fem][assembly]") {
  const std::vector<double> u{0, 0.13, 0.4, 0.55, 0.9, 1};
  const CurveAssembler assembler{CurveMesh(u)};
  const int last = assembler.mesh().dof_count() - 2;
  Points f = Points::Zero(6, 3);
  for (int i = 0; i < 6; ++i) f.row(i) << 1, u[i], 0;
  const Points F = assembler.load(f);

  // Clamped beam: cubic segments are exact at the nodes. f = 1: u²(1-u)²/24; f = u: below.
  const SparseMatrix bending = assembler.stiffness({0}, {2});
  const VecX uniform = solve_with_fixed(bending, F.col(0), {0, 1, last, last + 1});
  const VecX ramp = solve_with_fixed(bending, F.col(1), {0, 1, last, last + 1});
  // String: u(1-u)/2 is a polynomial of the space.
  const VecX string = solve_with_fixed(assembler.stiffness({3}, {0}), F.col(0), {0, last});
  for (int i = 0; i < 6; ++i) {
    const double x = u[i];
    CHECK(std::abs(2 * uniform[2 * i] - x * x * (1 - x) * (1 - x) / 24) < 1e-15);
    CHECK(std::abs(2 * uniform[2 * i + 1] - (2 * x - 6 * x * x + 4 * x * x * x) / 24) < 1e-14);
    CHECK(std::abs(2 * ramp[2 * i] - x * x * (x * x * x - 3 * x + 2) / 120) < 1e-15);
    CHECK(std::abs(3 * string[2 * i] - x * (1 - x) / 2) < 1e-14);
    CHECK(std::abs(3 * string[2 * i + 1] - (1 - 2 * x) / 2) < 1e-13);
  }
}
