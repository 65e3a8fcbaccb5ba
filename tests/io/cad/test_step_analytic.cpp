// SPDX-License-Identifier: MPL-2.0
// Planes, cylinders, spheres, cones and tori become analytic faces in the file, and CAD programs
// accept them as valid.
#include <BRepAdaptor_Surface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "batten/io/step/step.h"
#include "batten/io/step/step_check.h"
#include "batten/tests/io/cad/bop_faults.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;

namespace {

using std::numbers::pi;
using Map = std::function<Vec3(const Vec3&)>;
using Kinds = std::map<std::string, int>;

/// The directional derivative of a map.
Vec3 along(const Map& map, const Vec3& x, const Vec3& direction) {
  constexpr double step = 1e-4;
  const double length = direction.norm();
  if (length == 0) return Vec3::Zero();
  const Vec3 d = step / length * direction;
  return (map(x + d) - map(x - d)) * (length / (2 * step));
}

HermiteCurve mapped(const HermiteCurve& curve, const Map& map) {
  Points dofs = curve.dofs();
  for (int i = 0; i < curve.node_count(); ++i) {
    dofs.row(curve.mesh().position_dof(i)) = map(curve.position(i));
    for (const int slope : {curve.mesh().slope_in(i), curve.mesh().slope_out(i)})
      dofs.row(slope) = along(map, curve.position(i), curve.dofs().row(slope));
  }
  return {curve.mesh(), dofs};
}

/// The surface whose vertices and derivatives are mapped from another one.
Surface mapped(const Surface& surface, const Map& map) {
  const ParametricMesh& mesh = surface.mesh();
  const DofMap& at = surface.dof_map();
  Points dofs = surface.dofs();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 x = surface.dofs().row(at.vertex(v));
    dofs.row(at.vertex(v)) = map(x);
    for (const int k : {1, 2})
      dofs.row(at.vertex(v) + k) = along(map, x, surface.dofs().row(at.vertex(v) + k));
  }
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int local = 0; local < 3; ++local) {
      const int edge = mesh.edges_of(t)[static_cast<size_t>(local)];
      Vec3 L = Vec3::Constant(0.5);
      L[local] = 0;
      const SurfaceJet jet = surface.jet({t, L});
      const Vec2 n = mesh.edge_normal(edge);
      dofs.row(at.edge(edge)) = along(map, jet.x, n.x() * jet.x_u + n.y() * jet.x_v);
    }
  return {surface.shared_mesh(), surface.kind(), dofs, surface.trim()};
}

/// A face moved in space, with its curves moved or unmoved.
SkinnedRegion mapped(const SkinnedRegion& region, const Map& map, bool lines = true) {
  SkinnedRegion moved = region;
  moved.surface = mapped(region.surface, map);
  if (!lines) return moved;
  for (EdgeAlignedLine& aligned_line : moved.edge_aligned)
    aligned_line.fitted = mapped(aligned_line.fitted, map);
  for (EmbeddedLine& line : moved.embedded) line.fitted = mapped(line.fitted, map);
  return moved;
}

struct Written {
  StepReport report;
  Kinds kinds;  // of faces read back
  std::vector<double>
      radii;  // of cylinders, spheres, and the tubes of tori, in the order of the file
  int faults = 0;
};

Written written(const std::vector<SkinnedRegion>& regions, const std::string& name,
                double tolerance, bool analytic = true) {
  std::vector<const SkinnedRegion*> pointers;
  for (const SkinnedRegion& region : regions) pointers.push_back(&region);
  StepFaceOptions options;
  options.tolerance = tolerance;
  options.analytic = analytic;
  const auto path = scratch("step_analytic_" + name) / (name + ".step");
  Written w;
  w.report = write_step_faces(path, pointers, kMm, options);
  for (TopExp_Explorer it(read_step(path), TopAbs_FACE); it.More(); it.Next()) {
    const BRepAdaptor_Surface face(TopoDS::Face(it.Current()));
    const auto type = face.GetType();
    ++w.kinds[type == GeomAbs_Plane      ? "plane"
              : type == GeomAbs_Cylinder ? "cylinder"
              : type == GeomAbs_Sphere   ? "sphere"
              : type == GeomAbs_Cone     ? "cone"
              : type == GeomAbs_Torus    ? "torus"
                                         : "B-spline"];
    if (type == GeomAbs_Cylinder) w.radii.push_back(face.Cylinder().Radius());
    if (type == GeomAbs_Sphere) w.radii.push_back(face.Sphere().Radius());
    if (type == GeomAbs_Torus) w.radii.push_back(face.Torus().MinorRadius());
  }
  w.faults = faults(path);
  Kinds said;
  for (const StepPatch& patch : w.report.patches) ++said[patch.surface];
  CHECK(said == w.kinds);
  CHECK(w.report.valid);
  CHECK(w.report.reached);
  CHECK(*w.report.max_deviation <= tolerance);
  CHECK(w.faults == 0);
  return w;
}

void check_solid(const Written& w, double volume) {
  CHECK(w.report.solids == 1);
  CHECK(w.report.free_edges == 0);
  CHECK(w.report.volume == Approx(volume).epsilon(1e-4));
}

