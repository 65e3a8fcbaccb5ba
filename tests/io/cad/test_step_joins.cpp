// SPDX-License-Identifier: MPL-2.0
// Faces in a STEP file meet like their surfaces: tangent across smooth edges, at any tolerance,
// verified by an independent reader.
#include <map>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fem/surface_projector.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/step/face_boundary.h"
#include "batten/io/step/face_measure.h"
#include "batten/io/step/step.h"
#include "batten/tests/io/cad/step_models.h"
#include "batten/tests/support/aerofoil.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
namespace fs = std::filesystem;
using Kind = EdgeContinuity::Kind;

namespace {

/// A vault of two faces: four sides and a ridge in the middle, smooth across the ridge; length 20.
BuiltModel vault() {
  const auto arch = [](const std::string& name, double y, double from, double to) {
    return CharacterLine{name, curve_from_formula(from, to, [y](double x, int order) {
                           const double k = 0.25, h = 3 + 0.05 * y;
                           return order == 0   ? Vec3(x, y, h * std::cos(k * x))
                                  : order == 1 ? Vec3(1, 0, -h * k * std::sin(k * x))
                                               : Vec3(0, 0, -h * k * k * std::cos(k * x));
                         })};
  };
  const auto along = [](const std::string& name, double x) {
    return straight(name, {x, 0, 3 * std::cos(0.25 * x)}, {x, 12, 3.6 * std::cos(0.25 * x)});
  };
  return build_model({arch("front left", 0, -8, 1), arch("front right", 0, 1, 8),
                      arch("back left", 12, -8, 1), arch("back right", 12, 1, 8), along("left", -8),
                      along("ridge", 1), along("right", 8)});
}

/// A swept wing with ribs of the given chords at the given y, a leading and a trailing edge.
BuiltModel wing(const std::vector<std::pair<double, double>>& ribs) {
  std::vector<CharacterLine> lines;
  std::vector<Vec3> leading, trailing;
  for (const auto& [chord, y] : ribs) {
    constexpr int kCount = 40;
    std::vector<Vec3> points = aerofoil(kCount, chord, y);
    for (Vec3& p : points) p.x() += 0.3 * y;
    trailing.push_back(points[0]);
    leading.push_back(points[kCount]);
    lines.push_back(closed_line("rib " + std::to_string(lines.size()), points));
  }
  lines.push_back({"leading", curve_through_points("leading", leading)});
  lines.push_back({"trailing", curve_through_points("trailing", trailing)});
  CurveNetwork network(lines);
  SurfaceModel model = skin_network(network, find_regions(network, {}), {});
  return {std::move(network), std::move(model)};
}

StepReport written(const fs::path& file, const BuiltModel& made, double tolerance,
                   double join_deg = 0.1) {
  StepFaceOptions options;
  options.tolerance = tolerance;
  options.join_deg = join_deg;
  return write_step_faces(file, made.model.skinned(), 1e-3, options);
}

/// Largest distance of points of the surfaces without a trim from the closest face of the file.
double distance_from_file(const BuiltModel& made, const fs::path& file) {
  const auto faces = read_cad_surfaces(file, 1e-3);
  double largest = 0;
  size_t first = 0;
  for (const SkinnedRegion* region : made.model.skinned()) {
    if (region->surface.trim()) continue;
    for (const Location& where : tessellate(region->surface.mesh(), 3).points)
      largest = std::max(largest, distance(faces, region->surface.position(where), first));
  }
  return largest;
}

}  // namespace

