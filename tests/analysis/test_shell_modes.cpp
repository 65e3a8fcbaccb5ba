// SPDX-License-Identifier: MPL-2.0
// Frequencies and buckling loads compared with closed-form solutions.
#include <cmath>
#include <numbers>

#include "batten/analysis/models/harmonic_response.h"
#include "batten/analysis/models/response_spectrum.h"
#include "batten/analysis/models/shell_modes.h"
#include "batten/core/errors.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;
using std::numbers::pi;

namespace {

constexpr double kDensity = 0.3;

// One plate of material E, nu and density kDensity.
struct OnePlate : SinglePlate {
  using SinglePlate::SinglePlate;
  ShellDefinition made_of(double nu, std::vector<LineSupport> supports = {}) const {
    return {{{ShellMaterial::isotropic(Plates::E, nu, kDensity), Plates::t}},
            std::move(supports),
            {},
            {}};
  }
};

LineSupport held(const std::string& line, const std::vector<Vec3>& directions) {
  return {line, line, directions, Vec3::Zero(), false};
}

}  // namespace

TEST_CASE("a simply supported plate has its frequencies, also where two are equal",
          "[analysis][modes]") {
  const OnePlate plate(Plates::W, Plates::W / 8);
  constexpr double nu = 0.3;
  std::vector<LineSupport> supports;
  for (const std::string& edge : OnePlate::edges)
    supports.push_back(held(edge, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}));
  const ShellModel shell(plate.layout, plate.shape, plate.made_of(nu, supports));
  const ShellModes modes = natural_modes(shell, 5);
  const double D = Plates::EI / (1 - nu * nu);
  const double first = pi / 2 * 2 / (Plates::W * Plates::W) * std::sqrt(D / (kDensity * Plates::t));
  CHECK(modes.rigid_body_count == 0);
  REQUIRE(modes.frequencies.size() == 5);
  const double times[] = {2, 5, 5, 8, 10};
  for (int k = 0; k < 5; ++k)
    CHECK(modes.frequencies[k] == Approx(first * times[k] / 2).epsilon(5e-3));
}

TEST_CASE("an unsupported strip has six rigid-body modes, then the bending modes of a free beam",
          "[analysis][modes]") {
  const OnePlate strip(6 * Plates::W, Plates::W / 3);
  using Free = ShellModel::RigidBodyHandling;
  const ShellModel shell(strip.layout, strip.shape, strip.made_of(0), Free::Shifted);
  const ShellModes modes = natural_modes(shell, 2);
  CHECK(modes.rigid_body_count == 6);
  REQUIRE(modes.frequencies.size() == 8);
  const double root = 4.730041;
  const double beam = root * root / (2 * pi * strip.length * strip.length) *
                      std::sqrt(Plates::EI / (kDensity * Plates::t));
  CHECK(modes.frequencies[6] == Approx(beam).epsilon(5e-3));
  const SparseMatrix M = shell.assembler().mass();
  const Points& u = modes.shapes[6];
  CHECK(u.cwiseProduct(M.selfadjointView<Eigen::Lower>() * u).sum() == Approx(1));
  // The rigid-body modes have the whole mass.
  CHECK(modes.mass == Approx(kDensity * Plates::t * Plates::W * strip.length));
  Vec3 effective = Vec3::Zero();
  for (int k = 0; k < 6; ++k) effective += modes.participation[k].cwiseAbs2();
  for (int c = 0; c < 3; ++c) CHECK(effective[c] == Approx(modes.mass).epsilon(1e-6));
  CHECK(modes.participation[6].norm() < 1e-6 * std::sqrt(modes.mass));
  const ShellModel weightless(
      strip.layout, strip.shape,
      {{{ShellMaterial::isotropic(1, 0), 1}}, {LineSupport::clamped("a")}, {}, {}});
  CHECK_THROWS_WITH(natural_modes(weightless, 2), Contains("density"));
}

