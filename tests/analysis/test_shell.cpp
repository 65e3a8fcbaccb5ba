// SPDX-License-Identifier: MPL-2.0
// Kirchhoff-Love shells on C1 triangles: properties of the element, and the obstacle course.
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/analysis/shell_assembler.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;

using Shape = std::function<SurfaceJet(const Vec2&)>;

SurfaceJet cylinder(const Vec2& p, double R, double angle, double length) {
  const double a = angle * p.x(), s = std::sin(a), c = std::cos(a);
  SurfaceJet j{};
  j.x = {R * s, R * c, length * p.y()};
  j.x_u = angle * R * Vec3(c, -s, 0);
  j.x_v = {0, 0, length};
  return j;
}

SurfaceJet sphere(const Vec2& p, double R, double top) {
  const double a = pi / 2 * p.x(), b = top * p.y();
  SurfaceJet j{};
  j.x = R * Vec3(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b));
  j.x_u = pi / 2 * R * Vec3(-std::cos(b) * std::sin(a), std::cos(b) * std::cos(a), 0);
  j.x_v = top * R * Vec3(-std::sin(b) * std::cos(a), -std::sin(b) * std::sin(a), std::cos(b));
  return j;
}

// A quarter or an eighth of a shell over the unit square, with supports along its sides.
struct Part {
  Surface surface;
  ConstraintSet supports;

  Part(const Shape& shape, int n, TriangleElement kind)
      : surface(interpolated(std::make_shared<ParametricMesh>(ParametricMesh::unit_square(n)), kind,
                             shape)),
        supports(surface.dof_map().count(), ConstraintSet::Kind::Coupled) {}

  void fix(int dof, int coordinate) {
    supports.add_coupled("support", {{dof, Vec3::Unit(coordinate)}}, 0);
  }
  // Visits vertices and edges on the side u = at (side 0) or v = at (side 1).
  template <class Vertex, class Edge>
  void along(int side, double at, const Vertex& vertex, const Edge& edge) const {
    const ParametricMesh& mesh = surface.mesh();
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (mesh.vertices()[v][side] == at) vertex(v);
    for (int e = 0; e < mesh.edge_count(); ++e) {
      const auto& edge_of = mesh.edges()[e];
      if (mesh.vertices()[edge_of.low][side] == at && mesh.vertices()[edge_of.high][side] == at)
        edge(e);
    }
  }
  // The plane through the side is perpendicular to a coordinate axis.
  void symmetry(int side, double at, int normal) {
    const DofMap& dofs = surface.dof_map();
    along(
        side, at,
        [&](int v) {
          for (int c = 0; c < 3; ++c) {
            if (c == normal) fix(dofs.vertex(v), c);
            fix(dofs.vertex(v, c == normal ? 2 - side : 1 + side), c);
          }
        },
        [&](int e) {
          for (int c = 0; c < 3; ++c)
            if (c != normal) fix(dofs.edge(e), c);
        });
  }
  // A diaphragm, rigid in its plane and flexible out of it, perpendicular to a coordinate axis.
  void diaphragm(int side, double at, int normal) {
    const DofMap& dofs = surface.dof_map();
    along(
        side, at,
        [&](int v) {
          for (int c = 0; c < 3; ++c)
            if (c != normal) {
              fix(dofs.vertex(v), c);
              fix(dofs.vertex(v, 2 - side), c);
            }
        },
        [](int) {});
  }
  int vertex_at(const Vec2& p) const {
    const auto& all = surface.mesh().vertices();
    for (size_t v = 0; v < all.size(); ++v)
      if ((all[v] - p).norm() < 1e-12) return static_cast<int>(v);
    return -1;
  }
  Vec3 displacement(const Points& q, const Vec2& p) const {
    return q.row(surface.dof_map().vertex(vertex_at(p)));
  }
};

double scordelis_lo(int n, TriangleElement kind) {
  Part p([](const Vec2& uv) { return cylinder(uv, 25, 40 * degree, 25); }, n, kind);
  p.symmetry(0, 0, 0);
  p.symmetry(1, 0, 2);
  p.diaphragm(1, 1, 2);
  const ShellAssembler shell(p.surface, {{ShellMaterial::isotropic(4.32e8, 0), 0.25}});
  const SurfaceAssembler loads(p.surface.mesh(), kind);
  const Points F = loads.area_load(p.surface) * Eigen::RowVector3d(0, -90, 0);
  const Points q = ConstrainedSolver(p.supports, shell.stiffness()).solve(F);
  return -p.displacement(q, {1, 0}).y();
}