TEST_CASE("a face corrects its own part of a join, and needs no poles for the other's part",
          "[io][step]") {
  const auto turned = [](double deg) {
    const double a = deg * std::numbers::pi / 180;
    return Vec3(std::sin(a), 0, std::cos(a));
  };
  const auto side = [&](const char* region, std::vector<double> degrees) {
    JoinNormals normals;
    normals.region = region;
    for (const double deg : degrees) {
      normals.of_face.push_back(2 * turned(deg));
      normals.of_surface.push_back(turned(0));
      normals.target_normals.push_back(3 * turned(0));
    }
    return FaceNormals{{{"line", 0}, normals}};
  };
  const auto mend = [&](std::vector<double> one, std::vector<double> other) {
    return correctable_angles({side("one", std::move(one)), side("other", std::move(other))}, 0.1);
  };
  const auto near = [](const std::vector<double>& found, double one, double other) {
    CHECK(found.size() == 2);
    CHECK(found[0] == Approx(one).margin(1e-9));
    CHECK(found[1] == Approx(other).margin(1e-9));
  };
  near(mend({0.04, -0.01}, {-0.05, 0.08}), 0, 0);       // within the limit
  near(mend({0.07, 0.02}, {-0.06, 0.02}), 0.13, 0.13);  // both deviate by half of it
  near(mend({3, 0}, {0.01, 0}), 2.99, 0);               // only one deviates
  near(mend({3, 0.09}, {0.01, -0.08}), 2.99, 0.17);     // elsewhere the other deviates
  near(mend({2, 0}, {-1, 0}), 4, 2);                    // each by its own angle
}

TEST_CASE("the faces of a swept wing are tangent along ribs and nose", "[io][step]") {
  // At the nose of a rib the normal turns by 90 degrees within one per cent of the rib.
  const BuiltModel made = wing({{1, 0}, {0.8, 1.5}, {0.45, 3}});
  REQUIRE(made.model.skinned().size() == 6);
  const double tolerance = 1e-4 * made.network.size();
  const fs::path file = scratch("wing") / "wing.step";
  const StepReport report = written(file, made, tolerance);
  CHECK(report.reached);
  CHECK(report.joins.size() == 4);
  CHECK(report.max_join_deg <= 0.1);
  CHECK(*report.max_deviation <= tolerance);
  CHECK(distance_from_file(made, file) <= tolerance);
  const ContinuityReport found = measure_continuity(file, 1e-3, {});
  CHECK(found.count(Kind::Crease) == 6);  // the tail, and the ribs at the ends
  CHECK(found.max_smooth_deg() <= 0.1);
}

TEST_CASE("the sides of a quadrilateral domain are isoparametric curves of its face",
          "[io][step]") {
  int quadrilaterals = 0;
  const BuiltModel made = wing({{1, 0}, {0.4, 3}});
  for (const SkinnedRegion* region : made.model.skinned()) {
    const FaceBoundary boundary(*region);
    if (!boundary.to_domain) continue;
    ++quadrilaterals;
    REQUIRE(boundary.loops.size() == 1);
    CHECK(boundary.contains(0.5 * boundary.to_domain->extent()));
    size_t piece = 0;
    for (const FaceBoundarySegment& segment : boundary.loops[0]) {
      CHECK((segment.last() - segment.first()).cwiseAbs().minCoeff() < 1e-12);
      const HermiteCurve own = boundary_pcurve(*region, region->boundary[0][piece++]);
      for (const double f : {0.0, 0.3, 0.7}) {
        const double t = own.start() + f * (own.end() - own.start());
        CHECK((boundary.domain_point(segment.uv(t)) - drop_z(own.evaluate(t))).norm() < 1e-12);
      }
    }
    CHECK(piece == region->boundary[0].size());
  }
  CHECK(quadrilaterals == 2);  // not the ribs
}

TEST_CASE("two faces keep tolerance and tangent plane across a smooth join, at four tolerances",
          "[io][step]") {
  const BuiltModel made = vault();
  REQUIRE(made.model.skinned().size() == 2);
  for (const double fraction : {1e-2, 1e-3, 1e-4, 1e-5}) {
    INFO("tolerance " << fraction << " of the size");
    const fs::path file = scratch("vault") / "vault.step";
    const double tolerance = fraction * made.network.size();
    const StepReport report = written(file, made, tolerance);
    CHECK(report.valid);
    CHECK(report.reached);
    CHECK(report.faces == 2);
    CHECK(*report.max_deviation <= tolerance);
    CHECK(distance_from_file(made, file) <= tolerance);
    REQUIRE(report.joins.size() == 1);
    CHECK(report.joins[0].line == "ridge");
    CHECK(report.joins[0].reached);
    CHECK(report.max_join_deg <= 0.1);
    // Independent computation of the same values: closest points on the faces that are read.
    const ContinuityReport edges = measure_continuity(file, 1e-3);
    CHECK(edges.free_edges == 6);
    CHECK(edges.count(Kind::Crease) == 0);
    CHECK(edges.max_smooth_deg() <= 0.1);
    CHECK(edges.max_smooth_deg() <= report.max_join_deg + 0.01);
    REQUIRE(report.continuity);
    CHECK(report.continuity->max_smooth_deg() == Approx(edges.max_smooth_deg()).epsilon(0.05));
  }
}

