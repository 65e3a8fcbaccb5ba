// SPDX-License-Identifier: MPL-2.0
// Laminates, offsets of the reference surface, temperatures, and failure criteria.
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/analysis/shell_assembler.h"
#include "batten/analysis/shell_stress.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

const ShellMaterial kCarbon = [] {
  ShellMaterial m = ShellMaterial::orthotropic(140e3, 10e3, 0.3, 5e3, 1.6e-9);
  m.expansion = {-0.5e-6, 30e-6};
  m.strength = {1500, 1200, 50, 250, 70};
  return m;
}();

std::vector<Ply> plies_of(const std::vector<double>& angles, double thickness = 0.125,
                          const ShellMaterial& material = kCarbon) {
  std::vector<Ply> plies;
  for (const double angle : angles) plies.push_back({material, thickness, angle * kDegree});
  return plies;
}

/// A flat rectangle a × b on n × n squares.
struct Rectangle {
  double a, b;
  Surface surface;
  ConstraintSet supports;

  Rectangle(double width, double height, int n)
      : a(width),
        b(height),
        surface(interpolated(std::make_shared<ParametricMesh>(ParametricMesh::unit_square(n)),
                             TriangleElement::HCT,
                             [=](const Vec2& p) {
                               SurfaceJet j{};
                               j.x = {width * p.x(), height * p.y(), 0};
                               j.x_u = {width, 0, 0};
                               j.x_v = {0, height, 0};
                               return j;
                             })),
        supports(surface.dof_map().count(), ConstraintSet::Kind::Coupled) {}

  void fix(int dof, int coordinate) {
    supports.add_coupled("support", {{dof, Vec3::Unit(coordinate)}}, 0);
  }
  int vertex_at(const Vec2& p) const {
    const auto& all = surface.mesh().vertices();
    for (size_t v = 0; v < all.size(); ++v)
      if ((all[v] - p).norm() < 1e-12) return static_cast<int>(v);
    return -1;
  }
  /// Fixes a coordinate on all four sides, or on those with u = 0, 1 (side 0) or v = 0, 1 (side 1).
  void fix_sides(int coordinate, const std::vector<int>& sides) {
    const DofMap& dofs = surface.dof_map();
    for (int v = 0; v < surface.mesh().vertex_count(); ++v)
      for (const int side : sides) {
        const double at = surface.mesh().vertices()[v][side];
        if (at != 0 && at != 1) continue;
        fix(dofs.vertex(v), coordinate);
        fix(dofs.vertex(v, 2 - side), coordinate);
      }
  }
  void fix_rigid_motion() {
    const DofMap& dofs = surface.dof_map();
    const int v = vertex_at({0, 0});
    for (int c = 0; c < 3; ++c) fix(dofs.vertex(v), c);
    fix(dofs.vertex(v, 1), 1);
    fix(dofs.vertex(v, 1), 2);
    fix(dofs.vertex(v, 2), 2);
  }
  /// Load vector of a pressure along z.
  Points pressure(const ShellAssembler& shell,
                  const std::function<double(double x, double y)>& p) const {
    Points load = Points::Zero(surface.dof_map().count(), 3);
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      std::optional<Mat12> pull_back;
      const auto dofs = surface.dof_map().triangle(surface.mesh(), t);
      shell.for_each_quadrature_point(
          t, [&](const ShellTriangle& triangle, const ReferenceTabulation& f, const ShellPoint&,
                 const Vec3& L, double area) {
            if (!pull_back) pull_back = triangle.pull_back_matrix();
            const Tabulation N = triangle.functions(*pull_back, f);
            const Vec3 x = surface.position({t, L});
            for (int k = 0; k < 12; ++k)
              load(dofs[static_cast<size_t>(k)], 2) += area * p(x.x(), x.y()) * N(k, kW);
          });
    }
    return load;
  }
  Points solve(const ShellAssembler& shell, const Points& load) const {
    return ConstrainedSolver(supports, shell.stiffness()).solve(load);
  }
  double deflection(const Points& q, const Vec2& p) const {
    return q(surface.dof_map().vertex(vertex_at(p)), 2);
  }
};

