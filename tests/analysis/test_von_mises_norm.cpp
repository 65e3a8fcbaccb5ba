// SPDX-License-Identifier: MPL-2.0
// The P-norm of the von Mises stress, its gradient, and the derivatives of a shell's quantities with
// respect to its shape.
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "batten/analysis/models/shell_sensitivities.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A curved strip, clamped at its foot, with a line force at its tip.
struct Arch {
  std::shared_ptr<const ModelLayout> layout;
  Points shape;

  static ModelLayout made() {
    Plates plates;
    plates.h = plates.builder.options.edge_length = 0.25;
    plates.across("foot", {0, 0, 0}, {0, 0, 0});
    plates.across("tip", {1, 0, 0}, {1, 0, 0});
    plates.plate("foot", "tip");
    return plates.builder.model({});
  }
  Arch()
      : layout(std::make_shared<const ModelLayout>(made())),
        shape(layout->minimize_energy(SurfaceStiffness::isotropic(0, 1))) {
    for (long m = 0; m < shape.rows(); ++m)
      shape(m, 2) += 0.3 * shape(m, 0) + 0.1 * std::sin(7.0 * static_cast<double>(m)) * 0.02;
  }
  static ShellProblem problem() {
    return {[](const ModelLayout&, const Points&) {
              return ShellDefinition{{{ShellMaterial::isotropic(Plates::E, 0.3, 2.0), Plates::t}},
                                     {LineSupport::clamped("foot")},
                                     {},
                                     {}};
            },
            [](const ModelLayout& layout, const Points& shape, const ShellDefinition&) {
              return std::vector<ShellLoadCase>{
                  {"tip", line_force(layout, shape, "tip", {1e-4, 2e-4, -1e-4})},
                  {"wind", surface_traction(layout, shape, [](const Vec3&, const Vec3& n) -> Vec3 {
                     return 1e-4 * n;
                   })}};
            }};
  }
  ShellModel shell(const Points& at) const {
    return {*layout, at, problem().definition(*layout, at)};
  }
  Points solved(const ShellModel& shell, size_t load_case) const {
    return shell.solve(
        problem().load_cases(*layout, shell.shape(), shell.definition())[load_case].load);
  }
};

Points wavy(long rows) {
  Points q(rows, 3);
  for (long m = 0; m < rows; ++m)
    for (int c = 0; c < 3; ++c) q(m, c) = std::sin(1.7 * static_cast<double>(m) + c);
  return q;
}

}  // namespace

TEST_CASE("the norm of the von Mises stress grows towards the largest stress", "[analysis][norm]") {
  const Arch arch;
  const ShellModel shell = arch.shell(arch.shape);
  const Points u = arch.solved(shell, 0);
  const auto norm = [&](double exponent, double factor = 1) {
    return von_mises_norm(shell.assembler(), factor * u, exponent).value;
  };
  const double least = norm(2), middle = norm(8), most = norm(100);
  CHECK(0 < least);
  CHECK(least < middle);
  CHECK(middle < most);
  const ShellStresses stresses(shell, u);
  CHECK(most == Approx(stresses.peak().value).epsilon(0.15));
  CHECK(norm(8, 3) == Approx(3 * middle).epsilon(1e-12));
  CHECK(norm(8, -1e-150) == Approx(1e-150 * middle).epsilon(1e-12));
  // Rigid motions and the zero displacement have no stress.
  const VecX positions = arch.layout->position_dofs();
  const Points moved = u + positions * Vec3(1, -2, 3).transpose();
  CHECK(von_mises_norm(shell.assembler(), moved, 8).value == Approx(middle).epsilon(1e-8));
  const VonMisesNorm none = von_mises_norm(shell.assembler(), 0 * u, 8);
  CHECK(none.value == 0);
  CHECK(none.gradient.isZero(0));
}

