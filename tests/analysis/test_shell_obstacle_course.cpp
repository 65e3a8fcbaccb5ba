// SPDX-License-Identifier: MPL-2.0
// The shell obstacle course on models: as one face, as two faces, and trimmed.
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/core/eigen.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_model_builder.h"

using namespace batten_test;

namespace {

constexpr double pi = std::numbers::pi, degree = pi / 180;
enum class Subdivision { One, Two, Trimmed };

// A part of a surface x(a, b) over the unit square.
struct Piece {
  std::function<SurfaceJet(double a, double b)> at;

  std::shared_ptr<const InputCurve> line(const Vec2& from, const Vec2& to) const {
    return curve_from_formula(0, 1, [=, at = at](double s, int order) -> Vec3 {
      const Vec2 p = from + s * (to - from), d = to - from;
      const SurfaceJet j = at(p.x(), p.y());
      if (order == 0) return j.x;
      if (order == 1) return d.x() * j.x_u + d.y() * j.x_v;
      return d.x() * d.x() * j.x_uu + 2 * d.x() * d.y() * j.x_uv + d.y() * d.y() * j.x_vv;
    });
  }
};

Piece cylinder(double R, double angle, double length) {
  return {[=](double a, double b) {
    const double s = std::sin(angle * a), c = std::cos(angle * a);
    SurfaceJet j{};
    j.x = {R * s, R * c, length * b};
    j.x_u = angle * R * Vec3(c, -s, 0);
    j.x_v = {0, 0, length};
    j.x_uu = -angle * angle * R * Vec3(s, c, 0);
    return j;
  }};
}

Piece sphere(double R, double top) {
  return {[=](double u, double v) {
    const double a = pi / 2 * u, b = top * v, ca = std::cos(a), sa = std::sin(a), cb = std::cos(b),
                 sb = std::sin(b);
    SurfaceJet j{};
    j.x = R * Vec3(cb * ca, cb * sa, sb);
    j.x_u = pi / 2 * R * Vec3(-cb * sa, cb * ca, 0);
    j.x_v = top * R * Vec3(-sb * ca, -sb * sa, cb);
    j.x_uu = -pi * pi / 4 * R * Vec3(cb * ca, cb * sa, 0);
    j.x_uv = pi / 2 * top * R * Vec3(sb * sa, -sb * ca, 0);
    j.x_vv = -top * top * j.x;
    return j;
  }};
}

// Dofs of the part over a planar domain, which is its projection.
Points parametrize(const RegionLayout& layout, const Piece& piece) {
  MatX x(0, 4), uv(0, 2);
  for (const EmbeddedLine& line : layout.embedded())
    for (const double t : line.points) {
      x.conservativeResize(x.rows() + 1, 4);
      uv.conservativeResize(x.rows(), 2);
      x.bottomRows(1) << line.fitted.evaluate(t).transpose(), 1;
      uv.bottomRows(1) << line.pcurve.evaluate(t).head<2>().transpose();
    }
  const MatX projection = least_squares(x, uv);  // 4×2
  return interpolated(
             layout.mesh(), layout.element(),
             [&](const Vec2& p) {
               Vec2 at(0.5, 0.5);
               SurfaceJet j{};
               for (int step = 0; step < 50; ++step) {
                 j = piece.at(at.x(), at.y());
                 Eigen::Matrix<double, 3, 2> d;
                 d << j.x_u, j.x_v;
                 const Mat2 J = projection.topRows(3).transpose() * d;
                 const Vec2 missed =
                     projection.transpose() * Eigen::Vector4d(j.x.x(), j.x.y(), j.x.z(), 1) - p;
                 at -= J.inverse() * missed;
                 d = d * J.inverse();
                 j.x_u = d.col(0);
                 j.x_v = d.col(1);
               }
               return j;
             })
      .dofs();
}

// A part as a model; its sides are "a0", "b1", "a1", "b0" (a = 0, b = 1, …). Sides with constant b
// consist of two parts, "b0 1" and "b0 2", if the model is split in two along a = middle.
struct Course {
  TestModelBuilder builder;
  ModelLayout layout;
  Points shape;