double pinched_cylinder(int n, TriangleElement kind) {
  Part p([](const Vec2& uv) { return cylinder(uv, 300, pi / 2, 300); }, n, kind);
  p.symmetry(0, 0, 0);
  p.symmetry(0, 1, 1);
  p.symmetry(1, 0, 2);
  p.diaphragm(1, 1, 2);
  const ShellAssembler shell(p.surface, {{ShellMaterial::isotropic(3e6, 0.3), 3}});
  Points F = Points::Zero(p.surface.dof_map().count(), 3);
  F(p.surface.dof_map().vertex(p.vertex_at({0, 0})), 1) = -0.25;
  const Points q = ConstrainedSolver(p.supports, shell.stiffness()).solve(F);
  return -p.displacement(q, {0, 0}).y();
}

double hemisphere(int n, TriangleElement kind) {
  Part p([](const Vec2& uv) { return sphere(uv, 10, 72 * degree); }, n, kind);
  p.symmetry(0, 0, 1);
  p.symmetry(0, 1, 0);
  const int at_x = p.vertex_at({0, 0}), at_y = p.vertex_at({1, 0});
  p.fix(p.surface.dof_map().vertex(at_x), 2);
  const ShellAssembler shell(p.surface, {{ShellMaterial::isotropic(6.825e7, 0.3), 0.04}});
  Points F = Points::Zero(p.surface.dof_map().count(), 3);
  F(p.surface.dof_map().vertex(at_x), 0) = 1;
  F(p.surface.dof_map().vertex(at_y), 1) = -1;
  const Points q = ConstrainedSolver(p.supports, shell.stiffness()).solve(F);
  return p.displacement(q, {0, 0}).x();
}

Surface bumpy(TriangleElement kind, int n = 3) {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(n, 5));
  return interpolated(mesh, kind, [](const Vec2& p) {
    SurfaceJet j{};
    j.x = {p.x() + 0.2 * p.y() * p.y(), p.y(), 0.5 * p.x() * p.x() - 0.3 * p.x() * p.y()};
    j.x_u = {1, 0, p.x() - 0.3 * p.y()};
    j.x_v = {0.4 * p.y(), 1, -0.3 * p.x()};
    return j;
  });
}

VecX stacked(const Points& q) { return Eigen::Map<const VecX>(q.data(), q.size()); }

}  // namespace

TEST_CASE("a shell moves freely in six ways, and no strain comes of that", "[analysis][shell]") {
  for (const TriangleElement kind : kBothElements) {
    INFO(name(kind));
    const Surface surface = bumpy(kind);
    const ShellAssembler shell(surface, {{ShellMaterial::isotropic(200, 0.3), 0.05}});
    const SparseMatrix K = shell.stiffness();
    const double size = K.coeffs().abs().maxCoeff();
    VecX ones = VecX::Zero(surface.dof_map().count());
    for (int v = 0; v < surface.mesh().vertex_count(); ++v) ones[3 * v] = 1;
    for (int c = 0; c < 3; ++c) {
      const Points shift = ones * Vec3::Unit(c).transpose();
      Points turn(surface.dofs().rows(), 3);
      for (long d = 0; d < turn.rows(); ++d)
        turn.row(d) = Vec3::Unit(c).cross(Vec3(surface.dofs().row(d))).transpose();
      for (const Points& rigid : {shift, turn}) {
        const VecX r = K.selfadjointView<Eigen::Lower>() * stacked(rigid);
        CHECK(r.cwiseAbs().maxCoeff() < 1e-13 * size);
        const ShellStrain s = shell.strain(rigid, {4, Vec3(0.2, 0.3, 0.5)});
        CHECK(s.membrane.norm() < 1e-13);
        CHECK(s.curvature.norm() < 1e-12);
      }
    }
    const MatX dense = SparseMatrix(K.selfadjointView<Eigen::Lower>());
    const VecX values = symmetric_eigenvalues(dense);
    CHECK(values.head(6).cwiseAbs().maxCoeff() < 1e-14 * values.maxCoeff());
    CHECK(values[6] > 1e-11 * values.maxCoeff());
  }
}

