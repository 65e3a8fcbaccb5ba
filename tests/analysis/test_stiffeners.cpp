// SPDX-License-Identifier: MPL-2.0
// Stiffeners along curves of a shell.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "batten/analysis/models/shell_modes.h"
#include "batten/analysis/models/stiffeners.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

constexpr double kE = 1000, kDensityOfStiffener = 0.3;

StiffenerSection blade(double width, double height) {
  StiffenerSection s = StiffenerSection::rectangle(width, height);
  s.young = kE;
  s.shear_modulus = kE / 2;
  s.density = kDensityOfStiffener;
  return s;
}

/// A strip of two plates along y, with a common line "rib" in its middle.
struct RibbedStrip {
  Plates plates;
  ModelLayout layout;
  Points shape;
  static constexpr double half = 0.03;

  static Plates lines() {
    Plates p;
    p.h = p.builder.options.edge_length = 0.03;
    p.across("left", {-half, 0, 0}, {-half, 0, 0});
    p.across("rib", {0, 0, 0}, {0, 0, 0});
    p.across("right", {half, 0, 0}, {half, 0, 0});
    p.plate("left", "rib");
    p.plate("rib", "right");
    return p;
  }
  RibbedStrip()
      : plates(lines()),
        layout(plates.builder.model({plates.builder.join_line("rib", 0, 1)})),
        shape(layout.all_dofs(plates.builder.first)) {}

  ShellDefinition with(const StiffenerSection& section, std::vector<LineSupport> supports) const {
    ShellDefinition definition{{{ShellMaterial::isotropic(kE, 0, kDensityOfStiffener), Plates::t}},
                               std::move(supports),
                               {},
                               {}};
    definition.stiffeners = {{"rib", "rib", section}};
    return definition;
  }
  std::vector<LineSupport> clamped() const {
    return {LineSupport::clamped("leftrib 0"), LineSupport::clamped("ribright 0")};
  }
  Points tip(const Vec3& per_length) const {
    return line_force(layout, shape, "leftrib W", per_length) +
           line_force(layout, shape, "ribright W", per_length);
  }
  double moved(const Points& q, int c) const {
    const ShellLocation at = nearest_location(layout, shape, {0, Plates::W, 0});
    return layout.surface(q).position(at.where)[c];
  }
};

}  // namespace

TEST_CASE("sections of stiffeners", "[analysis][stiffener]") {
  const StiffenerSection r = StiffenerSection::rectangle(2, 6);
  CHECK(r.area == 12);
  CHECK(r.inertia == Approx(36));
  CHECK(r.lateral_inertia == Approx(4));
  CHECK(r.torsion == Approx(0.790 * 16).epsilon(1e-2));  // 16/3 (1 - 0.63/3) · 3, [Timoshenko]
  const StiffenerSection tube = StiffenerSection::tube(5, 0.01);
  CHECK(tube.inertia == Approx(std::numbers::pi * 125 * 0.01).epsilon(1e-2));
  CHECK(tube.torsion == Approx(2 * tube.inertia));
  // A T whose flange is as wide as its web is thick is a rectangle.
  const StiffenerSection tee = StiffenerSection::tee(4, 2, 2, 2);
  CHECK(tee.area == 12);
  CHECK(tee.foot == Approx(3));
  CHECK(tee.inertia == Approx(36));
  CHECK(tee.lateral_inertia == Approx(4));
  const StiffenerSection below = r.on_side(-1, -0.5);
  CHECK(below.eccentricity == Approx(-3.5));
  CHECK_THROWS_WITH(StiffenerSection::rectangle(0, 1), Contains("width"));
  CHECK_THROWS_WITH(StiffenerSection::tube(1, 2), Contains("at most the radius"));
}

