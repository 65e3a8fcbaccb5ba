// SPDX-License-Identifier: MPL-2.0
// Shells of several faces: transfer of moments across creases, smooth edges and T-joints.
#include <cmath>

#include "batten/analysis/models/shell_model.h"
#include "batten/core/errors.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

struct Solved {
  ModelLayout layout;
  Points shape, q;
  // The displacement in the middle of a curve.
  Vec3 at(const std::string& name) const {
    const ModelLine& line = layout.model_line(name);
    const EdgeAlignedLine& aligned_line =
        layout.region(line.sides[0].region).edge_aligned()[line.sides[0].index];
    const int v = aligned_line.vertices[aligned_line.vertices.size() / 2];
    return q.row(layout.dof_offsets(line.sides[0].region)(3 * v));
  }
};

// Clamped along "foot", with a load q downwards on one face.
Solved solved(const Plates& plates, int loaded, const std::vector<std::string>& hinges = {}) {
  const ModelLayout layout = plates.builder.model({});
  const Points shape = layout.all_dofs(plates.builder.first);
  const Surface one = layout.skinned(loaded, shape).surface;
  const VecX load = SurfaceAssembler(one.mesh(), one.kind()).area_load(one);
  const Points F = layout.spread(loaded, load) * Eigen::RowVector3d(0, 0, -Plates::q);
  const ShellModel shell(layout, shape,
                         {{{ShellMaterial::isotropic(Plates::E, 0), Plates::t}},
                          {LineSupport::clamped("foot")},
                          {},
                          hinges});
  return {layout, shape, shell.solve(F)};
}

}  // namespace

TEST_CASE("a plate of two faces bends as one, whatever the curve between them",
          "[analysis][ties]") {
  Plates plates;
  const double L = 1, exact = Plates::q * L * L * L * L / (8 * Plates::EI);
  plates.across("foot", {0, 0, 0}, {0, 0, 0});
  plates.across("between", {0.6, 0, 0}, {0.45, 0, 0});
  plates.across("tip", {L, 0, 0}, {L, 0, 0});
  plates.plate("foot", "between");
  plates.plate("between", "tip");
  // The load on both, one after the other.
  const double sum = solved(plates, 0).at("tip").z() + solved(plates, 1).at("tip").z();
  CHECK(-sum == Approx(exact).epsilon(1e-3));
}

TEST_CASE("a crease carries moments around its corner, a hinge does not", "[analysis][ties]") {
  Plates plates;
  const double L = 0.8, H = 0.6, q = Plates::q, EI = Plates::EI;
  plates.across("foot", {0, 0, 0}, {0, 0, 0});
  plates.across("knee", {0, 0, H}, {0, 0, H});
  plates.across("tip", {L, 0, H}, {L, 0, H});
  plates.plate("foot", "knee");
  plates.plate("knee", "tip");
  const Solved frame = solved(plates, 1);
  const double down = q * L * L * L * L / (8 * EI) + q * L * L / 2 * H / EI * L +
                      q * L * H / (Plates::E * Plates::t);
  CHECK(-frame.at("tip").z() == Approx(down).epsilon(1e-3));
  CHECK(frame.at("knee").x() == Approx(q * L * L / 2 * H * H / (2 * EI)).epsilon(1e-3));
  CHECK_THROWS_AS(solved(plates, 1, {"knee"}), NoSolutionError);  // the arm is a mechanism
  CHECK_THROWS_WITH(solved(plates, 1, {"foot"}), Contains("'foot' is a free edge"));
  CHECK_THROWS_WITH(solved(plates, 1, {"kne"}), Contains("knee"));
}

TEST_CASE("a third plate at a crease goes along, whatever its angle", "[analysis][ties]") {
  Plates plates;
  const double L = 0.8, H = 0.6, q = Plates::q, EI = Plates::EI;
  plates.across("foot", {0, 0, 0}, {0, 0, 0});
  plates.across("knee", {0, 0, H}, {0, 0, H});
  plates.across("tip", {L, 0, H}, {L, 0, H});
  plates.across("top", {-0.2, 0, H + 0.3}, {-0.2, 0, H + 0.3});
  plates.plate("foot", "knee");
  plates.plate("knee", "tip");
  plates.plate("knee", "top");
  const Solved frame = solved(plates, 1);
  const double turn = q * L * L / 2 * H / EI;
  CHECK(frame.at("knee").x() == Approx(turn * H / 2).epsilon(1e-3));
  // The free arm rotates with the knee about y: displacement (x, z) = (z, -x) times the rotation.
  const Vec3 moved = frame.at("top") - frame.at("knee");
  CHECK(moved.x() == Approx(turn * 0.3).epsilon(2e-3));
  CHECK(moved.z() == Approx(turn * 0.2).epsilon(2e-3));
}