TEST_CASE("the matrix is the energy of the strains", "[analysis][shell]") {
  Random random(3);
  for (const TriangleElement kind : kBothElements) {
    const Surface surface = bumpy(kind, 2);
    const ShellSection section{ShellMaterial::orthotropic(120, 10, 0.3, 5), 0.08, {1, 1, 0}};
    const ShellAssembler shell(surface, {section});
    Points q(surface.dof_map().count(), 3);
    for (long i = 0; i < q.size(); ++i) q.data()[i] = random();
    const TriangleRule rule =
        kind == TriangleElement::HCT ? split_triangle_rule(8) : six_duffy_rule(10);
    double energy = 0;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t)
      for (long p = 0; p < rule.weights.size(); ++p) {
        const Location at{t, rule.L.row(p)};
        const ShellStrain s = shell.strain(q, at);
        const auto r = shell.resultants(q, at);
        const ShellPoint point = shell.point(at);
        energy += rule.weights[p] * surface.mesh().shape(t).area * point.jacobian() *
                  (s.membrane.dot(r.forces) + s.curvature.dot(r.moments));
        // The stress integrated through the thickness equals the resultants.
        CHECK((0.5 * 0.08 * (shell.stress(q, at, 0.04) + shell.stress(q, at, -0.04)) - r.forces)
                  .norm() < 1e-12 * r.forces.norm());
        CHECK(std::abs(point.e1().dot(point.normal())) < 1e-14);
        CHECK(point.e1().cross(point.e2()).dot(point.normal()) == Approx(1));
      }
    const VecX x = stacked(q);
    CHECK(x.dot(shell.stiffness().selfadjointView<Eigen::Lower>() * x) ==
          Approx(energy).epsilon(1e-3));
  }
}

TEST_CASE("the obstacle course agrees with the reference numbers", "[analysis][shell]") {
  const TriangleElement HCT = TriangleElement::HCT, Z12 = TriangleElement::Z12;
  CHECK(scordelis_lo(4, HCT) == Approx(0.298672).epsilon(2e-4));
  CHECK(scordelis_lo(8, HCT) == Approx(0.30050631).epsilon(2e-5));
  CHECK(scordelis_lo(8, Z12) == Approx(0.30050681).epsilon(2e-5));
  CHECK(scordelis_lo(16, HCT) == Approx(0.30058928).epsilon(1e-6));
  CHECK(pinched_cylinder(8, HCT) == Approx(1.5859904e-5).epsilon(2e-3));
  CHECK(pinched_cylinder(16, HCT) == Approx(1.7720662e-5).epsilon(2e-3));
  CHECK(hemisphere(8, HCT) == Approx(0.088698191).epsilon(2e-3));
  CHECK(hemisphere(16, HCT) == Approx(0.093257167).epsilon(2e-3));
}

TEST_CASE("the wall of a cylinder under pressure carries p R around, better with each refinement",
          "[analysis][shell]") {
  const double R = 2, t = 0.01, p = 3;
  double last = 1;
  for (const int n : {4, 8, 16}) {
    Part part([&](const Vec2& uv) { return cylinder(uv, R, pi / 2, 1); }, n, TriangleElement::HCT);
    part.symmetry(0, 0, 0);
    part.symmetry(0, 1, 1);
    part.symmetry(1, 0, 2);
    const ShellAssembler shell(part.surface, {{ShellMaterial::isotropic(1000, 0), t}});
    const SurfaceAssembler loads(part.surface.mesh(), TriangleElement::HCT);
    Points F = p * loads.pressure_load(part.surface.dofs());
    if (shell.point({0, Vec3::Constant(1.0 / 3)}).normal().y() < 0) F = -F;  // outwards
    const Points q = ConstrainedSolver(part.supports, shell.stiffness()).solve(F);
    double worst = 0;
    for (int k = 0; k < part.surface.mesh().triangle_count(); ++k)
      for (int sub = 0; sub < 3; ++sub) {
        const Location at{k, (Vec3::Constant(4) - 3 * Vec3::Unit(sub)) / 9};
        worst = std::max(worst, std::abs(shell.resultants(q, at).forces[0] / (p * R) - 1));
      }
    CHECK(worst < last / 3);
    last = worst;
  }
  CHECK(last < 2e-5);
}

