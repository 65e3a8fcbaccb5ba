// SPDX-License-Identifier: MPL-2.0
// A model as a shell: loads, reactions, rigid-body modes, recovered stresses.
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <cmath>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/core/errors.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

// An L of two plates with a common edge ("knee"), on a base ("foot").
struct Arm {
  Plates plates;
  ModelLayout layout;
  Points shape;
  static constexpr double L = 0.8, H = 0.6;

  static Plates lines() {
    Plates p;
    p.across("foot", {0, 0, 0}, {0, 0, 0});
    p.across("knee", {0, 0, H}, {0, 0, H});
    p.across("tip", {L, 0, H}, {L, 0, H});
    p.plate("foot", "knee");
    p.plate("knee", "tip");
    return p;
  }
  Arm()
      : plates(lines()),
        layout(plates.builder.model({})),
        shape(layout.all_dofs(plates.builder.first)) {}

  ShellModel shell(const std::vector<LineSupport>& supports,
                   const std::vector<std::string>& hinges = {}, double nu = 0) const {
    return {layout,
            shape,
            {{{ShellMaterial::isotropic(Plates::E, nu), Plates::t}}, supports, {}, hinges}};
  }
  std::string rejection_reason(const std::vector<LineSupport>& supports,
                               const std::vector<std::string>& hinges = {}) const {
    try {
      shell(supports, hinges);
    } catch (const NoSolutionError& e) {
      return e.what();
    }
    return "";
  }
};

Vec3 downwards(const Vec3&, const Vec3&) { return {0, 0, -Plates::q}; }

}  // namespace

TEST_CASE("reactions balance every kind of load, and the work is twice the energy",
          "[analysis][shell]") {
  const Arm arm;
  const ShellModel shell = arm.shell({LineSupport::clamped("foot")}, {}, 0.3);
  const ShellLocation knob = nearest_location(arm.layout, arm.shape, {0.7, 0.2, Arm::H + 0.1});
  CHECK(knob.distance == Approx(0.1));
  const auto pressure = [](const Vec3&, const Vec3& n) -> Vec3 { return 1e-4 * n; };
  const Points F = surface_traction(arm.layout, arm.shape, pressure, {{1}}) +
                   line_force(arm.layout, arm.shape, "tip", {1e-5, 2e-5, -3e-5}) +
                   line_moment(arm.layout, arm.shape, "tip", 1e-5) +
                   point_force(arm.layout, knob, {0, 1e-5, 1e-5});
  const Points q = shell.solve(F);
  const Resultant load = resultant(arm.layout, arm.shape, F);
  const std::vector<SupportReaction> reactions = shell.reactions(q, F);
  REQUIRE(reactions.size() == 1);
  CHECK(reactions[0].support == "clamped foot");
  CHECK((reactions[0].resultant.force + load.force).norm() < 1e-9 * load.force.norm());
  CHECK((reactions[0].resultant.moment + load.moment).norm() < 1e-9 * load.moment.norm());
  CHECK(2 * shell.energy(q) == Approx(F.cwiseProduct(q).sum()).epsilon(1e-9));
}

TEST_CASE("loads have the resultants that their definitions state", "[analysis][shell]") {
  const Arm arm;
  const double W = Plates::W, L = Arm::L, H = Arm::H;
  const auto check = [&](const Points& F, const Vec3& force, const Vec3& moment) {
    const Resultant sum = resultant(arm.layout, arm.shape, F);
    CHECK((sum.force - force).norm() < 1e-12);
    CHECK((sum.moment - moment).norm() < 1e-12);
  };
  const Vec3 weight(0, 0, -Plates::q * L * W);
  check(surface_traction(arm.layout, arm.shape, downwards, {{1}}), weight,
        Vec3(L / 2, W / 2, H).cross(weight));
  check(line_force(arm.layout, arm.shape, "tip", {0, 0, 3}), {0, 0, 3 * W},
        Vec3(L, W / 2, H).cross(Vec3(0, 0, 3 * W)));
  // About the direction of the curve, +y.
  check(line_moment(arm.layout, arm.shape, "tip", 5), {0, 0, 0}, {0, 5 * W, 0});
  CHECK_THROWS_WITH(line_force(arm.layout, arm.shape, "tipp", {0, 0, 1}), Contains("'tip'"));
  CHECK_THROWS_AS(surface_traction(arm.layout, arm.shape, downwards, {{2}}), InputError);
}