TEST_CASE("a uniform stress is its own norm, for every exponent", "[analysis][norm]") {
  const Arch arch;
  const ShellMaterial material = ShellMaterial::isotropic(Plates::E, 0.3);
  const ShellAssembler shell(
      arch.layout->surface(arch.layout->minimize_energy(SurfaceStiffness::isotropic(0, 1))),
      {{material, Plates::t}});
  // A plane shape that is stretched along x.
  Points stretch = arch.layout->minimize_energy(SurfaceStiffness::isotropic(0, 1));
  constexpr double strain = 1e-3;
  stretch.col(0) *= strain;
  stretch.rightCols<2>().setZero();
  const double a = Plates::E / (1 - 0.09) * strain, b = 0.3 * a,
               expected = std::sqrt(a * a - a * b + b * b);
  for (const double exponent : {2.0, 5.0, 30.0})
    CHECK(von_mises_norm(shell, stretch, exponent).value == Approx(expected).epsilon(1e-9));
}

TEST_CASE("the gradient of the norm is its derivative", "[analysis][norm]") {
  const Arch arch;
  const ShellModel shell = arch.shell(arch.shape);
  const Points u = arch.solved(shell, 1), along = u.cwiseAbs().maxCoeff() * wavy(u.rows());
  for (const double exponent : {2.0, 8.0, 20.0}) {
    const VonMisesNorm norm = von_mises_norm(shell.assembler(), u, exponent);
    constexpr double h = 1e-7;
    const double difference = (von_mises_norm(shell.assembler(), u + h * along, exponent).value -
                               von_mises_norm(shell.assembler(), u - h * along, exponent).value) /
                              (2 * h);
    CHECK(norm.gradient.cwiseProduct(along).sum() == Approx(difference).epsilon(1e-4));
    // Euler's identity of a function that is homogeneous of degree 1.
    CHECK(norm.gradient.cwiseProduct(u).sum() == Approx(norm.value).epsilon(1e-9));
  }
}

TEST_CASE("a norm refuses exponents out of range and other displacements", "[analysis][norm]") {
  const Arch arch;
  const ShellModel shell = arch.shell(arch.shape);
  for (const double exponent : {1.9, 101.0, std::nan("")})
    CHECK_THROWS_WITH(von_mises_norm(shell.assembler(), arch.shape, exponent),
                      Contains("expected 2 to 100"));
  CHECK_THROWS_WITH(von_mises_norm(shell.assembler(), Points::Zero(3, 3), 8), Contains("3 dofs"));
}

TEST_CASE(
    "derivatives of displacement, compliance, stress norm and mass equal differences of whole "
    "analyses",
    "[analysis][norm]") {
  const Arch arch;
  const Vec3 at(0.9, 0.1, 0.27);
  using Goals = std::vector<ShellSensitivities::Goal>;
  const Goals goals{{"tip", at, {1, 0, 2}}, {"wind", at, {0, 0, 1}}};
  constexpr double exponent = 6;
  const ShellSensitivities here(*arch.layout, arch.shape, Arch::problem(), goals, exponent);
  const Points rate = wavy(arch.shape.rows()).cwiseProduct(arch.shape) +
                      Points(arch.shape.col(0) * Vec3(1, 0.5, 0.3).transpose());
  const ShellLocation where = nearest_location(*arch.layout, arch.shape, at);
  const auto values = [&](double s, size_t g) {
    const ShellModel shell = arch.shell(arch.shape + s * rate);
    const Points F =
        Arch::problem().load_cases(*arch.layout, shell.shape(), shell.definition())[g].load;
    const Points u = shell.solve(F);
    const Points G = point_force(*arch.layout, where, goals[g].direction.normalized());
    return std::array<double, 4>{G.cwiseProduct(u).sum(), F.cwiseProduct(u).sum(),
                                 von_mises_norm(shell.assembler(), u, exponent).value,
                                 shell_mass(shell.assembler())};
  };
  const auto along = here.along(rate);
  for (size_t g = 0; g < goals.size(); ++g) {
    constexpr double h = 1e-5;
    const auto up = values(h, g), down = values(-h, g), now = values(0, g);
    const auto difference = [&](size_t k) {
      return Approx((up[k] - down[k]) / (2 * h)).epsilon(1e-4);
    };
    CHECK(here.values()[g].displacement == Approx(now[0]));
    CHECK(here.values()[g].compliance == Approx(now[1]));
    CHECK(here.values()[g].von_mises_norm == Approx(now[2]));
    CHECK(along[g].displacement == difference(0));
    CHECK(along[g].compliance == difference(1));
    CHECK(along[g].von_mises_norm == difference(2));
    CHECK(along[g].mass == difference(3));
    CHECK(here.values()[g].mass == Approx(now[3]));
  }
}