constexpr double kRadius = 20, kHeight = 40;

/// The tube between two circles, and its caps: faces 0, 1 (at z = kHeight) and 2 (the tube).
std::vector<SkinnedRegion> can(double from = 0, double edge_length = 5) {
  const BuiltModel made =
      build_model({circle_line("low", kRadius, 0), circle_line("high", kRadius, kHeight, from)},
                  region_specs({{{"low"}}, {{"high"}}, {{"low"}, {"high"}}}), edge_length);
  std::vector<SkinnedRegion> regions;
  for (const SkinnedRegion* region : made.model.skinned()) regions.push_back(*region);
  REQUIRE(regions.size() == 3);
  return regions;
}

}  // namespace

TEST_CASE("a can is a cylinder and two planes, closed and valid", "[io][step]") {
  // Circles that start at the same angle, at different angles, and too close for an edge between
  // the starts.
  for (const double from : {0.0, 1.3, 1e-3}) {
    CAPTURE(from);
    const Written w = written(can(from), "can", 5e-3);
    CHECK(w.kinds == Kinds{{"cylinder", 1}, {"plane", 2}});
    REQUIRE(w.radii.size() == 1);
    CHECK(w.radii[0] == Approx(kRadius).epsilon(1e-5));
    check_solid(w, pi * kRadius * kRadius * kHeight);
    CHECK(w.report.area == Approx(2 * pi * kRadius * (kRadius + kHeight)).epsilon(1e-4));
  }
}

TEST_CASE("without analytic faces the same can is made of splines", "[io][step]") {
  const Written w = written(can(), "splines", 5e-3, false);
  CHECK(w.kinds == Kinds{{"B-spline", 3}});
  check_solid(w, pi * kRadius * kRadius * kHeight);
}

TEST_CASE("a tube alone keeps its two free edges", "[io][step]") {
  const Written w = written({can()[2]}, "tube", 5e-3);
  CHECK(w.kinds == Kinds{{"cylinder", 1}});
  CHECK(w.report.solids == 0);
  CHECK(w.report.free_edges == 2);
  CHECK(w.report.area == Approx(2 * pi * kRadius * kHeight).epsilon(1e-4));
}

TEST_CASE("walls that face inwards are cylinders too", "[io][step]") {
  const BuiltModel made =
      build_model({circle_line("low", 20, 0), circle_line("high", 20, 30, 2),
                   circle_line("hole low", 8, 0), circle_line("hole high", 8, 30, 1)},
                  region_specs({{{"low"}, {"high"}},
                                {{"hole low"}, {"hole high"}},
                                {{"low"}, {"hole low"}},
                                {{"high"}, {"hole high"}}}),
                  3);
  std::vector<SkinnedRegion> regions;
  for (const SkinnedRegion* region : made.model.skinned()) regions.push_back(*region);
  REQUIRE(regions.size() == 4);
  const Written w = written(regions, "washer", 5e-3);
  CHECK(w.kinds == Kinds{{"cylinder", 2}, {"plane", 2}});
  check_solid(w, pi * (400 - 64) * 30);
}

TEST_CASE("a vessel is a cylinder and a hemisphere with its pole, smooth where they meet",
          "[io][step]") {
  std::vector<SkinnedRegion> regions = can();
  // The cap becomes the head: equal steps of the radius are equal steps of latitude.
  regions[1] = mapped(
      regions[1],
      [](const Vec3& x) {
        const double r = std::hypot(x.x(), x.y()), a = r / kRadius * pi / 2;
        const double out = r > 1e-9 ? kRadius * std::sin(a) / r : pi / 2;
        return Vec3(out * x.x(), out * x.y(), kHeight + kRadius * std::cos(a));
      },
      false);
  const Written w = written(regions, "vessel", 5e-3);
  CHECK(w.kinds == Kinds{{"cylinder", 1}, {"plane", 1}, {"sphere", 1}});
  for (const double radius : w.radii) CHECK(radius == Approx(kRadius).epsilon(2e-5));
  check_solid(w, pi * kRadius * kRadius * (kHeight + 2 * kRadius / 3));
  REQUIRE(w.report.joins.size() == 1);
  CHECK(w.report.joins[0].line == "high");
  CHECK(w.report.joins[0].reached);
  CHECK(w.report.joins[0].angle_deg < 0.1);
}