TEST_CASE("a free ring of two halves has the natural frequencies of Hoppe", "[analysis][modes]") {
  constexpr double R = 1, b = 0.2, t = 0.01, E = 1000;
  TestModelBuilder p;
  p.options.edge_length = 0.1;
  const auto half = [&](const std::string& name, double side, double z) {
    p.add(prescribed_line(
        name,
        curve_from_formula(0, 1,
                           [=](double s, int order) -> Vec3 {
                             const double a = pi * s, w = pi;
                             const Vec3 x(R * std::cos(a), side * R * std::sin(a), z),
                                 d(-R * std::sin(a), side * R * std::cos(a), 0);
                             return order == 0   ? x
                                    : order == 1 ? Vec3(w * d)
                                                 : Vec3(-w * w * Vec3(x.x(), x.y(), 0));
                           }),
        1, p.options.edge_length));
  };
  const auto upright = [&](const std::string& name, double x) {
    p.add(prescribed_line(name,
                          curve_from_formula(0, 1,
                                             [=](double s, int order) -> Vec3 {
                                               return order == 0   ? Vec3(x, 0, b * s)
                                                      : order == 1 ? Vec3(0, 0, b)
                                                                   : Vec3(0, 0, 0);
                                             }),
                          1, p.options.edge_length));
  };
  half("low 1", 1, 0);
  half("high 1", 1, b);
  half("low 2", -1, 0);
  half("high 2", -1, b);
  upright("east", R);
  upright("west", -R);
  p.region({"low 1", "west", "high 1", "east"});
  p.region({"low 2", "west", "high 2", "east"});
  const ModelLayout layout = p.model({});
  const Points shape = layout.minimize_energy({}, rest_dofs(layout));
  const ShellModel shell(layout, shape,
                         {{{ShellMaterial::isotropic(E, 0, kDensity), t}}, {}, {}, {}},
                         ShellModel::RigidBodyHandling::Shifted);
  const ShellModes modes = natural_modes(shell, 4);
  CHECK(modes.rigid_body_count == 6);
  // The lowest frequencies include those of k circumferential waves in the plane: (2 pi f)^2 = E
  // t^2/(12 rho R^4) ....
  const auto of = [&](int k) {
    const double k2 = k * k;
    return std::sqrt(E * t * t / (12 * kDensity) * k2 * (k2 - 1) * (k2 - 1) / (k2 + 1)) / (2 * pi);
  };
  for (const int k : {2}) CHECK((modes.frequencies.array() / of(k) - 1).abs().minCoeff() < 5e-3);
}

namespace {

// A sector of a cylinder of radius 1 between two planes of symmetry, with diaphragms at its ends.
struct Sector {
  static constexpr double E = 1000;
  double theta, L, t;
  TestModelBuilder builder;
  ModelLayout layout;
  Points shape;

  static TestModelBuilder lines(double theta, double L, double h) {
    TestModelBuilder p;
    p.options.edge_length = h;
    const auto add = [&](const std::string& name, const std::shared_ptr<const InputCurve>& curve) {
      p.add(prescribed_line(name, curve, 1, h));
    };
    const auto arc = [=](double z) {
      return curve_from_formula(0, 1, [=](double s, int order) -> Vec3 {
        const double a = theta * s;
        if (order == 0) return {std::cos(a), std::sin(a), z};
        if (order == 1) return theta * Vec3(-std::sin(a), std::cos(a), 0);
        return -theta * theta * Vec3(std::cos(a), std::sin(a), 0);
      });
    };
    const auto generator = [=](double a) {
      return curve_from_formula(0, 1, [=](double s, int order) -> Vec3 {
        if (order == 0) return {std::cos(a), std::sin(a), L * s};
        return order == 1 ? Vec3(0, 0, L) : Vec3(0, 0, 0);
      });
    };
    add("low", arc(0));
    add("right", generator(theta));
    add("high", arc(L));
    add("left", generator(0));
    p.region({"low", "right", "high", "left"});
    return p;
  }
  Sector(double theta, double L, double t, double h)
      : theta(theta),
        L(L),
        t(t),
        builder(lines(theta, L, h)),
        layout(builder.model({})),
        shape(layout.minimize_energy({}, rest_dofs(layout))) {}

