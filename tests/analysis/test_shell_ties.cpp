// Shells of several regions: moments go around creases, through smooth lines and T-joints.
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "batten/analysis/models/shell_model.h"
#include "batten/core/errors.h"
#include "batten/fem/assembly.h"
#include "batten/skinning/model/natural_shape.h"
#include "batten/tests/analysis/plates.h"
#include "batten/tests/catch.h"
#include "batten/tests/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

struct Solved {
  ModelLayout layout;
  Points shape, q;
  // The displacement in the middle of a line.
  Vec3 at(const std::string& name) const {
    const ModelLine& line = layout.model_line(name);
    const LineRun& run = layout.region(line.sides[0].region).runs()[line.sides[0].index];
    const int v = run.vertices[run.vertices.size() / 2];
    return q.row(layout.numbers(line.sides[0].region)(3 * v));
  }
};

// The dofs of the cylinder (R sin a, R cos a, z) over a plane domain, which is its projection.
Points over_plane(const RegionLayout& layout, double R) {
  MatX x(0, 4), uv(0, 2);
  for (const EmbeddedLine& line : layout.embedded())
    for (const double t : line.points) {
      x.conservativeResize(x.rows() + 1, 4);
      uv.conservativeResize(x.rows(), 2);
      x.bottomRows(1) << line.fitted.evaluate(t).transpose(), 1;
      uv.bottomRows(1) << line.image.evaluate(t).head<2>().transpose();
    }
  const MatX projection = x.colPivHouseholderQr().solve(uv);  // 4×2
  return interpolated(
             layout.mesh(), layout.element(),
             [&](const Vec2& p) {
               Vec2 at(0.3, 0.5 * R);  // (a, z), by Newton's method
               Eigen::Matrix<double, 3, 2> d;
               Mat2 J;
               SurfaceJet j{};
               for (int step = 0; step < 30; ++step) {
                 j.x = {R * std::sin(at[0]), R * std::cos(at[0]), at[1]};
                 d << R * std::cos(at[0]), 0, -R * std::sin(at[0]), 0, 0, 1;
                 J = projection.topRows(3).transpose() * d;
                 const Vec2 missed =
                     projection.transpose() * Eigen::Vector4d(j.x.x(), j.x.y(), j.x.z(), 1) - p;
                 at -= J.inverse() * missed;
               }
               d = d * J.inverse();
               j.x_u = d.col(0);
               j.x_v = d.col(1);
               return j;
             })
      .dofs();
}