ShellTemperature uniform(const Surface& surface, double middle, double difference) {
  const VecX ones = VecX::Ones(surface.mesh().vertex_count());
  return {middle * ones, difference * ones};
}

ShellSection section_of(std::vector<Ply> plies) {
  return ShellSection::of_plies(std::move(plies), Vec3::UnitX());
}

}  // namespace

TEST_CASE("the integrals of laminates have the symmetries of their plies", "[analysis][laminate]") {
  const auto integrals = [](const std::vector<double>& angles) {
    return Laminate(plies_of(angles)).integrals();
  };
  const double size = kCarbon.Q.norm();
  CHECK(integrals({0, 45, -45, 90, 90, -45, 45, 0}).B.norm() < 1e-15 * size);
  CHECK(integrals({0, 90}).B.norm() > 1e-2 * size);
  // Three directions at equal angles are isotropic in the plane.
  const Mat3 A = integrals({0, 60, -60}).A;
  CHECK(A(0, 0) == Approx(A(1, 1)));
  CHECK(2 * A(2, 2) == Approx(A(0, 0) - A(0, 1)));
  CHECK(std::abs(A(0, 2)) + std::abs(A(1, 2)) < 1e-12 * size);
  // Balanced angle plies do not couple stretch and shear.
  CHECK(std::abs(integrals({30, -30}).A(0, 2)) < 1e-12 * size);
  // Half a turn changes nothing; a quarter exchanges the directions.
  CHECK((integrals({20}).A - integrals({200}).A).norm() < 1e-12 * size);
  CHECK(integrals({90}).A(0, 0) == Approx(kCarbon.Q(1, 1)));
  CHECK(integrals({90}).thermal[0][0] == Approx(kCarbon.thermal_stress()[1]));
  const Laminate laminate(plies_of({0, 30, 90}));
  Eigen::Matrix<double, 6, 6> stiffness;
  const SectionIntegrals& of = laminate.integrals();
  stiffness << of.A, of.B, of.B, of.D;
  CHECK((laminate.compliance() * stiffness - Eigen::Matrix<double, 6, 6>::Identity()).norm() <
        1e-10);
  CHECK(laminate.thickness() == Approx(0.375));
  CHECK(of.density == Approx(1.6e-9));
  CHECK_THROWS_WITH(Laminate({}), Contains("without plies"));
  CHECK_THROWS_WITH(Laminate({{kCarbon, 0, 0}}), Contains("ply 1"));
}

TEST_CASE("plies of one isotropic material are that material", "[analysis][laminate]") {
  const Rectangle plate(2, 1, 2);
  const ShellMaterial steel = ShellMaterial::isotropic(210e3, 0.3, 7.85e-9);
  const ShellAssembler one(plate.surface, {{steel, 0.3, Vec3::UnitX()}}),
      three(plate.surface, {section_of(plies_of({10, 50, 70}, 0.1, steel))});
  const SparseMatrix K = one.stiffness(), same = three.stiffness();
  CHECK((K - same).norm() < 1e-12 * K.norm());
  CHECK((one.mass() - three.mass()).norm() < 1e-12 * one.mass().norm());
}

