// SPDX-License-Identifier: MPL-2.0
// Estimates of large displacements and of transverse shear.
#include <cmath>
#include <numbers>

#include "batten/analysis/models/theory_limits.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;

namespace {

constexpr double kYoung = 1000, kPoisson = 0.3;

struct SingleSheet : SinglePlate {
  using SinglePlate::SinglePlate;
  ShellModel shell(const std::vector<LineSupport>& supports, double thickness,
                   double poisson = kPoisson) const {
    return {layout,
            shape,
            {{{ShellMaterial::isotropic(kYoung, poisson), thickness}}, supports, {}, {}}};
  }
  Points pressure(double p) const {
    return surface_traction(layout, shape, [p](const Vec3&, const Vec3&) -> Vec3 {
      return {0, 0, p};
    });
  }
};

std::vector<LineSupport> all_sides(LineSupport (*support)(const std::string&)) {
  std::vector<LineSupport> supports;
  for (const std::string& side : SinglePlate::edges) supports.push_back(support(side));
  return supports;
}

double height(const ModelLayout& layout, const Points& q) {
  return q.col(2).cwiseProduct(layout.position_dofs()).maxCoeff();
}

double nonlinearity_of(const ShellModel& shell, const Points& F) {
  const Points q = shell.solve(F);
  return nonlinearity(shell, q, shell.energy(q));
}

}  // namespace

TEST_CASE("plates with edges that cannot move stiffen with the square of the displacement",
          "[analysis][limits]") {
  // Simply supported square plate, w = w0 sin sin, whose edges cannot move across, but along: with the
  // stress function E w0² (cos 2πx/a + cos 2πy/a)/32 and the mean force E t w0² π²/(8 a² (1-ν)),
  // w0 (1 + c (w0/t)²) is the linear displacement.
  const double t = 0.005, c = 0.375 * (1 - kPoisson * kPoisson) + 0.75 * (1 + kPoisson);
  const SingleSheet sheet(Plates::W, 0.05);
  std::vector<LineSupport> supports;
  for (const std::string& side : SinglePlate::edges) {
    const Vec3 across = side == "a" || side == "b" ? Vec3::UnitX() : Vec3::UnitY();
    supports.push_back({side, side, {across, Vec3::UnitZ()}, Vec3::Zero(), false});
  }
  const ShellModel shell = sheet.shell(supports, t);
  constexpr double pi = std::numbers::pi;
  const Points F =
      surface_traction(sheet.layout, sheet.shape, [&](const Vec3& x, const Vec3&) -> Vec3 {
        return {0, 0, 1e-5 * std::sin(pi * x.x() / Plates::W) * std::sin(pi * x.y() / Plates::W)};
      });
  const Points q = shell.solve(F);
  const double w = height(sheet.layout, q), found = nonlinearity(shell, q, shell.energy(q));
  CHECK(found == Approx(c * std::pow(w / t, 2)).epsilon(0.02));
  CHECK(nonlinearity_of(shell, 2 * F) == Approx(4 * found).epsilon(1e-6));
}

TEST_CASE("strips that bend freely do not stiffen", "[analysis][limits]") {
  const double t = 0.005;
  const SingleSheet sheet(1, 0.05);
  const ShellModel shell = sheet.shell({LineSupport::clamped("a")}, t, 0);
  const Points F = sheet.pressure(2e-7);
  const Points q = shell.solve(F);
  CHECK(height(sheet.layout, q) > 0.4 * t);
  CHECK(nonlinearity(shell, q, shell.energy(q)) < 1e-3);
}

TEST_CASE("compression softens: at half of the buckling load, displacements double",
          "[analysis][limits]") {
  // A strut with an axial force P and a small lateral load: the first correction is P/P_E.
  const double t = 0.02, I = t * t * t / 12;
  const SingleSheet sheet(1, 0.1);
  const ShellModel shell =
      sheet.shell({LineSupport::pinned("a"),
                   {"guided", "b", {Vec3::UnitY(), Vec3::UnitZ()}, Vec3::Zero(), false}},
                  t, 0);
  constexpr double pi = std::numbers::pi;
  const double euler = pi * pi * kYoung * I;  // per width
  const Points lateral =
      surface_traction(sheet.layout, sheet.shape, [&](const Vec3& x, const Vec3&) -> Vec3 {
        return {0, 0, 1e-4 * std::sin(pi * x.x())};
      });
  const Points F = lateral + line_force(sheet.layout, sheet.shape, "b", {-0.2 * euler, 0, 0});
  const Points q = shell.solve(F);
  const Points bent = shell.solve(lateral);
  // Relative to the energy of bending, that of the axial shortening left out.
  CHECK(nonlinearity(shell, q, shell.energy(bent)) == Approx(3 * 0.2 / 2).epsilon(0.05));
}

TEST_CASE("the energy of transverse shear is that of thick plates", "[analysis][limits]") {
  // w_shear/w_bending = D (2 π²/a²)/(5/6 G t) for a simply supported square plate, w ~ sin sin.
  const double t = 0.05;
  const SingleSheet sheet(Plates::W, 0.05);
  const ShellModel shell = sheet.shell(all_sides(&LineSupport::pinned), t);
  constexpr double pi = std::numbers::pi;
  const Points F =
      surface_traction(sheet.layout, sheet.shape, [&](const Vec3& x, const Vec3&) -> Vec3 {
        return {0, 0, 1e-2 * std::sin(pi * x.x() / Plates::W) * std::sin(pi * x.y() / Plates::W)};
      });
  const Points q = shell.solve(F);
  const double D = kYoung * t * t * t / (12 * (1 - kPoisson * kPoisson)),
               G = kYoung / (2 * (1 + kPoisson));
  const double share =
      transverse_shear_energy(shell.assembler(), ShellStresses(shell, q)) / shell.energy(q);
  CHECK(share ==
        Approx(D * 2 * pi * pi / (Plates::W * Plates::W) / (5.0 / 6 * G * t)).epsilon(0.02));
}