  static TestModelBuilder lines(const Piece& piece, double size, double h, Subdivision cut,
                                double middle) {
    TestModelBuilder p;
    p.options.edge_length = h;
    p.options.domain =
        cut == Subdivision::Trimmed ? SkinOptions::Domain::Projected : SkinOptions::Domain::Polygon;
    p.size = size;
    const auto add = [&](const std::string& name, const Vec2& from, const Vec2& to) {
      p.add(prescribed_line(name, piece.line(from, to), size, h));
    };
    add("a0", {0, 0}, {0, 1});
    add("a1", {1, 0}, {1, 1});
    const double end = cut == Subdivision::Two ? middle : 1;
    add("b0 1", {0, 0}, {end, 0});
    add("b1 1", {0, 1}, {end, 1});
    if (cut != Subdivision::Two) {
      p.region({"a0", "b0 1", "a1", "b1 1"});
      return p;
    }
    add("between", {end, 0}, {end, 1});
    add("b0 2", {end, 0}, {1, 0});
    add("b1 2", {end, 1}, {1, 1});
    p.region({"a0", "b0 1", "between", "b1 1"});
    p.region({"between", "b0 2", "a1", "b1 2"});
    return p;
  }
  Course(const Piece& piece, double size, double h, Subdivision cut, double middle)
      : builder(lines(piece, size, h, cut, middle)), layout(builder.model({})) {
    shape = cut == Subdivision::Trimmed ? parametrize(layout.region(0), piece) : rest_dofs(layout);
    if (shape.rows() == 0) shape = layout.all_dofs(builder.first);  // planar
  }
  // The parts of a side.
  std::vector<std::string> side(const std::string& name) const {
    if (name[0] == 'a') return {name};
    if (layout.region_count() == 2) return {name + " 1", name + " 2"};
    return {name + " 1"};
  }
};

// The shells of the course, a part of each between planes of symmetry.
struct ShellResult {
  double displacement;  ///< of the reference point
  double energy, estimate;
};

Vec3 weight(const Vec3&, const Vec3&) { return {0, -90, 0}; }

struct Shell {
  Course course;
  ShellDefinition definition;