TEST_CASE("an edge force pulls away from the face, however the edge runs", "[analysis][shell]") {
  const Arm arm;
  const double W = Plates::W, L = Arm::L;
  const auto force = [&](const std::string& line) {
    return resultant(arm.layout, arm.shape, edge_force(arm.layout, arm.shape, line, 2)).force;
  };
  CHECK((force("tip") - Vec3(2 * W, 0, 0)).norm() < 1e-12);
  CHECK((force("foot") - Vec3(0, 0, -2 * W)).norm() < 1e-12);
  CHECK((force("kneetip 0") - Vec3(0, -2 * L, 0)).norm() < 1e-12);
  CHECK((force("kneetip W") - Vec3(0, 2 * L, 0)).norm() < 1e-12);
  CHECK_THROWS_WITH(edge_force(arm.layout, arm.shape, "knee", 1), Contains("exactly one face"));
}

TEST_CASE("a total force and moment are the resultant at the centroid of their part",
          "[analysis][shell]") {
  const Arm arm;
  const Vec3 force(1, -2, 3);
  const auto on_tip = [&](const LineTraction& f) {
    return line_force(arm.layout, arm.shape, "tip", f);
  };
  const auto on_face = [&](const LineTraction& f) {
    return surface_traction(arm.layout, arm.shape, [&](const Vec3& x, const Vec3&) { return f(x); },
                            {{1}});
  };
  const auto check = [&](const auto& part, const Vec3& centroid, const Vec3& moment) {
    const Points F = spread_load(arm.layout, arm.shape, part, force, moment);
    const Resultant sum = resultant(arm.layout, arm.shape, F);
    CHECK((sum.force - force).norm() < 1e-12);
    CHECK((sum.moment - centroid.cross(force) - moment).norm() < 1e-12);
  };
  check(on_tip, {Arm::L, Plates::W / 2, Arm::H}, {0.3, 0, -0.2});
  check(on_face, {Arm::L / 2, Plates::W / 2, Arm::H}, {0.3, 0.4, -0.2});
  CHECK_THROWS_WITH(spread_load(arm.layout, arm.shape, on_tip, force, {0, 1, 0}),
                    Contains("about the direction of a straight curve"));
}