TEST_CASE("rows on a shell that mix x, y and z hold, and equal a saddle point system",
          "[analysis][shell]") {
  const Surface surface = bumpy(TriangleElement::HCT, 2);
  const int n = surface.dof_map().count();
  const ShellAssembler shell(surface, {{ShellMaterial::isotropic(100, 0.3), 0.1}});
  const SparseMatrix K = shell.stiffness();
  ConstraintSet set(n, ConstraintSet::Kind::Coupled);
  Random random(8);
  for (int v = 0; v < 4; ++v) set.fix("points", 3 * v, random.point());
  for (int k = 0; k < 5; ++k)
    set.add_coupled("rows", {{20 + k, random.point()}, {12 + k, random.point()}}, random());
  Points F(n, 3);
  for (long i = 0; i < F.size(); ++i) F.data()[i] = random();
  const Points q = ConstrainedSolver(set, K).solve(F);
  CHECK(set.max_residual(q) < 1e-12);
  const Points expected = solve_kkt(set, K, F);
  CHECK((q - expected).cwiseAbs().maxCoeff() < 1e-8 * expected.cwiseAbs().maxCoeff());
  // Reactions and loads are in equilibrium.
  const Points reaction = reaction_forces(K, q, F);
  Vec3 sum = Vec3::Zero();
  for (int v = 0; v < surface.mesh().vertex_count(); ++v)
    sum += Vec3(reaction.row(3 * v) + F.row(3 * v));
  CHECK(sum.norm() < 1e-9 * F.norm());
}

TEST_CASE("an orthotropic material with equal moduli is isotropic, whatever its direction",
          "[analysis][shell]") {
  const Surface surface = bumpy(TriangleElement::HCT);
  const double E = 70, nu = 0.33;
  const SparseMatrix K =
      ShellAssembler(surface, {{ShellMaterial::isotropic(E, nu), 0.02}}).stiffness();
  const SparseMatrix other =
      ShellAssembler(
          surface, {{ShellMaterial::orthotropic(E, E, nu, E / (2 * (1 + nu))), 0.02, {1, -2, 0.5}}})
          .stiffness();
  CHECK((K - other).norm() < 1e-13 * K.norm());
}

TEST_CASE("the same bits on one thread and on two, and the same from one section or many",
          "[analysis][shell]") {
  const Surface surface = bumpy(TriangleElement::HCT, 20);
  const ShellSection section{ShellMaterial::isotropic(70, 0.3), 0.02};
  const SparseMatrix K = ShellAssembler(surface, {section}).stiffness();
  const ThreadGuard one(1);
  const std::vector<ShellSection> many(static_cast<size_t>(surface.mesh().triangle_count()),
                                       section);
  CHECK((K - ShellAssembler(surface, many).stiffness()).norm() == 0);
}

TEST_CASE("an invalid shell is refused with the reason", "[analysis][shell]") {
  const Surface surface = bumpy(TriangleElement::HCT);
  const ShellMaterial steel = ShellMaterial::isotropic(210000, 0.3);
  CHECK_THROWS_WITH(ShellMaterial::isotropic(-1, 0.3),
                    Contains("E = -1, expected a number above 0"));
  CHECK_THROWS_WITH(ShellMaterial::isotropic(1, 0.5), Contains("nu = 0.5"));
  CHECK_THROWS_WITH(ShellMaterial::isotropic(1, NAN), Contains("nu = nan"));
  CHECK_THROWS_WITH(ShellMaterial::isotropic(1, 0.3, -1), Contains("density = -1"));
  CHECK_THROWS_WITH(ShellMaterial::orthotropic(1, 100, 0.3, 1), Contains("nu12² below E1/E2"));
  CHECK_THROWS_WITH(ShellAssembler(surface, {{steel, 0}}), Contains("thickness = 0"));
  CHECK_THROWS_WITH(ShellAssembler(surface, {{steel, NAN}}), Contains("thickness = nan"));
  CHECK_THROWS_WITH(ShellAssembler(surface, {{ShellMaterial{}, 1}}), Contains("positive definite"));
  CHECK_THROWS_WITH(ShellAssembler(surface, {{steel, 1}, {steel, 1}}),
                    Contains("2 shell sections for 18"));
  const Surface point(surface.shared_mesh(), TriangleElement::HCT,
                      Points::Zero(surface.dofs().rows(), 3));
  CHECK_THROWS_WITH(ShellAssembler(point, {{steel, 1}}).stiffness(),
                    Contains("singular at (0, 0, 0)"));
}