  Shell(const Piece& piece, double size, double h, Subdivision cut, double middle,
        const ShellSection& section)
      : course(piece, size, h, cut, middle), definition{{section}, {}, {}, {}} {}
  void symmetric(const std::string& side, const Vec3& normal) {
    for (const std::string& line : course.side(side))
      definition.lines.push_back(LineSupport::symmetric(line, normal));
  }
  // A diaphragm, rigid in its plane and flexible out of it.
  void diaphragm(const std::string& side) {
    for (const std::string& line : course.side(side))
      definition.lines.push_back(
          {"wall", line, {Vec3::UnitX(), Vec3::UnitY()}, Vec3::Zero(), false});
  }
  ShellLocation nearest(const Vec3& p) const {
    return nearest_location(course.layout, course.shape, p);
  }
  Points at(const ShellLocation& place, const Vec3& force) const {
    return point_force(course.layout, place, force);
  }
  ShellResult answer(const Points& load, const ShellLocation& place, const Vec3& direction) const {
    const ShellModel shell(course.layout, course.shape, definition);
    const Points q = shell.solve(load);
    return {at(place, direction).cwiseProduct(q).sum(), shell.energy(q),
            ShellStresses(shell, q).energy_norm_error()};
  }
};

ShellResult scordelis_lo(double n, Subdivision cut) {
  constexpr double R = 25, angle = 40 * degree;
  const Piece roof = cylinder(R, angle, R);
  Shell s(roof, R, R * angle / n, cut, 0.55, {ShellMaterial::isotropic(4.32e8, 0), 0.25});
  s.symmetric("a0", Vec3::UnitX());
  s.symmetric("b0", Vec3::UnitZ());
  s.diaphragm("b1");
  return s.answer(surface_traction(s.course.layout, s.course.shape, weight),
                  s.nearest(roof.at(1, 0).x), {0, -1, 0});
}

ShellResult pinched_cylinder(double n, Subdivision cut) {
  constexpr double R = 300;
  const Piece wall = cylinder(R, pi / 2, R);
  Shell s(wall, R, R * pi / 2 / n, cut, 0.55, {ShellMaterial::isotropic(3e6, 0.3), 3});
  s.symmetric("a0", Vec3::UnitX());
  s.symmetric("a1", Vec3::UnitY());
  s.symmetric("b0", Vec3::UnitZ());
  s.diaphragm("b1");
  const ShellLocation top = s.nearest(wall.at(0, 0).x);
  return s.answer(s.at(top, {0, -0.25, 0}), top, {0, -1, 0});
}

ShellResult hemisphere(double n, Subdivision cut) {
  constexpr double R = 10;
  const Piece shell = sphere(R, 72 * degree);
  Shell s(shell, R, R * pi / 2 / n, cut, 0.5, {ShellMaterial::isotropic(6.825e7, 0.3), 0.04});
  s.symmetric("a0", Vec3::UnitY());
  s.symmetric("a1", Vec3::UnitX());
  const ShellLocation x = s.nearest(shell.at(0, 0).x), y = s.nearest(shell.at(1, 0).x);
  s.definition.points.push_back({"foot", x, {Vec3::UnitZ()}});
  return s.answer(s.at(x, {1, 0, 0}) + s.at(y, {0, -1, 0}), x, {1, 0, 0});
}

const char* name(Subdivision cut) {
  return cut == Subdivision::One   ? "one region"
         : cut == Subdivision::Two ? "two regions"
                                   : "trimmed";
}

// The estimate is the true error within a factor of two; `energy` is the exact one.
void check_estimate(const ShellResult& a, double energy) {
  const double error = std::sqrt(1 - a.energy / energy);
  INFO("true error " << error << ", estimate " << a.estimate);
  CHECK(a.estimate < 2 * error);
  CHECK(a.estimate > 0.5 * error);
}

}  // namespace

TEST_CASE("the obstacle course gives the same results with one face, with two, and trimmed",
          "[analysis][shell]") {
  for (const Subdivision cut : {Subdivision::One, Subdivision::Two, Subdivision::Trimmed}) {
    INFO(name(cut));
    CHECK(scordelis_lo(16, cut).displacement == Approx(0.30059).epsilon(2e-3));
    CHECK(pinched_cylinder(40, cut).displacement == Approx(1.8248e-5).epsilon(5e-3));
    CHECK(hemisphere(24, cut).displacement == Approx(0.0935).epsilon(2e-3));
  }
}