TEST_CASE("the centrifugal load of two plates is that of their mass at its radius",
          "[analysis][shell]") {
  const Arm arm;
  constexpr double rho = 3, t = Plates::t, omega = 5;
  const ShellSection section{ShellMaterial::isotropic(Plates::E, 0, rho), t};
  const Points F = body_load(arm.layout, arm.shape, {section}, [](const Vec3& x) -> Vec3 {
    return omega * omega * Vec3(x.x(), x.y(), 0);
  });
  const double W = Plates::W, L = Arm::L, H = Arm::H;
  const Vec3 expected = rho * t * omega * omega * Vec3(L * L * W / 2, (L + H) * W * W / 2, 0);
  CHECK((resultant(arm.layout, arm.shape, F).force - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("unsupported motions are named", "[analysis][shell]") {
  const Arm arm;
  using Support = LineSupport;
  const std::string not_held = "the supports do not constrain the shell: ";
  CHECK(arm.rejection_reason({Support::clamped("foot")}).empty());
  CHECK_THAT(arm.rejection_reason({}), Contains("the whole model can translate along [1, 0, 0]") &&
                                           Contains("[0, 0, 1]") && Contains("rotate about"));
  CHECK_THAT(arm.rejection_reason({Support::pinned("foot")}),
             StartsWith(not_held +
                        "the whole model can rotate about the axis along [0, 1, 0] through [0,") &&
                 EndsWith(", 0]"));
  CHECK_THAT(arm.rejection_reason({Support::clamped("foot")}, {"knee"}),
             StartsWith(not_held + "face 'region 2' can rotate about the axis along [0, 1, 0]") &&
                 EndsWith(", 0.6]"));
  CHECK(arm.rejection_reason(
            {{"wall", "foot", {Vec3::UnitX(), Vec3::UnitZ()}, Vec3::Zero(), true}}) ==
        not_held + "the whole model can translate along [0, 1, 0]");
  CHECK(arm.rejection_reason({Support::pinned("foot"), Support::pinned("tip")}, {"knee"}).empty());
}

TEST_CASE("recovered stresses of a bent plate are those of a beam, with the tension on top",
          "[analysis][shell]") {
  const Arm arm;
  const ShellModel shell = arm.shell({LineSupport::clamped("foot")});
  constexpr double m = 1e-4;
  const Points q = shell.solve(line_moment(arm.layout, arm.shape, "tip", m));
  const ShellStresses stresses(shell, q);
  const double sigma = 6 * m / (Plates::t * Plates::t);
  const ShellLocation at = nearest_location(arm.layout, arm.shape, {0.3, 0.2, Arm::H});
  const ShellStress stress = stresses.at(at.where);
  // The moment bends the tip down: the upper side is in tension, whatever the normal.
  const double up = shell.assembler().point(at.where).normal().z();
  CHECK(stress.at(up)(0, 0) == Approx(sigma).epsilon(1e-6));
  CHECK(stress.at(-up)(0, 0) == Approx(-sigma).epsilon(1e-6));
  CHECK(von_mises(stress.at(1)) == Approx(sigma).epsilon(1e-6));
  CHECK(std::abs(stress.at(0)(0, 0)) < 1e-6 * sigma);
  CHECK(stresses.energy_norm_error() < 1e-6);
  CHECK(stresses.peak().value == Approx(sigma).epsilon(1e-5));
  const auto [s1, s2] = principal(stress.at(up));
  CHECK(s1 == Approx(sigma).epsilon(1e-6));
  CHECK(std::abs(s2) < 1e-6 * sigma);
}

TEST_CASE("the error estimate follows the true error as the mesh gets finer", "[analysis][shell]") {
  // A strip under self-weight, clamped at one end: its moment is q (L - x)² / 2.
  const double L = 1, q = Plates::q;
  const double exact = q * q * std::pow(L, 5) / (40 * Plates::EI) * Plates::W;
  double before = 0;
  for (const double h : {0.25, 0.125}) {
    Plates plates;
    plates.h = plates.builder.options.edge_length = h;
    plates.across("foot", {0, 0, 0}, {0, 0, 0});
    plates.across("tip", {L, 0, 0}, {L, 0, 0});
    plates.plate("foot", "tip");
    const ModelLayout layout = plates.builder.model({});
    const Points shape = layout.all_dofs(plates.builder.first);
    const ShellModel shell(layout, shape,
                           {{{ShellMaterial::isotropic(Plates::E, 0), Plates::t}},
                            {LineSupport::clamped("foot")},
                            {},
                            {}});
    const Points u = shell.solve(surface_traction(layout, shape, downwards));
    const double error = std::sqrt(std::abs(exact - shell.energy(u)) / exact);
    const ShellStresses stresses(shell, u);
    INFO(h << ": true " << error << ", estimate " << stresses.energy_norm_error());
    CHECK(stresses.energy_norm_error() < 2 * error);
    CHECK(stresses.energy_norm_error() > 0.5 * error);
    if (before > 0) CHECK(stresses.energy_norm_error() < 0.6 * before);
    before = stresses.energy_norm_error();
  }
}

TEST_CASE("sections belong to faces and are checked before they are used", "[analysis][shell]") {
  const Arm arm;
  const ShellSection good{ShellMaterial::isotropic(Plates::E, 0), Plates::t},
      none{good.material, 0};
  const std::vector<LineSupport> foot = {LineSupport::clamped("foot")};
  const auto made = [&](const std::vector<ShellSection>& sections) {
    return ShellModel(arm.layout, arm.shape, {sections, foot, {}, {}});
  };
  CHECK_NOTHROW(made({good, good}));
  CHECK_THROWS_WITH(made({good, good, good}), Contains("3 shell sections for 2 faces"));
  CHECK_THROWS_WITH(made({}), Contains("0 shell sections"));
  CHECK_THROWS_AS(made({good, none}), InputError);
}

TEST_CASE("springs give way by force over stiffness, and their reactions balance",
          "[analysis][shell]") {
  const Arm arm;
  const double W = Plates::W, L = Arm::L;
  // Supported only by an elastic foundation of the shelf and springs along the foot.
  const ShellLocation end = nearest_location(arm.layout, arm.shape, {L, W / 2, Arm::H});
  ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}}, {}, {}, {}};
  definition.elastic = {{"floor", {}, "", {{1}}, Vec3::Zero(), 2.0},
                        {"foot", {}, "foot", {}, {5, 5, 0}, 0},
                        {"wire", end, "", {}, {3, 0, 0}, 0}};
  const ShellModel shell(arm.layout, arm.shape, definition);
  const Points F = surface_traction(arm.layout, arm.shape, downwards);
  const Points q = shell.solve(F);
  const auto reactions = shell.reactions(q, F);
  Resultant sum = resultant(arm.layout, arm.shape, F);
  for (const auto& r : reactions) {
    sum.force += r.resultant.force;
    sum.moment += r.resultant.moment;
  }
  CHECK(sum.force.norm() < 1e-10);
  CHECK(sum.moment.norm() < 1e-10);
  // All weight is carried by the floor.
  CHECK(reactions[0].resultant.force.z() == Approx(Plates::q * W * (L + Arm::H)));
  CHECK(std::abs(reactions[1].resultant.force.z()) < 1e-12);
}