TEST_CASE("the stresses of the plies have the section's resultants", "[analysis][laminate]") {
  Random random(5);
  const Rectangle plate(2, 1, 1);
  for (const double offset : {0.0, 0.5, -0.3}) {
    ShellSection section = section_of(plies_of({0, 30, 90, -45}));
    section.offset = offset;
    const ShellAssembler shell(plate.surface, {section});
    ShellTemperature temperature = uniform(plate.surface, 80, -20);
    Points q(plate.surface.dof_map().count(), 3);
    for (long i = 0; i < q.size(); ++i) q.data()[i] = 1e-3 * random();
    const ShellStresses stresses(shell, q, temperature);
    const Location where{0, {0.2, 0.3, 0.5}};
    const ShellStress at = stresses.raw(where);
    // Stresses are linear in each ply: Simpson's rule with the middle of the ply is exact.
    Mat3 forces = Mat3::Zero(), moments = Mat3::Zero();
    const double t = section.thickness;
    for (int k = 0; k < section.ply_count(); ++k) {
      const auto ply = section.ply(k);
      const double low = 2 * ply.bottom + 1e-9, high = 2 * ply.top - 1e-9;
      for (const auto& [height, weight] :
           {std::pair{low, 1.0}, std::pair{0.5 * (low + high), 4.0}, std::pair{high, 1.0}}) {
        const Mat3 part = weight / 6 * (ply.top - ply.bottom) * t * at.at(height);
        forces += part;
        moments += (height / 2 + offset) * t * part;
      }
    }
    CHECK((forces - at.forces).norm() < 1e-7 * at.forces.norm());
    CHECK((moments - at.moments).norm() < 1e-7 * at.moments.norm());
  }
}

TEST_CASE("a shell on its bottom surface bends like one on its middle", "[analysis][laminate]") {
  // The ends are free to move in the plane, so that only the reference surface differs.
  const double E = 1000, t = 0.1, L = 2;
  const auto bent = [&](double offset) {
    Rectangle strip(L, 0.5, 8);
    const DofMap& dofs = strip.surface.dof_map();
    for (int v = 0; v < strip.surface.mesh().vertex_count(); ++v)
      if (strip.surface.mesh().vertices()[v].x() == 0) {
        strip.fix(dofs.vertex(v), 2);
        strip.fix(dofs.vertex(v, 1), 2);
        strip.fix(dofs.vertex(v), 0);
      }
    const ParametricMesh& mesh = strip.surface.mesh();
    for (int e = 0; e < mesh.edge_count(); ++e)
      if (mesh.vertices()[mesh.edges()[e].low].x() == 0 &&
          mesh.vertices()[mesh.edges()[e].high].x() == 0)
        strip.fix(dofs.edge(e), 2);
    strip.fix(dofs.vertex(strip.vertex_at({0, 0})), 1);
    ShellSection section{ShellMaterial::isotropic(E, 0), t, Vec3::UnitX()};
    section.offset = offset;
    const ShellAssembler shell(strip.surface, {section});
    const Points q = strip.solve(shell, strip.pressure(shell, [](double, double) { return 1e-4; }));
    const ShellStresses stresses(shell, q);
    const double root = stresses.at({0, {1.0 / 3, 1.0 / 3, 1.0 / 3}}).at(1)(0, 0);
    return std::array{strip.deflection(q, {1, 0}), q(dofs.vertex(strip.vertex_at({1, 0})), 0),
                      root};
  };
  const auto middle = bent(0), bottom = bent(0.5);
  CHECK(middle[0] == Approx(1e-4 * std::pow(L, 4) / 8 / (E * t * t * t / 12)).epsilon(1e-5));
  CHECK(bottom[0] == Approx(middle[0]).epsilon(1e-5));
  CHECK(bottom[2] == Approx(middle[2]).epsilon(1e-5));
  // The bottom moves along x, by the slope times its distance from the middle.
  const double slope = 1e-4 * std::pow(L, 3) / 6 / (E * t * t * t / 12);
  CHECK(bottom[1] == Approx(slope * t / 2).epsilon(1e-5));
}