TEST_CASE(
    "the skin of a sphere under pressure carries p R/2 both ways, better with each refinement",
    "[analysis][shell]") {
  const double R = 2, t = 0.01, p = 3, E = 1000, nu = 0.3;
  // R (a, b, 1 - a - b)/|…|: an octant.
  const Piece octant{[R](double a, double b) {
    const Vec3 y(a, b, 1 - a - b), y_a(1, 0, -1), y_b(0, 1, -1), n = y.normalized();
    const auto along = [&](const Vec3& d) -> Vec3 { return R / y.norm() * (d - n.dot(d) * n); };
    SurfaceJet j{};
    j.x = R * n;
    j.x_u = along(y_a);
    j.x_v = along(y_b);
    return j;
  }};
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  double last = 1;
  for (const double h : {0.6, 0.3, 0.15}) {
    TestModelBuilder sheet;
    sheet.options.edge_length = h;
    sheet.options.domain = SkinOptions::Domain::Projected;
    for (const auto& [name, a, b] :
         {std::tuple<const char*, Vec3, Vec3>{"zx", z, x}, {"xy", x, y}, {"yz", y, z}})
      sheet.add(prescribed_line(name, quarter(R * a, R * b), R, h));
    sheet.region({"zx", "xy", "yz"});
    const ModelLayout layout = sheet.model({});
    const Points shape = parametrize(layout.region(0), octant);
    const ShellModel shell(layout, shape,
                           {{{ShellMaterial::isotropic(E, nu), t}},
                            {LineSupport::symmetric("zx", y), LineSupport::symmetric("xy", z),
                             LineSupport::symmetric("yz", x)},
                            {},
                            {}});
    const Points q = shell.solve(surface_traction(
        layout, shape, [p](const Vec3& at, const Vec3&) -> Vec3 { return p * at.normalized(); }));
    double worst = 0;
    const ShellStresses stresses(shell, q);
    const Surface moved = layout.surface(q);
    for (const Vec3& to : {Vec3(1, 1, 1), Vec3(2, 1, 1), Vec3(1, 3, 1)}) {
      const ShellLocation place = nearest_location(layout, shape, R * to.normalized());
      const auto [most, least] = principal(stresses.at(place.where).at(0));
      worst = std::max(
          {worst, std::abs(most * t / (p * R / 2) - 1), std::abs(least * t / (p * R / 2) - 1)});
      CHECK(moved.position(place.where).norm() ==
            Approx(p * R * R * (1 - nu) / (2 * E * t)).epsilon(0.02));
    }
    CHECK(worst < last);
    last = worst / 2;
  }
  CHECK(last < 2e-3);
}

TEST_CASE("plates bend as in theory, clamped and simply supported", "[analysis][shell]") {
  constexpr double t = 0.01, E = 1000, nu = 0.3, q = 1e-5;
  const double D = E * t * t * t / (12 * (1 - nu * nu));
  const Piece square{[](double a, double b) {
    SurfaceJet j{};
    j.x = {a, b, 0};
    j.x_u = {1, 0, 0};
    j.x_v = {0, 1, 0};
    return j;
  }};
  for (const Subdivision cut : {Subdivision::One, Subdivision::Two, Subdivision::Trimmed})
    for (const bool clamped : {true, false}) {
      INFO(name(cut) << (clamped ? ", clamped" : ", simply supported"));
      Shell s(square, 1, 0.08, cut, 0.55, {ShellMaterial::isotropic(E, nu), t});
      for (const char* side : {"a0", "a1", "b0", "b1"})
        for (const std::string& line : s.course.side(side))
          s.definition.lines.push_back(clamped ? LineSupport::clamped(line)
                                               : LineSupport::pinned(line));
      const ShellResult a = s.answer(surface_traction(s.course.layout, s.course.shape,
                                                      [](const Vec3&, const Vec3&) -> Vec3 {
                                                        return {0, 0, -q};
                                                      }),
                                     s.nearest({0.5, 0.5, 0}), {0, 0, -1});
      CHECK(a.displacement == Approx((clamped ? 0.00126532 : 0.00406235) * q / D).epsilon(5e-3));
    }
}

TEST_CASE("the error estimate is right within a factor of two, also where elements lock",
          "[analysis][shell]") {
  for (const Subdivision cut : {Subdivision::One, Subdivision::Two, Subdivision::Trimmed}) {
    INFO(name(cut));
    const double roof = scordelis_lo(24, cut).energy;
    for (const double n : {4.0, 6.0}) check_estimate(scordelis_lo(n, cut), roof);
    for (const double n : {8.0, 16.0})
      check_estimate(pinched_cylinder(n, cut), 0.5 * 0.25 * 1.8248e-5);
    for (const double n : {8.0, 12.0}) check_estimate(hemisphere(n, cut), 0.0935);
  }
}