TEST_CASE("one adjoint solution gives the same sensitivities of targets as solving again",
          "[analysis][shell]") {
  const Arm arm;
  // In a thick wall strains are as large as rotations: constraints that rotate with the shape
  // matter there.
  for (const auto& [pinned, thickness] :
       {std::pair(false, Plates::t), {true, Plates::t}, {false, 0.4}}) {
    const ShellDefinition definition{
        {{ShellMaterial::isotropic(Plates::E, 0.3), thickness}},
        {pinned ? LineSupport::pinned("foot") : LineSupport::clamped("foot"),
         {"prop", "tip", {Vec3::UnitZ()}, {0, 0, pinned ? 1e-3 : 0}, false}},
        {},
        {}};
    const ShellModel shell(arm.layout, arm.shape, definition);
    const auto load = [&](const Points& shape) {
      return surface_traction(arm.layout, shape, downwards);
    };
    const Points F = load(arm.shape), u = shell.solve(F);
    const ShellLocation middle = nearest_location(arm.layout, arm.shape, {0.4, 0.25, Arm::H});
    const Points G = point_force(arm.layout, middle, {0, 0, 1});
    const Points a = shell.adjoint(G);
    // The shelf is bent upwards, and everything tilts.
    Points way = Points::Zero(arm.shape.rows(), 3);
    for (long m = 0; m < way.rows(); ++m)
      way.row(m) = Eigen::RowVector3d(0.2 * arm.shape(m, 2), 0, 0.3 * arm.shape(m, 0));
    const auto goal = [&](double s) {
      const Points shape = arm.shape + s * way;
      return ShellModel(arm.layout, shape, definition).solve(load(shape)).cwiseProduct(G).sum();
    };
    constexpr double s = 1e-4;
    const double again = (goal(s) - goal(-s)) / (2 * s);
    const auto change = [&](double step) {
      const Points shape = arm.shape + step * way;
      return shell.goal_change(u, F, a, G, shell.assemble_system(shape), load(shape));
    };
    CHECK((change(s) - change(-s)) / (2 * s) == Approx(again).epsilon(1e-4));
  }
}

TEST_CASE("a very thin shell has the same displacement to ten digits, whatever factors its system",
          "[analysis][shell]") {
  class EigenBackend : public LinearSolverBackend {
   public:
    bool factorize(const SparseMatrix& A) override {
      factor_.compute(A);
      return true;
    }
    const std::string& message() const override { return message_; }
    void solve_in_place(Eigen::Ref<MatX> b) const override { b = factor_.solve(MatX(b)); }

   private:
    std::string message_;
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
  };
  const Arm arm;
  const ShellDefinition definition{
      {{ShellMaterial::isotropic(Plates::E, 0.3), 0.0005}}, {LineSupport::clamped("foot")}, {}, {}};
  const ShellModel one(arm.layout, arm.shape, definition),
      other(arm.layout, arm.shape, definition, ShellModel::RigidBodyHandling::Refused,
            [] { return std::make_unique<EigenBackend>(); });
  const Points F = surface_traction(arm.layout, arm.shape, downwards);
  const auto differs = [](const Points& a, const Points& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
  };
  CHECK(differs(one.solve(F), other.solve(F)) < 5e-11);
  CHECK(differs(one.solver().solve(F), other.solver().solve(F)) > 5e-11);  // without refinement
}