TEST_CASE("cross-ply and angle-ply plates have the deflections of Navier's solutions",
          "[analysis][laminate]") {
  const double a = 100, b = 80, q0 = 0.01;
  const double alpha = kPi / a, beta = kPi / b;
  const auto load = [&](double x, double y) {
    return q0 * std::sin(alpha * x) * std::sin(beta * y);
  };
  // The amplitudes of u, v, w from the stiffness of the trigonometric displacements, [Jones1999], 5.4.
  const auto amplitude = [&](const SectionIntegrals& of, double t, bool angle_ply) {
    const Mat3 A = t * of.A, B = t * t * of.B, D = t * t * t * of.D;
    const double T11 = A(0, 0) * alpha * alpha + A(2, 2) * beta * beta,
                 T12 = (A(0, 1) + A(2, 2)) * alpha * beta,
                 T22 = A(2, 2) * alpha * alpha + A(1, 1) * beta * beta,
                 T33 = D(0, 0) * std::pow(alpha, 4) +
                       2 * (D(0, 1) + 2 * D(2, 2)) * alpha * alpha * beta * beta +
                       D(1, 1) * std::pow(beta, 4);
    const double T13 = angle_ply
                           ? -(3 * B(0, 2) * alpha * alpha * beta + B(1, 2) * std::pow(beta, 3))
                           : -B(0, 0) * std::pow(alpha, 3),
                 T23 = angle_ply
                           ? -(B(0, 2) * std::pow(alpha, 3) + 3 * B(1, 2) * alpha * beta * beta)
                           : -B(1, 1) * std::pow(beta, 3);
    Mat3 T;
    T << T11, T12, T13, T12, T22, T23, T13, T23, T33;
    return Vec3(T.inverse() * Vec3(0, 0, q0))[2];
  };
  const auto middle = [&](const std::vector<double>& angles, bool angle_ply) {
    const ShellSection section = section_of(plies_of(angles));
    Rectangle plate(a, b, 16);
    plate.fix_sides(2, {0, 1});
    // Cross-ply: no displacement along the sides (S2); angle-ply: none across them (S3).
    plate.fix_sides(angle_ply ? 0 : 1, {0});
    plate.fix_sides(angle_ply ? 1 : 0, {1});
    const ShellAssembler shell(plate.surface, {section});
    const Points q = plate.solve(shell, plate.pressure(shell, load));
    return plate.deflection(q, {0.5, 0.5}) /
           amplitude(section.integrals(), section.thickness, angle_ply);
  };
  CHECK(middle({0, 90, 90, 0}, false) == Approx(1).epsilon(1e-3));
  CHECK(middle({0, 90}, false) == Approx(1).epsilon(1e-3));
  CHECK(middle({45, -45}, true) == Approx(1).epsilon(1e-3));
  CHECK(middle({-30, 30, -30, 30}, true) == Approx(1).epsilon(1e-3));
}

TEST_CASE("a heated bimetal strip has Timoshenko's curvature", "[analysis][laminate]") {
  ShellMaterial brass = ShellMaterial::isotropic(100e3, 0.3),
                steel = ShellMaterial::isotropic(200e3, 0.3);
  brass.expansion = {19e-6, 19e-6};
  steel.expansion = {11e-6, 11e-6};
  const double below = 0.4, above = 0.6, heat = 100;
  Rectangle strip(40, 10, 4);
  strip.fix_rigid_motion();
  const ShellAssembler shell(strip.surface, {section_of({{brass, below, 0}, {steel, above, 0}})});
  const ShellTemperature temperature = uniform(strip.surface, heat, 0);
  const Points q = strip.solve(shell, shell.thermal_load(temperature));
  const double m = below / above, n = 100e3 / 200e3, h = below + above;
  const double curvature = 6 * (11e-6 - 19e-6) * heat * (1 + m) * (1 + m) /
                           (h * (3 * (1 + m) * (1 + m) + (1 + m * n) * (m * m + 1 / (m * n))));
  // Both directions curve, w = -κ (x² + y²)/2.
  CHECK(strip.deflection(q, {1, 0}) == Approx(-curvature * 40 * 40 / 2).epsilon(1e-9));
  CHECK(strip.deflection(q, {0, 1}) == Approx(-curvature * 10 * 10 / 2).epsilon(1e-9));
  // Free of resultants, but not of stresses: their forces cancel.
  const ShellStresses stresses(shell, q, temperature);
  const ShellStress at = stresses.at({0, {0.3, 0.3, 0.4}});
  CHECK(at.forces.norm() < 1e-9 * at.at(1).norm());
  CHECK(at.largest_von_mises().value > 20);
  CHECK(stresses.peak().value == Approx(at.largest_von_mises().value).epsilon(1e-6));
}