  ShellModel shell() const {
    ShellDefinition d{{{ShellMaterial::isotropic(E, 0, kDensity), t}}, {}, {}, {}};
    d.lines = {LineSupport::symmetric("left", {0, 1, 0}),
               LineSupport::symmetric("right", {-std::sin(theta), std::cos(theta), 0}),
               held("low", {Vec3::UnitX(), Vec3::UnitY()}),
               held("high", {Vec3::UnitX(), Vec3::UnitY()})};
    // By symmetry, the waves have no axial displacement in the middle.
    const Vec3 middle(std::cos(theta / 2), std::sin(theta / 2), L / 2);
    d.points = {{"middle", nearest_location(layout, shape, middle), {Vec3::UnitZ()}, Vec3::Zero()}};
    return {layout, shape, d};
  }
  // For m half waves along and n across, Donnell: bending and membrane parts, with wave numbers.
  double stiffness(int m, int n) const {
    const double a2 = std::pow(m * pi / L, 2), b2 = std::pow(n * pi / theta, 2);
    return E * t * t * t / 12 * std::pow(a2 + b2, 2) + E * t * a2 * a2 / std::pow(a2 + b2, 2);
  }
};

}  // namespace

TEST_CASE("a cylinder buckles under axial load at the load of Donnell", "[analysis][modes]") {
  const Sector sector(0.6, 0.4, 0.004, 0.025);
  const ShellModel shell = sector.shell();
  const Points q = shell.solve(line_force(sector.layout, sector.shape, "high", {0, 0, -1}) +
                               line_force(sector.layout, sector.shape, "low", {0, 0, 1}));
  double least = 1e300;
  for (int m = 1; m < 20; ++m)
    for (int n = 0; n < 20; ++n)
      least = std::min(least, sector.stiffness(m, n) / std::pow(m * pi / sector.L, 2));
  const double classical = Sector::E * sector.t * sector.t / std::sqrt(3);
  CHECK(least == Approx(classical).epsilon(0.02));
  const double found = buckling(shell, q, 1).factors[0];
  INFO(found / least << " of Donnell");
  CHECK(found == Approx(least).epsilon(0.02));
}

TEST_CASE("a cylindrical panel has the natural frequencies of Donnell", "[analysis][modes]") {
  const Sector sector(0.2, 0.2, 0.002, 0.02);
  const ShellModes modes = natural_modes(sector.shell(), 6);
  for (const auto& [m, n] : {std::pair(1, 1), std::pair(1, 2)}) {
    const double f = std::sqrt(sector.stiffness(m, n) / (kDensity * sector.t)) / (2 * pi);
    INFO(m << ", " << n << ": " << (modes.frequencies.array() / f - 1).abs().minCoeff());
    CHECK((modes.frequencies.array() / f - 1).abs().minCoeff() < 5e-3);
  }
}

TEST_CASE("a square plate buckles under the pressure of two sides at the load of Bryan",
          "[analysis][modes]") {
  const OnePlate plate(Plates::W, Plates::W / 8);
  constexpr double nu = 0.3;
  std::vector<LineSupport> supports;
  for (const std::string& edge : OnePlate::edges) supports.push_back(held(edge, {Vec3::UnitZ()}));
  supports.push_back(held("a", {Vec3::UnitX()}));
  ShellDefinition definition = plate.made_of(nu, supports);
  definition.points = {{"corner",
                        nearest_location(plate.layout, plate.shape, {0, 0, 0}),
                        {Vec3::UnitY()},
                        Vec3::Zero()}};
  const ShellModel shell(plate.layout, plate.shape, definition);
  const Points q = shell.solve(line_force(plate.layout, plate.shape, "b", {-1, 0, 0}));
  const ShellBuckling found = buckling(shell, q, 2);
  const double D = Plates::EI / (1 - nu * nu), unit = pi * pi * D / (Plates::W * Plates::W);
  REQUIRE(found.factors.size() == 2);
  CHECK(found.factors[0] == Approx(4 * unit).epsilon(1e-2));
  CHECK(found.factors[1] == Approx(6.25 * unit).epsilon(1e-2));
  // Under tension it does not buckle.
  CHECK(buckling(shell, -q, 1).factors.size() == 0);
}