TEST_CASE("four faces around a smooth node meet as their surfaces do, with few poles",
          "[io][step]") {
  // A hill over a flat boundary: its two curves do not determine the twists, which the surfaces
  // choose themselves.
  const auto line = [](const std::string& name, int axis, double at, double height) {
    return CharacterLine{name, curve_from_formula(0, 10, [=](double t, int order) {
                           const double k = std::numbers::pi / 5;
                           const Vec3 d = axis == 0 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
                           const Vec3 from = axis == 0 ? Vec3(0, at, 0) : Vec3(at, 0, 0);
                           const double h = height / 2;
                           if (order == 0)
                             return Vec3(from + t * d + Vec3(0, 0, h * (1 - std::cos(k * t))));
                           if (order == 1) return Vec3(d + Vec3(0, 0, h * k * std::sin(k * t)));
                           return Vec3(0, 0, h * k * k * std::cos(k * t));
                         })};
  };
  const BuiltModel made =
      build_model({line("south", 0, 0, 0), line("across", 0, 4.5, 2), line("north", 0, 10, 0),
                   line("west", 1, 0, 0), line("along", 1, 5.5, 2), line("east", 1, 10, 0)});
  REQUIRE(made.model.skinned().size() == 4);
  const fs::path file = scratch("four_faces") / "four.step";
  const StepReport report = written(file, made, 1e-3 * made.network.size());
  CHECK(report.reached);
  CHECK(report.joins.size() == 4);
  CHECK(report.max_join_deg <= 0.1);
  CHECK(measure_continuity(file, 1e-3).max_smooth_deg() <= 0.1);
  const auto poles = [](const StepReport& of) {
    int count = 0;
    for (const StepPatch& patch : of.patches) count += patch.poles_u * patch.poles_v;
    return count;
  };
  CHECK(poles(report) <= 4 * 360);
  const StepReport strict = written(file, made, 1e-5 * made.network.size(), 0.01);
  CHECK(strict.reached);
  CHECK(poles(strict) <= 11'000);  // 14,112 with two twists per corner
}

TEST_CASE("creases stay creases and are no joins, and eleven model faces are eleven CAD faces",
          "[io][step]") {
  const BuiltModel made = mouse(6, false);
  const fs::path file = scratch("mouse_joins") / "mouse.step";
  const StepReport report = written(file, made, 1e-3 * made.network.size());
  CHECK(report.faces == 11);
  CHECK(report.joins.size() == 9);
  CHECK(report.max_join_deg <= 0.1);
  REQUIRE(report.continuity);
  CHECK(report.continuity->count(Kind::Crease) == 12);
  CHECK(report.continuity->max_smooth_deg() <= 0.1);
}

TEST_CASE("an angle that cannot be reached is reported, within the limits of poles", "[io][step]") {
  const BuiltModel made = mouse(6, false);
  const fs::path file = scratch("mouse_missed") / "mouse.step";
  const double tolerance = 1e-3 * made.network.size();
  const StepReport report = written(file, made, tolerance, 1e-6);
  CHECK_FALSE(report.reached);
  CHECK(*report.max_deviation <= tolerance);
  int missed = 0;
  for (const StepJoin& join : report.joins) {
    // If the surfaces meet at a larger angle, the file cannot be better.
    CHECK((join.reached || join.angle_deg > 1e-6));
    missed += !join.reached;
  }
  CHECK(missed > 0);
  std::map<std::string, int> triangles;
  for (const SkinnedRegion* region : made.model.skinned())
    triangles[region->name] = region->surface.mesh().triangle_count();
  for (const StepPatch& patch : report.patches) {
    INFO(patch.region);
    CHECK(patch.poles_u * patch.poles_v <= std::max(6000, 8 * triangles.at(patch.region)));
  }
  CHECK_THROWS_AS(written(file, made, tolerance, 0), InputError);
}