TEST_CASE("free shells expand without stress, clamped ones have the stress E α T/(1 - ν)",
          "[analysis][laminate]") {
  const double E = 200e3, nu = 0.3, alpha = 12e-6, t = 0.5, heat = 50, difference = 30;
  ShellSection section{ShellMaterial::isotropic(E, nu), t, Vec3::UnitX()};
  section.material.expansion = {alpha, alpha};
  Rectangle free(40, 30, 3);
  free.fix_rigid_motion();
  for (const double offset : {0.0, 0.5}) {
    section.offset = offset;
    const ShellAssembler shell(free.surface, {section});
    const ShellTemperature temperature = uniform(free.surface, heat, difference);
    const Points q = free.solve(shell, shell.thermal_load(temperature));
    const int corner = free.surface.dof_map().vertex(free.vertex_at({1, 0}));
    CHECK(q(corner, 0) == Approx(40 * alpha * (heat - offset * difference)).epsilon(1e-8));
    // The top is warmer: the middle of the plate rises between its ends, w = -κ x²/2.
    CHECK(q(corner, 2) == Approx(-alpha * difference / t * 40 * 40 / 2).epsilon(1e-8));
    const ShellStresses stresses(shell, q, temperature);
    CHECK(stresses.peak().value < 1e-8 * E * alpha * heat);
    CHECK(stresses.energy_norm_error() == 0);
  }
  section.offset = 0;
  const ShellAssembler shell(free.surface, {section});
  const ShellTemperature temperature = uniform(free.surface, heat, difference);
  const Points none = Points::Zero(free.surface.dof_map().count(), 3);
  const ShellStresses stresses(shell, none, temperature);
  const auto stress_at = [&](double height) {
    return stresses.at({0, {0.2, 0.2, 0.6}}).at(height)(0, 0);
  };
  for (const double height : {-1.0, 0.0, 1.0})
    CHECK(stress_at(height) ==
          Approx(-E * alpha / (1 - nu) * (heat + height / 2 * difference)).epsilon(1e-9));
  // The energy of the prevented strains: E α²/(1 - ν) (T² + ΔT²/12) per volume.
  CHECK(stresses.energy() == Approx(40 * 30 * t * E * alpha * alpha / (1 - nu) *
                                    (heat * heat + difference * difference / 12))
                                 .epsilon(1e-9));
}