TEST_CASE("rigid motions of a stiffener cost nothing, on its surface and off it",
          "[analysis][stiffener]") {
  const TestModelBuilder sphere = octants(0.3);
  const ModelLayout layout = sphere.model({});
  const Points shape = layout.all_dofs(sphere.first);
  StiffenerSection section = blade(0.02, 0.1);
  section.eccentricity = 0.08;
  const Stiffeners stiffeners(layout, shape, {{"arc", "zx", section}});
  const VecX positions = layout.position_dofs();
  const Vec3 axis(0.3, -0.8, 0.5);
  Points q(shape.rows(), 3), stretched = shape;
  for (long m = 0; m < shape.rows(); ++m)
    q.row(m) = axis.cross(Vec3(shape.row(m))) + positions[m] * Vec3(1, 2, 3);
  const double rigid = stiffeners.energy(q, {});
  CHECK(rigid < 1e-20 * kE);
  CHECK(stiffeners.energy(stretched, {}) > 1e-3);
}

TEST_CASE("a ring that grows is stretched by u/(R + e), and is not bent", "[analysis][stiffener]") {
  const TestModelBuilder sphere = octants(0.15);  // nearly, between its edges
  const ModelLayout layout = sphere.model({});
  const Points shape = layout.all_dofs(sphere.first);
  StiffenerSection section = blade(0.02, 0.1);
  section.eccentricity = 0.25;  // away from the centre or towards it
  const Stiffeners stiffeners(layout, shape, {{"arc", "zx", section}});
  // U = 0.01 (x - centre): a similarity.
  const VecX positions = layout.position_dofs();
  const Vec3 centre(0.3, 0.2, 0.1);
  const Points q = 0.01 * shape;
  const auto results = stiffeners.results(q, {});
  REQUIRE(results.size() == 1);
  // Both, the curve and its distance from the centroid line, would have to grow; the distance e does
  // not: the strain of the centroid line is 0.01 R/(R + e), with R = 1 and e against or along n.
  const double out = 0.01 / 1.25, in = 0.01 / 0.75;
  const double found = results[0].largest.axial / (kE * section.area);
  CHECK(std::min(std::abs(found - out), std::abs(found - in)) < 3e-4);
  CHECK(std::abs(results[0].largest.torque) < 1e-3 * kE * section.torsion);
  CHECK(results[0].largest.axial - results[0].least.axial < 0.1 * results[0].largest.axial);
}

TEST_CASE("a ribbed strip bends like a beam of both, about their common axis",
          "[analysis][stiffener]") {
  const RibbedStrip strip;
  const double width = 0.01, height = 0.06, L = Plates::W, B = 2 * RibbedStrip::half, t = Plates::t;
  const StiffenerSection section = blade(width, height).on_side(1, t / 2);
  const double sheet = B * t, rib = width * height, e = t / 2 + height / 2,
               axis = rib * e / (sheet + rib);
  const double EI = kE * (B * t * t * t / 12 + sheet * axis * axis +
                          width * height * height * height / 12 + rib * (e - axis) * (e - axis));
  const ShellModel shell(strip.layout, strip.shape, strip.with(section, strip.clamped()));
  const double force = 1e-3;
  const Points F = strip.tip({0, 0, force / B});
  const Points q = shell.solve(F);
  CHECK(strip.moved(q, 2) == Approx(force * L * L * L / (3 * EI)).epsilon(0.01));
  CHECK(2 * shell.energy(q) == Approx(F.cwiseProduct(q).sum()).epsilon(1e-9));
  // The largest stress is at the free fibre of the rib, next to the support.
  const auto results = shell.stiffeners().results(q, {});
  const double fibre = t / 2 + height - axis;
  CHECK(std::abs(results[0].largest_stress) == Approx(kE * force * L * fibre / EI).epsilon(0.03));
  CHECK(results[0].stress_at.y() < 0.05 * L);
  // A pull at the sheet bends it: the common axis is above the sheet.
  const Points pulled = shell.solve(strip.tip({0, force / B, 0}));
  CHECK(std::abs(strip.moved(pulled, 2)) == Approx(force * axis * L * L / (2 * EI)).epsilon(0.02));
  // Bending in the plane: EI of the sheet and the rib in their planes.
  const ShellModel flat(strip.layout, strip.shape,
                        strip.with(blade(width, height), strip.clamped()));
  const double lateral = kE * (t * B * B * B / 12 + height * std::pow(width, 3) / 12);
  CHECK(
      strip.moved(flat.solve(strip.tip({force / B, 0, 0})), 0) ==
      Approx(force * L * L * L / (3 * lateral) + 1.2 * force * L / (kE / 2 * sheet)).epsilon(0.02));
}

