// SPDX-License-Identifier: MPL-2.0
// Rotations of features by the equilibrium of the moments on them.
#include "batten/mesh/editing/feature_equilibrium.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/mesh/editing/mesh_editor.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A sheet with features, whose left border is fixed and whose right one is a handle.
struct Sheet {
  explicit Sheet(MeshModel m, bool rims = false)
      : model(std::move(m)), prepared(prepare(model.shells)) {
    for (const NamedSet& f : rims ? model.rims : model.features)
      problem.features.push_back({f.name, f.items});
    problem.fixed = model.fixed;
    problem.handles = {{"handle", model.handle}};
    edit.handles.resize(1);
    edit.handles[0].about = VertexCombination::mean_of(model.handle).at(prepared.mesh.points());
  }
  ShapeEstimate unrotated() const {
    ShapeEstimate estimate;
    estimate.positions = prepared.mesh.points();
    estimate.feature_rotations.assign(problem.features.size(), Mat3(Mat3::Identity()));
    return estimate;
  }
  MeshModel model;
  PreparedMesh prepared;
  DeformProblem problem;
  DeformEdit edit;
};

/// A flat square of n × n cells with rigid squares of `size` cells, `pitch` cells apart.
MeshModel plate_with_squares(int n, int pitch, int size) {
  MeshModel plate;
  plate.shells.points.resize((n + 1) * (n + 1), 3);
  const auto at = [n](int i, int j) { return j * (n + 1) + i; };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) plate.shells.points.row(at(i, j)) << i, j, 0;
  for (int j = 0; j < n; ++j) {
    plate.fixed.push_back(at(0, j));
    plate.handle.push_back(at(n, j));
    for (int i = 0; i < n; ++i)
      plate.shells.add_face(std::vector{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  }
  for (int j = 2; j + size < n; j += pitch)
    for (int i = 2; i + size < n; i += pitch) {
      NamedSet& square = plate.features.emplace_back(
          "square-" + std::to_string(plate.features.size()), std::vector<int>());
      for (int k = 0; k <= size; ++k)
        for (int l = 0; l <= size; ++l) square.items.push_back(at(i + l, j + k));
    }
  return plate;
}

Vec3 moment(const Points& first_moments, long feature) {
  const Mat3 T = first_moments.middleRows<3>(3 * feature);
  return {T(1, 2) - T(2, 1), T(2, 0) - T(0, 2), T(0, 1) - T(1, 0)};
}

double largest_moment(const Points& first_moments) {
  double largest = 0;
  for (long f = 0; f < first_moments.rows() / 3; ++f)
    largest = std::max(largest, moment(first_moments, f).norm());
  return largest;
}

std::vector<int> all_bodies(const Sheet& sheet) {
  std::vector<int> body;
  for (int f = 0; f < static_cast<int>(sheet.problem.features.size()); ++f) body.push_back(f);
  return body;
}

/// Takes steps until rotations change by less than 1e-9 degrees, at most `most`; returns their number.
int steps_to_equilibrium(const Sheet& sheet, FormFeatureDeformer& deformer, ShapeEstimate& estimate,
                         int most) {
  FeatureEquilibrium equilibrium(deformer, all_bodies(sheet));
  int steps = 0;
  for (double change = 1; change > 1e-9 && steps < most; ++steps) {
    change = equilibrium.rotate_features(deformer, estimate);
    deformer.deform(sheet.edit, estimate);
  }
  return steps;
}

Points solved(const Sheet& sheet, const DeformEdit& edit) {
  MeshEditor editor(sheet.prepared, sheet.prepared.mesh.points(), sheet.problem);
  editor.set(edit);
  const Points after = editor.solve_to_equilibrium();
  CHECK(editor.statistics().converged);
  return after;
}

}  // namespace