TEST_CASE("a box beam in torsion rotates as in Bredt's formula", "[analysis][ties]") {
  // Four plates around, clamped at one end; moments around the closed free edge at the other are a
  // torque.
  constexpr double L = 4, a = 0.5, b = 0.3, t = 0.02, E = 1000, nu = 0.3;
  Plates plates;
  plates.h = plates.builder.options.edge_length = 0.1;
  const Vec3 corner[4] = {{0, 0, 0}, {0, a, 0}, {0, a, b}, {0, 0, b}};
  for (int k = 0; k < 4; ++k) {
    const Vec3 &p = corner[k], &q = corner[(k + 1) % 4], x(L, 0, 0);
    const std::string n = std::to_string(k);
    plates.line("foot " + n, p, q);
    plates.line("tip " + n, p + x, q + x);
    plates.line("edge " + n, p, p + x);
  }
  for (int k = 0; k < 4; ++k) {
    const std::string n = std::to_string(k), next = std::to_string((k + 1) % 4);
    plates.builder.region({"foot " + n, "edge " + next, "tip " + n, "edge " + n});
  }
  const ModelLayout layout = plates.builder.model({});
  const Points shape = layout.all_dofs(plates.builder.first);
  ShellDefinition definition{{{ShellMaterial::isotropic(E, nu), t}}, {}, {}, {}};
  Points F = Points::Zero(shape.rows(), 3);
  // A shear flow of 1 around the tip: the torque is twice the area.
  for (int k = 0; k < 4; ++k) {
    const std::string n = std::to_string(k);
    definition.lines.push_back(LineSupport::clamped("foot " + n));
    F += line_force(layout, shape, "tip " + n, (corner[(k + 1) % 4] - corner[k]).normalized());
  }
  const double torque = resultant(layout, shape, F).moment.x(), area = a * b;
  CHECK(torque == Approx(2 * area));
  const Points q = ShellModel(layout, shape, definition).solve(F);
  const Surface moved = layout.surface(q);
  // The mean rotation of its sides: they differ due to distortion of the section.
  const auto turn_at = [&](double x) {
    const auto at = [&](const Vec3& p) {
      return moved.position(nearest_location(layout, shape, p).where);
    };
    const double upright = (at({x, a, b / 2}).z() - at({x, 0, b / 2}).z()) / a,
                 level = (at({x, a / 2, 0}).y() - at({x, a / 2, b}).y()) / b;
    return (upright + level) / 2;
  };
  const double G = E / (2 * (1 + nu)), J = 4 * area * area * t / (2 * (a + b));
  // Away from both ends, where sections are free to warp.
  CHECK(turn_at(3) - turn_at(1) == Approx(torque * 2 / (G * J)).epsilon(1e-2));
}

TEST_CASE("rigid motions of a model keep its ties", "[analysis][ties]") {
  Plates plates;
  plates.across("foot", {0, 0, 0}, {0.1, 0, 0});
  plates.across("knee", {0, 0, 0.5}, {0, 0, 0.6});
  plates.across("tip", {0.7, 0, 0.4}, {0.6, 0, 0.5});
  plates.plate("foot", "knee");
  plates.plate("knee", "tip");
  const ModelLayout layout = plates.builder.model({});
  const Points shape = layout.all_dofs(plates.builder.first);
  const ConstraintSet ties =
      shell_ties(layout, shape, {{ShellMaterial::isotropic(1, 0), 1}}).constraints;
  for (int c = 0; c < 3; ++c) {
    Points turn(shape.rows(), 3);
    for (long d = 0; d < turn.rows(); ++d)
      turn.row(d) = Vec3::Unit(c).cross(Vec3(shape.row(d))).transpose();
    CHECK(ties.max_residual(turn) < 1e-9);
    CHECK(ties.max_residual(layout.position_dofs() * Vec3::Unit(c).transpose()) < 1e-12);
  }
}