TEST_CASE("the factorization of a shell solves similar shells, and refuses others",
          "[analysis][shell]") {
  const Arm arm;
  ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}},
                             {LineSupport::clamped("foot")},
                             {},
                             {}};
  const ShellModel shell(arm.layout, arm.shape, definition);
  const Points start = shell.solve(surface_traction(arm.layout, arm.shape, downwards));
  const auto tilted = [&](double s) {
    Points shape = arm.shape;
    for (long m = 0; m < shape.rows(); ++m) shape(m, 2) += s * arm.shape(m, 0);
    return shape;
  };
  const auto solved = [&](const Points& shape, const Points& F, const Points& guess) {
    const ShellSystem system = shell.assemble_system(shape);
    return shell.solve(system, AffineReduction(system.ties.constraints), F, guess);
  };
  for (const double s : {0.0, 1e-6, 1e-3, 1e-2}) {
    const Points shape = tilted(s), F = surface_traction(arm.layout, shape, downwards);
    const auto q = solved(shape, F, start);
    REQUIRE(q);
    const Points anew = ShellModel(arm.layout, shape, definition).solve(F);
    CHECK((*q - anew).cwiseAbs().maxCoeff() < 1e-7 * anew.cwiseAbs().maxCoeff());
  }
  const Points far = tilted(3);
  CHECK_FALSE(solved(far, surface_traction(arm.layout, far, downwards), start));
  // Without a load, the solution is zero.
  const Points none = Points::Zero(start.rows(), 3);
  const auto zero = solved(tilted(1e-3), none, none);
  REQUIRE(zero);
  CHECK(zero->isZero(0));
}

TEST_CASE("a shell that moves is the shell that is made anew", "[analysis][shell]") {
  const Arm arm;
  ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}},
                             {LineSupport::clamped("foot")},
                             {},
                             {}};
  // As the arm rotates, the box contains other elements.
  definition.areas = {
      {"wall", {{}, Box3(Vec3(0.5, -1, 0), Vec3(1, 1, Arm::H + 0.06))}, {Vec3::UnitX()}}};
  ShellModel moving(arm.layout, arm.shape, definition);
  const Points start = moving.solve(surface_traction(arm.layout, arm.shape, downwards));
  for (const double s : {0.02, 0.1, 0.0}) {
    Points shape = arm.shape;
    for (long m = 0; m < shape.rows(); ++m) shape(m, 2) += s * arm.shape(m, 0);
    moving.update_shape(shape);
    const Points F = surface_traction(arm.layout, shape, downwards), q = moving.solve(F);
    const Points anew = ShellModel(arm.layout, shape, definition).solve(F);
    CHECK((q - anew).cwiseAbs().maxCoeff() < 1e-9 * anew.cwiseAbs().maxCoeff());
    if (s > 0)
      CHECK((q - start).cwiseAbs().maxCoeff() > 1e-4 * start.cwiseAbs().maxCoeff());
    else
      CHECK((q - start).cwiseAbs().maxCoeff() < 1e-9 * start.cwiseAbs().maxCoeff());
  }
  CHECK_THROWS_WITH(moving.update_shape(Points::Zero(3, 3)), Contains("3 dofs"));
}

TEST_CASE("a point support holds its direction, by the displacement that it is given",
          "[analysis][shell]") {
  const Arm arm;
  const ShellLocation jack = nearest_location(arm.layout, arm.shape, {Arm::L, 0.25, Arm::H});
  const ShellDefinition definition{{{ShellMaterial::isotropic(Plates::E, 0.3), Plates::t}},
                                   {LineSupport::clamped("foot")},
                                   {{"jack", jack, {Vec3::UnitZ()}, {0, 0, 0.01}}},
                                   {}};
  const ShellModel shell(arm.layout, arm.shape, definition);
  const Points none = Points::Zero(arm.shape.rows(), 3), q = shell.solve(none);
  CHECK(arm.layout.surface(arm.shape + q).position(jack.where).z() == Approx(Arm::H + 0.01));
  const auto reactions = shell.reactions(q, none);
  REQUIRE(reactions.size() == 2);
  const Vec3 pushed = reactions[1].resultant.force;
  CHECK(pushed.z() > 0);
  CHECK((reactions[0].resultant.force + pushed).norm() < 1e-9 * pushed.norm());
}