TEST_CASE("moments on features are the derivatives of the energy", "[mesh][deform]") {
  Sheet sheet(plate_with_holes());
  sheet.problem.bending = DeformProblem::Bending::Hinges;  // flat: no target depends on rotations
  const TriangleMesh& mesh = sheet.prepared.mesh;
  const auto& features = sheet.problem.features;
  // Constraints that act on features away from their centres.
  const auto one = [&](int f, size_t k) {
    return VertexCombination::mean_of({features[f].vertices[k]});
  };
  sheet.problem.point_constraints = {
      {"plane", one(0, 3), PointConstraint::Kind::OnPlane, {0.3, 0, 1}},
      {"line", one(1, 5), PointConstraint::Kind::OnLine, {1, 0.5, 0.2}}};
  sheet.problem.rows = {
      {.name = "soft", .combination = one(2, 1), .target = {3, 4, 30}, .weight = 2},
      {.name = "hard",
       .combination = one(3, 2),
       .target = one(3, 2).at(mesh.points()) + Vec3(1, -1, 5)}};
  sheet.edit.handles[0].translation = {-10, 5, 40};
  sheet.edit.handles[0].rotation_vector = {0.1, -0.4, 0.2};
  sheet.edit.feature_scales = {1, 1.2, 1, 1, 0.9};
  FormFeatureDeformer deformer(mesh, sheet.problem);
  const auto matrices = deformer.problem_matrices(sheet.edit);
  ShapeEstimate estimate = sheet.unrotated();
  for (size_t f = 0; f < features.size(); ++f)
    estimate.feature_rotations[f] = rotation_matrix(Vec3(0.1, -0.1 * static_cast<double>(f), 0.05));
  const auto energy = [&](size_t f, const Vec3& rotation) {
    ShapeEstimate rotated = estimate;
    rotated.feature_rotations[f] = rotation_matrix(rotation) * *estimate.feature_rotations[f];
    const Points& p = deformer.deform(sheet.edit, rotated);
    Points x(static_cast<long>(matrices.vertices.size()), 3);
    for (size_t k = 0; k < matrices.vertices.size(); ++k)
      x.row(static_cast<long>(k)) = p.row(matrices.vertices[k]) - matrices.origin.transpose();
    return (matrices.A * x - matrices.b).squaredNorm() / 2;
  };
  deformer.deform(sheet.edit, estimate);
  deformer.correct();
  const Points found = deformer.feature_moments();
  for (size_t f = 0; f < features.size(); ++f)
    for (int axis = 0; axis < 3; ++axis) {
      INFO(features[f].name << ", axis " << axis);
      const Vec3 h = 1e-4 * Vec3::Unit(axis);
      const double difference = (energy(f, h) - energy(f, -h)) / 2e-4;
      const double scale = largest_moment(found);
      CHECK(std::abs(moment(found, static_cast<long>(f))[axis] - difference) < 1e-6 * scale);
    }
}

TEST_CASE("the stiffness of features is the derivative of their moments", "[mesh][deform]") {
  for (const bool rims : {false, true}) {
    Sheet sheet(holed_panel(3000), rims);
    FormFeatureDeformer deformer(sheet.prepared.mesh, sheet.problem);
    ShapeEstimate estimate = sheet.unrotated();
    deformer.deform(sheet.edit, estimate);
    const MatX S = deformer.feature_stiffness(all_bodies(sheet)).S;
    const auto features = static_cast<long>(sheet.problem.features.size());
    REQUIRE(S.rows() == 3 * features);
    REQUIRE(S.cols() == 3 * features);
    const long h = 5;
    const Vec3 rotation(3e-6, -5e-6, 4e-6);
    const auto moments = [&](double sign) -> Points {
      estimate.feature_rotations[h] = rotation_matrix(sign * rotation);
      deformer.deform(sheet.edit, estimate);
      deformer.correct();
      return deformer.feature_moments();
    };
    const Points difference = (moments(1) - moments(-1)) / 2;
    for (long f = 0; f < features; ++f) {
      const Mat3 block = S.block<3, 3>(3 * f, 3 * h);
      const Vec3 expected = block.trace() * rotation - block.transpose() * rotation;
      CHECK((moment(difference, f) - expected).norm() < 1e-5 * largest_moment(difference));
    }
  }
}