TEST_CASE(
    "a ring buckles at 3 EI/R³ under pressure that follows it, at 4 EI/R³ if the pressure keeps "
    "its direction",
    "[analysis][modes]") {
  const Sector ring(pi / 2, 0.1, 0.01, 0.05);
  ShellDefinition d{{{ShellMaterial::isotropic(Sector::E, 0), ring.t}}, {}, {}, {}};
  d.lines = {LineSupport::symmetric("left", {0, 1, 0}), LineSupport::symmetric("right", {1, 0, 0}),
             held("low", {Vec3::UnitZ()})};
  const ShellModel shell(ring.layout, ring.shape, d);
  const Vec3 n = ring.layout.surface(ring.shape).jet({0, Vec3::Constant(1.0 / 3)}).normal();
  const Vec3 x = ring.layout.surface(ring.shape).position({0, Vec3::Constant(1.0 / 3)});
  const double inwards = n.head<2>().dot(x.head<2>()) > 0 ? -1 : 1;
  const Points q = shell.solve(
      surface_traction(ring.layout, ring.shape,
                       [&](const Vec3&, const Vec3& normal) -> Vec3 { return inwards * normal; }));
  const SparseMatrix follower =
      follower_stiffness(ring.layout, ring.shape, [&](const Vec3&) { return PressureAt{inwards}; });
  const double unit = Sector::E * ring.t * ring.t * ring.t / 12;
  CHECK(buckling(shell, q, 1, follower).factors[0] == Approx(3 * unit).epsilon(1e-2));
  CHECK(buckling(shell, q, 1).factors[0] == Approx(4 * unit).epsilon(1e-2));
}

TEST_CASE("the follower stiffness of a constant pressure is the second derivative of the volume",
          "[analysis][modes]") {
  const Sector sector(0.6, 0.4, 0.01, 0.1);
  const SparseMatrix S =
      follower_stiffness(sector.layout, sector.shape, [](const Vec3&) { return PressureAt{2}; });
  // A displacement that vanishes near the boundary.
  const VecX positions = sector.layout.position_dofs();
  const Vec3 middle(std::cos(0.3), std::sin(0.3), 0.2);
  Points u = Points::Zero(sector.shape.rows(), 3);
  for (long m = 0; m < u.rows(); ++m)
    if (positions[m] > 0 && (Vec3(sector.shape.row(m)) - middle).norm() < 0.1)
      u.row(m) << std::sin(3.0 * m), std::cos(2.0 * m), std::sin(5.0 * m + 1);
  REQUIRE(u.norm() > 0);
  const auto work = [&](double step) {  // of the pressure on u, at the displaced surface
    const Points moved = sector.shape + step * u;
    return surface_traction(sector.layout, moved,
                            [](const Vec3&, const Vec3& n) -> Vec3 { return 2 * n; })
        .cwiseProduct(u)
        .sum();
  };
  constexpr double step = 1e-4;
  const Eigen::Map<const VecX> all(u.data(), u.size());
  const double second = all.dot(S.selfadjointView<Eigen::Lower>() * all);
  CHECK(second == Approx((work(step) - work(-step)) / (2 * step)).epsilon(1e-7));
}

TEST_CASE("a steady vibration converges with few modes, and solves the equation of motion",
          "[analysis][modes]") {
  const OnePlate plate(1, 0.125);
  const ShellModel shell(plate.layout, plate.shape,
                         plate.made_of(0.3, {LineSupport::clamped("a")}));
  const Points F = line_force(plate.layout, plate.shape, "b", {0, 0, 1e-4});
  const Points still = shell.solve(F);
  const ShellModes few = natural_modes(shell, 6), many = natural_modes(shell, 24);
  const double first = few.frequencies[0];
  // The response as dofs, one vector of shapes per dof.
  const auto response = [&](const ShellModes& modes, double frequency, double damping) {
    const HarmonicResponse harmonic(modes, F, damping);
    Eigen::Matrix<std::complex<double>, Eigen::Dynamic, 3> u(F.rows(), 3);
    std::vector<Vec3> shapes(modes.shapes.size());
    for (long m = 0; m < F.rows(); ++m) {
      for (size_t k = 0; k < shapes.size(); ++k) shapes[k] = modes.shapes[k].row(m).transpose();
      u.row(m) = harmonic.at(frequency, still.row(m).transpose(), shapes).transpose();
    }
    return u;
  };
  CHECK((response(few, 0, 0.05).real() - still).norm() < 1e-9 * still.norm());
  for (const double f : {0.5 * first, 1.5 * first}) {
    const auto u = response(many, f, 0);
    CHECK((response(few, f, 0) - u).norm() < 1e-3 * u.norm());
    CHECK(u.imag().norm() == 0);
    // K u - ω² M u = F: the inertia forces as a static load give the same displacement.
    const Points inertia = shell.mass().selfadjointView<Eigen::Lower>() * Points(u.real());
    const Points again = shell.solve(F + std::pow(2 * pi * f, 2) * inertia);
    CHECK((again - u.real()).norm() < 1e-4 * u.norm());
  }
  // In resonance, the response lags by a quarter of a period.
  const auto peak = response(few, first, 0.02);
  CHECK(peak.imag().norm() > 10 * peak.real().norm());
  CHECK_THROWS_WITH(HarmonicResponse(few, F, 1), Contains("damping"));
  CHECK(modes_up_to(shell, 3 * first).frequencies.maxCoeff() > 3 * first);
}