// Clamped along "foot", loaded by q downwards on one region.
Solved solved(const Plates& plates, int loaded, const std::vector<std::string>& hinges = {}) {
  const ModelLayout layout = plates.patchwork.model({});
  const Points shape = layout.all_dofs(plates.patchwork.first);
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

TEST_CASE("a plate in two regions bends as one, whatever the line between them") {
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

TEST_CASE("a crease carries moments around its corner, a hinge does not") {
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
  CHECK_THROWS_AS(solved(plates, 1, {"knee"}), NoSolutionError);  // the arm swings
  CHECK_THROWS_WITH(solved(plates, 1, {"foot"}), Contains("'foot' is a rim"));
  CHECK_THROWS_WITH(solved(plates, 1, {"kne"}), Contains("knee"));
}

TEST_CASE("a third plate at a crease goes along, whatever its angle") {
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
  // Free, it turns with the knee about y: (x, z) by (z, -x) of the turn.
  const Vec3 moved = frame.at("top") - frame.at("knee");
  CHECK(moved.x() == Approx(turn * 0.3).epsilon(2e-3));
  CHECK(moved.z() == Approx(turn * 0.2).epsilon(2e-3));
}

TEST_CASE("the Scordelis-Lo roof comes out the same in one region, in two, and trimmed") {
  constexpr double R = 25, half = 40 * std::numbers::pi / 180, reference = 0.30059;
  const auto arc = [&](double from, double to, double z) {
    return curve_from_formula(0, 1, [=](double s, int order) -> Vec3 {
      const double a = from + s * (to - from), w = to - from;
      if (order == 0) return {R * std::sin(a), R * std::cos(a), z};
      if (order == 1) return w * R * Vec3(std::cos(a), -std::sin(a), 0);
      return w * w * R * Vec3(-std::sin(a), -std::cos(a), 0);
    });
  };
  const auto generator = [&](double a) {
    return curve_from_formula(0, 1, [=](double s, int order) -> Vec3 {
      if (order == 0) return {R * std::sin(a), R * std::cos(a), R * s};
      return order == 1 ? Vec3(0, 0, R) : Vec3(0, 0, 0);
    });
  };
  const auto roof = [&](bool cut, SkinOptions::Domain domain) {
    Patchwork p;
    p.options.edge_length = 1.6;
    p.options.domain = domain;
    p.size = R;
    const double at = cut ? 0.55 * half : half;
    const auto add = [&](const std::string& name, const std::shared_ptr<const InputCurve>& curve) {
      p.add(given_line(name, curve, R, p.options.edge_length));
    };
    add("crown", generator(0));
    add("free", generator(half));
    add("middle 1", arc(0, at, 0));
    add("wall 1", arc(0, at, R));
    if (cut) {
      add("between", generator(at));
      add("middle 2", arc(at, half, 0));
      add("wall 2", arc(at, half, R));
      p.region({"crown", "middle 1", "between", "wall 1"});
      p.region({"between", "middle 2", "free", "wall 2"});
    } else {
      p.region({"crown", "middle 1", "free", "wall 1"});
    }
    const ModelLayout layout = p.model({});
    const Points shape = domain == SkinOptions::Domain::Plane
                             ? over_plane(layout.region(0), R)
                             : layout.least_energy({}, natural_dofs(layout));
    ShellDefinition definition{{{ShellMaterial::isotropic(4.32e8, 0), 0.25}},
                               {LineSupport::symmetric("crown", Vec3::UnitX())},
                               {},
                               {}};
    for (int part = 1; part <= (cut ? 2 : 1); ++part) {
      const std::string k = std::to_string(part);
      definition.lines.push_back(LineSupport::symmetric("middle " + k, Vec3::UnitZ()));
      definition.lines.push_back(
          {"wall", "wall " + k, {Vec3::UnitX(), Vec3::UnitY()}, Vec3::Zero(), false});
    }
    Points F = Points::Zero(shape.rows(), 3);
    for (int r = 0; r < layout.region_count(); ++r) {
      const Surface one = layout.skinned(r, shape).surface;
      const VecX load = SurfaceAssembler(one.mesh(), one.kind(), one.trim()).area_load(one);
      F += layout.spread(r, load) * Eigen::RowVector3d(0, -90, 0);
    }
    const Points q = ShellModel(layout, shape, definition).solve(F);
    // At the free edge, in the middle of the roof.
    const int last = layout.region_count() - 1;
    const Surface moved = layout.skinned(last, q + shape).surface;
    const Surface still = layout.skinned(last, shape).surface;
    const Location where = still.closest_point({R * std::sin(half), R * std::cos(half), 0}).where;
    return still.position(where).y() - moved.position(where).y();
  };
  CHECK(roof(false, SkinOptions::Domain::Polygon) == Approx(reference).epsilon(2e-3));
  CHECK(roof(true, SkinOptions::Domain::Polygon) == Approx(reference).epsilon(5e-3));
  CHECK(roof(false, SkinOptions::Domain::Plane) == Approx(reference).epsilon(5e-4));
}

TEST_CASE("a box beam in torsion turns as Bredt says") {
  // Four plates around, clamped at one end; a closed rim of moments is a torque at the other.
  constexpr double L = 4, a = 0.5, b = 0.3, t = 0.02, E = 1000, nu = 0.3;
  Plates plates;
  plates.h = plates.patchwork.options.edge_length = 0.1;
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
    plates.patchwork.region({"foot " + n, "edge " + next, "tip " + n, "edge " + n});
  }
  const ModelLayout layout = plates.patchwork.model({});
  const Points shape = layout.all_dofs(plates.patchwork.first);
  ShellDefinition definition{{{ShellMaterial::isotropic(E, nu), t}}, {}, {}, {}};
  Points F = Points::Zero(shape.rows(), 3);
  // A shear flow of 1 around the tip: the torque is twice the area.
  for (int k = 0; k < 4; ++k) {
    const std::string n = std::to_string(k);
    definition.lines.push_back(LineSupport::clamped("foot " + n));
    F += line_force(layout, "tip " + n, (corner[(k + 1) % 4] - corner[k]).normalized());
  }
  const double torque = resultant(layout, shape, F).moment.x(), area = a * b;
  CHECK(torque == Approx(2 * area));
  const Points q = ShellModel(layout, shape, definition).solve(F);
  const Surface moved = layout.surface(q);
  // The mean of what its sides turn: where the section is distorted they differ.
  const auto turn_at = [&](double x) {
    const auto at = [&](const Vec3& p) {
      return moved.position(nearest_place(layout, shape, p).where);
    };
    const double upright = (at({x, a, b / 2}).z() - at({x, 0, b / 2}).z()) / a,
                 level = (at({x, a / 2, 0}).y() - at({x, a / 2, b}).y()) / b;
    return (upright + level) / 2;
  };
  const double G = E / (2 * (1 + nu)), J = 4 * area * area * t / (2 * (a + b));
  // Away from both ends, where sections warp freely.
  CHECK(turn_at(3) - turn_at(1) == Approx(torque * 2 / (G * J)).epsilon(1e-2));
}

TEST_CASE("rigid motions of a model keep its ties") {
  Plates plates;
  plates.across("foot", {0, 0, 0}, {0.1, 0, 0});
  plates.across("knee", {0, 0, 0.5}, {0, 0, 0.6});
  plates.across("tip", {0.7, 0, 0.4}, {0.6, 0, 0.5});
  plates.plate("foot", "knee");
  plates.plate("knee", "tip");
  const ModelLayout layout = plates.patchwork.model({});
  const Points shape = layout.all_dofs(plates.patchwork.first);
  const ConstraintSet ties = shell_ties(layout, shape, {{ShellMaterial::isotropic(1, 0), 1}}).rows;
  for (int c = 0; c < 3; ++c) {
    Points turn(shape.rows(), 3);
    for (long d = 0; d < turn.rows(); ++d)
      turn.row(d) = Vec3::Unit(c).cross(Vec3(shape.row(d))).transpose();
    CHECK(ties.max_residual(turn) < 1e-9);
    CHECK(ties.max_residual(layout.position_dofs() * Vec3::Unit(c).transpose()) < 1e-12);
  }
}
