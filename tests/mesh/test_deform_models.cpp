// SPDX-License-Identifier: MPL-2.0
// The paper's figures on similar models, and all checks at full size.
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/kkt_deformation.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten_test;

namespace {

struct Part {
  MeshModel model;
  TriangleMesh mesh;
  DeformProblem problem;
  DeformEdit edit;
  explicit Part(MeshModel given, FormFeature::Kind kind = FormFeature::Kind::Free)
      : model(std::move(given)), mesh(prepare(model.shells).mesh) {
    problem.fixed = model.fixed;
    problem.handles = {{"handle", model.handle}};
    for (const auto& f : model.features) problem.features.push_back({f.name, f.items, kind});
    edit.handles = {{}};
    edit.handles[0].about = VertexCombination::mean_of(model.handle).at(mesh.points());
  }
  /// Bends a sheet of this length in x about y; its right border is moved by the handle.
  void bend(double length, double degrees) {
    const double angle = degrees * std::numbers::pi / 180, radius = length / angle;
    edit.handles[0].rotation_vector = to_rotation_vector({0, -1, 0}, angle);
    edit.handles[0].translation = {radius * std::sin(angle) - length, 0,
                                   radius * (1 - std::cos(angle))};
  }
  Points deformed() {
    FormFeatureDeformer deformer(mesh, problem);
    deformer.deform(edit);
    deformer.correct();
    CHECK(deformer.hard_residual() < 1e-13);
    return deformer.positions();
  }
  Similarity fit(const Points& p, size_t f) const {
    return fit_similarity(mesh.points(), p, problem.features[f].vertices);
  }
};

double degrees_of(const Mat3& R) { return Eigen::AngleAxisd(R).angle() * 180 / std::numbers::pi; }

}  // namespace

TEST_CASE("plate with five holes: ovals without features, circles with them", "[mesh][deform]") {
  Part plate(plate_with_holes());
  plate.bend(300, 75);
  const auto features = plate.problem.features;
  const auto radius = [&](const Points& p, size_t f) {
    return measure_hole(p, plate.model.rims[f].items);
  };
  plate.problem.features.clear();
  const Points free = plate.deformed();
  plate.problem.features = features;
  const Points kept = plate.deformed();
  double worst = 0;
  for (size_t f = 0; f < features.size(); ++f) {
    const HoleMeasure before = radius(plate.mesh.points(), f);
    worst = std::max(worst, radius(free, f).roundness / before.radius);
    CHECK(std::abs(radius(kept, f).radius / before.radius - 1) < 1e-13);
    CHECK(radius(kept, f).roundness < 1e-13 * before.radius);
    CHECK(plate.fit(kept, f).max_error < 1e-13);
    CHECK(degrees_of(plate.fit(kept, f).R) > 1);  // they rotate with the sheet
  }
  CHECK(worst > 0.01);

  // Stretched: a flat sheet stays flat, the holes do not rotate.
  plate.edit.handles[0].rotation_vector.setZero();
  plate.edit.handles[0].translation = {90, 0, 0};
  const Points stretched = plate.deformed();
  CHECK(stretched.col(2).cwiseAbs().maxCoeff() < 1e-9);
  for (size_t f = 0; f < features.size(); ++f) {
    CHECK(plate.fit(stretched, f).max_error < 1e-13);
    CHECK(degrees_of(plate.fit(stretched, f).R) < 1e-9);
  }
}