TEST_CASE("a heated plate between rigid edges buckles at 4 π² D/b² on all sides",
          "[analysis][laminate]") {
  // Equal compression in both directions: N = E t α T/(1 - ν) = 2 π² D/a² at buckling.
  const double E = 200e3, nu = 0.3, alpha = 1e-5, t = 0.5, a = 100;
  ShellSection section{ShellMaterial::isotropic(E, nu), t, Vec3::UnitX()};
  section.material.expansion = {alpha, alpha};
  const Rectangle plate(a, a, 8);
  const ShellAssembler shell(plate.surface, {section});
  const ShellTemperature temperature = uniform(plate.surface, 1, 0);
  const Points none = Points::Zero(plate.surface.dof_map().count(), 3);
  const SparseMatrix G = shell.geometric_stiffness(none, temperature);
  // Energies of the buckling mode w = sin sin, interpolated.
  const Surface mode =
      interpolated(std::make_shared<ParametricMesh>(ParametricMesh::unit_square(8)),
                   TriangleElement::HCT, [](const Vec2& p) {
                     SurfaceJet j{};
                     const double x = kPi * p.x(), y = kPi * p.y();
                     j.x = {0, 0, std::sin(x) * std::sin(y)};
                     j.x_u = {0, 0, kPi * std::cos(x) * std::sin(y)};
                     j.x_v = {0, 0, kPi * std::sin(x) * std::cos(y)};
                     return j;
                   });
  const VecX w = mode.dofs().col(2);
  const double released = -w.dot(G.selfadjointView<Eigen::Lower>() * w);
  const Points q = mode.dofs();
  const VecX x = Eigen::Map<const VecX>(q.data(), q.size());
  const double bending = x.dot(shell.stiffness().selfadjointView<Eigen::Lower>() * x);
  const double D = E * t * t * t / (12 * (1 - nu * nu));
  CHECK(bending / released ==
        Approx(2 * kPi * kPi * D / (a * a) / (E * t * alpha / (1 - nu))).epsilon(2e-3));
}

TEST_CASE("failure criteria give the strengths back, and scale with the stress",
          "[analysis][laminate]") {
  const PlyStrength s{1500, 1200, 50, 250, 70};
  for (const FailureCriterion criterion : {FailureCriterion::TsaiHill, FailureCriterion::Hoffman}) {
    CHECK(reserve_factor(criterion, s, {1500, 0, 0}) == Approx(1));
    CHECK(reserve_factor(criterion, s, {-1200, 0, 0}) == Approx(1));
    CHECK(reserve_factor(criterion, s, {0, 50, 0}) == Approx(1));
    CHECK(reserve_factor(criterion, s, {0, -250, 0}) == Approx(1));
    CHECK(reserve_factor(criterion, s, {0, 0, -70}) == Approx(1));
    CHECK(std::isinf(reserve_factor(criterion, s, Vec3::Zero())));
    const Vec3 stress(300, -20, 25);
    const double factor = reserve_factor(criterion, s, stress);
    CHECK(reserve_factor(criterion, s, factor * stress) == Approx(1));
    CHECK(reserve_factor(criterion, s, 2 * stress) == Approx(factor / 2));
  }
  // Tsai-Hill by hand: (0.2² - 300 (-20)/1500² + 0.08² + (25/70)²)^-1/2.
  CHECK(reserve_factor(FailureCriterion::TsaiHill, s, {300, -20, 25}) ==
        Approx(1 / std::sqrt(0.04 + 6000.0 / (1500.0 * 1500) + 0.0064 + 625.0 / 4900)));
  ShellMaterial broken = kCarbon;
  broken.strength->shear = 0;
  CHECK_THROWS_WITH(require_material(broken), Contains("strength"));
}

TEST_CASE("the weakest ply and the place of the smallest reserve factor are found",
          "[analysis][laminate]") {
  // Tension along 0° in a cross-ply: the 90° plies fail first.
  const Rectangle plate(40, 20, 2);
  const ShellAssembler shell(plate.surface, {section_of(plies_of({0, 90, 0}))});
  Points stretch = plate.surface.dofs();
  stretch.col(0) *= 2e-3;
  stretch.rightCols(2).setZero();
  const ShellStresses stresses(shell, stretch);
  const auto reserve = stresses.smallest_reserve_factor(FailureCriterion::TsaiHill);
  REQUIRE(reserve);
  CHECK(reserve->ply == 1);
  const Vec3 across = kCarbon.Q * Vec3(0, 2e-3, 0);
  CHECK(reserve->factor ==
        Approx(reserve_factor(FailureCriterion::TsaiHill, *kCarbon.strength, across)));
  const ShellAssembler steel(plate.surface, {{ShellMaterial::isotropic(1, 0), 1}});
  CHECK(!ShellStresses(steel, stretch).smallest_reserve_factor(FailureCriterion::Hoffman));
}