TEST_CASE("a quarter of a vessel is a cylinder and a sphere without a pole", "[io][step]") {
  const auto straight_up = [](const std::string& name, double x, double y) {
    return straight(name, Vec3(x, y, -20), Vec3(x, y, 0));
  };
  const Vec3 x = 10 * Vec3::UnitX(), y = 10 * Vec3::UnitY(), z = 10 * Vec3::UnitZ();
  const auto foot = quarter("foot", x, y);
  const BuiltModel made = build_model(
      {CharacterLine{"foot", curve_from_formula(0, pi / 2,
                                                [](double t, int order) {
                                                  const Vec3 c(std::cos(t), std::sin(t), 0),
                                                      s(-std::sin(t), std::cos(t), 0);
                                                  return order == 0 ? Vec3(10 * c - Vec3(0, 0, 20))
                                                         : order == 1 ? Vec3(10 * s)
                                                                      : Vec3(-10 * c);
                                                })},
       quarter("joint", x, y), quarter("head x", x, z), quarter("head y", y, z),
       straight_up("side x", 10, 0), straight_up("side y", 0, 10)},
      {}, 2);
  std::vector<SkinnedRegion> regions;
  for (const SkinnedRegion* region : made.model.skinned()) regions.push_back(*region);
  REQUIRE(regions.size() == 2);
  for (SkinnedRegion& region : regions) {
    const bool head = region.surface.position({0, Vec3::Constant(1.0 / 3)}).z() > 0;
    region = mapped(
        region,
        [head](const Vec3& p) {
          if (head) return Vec3(10 * p.normalized());
          const double r = std::hypot(p.x(), p.y());
          return Vec3(10 * p.x() / r, 10 * p.y() / r, p.z());
        },
        false);
  }
  const Written w = written(regions, "quarter_vessel", 3e-3);
  CHECK(w.kinds == Kinds{{"cylinder", 1}, {"sphere", 1}});
  for (const double radius : w.radii) CHECK(radius == Approx(10).epsilon(3e-4));
  CHECK(w.report.area == Approx(pi / 2 * 10 * (20 + 10)).epsilon(2e-4));
  REQUIRE(w.report.joins.size() == 1);
  CHECK(w.report.joins[0].angle_deg < 0.1);
}

TEST_CASE("a bent can is a torus and a tapered one a cone", "[io][step]") {
  const auto closed = [](const std::string& name, const Map& map, const std::string& kind,
                         double volume) {
    CAPTURE(name);
    std::vector<SkinnedRegion> regions = can(0.7, 3);
    for (SkinnedRegion& region : regions) region = mapped(region, map);
    const Written w = written(regions, name, 8e-3);
    CHECK(w.kinds == Kinds{{"plane", 2}, {kind, 1}});
    check_solid(w, volume);
  };
  constexpr double spine = 50;
  closed(
      "elbow",
      [](const Vec3& x) {
        const double a = x.z() / kHeight * pi / 2, r = spine + x.x();
        return Vec3(r * std::cos(a), x.y(), r * std::sin(a));
      },
      "torus", pi / 2 * spine * pi * kRadius * kRadius);
  closed(
      "frustum",
      [](const Vec3& x) {
        const double scale = 1 - x.z() / kHeight / 2;
        return Vec3(scale * x.x(), scale * x.y(), x.z());
      },
      "cone", pi * kHeight / 3 * kRadius * kRadius * (1 + 0.5 + 0.25));
  const double height = kHeight / 2, ball2 = kRadius * kRadius + height * height;
  closed(
      "barrel",
      [=](const Vec3& x) {
        const double z = x.z() - height, scale = std::sqrt(ball2 - z * z) / kRadius;
        return Vec3(scale * x.x(), scale * x.y(), x.z());
      },
      "sphere", pi * (ball2 * kHeight - 2 * std::pow(height, 3) / 3));
}

TEST_CASE("a ball of eight octants is eight faces of one sphere", "[io][step]") {
  const BuiltModel made = build_model(octants(), {}, 0.2);
  std::vector<SkinnedRegion> regions;
  for (const SkinnedRegion* region : made.model.skinned())
    regions.push_back(mapped(
        *region, [](const Vec3& x) { return Vec3(x.normalized()); }, false));
  REQUIRE(regions.size() == 8);
  const Written w = written(regions, "ball", 3e-4);
  CHECK(w.kinds == Kinds{{"sphere", 8}});
  check_solid(w, 4 * pi / 3);
}

TEST_CASE("faces that are no primitives stay splines beside those that are", "[io][step]") {
  // A wall with a waist.
  std::vector<SkinnedRegion> regions = can();
  regions[2] = mapped(regions[2], [](const Vec3& x) {
    const double scale = 1 - 0.2 * std::pow(std::sin(pi * x.z() / kHeight), 2);
    return Vec3(scale * x.x(), scale * x.y(), x.z());
  });
  const Written w = written(regions, "waist", 5e-3);
  CHECK(w.kinds == Kinds{{"B-spline", 1}, {"plane", 2}});
  CHECK(w.report.solids == 1);
  CHECK(w.report.free_edges == 0);
}

TEST_CASE("a wall that is off its cylinder by more than the tolerance is a spline", "[io][step]") {
  const auto bulged = [](double by) {
    std::vector<SkinnedRegion> regions = can();
    regions[2] = mapped(regions[2], [by](const Vec3& x) {
      const double scale = 1 + by / kRadius * std::pow(std::sin(pi * x.z() / kHeight), 2);
      return Vec3(scale * x.x(), scale * x.y(), x.z());
    });
    return regions;
  };
  CHECK(written(bulged(4e-3), "bulged_little", 8e-3).kinds == Kinds{{"cylinder", 1}, {"plane", 2}});
  CHECK(written(bulged(4e-2), "bulged", 8e-3).kinds == Kinds{{"B-spline", 1}, {"plane", 2}});
}