TEST_CASE("plate: orientation kept, on a plane, on a line, with and without rotation",
          "[mesh][deform]") {
  size_t centre = 0;
  for (const auto kind : {FormFeature::Kind::TranslationOnly, FormFeature::Kind::Free}) {
    Part plate(plate_with_holes());
    plate.bend(300, 75);
    for (size_t f = 0; f < plate.model.rims.size(); ++f)
      if (plate.model.rims[f].items.size() > plate.model.rims[centre].items.size()) centre = f;
    plate.problem.features[centre].kind = kind;
    const auto middle = VertexCombination::mean_of(plate.model.rims[centre].items);
    const Vec3 start = middle.at(plate.mesh.points());
    const Points loose = plate.deformed();
    CHECK(std::abs(middle.at(loose).z() - start.z()) > 1);
    for (const auto guide : {PointConstraint::Kind::OnPlane, PointConstraint::Kind::OnLine}) {
      plate.problem.point_constraints = {{"guide", middle, guide, Vec3::UnitZ()}};
      const Points p = plate.deformed();
      const Vec3 off = middle.at(p) - start;
      if (guide == PointConstraint::Kind::OnPlane) {
        CHECK(std::abs(off.z()) < 1e-12 * plate.mesh.size());
        CHECK(off.head<2>().norm() > 0.1);
      } else {
        CHECK(off.head<2>().norm() < 1e-12 * plate.mesh.size());
        CHECK(std::abs(off.z()) > 1);
      }
      const double turned = degrees_of(plate.fit(p, centre).R);
      if (kind == FormFeature::Kind::TranslationOnly)
        CHECK(turned < 1e-10);
      else
        CHECK(turned > 10);
    }
  }
}

TEST_CASE("sheet with 16 cavities: they rotate with it, each by a further step", "[mesh][deform]") {
  Part sheet(sheet_with_cavities());
  sheet.bend(400, 95);
  const Points p = sheet.deformed();
  REQUIRE(sheet.problem.features.size() == 16);
  for (size_t f = 0; f < 16; ++f) {
    const Similarity fit = sheet.fit(p, f);
    CHECK(fit.max_error < 1e-13);
    const double x =
        VertexCombination::mean_of(sheet.problem.features[f].vertices).at(sheet.mesh.points()).x();
    // The field is nearly linear from border to border.
    CHECK(degrees_of(fit.R) == Approx(95 * x / 400).margin(6));
  }
  CHECK(inverted_faces(sheet.model.shells, sheet.mesh.points(), p).empty());
  // The arc of the sheet: all vertices are close to the cylinder given by the borders.
  const double radius = 400 / (95 * std::numbers::pi / 180);
  for (const auto& rim : sheet.model.rims)
    for (const int v : rim.items)
      CHECK(std::hypot(p(v, 0), p(v, 2) - radius) == Approx(radius).epsilon(0.05));
}

TEST_CASE("grill: cavities keep shape and direction, their scale can change at any event",
          "[mesh][deform]") {
  Part front(grill(), FormFeature::Kind::TranslationOnly);
  front.edit.handles[0].translation = {25, 0, -45};
  FormFeatureDeformer deformer(front.mesh, front.problem);
  for (const double scale : {1.0, 1.05, 1.1, 0.8}) {
    front.edit.feature_scales.assign(front.problem.features.size(), scale);
    const Points p = deformer.deform(front.edit);
    for (size_t f = 0; f < front.problem.features.size(); ++f) {
      const Similarity fit = front.fit(p, f);
      CHECK(fit.max_error < 1e-13);
      CHECK(fit.scale == Approx(scale).epsilon(1e-13));
      CHECK((fit.R - Mat3::Identity()).norm() < 1e-12);
    }
    CHECK(deformer.hard_residual() < 1e-14);
  }
}

TEST_CASE("door panel: feature lines are warped unless they are kept", "[mesh][deform]") {
  Part door(door_panel());
  // Pulled outwards between the curves.
  std::vector<int> patch =
      door.model.where([](const Vec2& p) { return (p - Vec2(400, 310)).norm() < 40; });
  REQUIRE(!patch.empty());
  door.problem.handles = {{"handle", patch}};
  door.edit.handles[0].translation = {0, 0, 50};
  REQUIRE(door.model.lines.size() == 2);
  const auto warp = [&](const Points& p) {
    double worst = 0;
    for (const auto& line : door.model.lines)
      worst = std::max(worst, fit_similarity(door.mesh.points(), p, line.items, 1).max_error);
    return worst;
  };
  const double warped = warp(door.deformed());
  CHECK(warped > 1e-3);
  for (const auto& line : door.model.lines)
    door.problem.features.push_back({line.name, line.items});
  CHECK(warp(door.deformed()) < 1e-14);
}