TEST_CASE("in equilibrium there are no moments on features, after a few steps", "[mesh][deform]") {
  for (const bool rims : {false, true}) {
    Sheet sheet(holed_panel(3000), rims);
    sheet.edit.handles[0].translation = {0, 0, 60};
    sheet.edit.handles[0].rotation_vector = {0.2, 0.4, 0.1};
    FormFeatureDeformer deformer(sheet.prepared.mesh, sheet.problem);
    ShapeEstimate estimate = sheet.unrotated();
    deformer.deform(sheet.edit, estimate);
    const double before = largest_moment(deformer.feature_moments());
    CHECK(steps_to_equilibrium(sheet, deformer, estimate, 14) < 14);
    CHECK(largest_moment(deformer.feature_moments()) < 1e-8 * before);
  }
}

TEST_CASE("equilibrium with point constraints, springs and scaled features", "[mesh][deform]") {
  Sheet sheet(plate_with_holes());
  const TriangleMesh& mesh = sheet.prepared.mesh;
  const auto centre = [&](int f) {
    return VertexCombination::mean_of(sheet.problem.features[f].vertices);
  };
  sheet.problem.point_constraints = {
      {"level", centre(2), PointConstraint::Kind::OnPlane, {0, 0, 1}}};
  sheet.problem.rows = {{.name = "stiff",
                         .combination = centre(1),
                         .target = centre(1).at(mesh.points()),
                         .weight = 1e4}};
  sheet.edit.handles[0].translation = {-40, 0, 110};
  sheet.edit.handles[0].rotation_vector = {0, -1.3, 0};
  sheet.edit.constraint_origins = {centre(2).at(mesh.points()) + Vec3(0, 0, 50)};
  sheet.edit.feature_scales = {1.1, 1, 1, 0.9, 1};
  FormFeatureDeformer deformer(mesh, sheet.problem);
  ShapeEstimate estimate = sheet.unrotated();
  deformer.deform(sheet.edit, estimate);
  CHECK(steps_to_equilibrium(sheet, deformer, estimate, 12) < 12);
}

TEST_CASE("a sheet that is stretched in its plane stays flat", "[mesh][deform]") {
  const Sheet sheet(plate_with_holes());
  DeformEdit edit = sheet.edit;
  edit.handles[0].translation = {30, 0, 0};
  const Points after = solved(sheet, edit);
  CHECK(after.col(2).cwiseAbs().maxCoeff() < 1e-9);
  for (const FormFeature& f : sheet.problem.features) {
    const Mat3 R = fit_similarity(sheet.prepared.mesh.points(), after, f.vertices, 1).R;
    CHECK(R(2, 2) > 1 - 1e-12);
    CHECK((f.name == "centre") == (Eigen::AngleAxisd(R).angle() < 1e-5));  // by symmetry
  }
}

TEST_CASE("the edge of a flange rotates like the whole flange", "[mesh][deform]") {
  // A sheet that is moved by a rigid flange rotates almost like one with a thin flange.
  const auto rotations = [](bool rims) {
    Sheet sheet(holed_panel(6000), rims);
    sheet.edit.handles[0].translation = {0, 0, 60};
    const Points after = solved(sheet, sheet.edit);
    std::vector<Mat3> all;
    for (const NamedSet& rim : sheet.model.rims)
      all.push_back(fit_similarity(sheet.prepared.mesh.points(), after, rim.items, 1).R);
    return all;
  };
  const auto flanges = rotations(false), edges = rotations(true);
  for (size_t f = 0; f < flanges.size(); ++f)
    CHECK(Eigen::AngleAxisd(flanges[f].transpose() * edges[f]).angle() <
          4 * std::numbers::pi / 180);
}

