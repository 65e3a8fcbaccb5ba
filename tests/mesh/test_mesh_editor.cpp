// SPDX-License-Identifier: MPL-2.0
// Edits of a mesh with features: relations, estimated rotations, kept centres, attached nodes.
#include "batten/mesh/editing/mesh_editor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/editing/feature_relation.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mesh_models.h"
#include "batten/tests/support/random_motion.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using RelationKind = FeatureRelation::Kind;

/// Features of one vertex each, which is also their centre.
struct PointFeatures {
  explicit PointFeatures(const std::vector<Vec3>& at) : points(static_cast<long>(at.size()), 3) {
    for (size_t i = 0; i < at.size(); ++i) {
      const auto v = static_cast<int>(i);
      points.row(v) = at[i].transpose();
      features.push_back({"hole-" + std::to_string(v + 1), {v}});
      centres.push_back(VertexCombination::mean_of({v}));
    }
  }
  RelationConstraints related(RelationKind kind, std::vector<int> of) const {
    FeatureRelation relation{"related", kind, std::move(of), {}, {}};
    relation.plane = {Vec3(0, 0, 2), Vec3(5, 5, 1)};
    return relation_constraints(relation, features, centres, points);
  }
  Points points;
  std::vector<FormFeature> features;
  std::vector<VertexCombination> centres;
};

/// The plate with five holes, its right border as a handle.
struct EditedPlate {
  EditedPlate() : model(plate_with_holes()), prepared(prepare(model.shells)) {
    for (const NamedSet& f : model.features) problem.features.push_back({f.name, f.items});
    problem.fixed = model.fixed;
    problem.handles = {{"right", model.handle}};
  }
  Points solved(const DeformEdit& edit, const MeshEditorOptions& options = {},
                std::vector<PrescribedRotation> prescribed = {}) const {
    MeshEditor editor(prepared, prepared.mesh.points(), problem, options);
    editor.set(edit, std::move(prescribed));
    return editor.solve_to_equilibrium();
  }
  Vec3 centre(size_t feature, const Points& p) const {
    return VertexCombination::mean_of(problem.features[feature].vertices).at(p);
  }
  Similarity fit(size_t feature, const Points& p) const {
    return fit_similarity(prepared.mesh.points(), p, problem.features[feature].vertices);
  }
  MeshModel model;
  PreparedMesh prepared;
  DeformProblem problem;
};

DeformEdit lifted_and_rotated() {
  DeformEdit edit;
  HandleTransform move;
  move.about = Vec3(300, 150, 0);
  move.rotation_vector = Vec3(0, -0.5, 0.1);
  move.translation = Vec3(-10, 0, 60);
  edit.handles = {move};
  return edit;
}

}  // namespace