TEST_CASE("a response spectrum is linear in logarithmic scales", "[analysis][modes]") {
  const ResponseSpectrum spectrum({{1, 100}, {10, 1000}, {100, 10}});
  CHECK(spectrum(0.1) == 100);
  CHECK(spectrum(std::sqrt(10.0)) == Approx(100 * std::sqrt(10.0)));
  CHECK(spectrum(10) == Approx(1000));
  CHECK(spectrum(std::sqrt(1000.0)) == Approx(100));
  CHECK(spectrum(500) == 10);
  CHECK_THROWS_WITH(ResponseSpectrum({}), Contains("without points"));
  CHECK_THROWS_WITH(ResponseSpectrum({{1, 0}}), Contains("above 0"));
  CHECK_THROWS_WITH(ResponseSpectrum({{2, 1}, {1, 1}}), Contains("ascending"));
}

TEST_CASE("the responses to a constant spectrum add up to the static one, and combine by CQC",
          "[analysis][modes]") {
  const OnePlate plate(1, 0.125);
  const ShellModel shell(plate.layout, plate.shape,
                         plate.made_of(0.3, {LineSupport::clamped("a")}));
  const ShellModes modes = natural_modes(shell, 5);
  const double acceleration = 3;
  const ResponseSpectrum constant({{1, acceleration}});
  const SpectrumResponse response(shell, modes, constant, {0, 0, 2}, 0.05);
  REQUIRE(response.displacements().size() == 6);
  const VecX positions = plate.layout.position_dofs();
  const Points inertia = shell.mass().selfadjointView<Eigen::Lower>() *
                         Points(positions * Eigen::RowVector3d(0, 0, 1));
  const Points F = acceleration * inertia;
  Points loads = Points::Zero(F.rows(), 3), sum = loads;
  for (size_t k = 0; k < 6; ++k) {
    loads += response.loads()[k];
    sum += response.displacements()[k];
    // Each one is the static response to its inertia forces.
    CHECK((shell.solve(response.loads()[k]) - response.displacements()[k]).norm() <
          1e-6 * sum.norm());
  }
  CHECK((loads - F).norm() < 1e-12 * F.norm());
  CHECK((sum - shell.solve(F)).norm() < 1e-6 * sum.norm());
  CHECK(response.mass_fraction() > 0.6);
  CHECK(response.mass_fraction() < 1);
  // One response is itself; two of different frequencies combine like perpendicular vectors.
  VecX values = VecX::Zero(6);
  values[0] = -2;
  CHECK(response.combine(values) == Approx(2));
  values[5] = 1;
  CHECK(response.combine(values) == Approx(std::sqrt(5.0)));
  std::vector<Mat3> stresses(6, Mat3::Zero());
  stresses[2] << 3, 1, 0, 1, -2, 0, 0, 0, 0;
  CHECK(response.combined_von_mises(stresses) == Approx(von_mises(stresses[2])));
  CHECK_THROWS_WITH(SpectrumResponse(shell, modes, constant, Vec3::UnitZ(), 0),
                    Contains("damping"));
}

TEST_CASE("equal frequencies combine by their sum", "[analysis][modes]") {
  // The second and third mode of a square plate.
  const OnePlate plate(Plates::W, Plates::W / 8);
  std::vector<LineSupport> supports;
  for (const std::string& edge : OnePlate::edges)
    supports.push_back(held(edge, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}));
  const ShellModel shell(plate.layout, plate.shape, plate.made_of(0.3, supports));
  const SpectrumResponse response(shell, natural_modes(shell, 3), ResponseSpectrum({{1, 1}}),
                                  Vec3::UnitZ(), 0.05);
  VecX values(4);
  values << 0, 1, 1, 0;
  CHECK(response.combine(values) == Approx(2).epsilon(1e-3));
  values << 1, 1, 0, 0;
  CHECK(response.combine(values) == Approx(std::sqrt(2.0)).epsilon(0.01));
}