TEST_CASE("fixed and handle vertices moved by one rigid motion, 101,000 vertices",
          "[mesh][deform]") {
  Part panel(holed_panel(101000));
  REQUIRE(panel.mesh.vertex_count() > 95000);
  panel.problem.handles.push_back({"borders", panel.problem.fixed});
  panel.problem.fixed.clear();
  HandleTransform move;
  move.about = {1000, -300, 77};
  move.rotation_vector = to_rotation_vector({1, 2, 3}, 2.5);
  move.translation = {50, 20, -100};
  panel.edit.handles = {move, move};
  FormFeatureDeformer deformer(panel.mesh, panel.problem);
  deformer.deform(panel.edit);
  const double first = deformer.correct();
  CHECK(first > 1e-13);  // there was an error to correct
  CHECK(deformer.correct() < 0.01 * first);
  double worst = 0;
  for (int v = 0; v < panel.mesh.vertex_count(); ++v)
    worst = std::max(worst,
                     (deformer.positions().row(v).transpose() - move(panel.mesh.point(v))).norm());
  CHECK(worst < 1e-10 * panel.mesh.size());
}

TEST_CASE("reduction and saddle point agree at 14,000 vertices, guided points and all",
          "[mesh][deform]") {
  Part panel(holed_panel(14000));
  panel.edit.handles[0].translation = {0, 0, 60};
  panel.edit.handles[0].rotation_vector = to_rotation_vector({1, 2, 0.5}, 0.5);
  panel.problem.point_constraints = {{"a", VertexCombination::mean_of(panel.model.rims[5].items),
                                      PointConstraint::Kind::OnPlane, Vec3(0.2, 0, 1)},
                                     {"b", VertexCombination::mean_of(panel.model.rims[10].items),
                                      PointConstraint::Kind::OnLine, Vec3::UnitZ()}};
  FormFeatureDeformer deformer(panel.mesh, panel.problem);
  const Points expected = deform_by_kkt(deformer, panel.edit);
  CHECK((deformer.positions() - expected).cwiseAbs().maxCoeff() < 1e-9 * panel.mesh.size());
  CHECK(deformer.hard_residual() < 1e-13);
  for (size_t f = 0; f < panel.problem.features.size(); ++f)
    CHECK(panel.fit(deformer.positions(), f).max_error < 1e-12);
}

TEST_CASE("details rotate with the sheet: curvature vectors are rotated", "[mesh][deform]") {
  // The sheet with cavities, none of them a feature, bent by 95 degrees.
  Part sheet(sheet_with_cavities());
  sheet.bend(400, 95);
  sheet.problem.features.clear();
  const Points p = sheet.deformed();
  double out_of_round = 0;
  for (size_t f = 0; f < sheet.model.rims.size(); ++f) {
    const auto& rim = sheet.model.rims[f].items;
    const auto& all = sheet.model.features[f].items;
    const auto depth = [&](const Points& points) {
      // Depth of the lowest vertex below the plane of the boundary, along its normal.
      const HoleMeasure m = measure_hole(points, rim);
      double deepest = 0;
      for (const int v : all)
        deepest = std::max(deepest, std::abs(m.axis.dot(points.row(v).transpose() - m.centre)));
      return deepest;
    };
    CHECK(depth(p) == Approx(depth(sheet.mesh.points())).epsilon(0.1));
    const HoleMeasure before = measure_hole(sheet.mesh.points(), rim), after = measure_hole(p, rim);
    const double x = before.centre.x();
    CHECK(std::acos(before.axis.dot(after.axis)) * 180 / std::numbers::pi ==
          Approx(95 * x / 400).margin(8));
    out_of_round = std::max(out_of_round, after.roundness / before.radius);
  }
  CHECK(out_of_round > 0.01);
}