TEST_CASE("constraints of relations hold in the rest shape and rotate with it", "[mesh][deform]") {
  Random random(3);
  const PointFeatures apart({random.point(), random.point(), random.point()}),
      row({{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {3, 6, 9}});
  const RigidMotion motion = random_motion(random);
  for (const auto& [given, found, count] :
       {std::tuple(&apart, apart.related(RelationKind::Distance, {2, 0, 1}), 2),
        {&apart, apart.related(RelationKind::Coaxial, {0, 1, 2}), 2},
        {&row, row.related(RelationKind::Spacing, {0, 1, 2, 3}), 2},
        {&apart, apart.related(RelationKind::Parallel, {0, 1}), 0}}) {
    CHECK(static_cast<int>(found.rows.size()) == count);
    for (const LinearConstraint& r : found.rows) {
      CHECK(std::abs(r.combination.sum()) < 1e-15);  // translations do not matter
      CHECK((r.combination.at(given->points) - r.target).norm() < 1e-15);
      CHECK((r.combination.at(moved(motion, given->points)) - motion.rotation * r.target).norm() <
            1e-14);
      CHECK(!r.weight);
    }
  }
  CHECK(apart.related(RelationKind::Distance, {2, 0}).rows[0].rotates_with == 2);
  CHECK(apart.related(RelationKind::Distance, {0, 1}).shared_rotations.empty());
  CHECK(apart.related(RelationKind::Coaxial, {1, 2}).shared_rotations ==
        std::vector<std::vector<int>>{{1, 2}});
}

TEST_CASE("mirror images are kept by their middle and their difference", "[mesh][deform]") {
  const PointFeatures two({{3, 4, 0.5}, {3, 4, 1.5}, {3, 4, 1.6}});
  const RelationConstraints found = two.related(RelationKind::Symmetric, {0, 1});
  REQUIRE(found.point_constraints.size() == 2);
  REQUIRE(found.constraint_origins.size() == 2);
  const auto& [middle, across] = std::pair(found.point_constraints[0], found.point_constraints[1]);
  CHECK(middle.kind == PointConstraint::Kind::OnPlane);
  CHECK(std::abs(middle.point.sum() - 1) < 1e-15);
  CHECK((middle.point.at(two.points) - Vec3(3, 4, 1)).norm() < 1e-15);
  CHECK(across.kind == PointConstraint::Kind::OnLine);
  CHECK(std::abs(across.point.sum()) < 1e-15);
  CHECK((across.point.at(two.points) - Vec3(0, 0, 1)).norm() < 1e-15);
  CHECK_THAT(error_message([&] {
               two.related(RelationKind::Symmetric, {0, 2});
             }),
             Contains("the relation 'related'") && Contains("mirror images"));
  CHECK_THAT(error_message([&] {
               two.related(RelationKind::Symmetric, {0, 1, 2});
             }),
             Contains("found 3 features, expected two"));
}

TEST_CASE("relations that the rest shape violates are rejected", "[mesh][deform]") {
  const PointFeatures uneven({{0, 0, 0}, {1, 0, 0}, {2.1, 0, 0}});
  CHECK_THAT(error_message([&] {
               uneven.related(RelationKind::Spacing, {0, 1, 2});
             }),
             Contains("before and after 'hole-2'"));
  CHECK_THAT(error_message([&] {
               uneven.related(RelationKind::Spacing, {0, 1});
             }),
             Contains("expected 3 or more"));
  CHECK_THAT(error_message([&] {
               uneven.related(RelationKind::Distance, {0, 7});
             }),
             Contains("expected one of 0 to 2"));
  FeatureRelation coaxial{"shaft", RelationKind::Coaxial, {0, 2}, HoleMeasure{}, {}};
  coaxial.hole->axis = Vec3::UnitX();
  coaxial.hole->radius = 1;
  const auto add = [&] {
    relation_constraints(coaxial, uneven.features, uneven.centres, uneven.points);
  };
  CHECK(error_message(add).empty());
  coaxial.hole->axis = Vec3(1, 0.01, 0).normalized();
  CHECK_THAT(error_message(add), Contains("from the axis of 'hole-1'"));
}

TEST_CASE("an edit that moves nothing changes no bit", "[mesh][deform]") {
  const EditedPlate plate;
  DeformEdit still;
  still.handles.resize(1);
  for (const RotationMode mode : {RotationMode::Estimated, RotationMode::Harmonic})
    CHECK(plate.solved(still, {mode, true, {}}) == plate.prepared.mesh.points());
}

TEST_CASE("features keep their shape and rotate like the sheet around them", "[mesh][deform]") {
  const EditedPlate plate;
  MeshEditor editor(plate.prepared, plate.prepared.mesh.points(), plate.problem);
  editor.set(lifted_and_rotated());
  const Points after = editor.solve_to_equilibrium();
  const MeshEditStatistics& s = editor.statistics();
  CHECK(s.converged);
  CHECK(s.iterations > 1);
  CHECK(s.hard_residual < 1e-12);
  CHECK(s.last_correction < 1e-9);
  CHECK(s.largest_displacement > 60);
  for (size_t f = 0; f < plate.problem.features.size(); ++f) {
    INFO(plate.problem.features[f].name);
    const Similarity fit = plate.fit(f, after);
    CHECK(fit.max_error < 1e-12);
    CHECK(std::abs(fit.scale - 1) < 1e-12);
    // The sheet rotates up to the angle of the handle, and overshoots it where it bends.
    const double angle = Eigen::AngleAxisd(fit.R).angle();
    CHECK(angle > 0.02);
    CHECK(angle < 1);
  }
}

TEST_CASE("previews converge to the equilibrium, which does not depend on them", "[mesh][deform]") {
  const EditedPlate plate;
  const Points alone = plate.solved(lifted_and_rotated());
  MeshEditor editor(plate.prepared, plate.prepared.mesh.points(), plate.problem);
  DeformEdit other = lifted_and_rotated();
  other.handles[0].translation *= -1;
  editor.set(other);
  editor.solve_preview();
  editor.set(lifted_and_rotated());
  bool at_rest = false;
  for (int i = 0; i < 30 && !at_rest; ++i) {
    editor.solve_preview();
    at_rest = editor.is_at_rest() && i > 0;
  }
  CHECK(at_rest);
  CHECK(distance(editor.shape(), alone) < 1e-2 * plate.prepared.mesh.size());
  CHECK(editor.solve_to_equilibrium() == alone);
}

TEST_CASE("previews go on after an edit that fails, and after one that scales features",
          "[mesh][deform]") {
  EditedPlate plate;
  const auto centre = VertexCombination::mean_of(plate.problem.features[2].vertices);
  const Vec3 at = centre.at(plate.prepared.mesh.points());
  plate.problem.point_constraints = {{"low", centre, PointConstraint::Kind::OnPlane, {0, 0, 1}},
                                     {"high", centre, PointConstraint::Kind::OnPlane, {0, 0, 1}}};
  MeshEditor editor(plate.prepared, plate.prepared.mesh.points(), plate.problem);
  DeformEdit possible = lifted_and_rotated();
  possible.constraint_origins = {at, at};
  const auto previewed = [&] {
    for (int i = 0; i < 30; ++i) editor.solve_preview();
    return editor.shape();
  };
  editor.set(possible);
  const Points expected = previewed();
  DeformEdit impossible = possible;
  impossible.constraint_origins[1].z() += 1;
  editor.set(impossible);
  CHECK_THROWS_AS(editor.solve_preview(), ConflictError);
  CHECK(editor.shape() == expected);
  editor.set(possible);
  CHECK(distance(previewed(), expected) < 1e-9);
  DeformEdit scaled = possible;
  scaled.feature_scales = {1.2, 1, 1, 1, 1};
  editor.set(scaled);
  editor.solve_to_equilibrium();  // keeps the centres
  editor.set(possible);
  CHECK(distance(previewed(), expected) < 1e-9);
}

TEST_CASE("the shape is a smooth function of the edit", "[mesh][deform]") {
  // Fourth-order difference quotients of two step sizes agree only if rotations have converged.
  const EditedPlate plate;
  const auto derivative = [&](double h) {
    const auto at = [&](double step) {
      DeformEdit edit = lifted_and_rotated();
      edit.handles[0].translation.z() += step;
      return plate.solved(edit);
    };
    return Points((8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h));
  };
  CHECK((derivative(0.1) - derivative(0.2)).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("the equilibrium is the limit of many previews", "[mesh][deform]") {
  const EditedPlate plate;
  MeshEditor editor(plate.prepared, plate.prepared.mesh.points(), plate.problem);
  editor.set(lifted_and_rotated());
  for (int i = 0; i < 200; ++i) editor.solve_preview();
  const Points limit = editor.shape();
  CHECK(distance(limit, editor.solve_to_equilibrium()) < 1e-6);
}

TEST_CASE("a rigid line across a sheet does not swing its free end", "[mesh][deform]") {
  // A strip that is fixed at its left border and lifted by a patch; a line crosses it behind the
  // patch. The right border is free.
  const TriangleMesh strip = sheet(40, 0, 0);  // [0, 4]²
  const auto where = [&](const auto& inside) {
    std::vector<int> found;
    for (int v = 0; v < strip.vertex_count(); ++v)
      if (inside(strip.point(v))) found.push_back(v);
    return found;
  };
  DeformProblem problem;
  problem.fixed = where([](const Vec3& p) { return p.x() < 0.15; });
  problem.handles = {
      {"patch", where([](const Vec3& p) { return (p - Vec3(2, 2, 0)).norm() < 0.25; })}};
  ShellMesh shells;
  shells.points = strip.points();
  for (const auto& t : strip.triangles()) shells.add_face(t);
  const PreparedMesh prepared = prepare(shells);
  DeformEdit edit;
  edit.handles.resize(1);
  edit.handles[0].translation = {0, 0, 0.4};
  const auto highest = [&](bool line) {
    DeformProblem with = problem;
    if (line)
      with.features = {{"line", where([](const Vec3& p) { return std::abs(p.x() - 3.5) < 0.01; })}};
    MeshEditor editor(prepared, prepared.mesh.points(), with);
    editor.set(edit);
    return editor.solve_to_equilibrium().col(2).maxCoeff();
  };
  CHECK(highest(true) < 1.15 * highest(false));
}

TEST_CASE("scaling a feature moves no centre, unless that is wanted", "[mesh][deform]") {
  const EditedPlate plate;
  const Points plain = plate.solved(lifted_and_rotated());
  DeformEdit scaled = lifted_and_rotated();
  scaled.feature_scales.assign(plate.problem.features.size(), 1);
  scaled.feature_scales[0] = 1.3;
  const Points kept = plate.solved(scaled), free = plate.solved(scaled, {{}, false, {}});
  CHECK(std::abs(plate.fit(0, kept).scale - 1.3) < 1e-12);
  double moved_centre = 0;
  for (size_t f = 0; f < plate.problem.features.size(); ++f) {
    CHECK((plate.centre(f, kept) - plate.centre(f, plain)).norm() <
          1e-10 * plate.prepared.mesh.size());
    moved_centre = std::max(moved_centre, (plate.centre(f, free) - plate.centre(f, plain)).norm());
  }
  CHECK(moved_centre > 1e-6 * plate.prepared.mesh.size());
  CHECK_THAT(error_message([&] {
               MeshEditorOptions options;
               options.centres.resize(1);
               plate.solved(scaled, options);
             }),
             Contains("found 1 centres of features"));
}

TEST_CASE("prescribed rotations are exact, also for features that share them", "[mesh][deform]") {
  EditedPlate plate;
  plate.problem.shared_rotations = {{1, 2}};
  const Mat3 R = rotation_matrix(Vec3(0.2, -0.3, 0.4));
  for (const RotationMode mode : {RotationMode::Estimated, RotationMode::Harmonic}) {
    const Points after = plate.solved(lifted_and_rotated(), {mode, true, {}}, {{1, R}});
    CHECK((plate.fit(1, after).R - R).norm() < 1e-11);
    CHECK((plate.fit(2, after).R - R).norm() < 1e-11);
    CHECK((plate.fit(3, after).R - R).norm() > 1e-2);
  }
  CHECK_THAT(error_message([&] {
               plate.solved(lifted_and_rotated(), {}, {{99, R}});
             }),
             Contains("feature 99"));
}

TEST_CASE("nothing is estimated if nothing moves, or in the harmonic mode", "[mesh][deform]") {
  const EditedPlate plate;
  const TriangleMesh& mesh = plate.prepared.mesh;
  DeformEdit still;
  still.handles.resize(1);
  FeatureRotationEstimator harmonic(plate.prepared, mesh, plate.problem, RotationMode::Harmonic),
      nonlinear(plate.prepared, mesh, plate.problem, RotationMode::Nonlinear);
  CHECK(!harmonic.estimate(lifted_and_rotated()));
  CHECK(!nonlinear.estimate(still));
  CHECK(nonlinear.iterations() == 0);
  CHECK(harmonic.estimate(still, std::vector<PrescribedRotation>(1)));
  const auto found = nonlinear.estimate(lifted_and_rotated());
  REQUIRE(found);
  CHECK(found->use == ShapeEstimate::Use::Shape);
  CHECK(nonlinear.iterations() > 0);
  CHECK(nonlinear.converged());
}

TEST_CASE("attached elements move rigidly or with the shells", "[mesh][deform]") {
  EditedPlate plate;
  ShellMesh shells = plate.model.shells;
  const int shell_nodes = shells.node_count(), free_node = shell_nodes, bolt_end = shell_nodes + 1;
  shells.points.conservativeResize(shell_nodes + 2, 3);
  const std::vector<int>& hole = plate.problem.features[0].vertices;
  shells.points.row(bolt_end) =
      plate.centre(0, shells.points).transpose() + Vec3(0, 0, 5).transpose();
  shells.points.row(free_node) =
      shells.points.row(plate.model.handle[0]) + Vec3(0, 0, -5).transpose();
  NonShellElement spider{NonShellElement::Kind::Rigid, "RBE2", 1, {bolt_end}, {}},
      bar{NonShellElement::Kind::Beam, "CBAR", 2, {plate.model.handle[0], free_node}, {}};
  spider.nodes.insert(spider.nodes.end(), hole.begin(), hole.end());
  const std::vector<NonShellElement> elements = {spider, bar};
  const PreparedMesh prepared = prepare(shells);
  const AttachedNodes attached(elements, prepared.mesh);
  REQUIRE(attached.connections().size() == 1);
  DeformProblem problem = plate.problem;
  attached.add_to(problem);
  CHECK(problem.features.size() == plate.problem.features.size() + 1);
  MeshEditor editor(prepared, prepared.mesh.points(), problem, {}, &attached);
  editor.set(lifted_and_rotated());
  const Points& before = prepared.mesh.points();
  const Points after = editor.solve_to_equilibrium();
  const AttachedMotion motion = attached.motion(before, after);
  CHECK(motion.connections == 1);
  CHECK(motion.max_rigid_error < 1e-10 * prepared.mesh.size());
  CHECK(motion.moved_nodes == 1);
  CHECK(motion.inverted_solids.empty());
  const HandleTransform& move = editor.edit().handles[0];
  CHECK((after.row(free_node).transpose() - move(before.row(free_node).transpose())).norm() <
        0.1 * 5);
  const AttachedMotion none = attached.motion(before, before);
  CHECK(none.moved_nodes == 0);
  CHECK(none.max_rigid_error < 1e-12);
}

TEST_CASE("a region of interest takes the connections with it", "[mesh][deform]") {
  const EditedPlate plate;
  ShellMesh shells = plate.model.shells;
  const int end = shells.node_count();
  shells.points.conservativeResize(end + 1, 3);
  shells.points.row(end) << 150, 150, 10;
  const int start = plate.problem.features[0].vertices[0];
  const std::vector<NonShellElement> elements = {
      {NonShellElement::Kind::Rigid, "RBE2", 1, {end, start}, {}}};
  const PreparedMesh prepared = prepare(shells);
  const AttachedNodes attached(elements, prepared.mesh);
  DeformProblem inside, outside;
  inside.region = {start};
  outside.region = {plate.model.handle[0]};
  attached.add_to(inside);
  attached.add_to(outside);
  CHECK(*inside.region == std::vector<int>{start, end});
  CHECK(*outside.region == std::vector<int>{plate.model.handle[0]});
}