TEST_CASE("the equilibrium of many features is stable, on every way to it", "[mesh][deform]") {
  const Sheet sheet(plate_with_squares(41, 5, 3));
  DeformEdit edit = sheet.edit;
  const auto part = [&](double share) {
    edit.handles[0].translation = share * Vec3(-2, 0, 8);
    edit.handles[0].rotation_vector = share * Vec3(0, -0.5, 0);
    return edit;
  };
  const Points at_once = solved(sheet, part(1));
  MeshEditor editor(sheet.prepared, sheet.prepared.mesh.points(), sheet.problem);
  for (int step = 1; step <= 20; ++step) {
    editor.set(part(step / 20.0));
    editor.solve_preview();
  }
  const double size = sheet.prepared.mesh.size();
  CHECK((editor.shape() - at_once).cwiseAbs().maxCoeff() < 0.01 * size);
  for (int i = 0; i < 20; ++i) editor.solve_preview();
  CHECK((editor.shape() - at_once).cwiseAbs().maxCoeff() < 1e-9 * size);
}

TEST_CASE("more features than the stiffness couples", "[mesh][deform]") {
  Sheet sheet(plate_with_squares(52, 3, 1));
  REQUIRE(sheet.problem.features.size() > 256);
  sheet.edit.handles[0].translation = {0, 0, 4};
  FormFeatureDeformer deformer(sheet.prepared.mesh, sheet.problem);
  ShapeEstimate estimate = sheet.unrotated();
  deformer.deform(sheet.edit, estimate);
  const double before = largest_moment(deformer.feature_moments());
  CHECK(deformer.feature_stiffness(all_bodies(sheet)).S.cols() == 3);
  steps_to_equilibrium(sheet, deformer, estimate, 60);
  CHECK(largest_moment(deformer.feature_moments()) < 1e-2 * before);
}

TEST_CASE("vertices on a line keep their rotation about it", "[mesh][deform]") {
  Sheet sheet(plate_with_squares(20, 30, 1));
  const int row = 10 * 21;
  sheet.problem.features = {
      {"one", {row + 4}}, {"two", {row + 8, row + 11}}, {"three", {row + 14, row + 16, row + 18}}};
  sheet.edit.handles[0].translation = {0, 0, 5};
  sheet.edit.handles[0].rotation_vector = {0.3, -0.3, 0};
  FormFeatureDeformer deformer(sheet.prepared.mesh, sheet.problem);
  ShapeEstimate estimate = sheet.unrotated();
  deformer.deform(sheet.edit, estimate);
  CHECK(steps_to_equilibrium(sheet, deformer, estimate, 20) < 20);
  CHECK(estimate.feature_rotations[0]->isIdentity(0));
  for (const int f : {1, 2}) {
    const Vec3 vector = to_rotation_vector(*estimate.feature_rotations[f]);
    CHECK(vector.norm() > 0.01);
    CHECK(std::abs(vector.dot(*estimate.feature_rotations[f] * Vec3::UnitX())) <
          1e-3 * vector.norm());
  }
}

TEST_CASE("moments need a solution, and a stiffness an estimate", "[mesh][deform]") {
  const Sheet sheet(plate_with_squares(10, 4, 1));
  FormFeatureDeformer deformer(sheet.prepared.mesh, sheet.problem);
  CHECK_THAT(error_message([&] { deformer.feature_moments(); }), Contains("call deform() first"));
  deformer.deform(sheet.edit);
  CHECK_THAT(error_message([&] { deformer.feature_stiffness(all_bodies(sheet)); }),
             Contains("with an estimate"));
  deformer.deform(sheet.edit, sheet.unrotated());
  CHECK_THAT(error_message([&] { deformer.feature_stiffness(std::vector<int>{0}); }),
             Contains("found 1 bodies of features, expected 4"));
}