TEST_CASE("a stiffener has mass, weight, heat and compression", "[analysis][stiffener]") {
  const RibbedStrip strip;
  const double width = 0.01, height = 0.06, L = Plates::W, B = 2 * RibbedStrip::half, t = Plates::t;
  StiffenerSection section = blade(width, height);
  section.expansion = 1e-5;
  const ShellModel shell(strip.layout, strip.shape, strip.with(section, strip.clamped()));
  CHECK(shell.stiffeners().mass() ==
        Approx(kDensityOfStiffener * width * height * L).epsilon(1e-6));
  const Points weight = shell.stiffeners().body_load([](const Vec3&) { return Vec3(0, 0, -2); });
  CHECK(resultant(strip.layout, strip.shape, weight).force.z() ==
        Approx(-2 * shell.stiffeners().mass()).epsilon(1e-9));
  // The first frequency of the cantilever: EI and mass of both.
  const ShellModes modes = natural_modes(shell, 1);
  const double EI = kE * (B * t * t * t / 12 + width * std::pow(height, 3) / 12),
               per_length = kDensityOfStiffener * (B * t + width * height);
  CHECK(modes.frequencies[0] ==
        Approx(1.8751 * 1.8751 / (2 * std::numbers::pi * L * L) * std::sqrt(EI / per_length))
            .epsilon(0.01));
  // Heated alone, it stretches the strip as far as the sheet allows.
  const VecX ones = VecX::Ones(strip.layout.mesh()->vertex_count());
  const ShellTemperature hot{50 * ones, 0 * ones};
  const Points q = shell.solve(shell.stiffeners().thermal_load(hot));
  const double share = width * height / (width * height + B * t);
  const ShellLocation middle = nearest_location(strip.layout, strip.shape, {0, L / 2, 0});
  CHECK(strip.layout.surface(q).position(middle.where).y() ==
        Approx(share * 1e-5 * 50 * L / 2).epsilon(0.02));
  const auto forces = shell.stiffeners().results(q, hot);
  CHECK(forces[0].least.axial ==
        Approx(-(1 - share) * kE * width * height * 1e-5 * 50).epsilon(0.03));
  // Buckling under a force at the tip: Euler's load of a cantilever.
  const Points F = strip.tip({0, -1e-3 / B, 0});
  const ShellBuckling buckled = buckling(shell, shell.solve(F), 1);
  // The strip buckles about its weaker axis; EI is that of bending along the normal, or in the plane.
  const double lateral = kE * (t * B * B * B / 12 + height * std::pow(width, 3) / 12);
  const double euler = std::pow(std::numbers::pi / (2 * L), 2) * std::min(EI, lateral);
  CHECK(buckled.factors[0] == Approx(euler / 1e-3).epsilon(0.03));
}

TEST_CASE("invalid stiffeners are refused", "[analysis][stiffener]") {
  const RibbedStrip strip;
  const auto refused = [&](StiffenerSection section, const std::string& line,
                           const std::string& text) {
    CHECK_THROWS_WITH(Stiffeners(strip.layout, strip.shape, {{"s", line, section}}),
                      Contains(text));
  };
  StiffenerSection section = blade(0.01, 0.05);
  refused(section, "rb", "rib");
  section.young = 0;
  refused(section, "rib", "young");
  section = blade(0.01, 0.05);
  section.inertia = -1;
  refused(section, "rib", "inertia");
}
