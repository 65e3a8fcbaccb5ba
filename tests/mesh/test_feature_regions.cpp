// SPDX-License-Identifier: MPL-2.0
// Feature regions: rotations of faces, regions that keep their shape, and their selection.
#include <Eigen/Geometry>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/op_counter.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/features/feature_cut.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/regions/feature_region_deformer.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/region_meshes.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

using Kind = FeatureRegionOptions::Kind;

Mat3 random_rotation(Random& random) {
  return Eigen::AngleAxisd(std::numbers::pi * random(), random.point().normalized())
      .toRotationMatrix();
}

bool is_rotation(const Mat3& R) {
  return (R.transpose() * R - Mat3::Identity()).norm() < 1e-13 && R.determinant() > 0;
}

double angle_between(const Mat3& a, const Mat3& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

FeatureRegionOptions options_of(Kind kind) {
  FeatureRegionOptions options;
  options.kind = kind;
  return options;
}

/// A lifted panel with its boss as a region, and an estimate.
struct Lifted {
  BossPanel panel;
  std::vector<HandleTransform> moves;
  Points estimate;
  std::vector<FeatureRegion> regions;
  explicit Lifted(int n = 20, double height = 1.2) : panel(n), moves(panel.lift(height)) {
    DualLaplacianDeformer dual(panel.mesh, {}, panel.fixed, panel.handles);
    estimate = dual.deform(moves);
    regions = {{"boss", {}, panel.boss}};
  }
  FeatureRegionDeformer deformer(const FeatureRegionOptions& options) const {
    return {panel.mesh, regions, panel.fixed, panel.handles, options};
  }
};

}  // namespace

TEST_CASE("rotations of 10,000 triangles that were rotated are exact", "[mesh][feature_regions]") {
  Random random(11);
  for (int k = 0; k < 10000; ++k) {
    Points before(3, 3), after(3, 3);
    double height = 0;
    do {  // the height of a triangle limits the accuracy of its direction
      for (int c = 0; c < 3; ++c) before.row(c) = random.point();
      const Vec3 a = before.row(1) - before.row(0), b = before.row(2) - before.row(0);
      height = a.cross(b).norm() / std::max({a.norm(), b.norm(), (a - b).norm()});
    } while (height < 0.01);
    const Mat3 R = random_rotation(random);
    const Vec3 translation = 10 * random.point();
    for (int c = 0; c < 3; ++c)
      after.row(c) = (R * before.row(c).transpose() + translation).transpose();
    const int corners[] = {0, 1, 2};
    const Mat3 found = rotation_of_face(corners, before, after);
    CHECK(is_rotation(found));
    CHECK((found - R).norm() < 1e-12);
  }
}

TEST_CASE("the rotation part is that of the singular value decomposition, and never a reflection",
          "[mesh][feature_regions]") {
  Random random(12);
  for (int k = 0; k < 3000; ++k) {
    Vec3 values = random.point().cwiseAbs();
    std::sort(values.data(), values.data() + 3, std::greater<>());
    if (k % 3 == 1) values[2] = 0;
    if (k % 7 == 2) values.tail<2>() *= 1e-6;
    const double sign = k % 2 ? 1 : -1;
    if (values[1] + sign * values[2] < 1e-8 * values[0]) continue;
    const Mat3 P = random_rotation(random), Q = random_rotation(random);
    const Mat3 M = P * Vec3(values[0], values[1], sign * values[2]).asDiagonal() * Q.transpose();
    const Mat3 R = nearest_rotation(1e5 * M);
    CHECK(is_rotation(R));
    CHECK((R - P * Q.transpose()).norm() < 3e-14 * values[0] / (values[1] + sign * values[2]));
  }
  CHECK(nearest_rotation(Mat3::Zero()) == Mat3::Identity());
  CHECK(is_rotation(nearest_rotation(-Mat3::Identity())));
  // On a line: the smallest rotation.
  const Mat3 line = Vec3::UnitY() * Vec3::UnitX().transpose();
  CHECK((nearest_rotation(line) - Mat3(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ())))
            .norm() < 1e-14);
}

TEST_CASE("faces that collapse, stretch or turn inside out have a rotation",
          "[mesh][feature_regions]") {
  Points before(4, 3);
  before << 0, 0, 0, 1, 0, 0, 1, 1, 0.2, 0, 1, 0;
  const std::vector<int> quad = {0, 1, 2, 3};
  const auto after = [&](const Mat3& map) { return Points(before * map.transpose()); };
  const Mat3 R = Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  // Stretched along the diagonal directions of a plane: H = R S with S symmetric.
  Mat3 S = Vec3(2, 0.5, 1.5).asDiagonal();
  S(0, 1) = S(1, 0) = 0.3;
  CHECK((rotation_of_face(quad, before, after(R * S)) - R).norm() < 1e-13);
  // Mirrored: no reflection.
  const Mat3 mirror = Vec3(1, 1, -1).asDiagonal();
  CHECK(is_rotation(rotation_of_face(quad, before, after(R * mirror))));
  CHECK(is_rotation(rotation_of_face(quad, before, after(Vec3(1, 0, 0).asDiagonal()))));
  CHECK(rotation_of_face(quad, before, after(Mat3::Zero())) == Mat3::Identity());
  CHECK(rotation_of_face(quad, after(Mat3::Zero()), before) == Mat3::Identity());
  // Onto a line: its direction is reproduced.
  const Mat3 onto =
      rotation_of_face(quad, before, after(Vec3::UnitZ() * Vec3::UnitX().transpose()));
  CHECK((onto * Vec3::UnitX() - Vec3::UnitZ()).norm() < 1e-7);
}

TEST_CASE("rotations of triangles side by side are those one by one", "[mesh][feature_regions]") {
  Random random(17);
  Points before(40, 3), after(40, 3);
  for (int i = 0; i < 40; ++i)
    for (int c = 0; c < 3; ++c) before(i, c) = random(), after(i, c) = random();
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i + 2 < 40; ++i) triangles.push_back({i, i + 1, i + 2});
  triangles[5] = {3, 3, 4};  // a line, a point
  triangles[6] = {7, 7, 7};
  std::vector<int> which;
  for (int i = 0; i < 38; i += 2) which.push_back(i), which.push_back(37 - i);
  for (const size_t count : {which.size(), size_t{1}, size_t{8}, size_t{0}, size_t{11}}) {
    std::vector<Mat3> rotations(count);
    rotations_of_triangles(triangles, std::span(which).first(count), before, after, rotations);
    for (size_t k = 0; k < count; ++k)
      CHECK(
          (rotations[k] - rotation_of_face(triangles[static_cast<size_t>(which[k])], before, after))
              .norm() < 1e-9);
  }
}

TEST_CASE("means of rotations: outliers carry the squared one away, not the other",
          "[mesh][feature_regions]") {
  Random random(13);
  const Mat3 truth = random_rotation(random);
  const Mat3 wrong = truth * Eigen::AngleAxisd(1.5, Vec3::UnitX()).toRotationMatrix();
  std::vector<Mat3> rotations;
  std::vector<double> weights;
  for (int k = 0; k < 100; ++k) {
    rotations.push_back(k < 70 ? truth : wrong);
    weights.push_back(1);
  }
  CHECK(angle_between(mean_rotation(rotations, weights), truth) > 0.3);
  CHECK((median_rotation(rotations, weights) - truth).norm() < 1e-9);
  // Weights matter: with most of the weight on the others, the median is theirs.
  for (int k = 70; k < 100; ++k) weights[k] = 5;
  CHECK(angle_between(mean_rotation(rotations, weights), wrong) <
        angle_between(mean_rotation(rotations, weights), truth));
  CHECK((median_rotation(rotations, weights) - wrong).norm() < 1e-9);
  // Scattered: no other nearby rotation has a smaller sum.
  std::fill(weights.begin(), weights.end(), 1.0);
  for (int k = 0; k < 70; ++k)
    rotations[k] =
        truth * Eigen::AngleAxisd(0.05 * random(), random.point().normalized()).toRotationMatrix();
  const auto sum = [&](const Mat3& R, double power) {
    double total = 0;
    for (const Mat3& Ri : rotations) total += std::pow((R - Ri).norm(), power);
    return total;
  };
  const Mat3 median = median_rotation(rotations, weights), mean = mean_rotation(rotations, weights);
  CHECK(is_rotation(median));
  CHECK(angle_between(median, truth) < 0.05);
  for (int k = 0; k < 50; ++k) {
    const Mat3 aside = Eigen::AngleAxisd(1e-3, random.point().normalized()).toRotationMatrix();
    CHECK(sum(median, 1) < sum(median * aside, 1));
    CHECK(sum(mean, 2) < sum(mean * aside, 2));
  }
  CHECK(mean_rotation({}, {}) == Mat3::Identity());
  CHECK(error_message([&] { mean_rotation(rotations, {}); }) ==
        "found 0 weights for 100 rotations, expected one for each");
}

TEST_CASE("regions: a rigid motion of all handles moves the mesh rigidly",
          "[mesh][feature_regions]") {
  const BossPanel panel(20);
  const std::vector<Handle> handles = {{"left", panel.fixed}, panel.handles[0]};
  HandleTransform move;
  move.about = {1, 2, 3};
  move.rotation_vector = to_rotation_vector({1, 2, -0.5}, 2.2);
  move.translation = {-3, 1, 2};
  Points moved(panel.mesh.vertex_count(), 3);
  for (int v = 0; v < panel.mesh.vertex_count(); ++v) moved.row(v) = move(panel.mesh.point(v));
  for (const Kind kind : {Kind::Soft, Kind::Hard}) {
    FeatureRegionDeformer deformer(panel.mesh, {{"boss", {}, panel.boss}}, {}, handles,
                                   options_of(kind));
    CHECK(relative(deformer.deform(moved, std::vector{move, move}), moved) < 1e-10);
    CHECK(relative(deformer.deform_per_face(moved, std::vector{move, move}), moved) < 1e-10);
    CHECK((deformer.region_rotations()[0] -
           Mat3(Eigen::AngleAxisd(2.2, Vec3(1, 2, -0.5).normalized())))
              .norm() < 1e-12);
  }
}

TEST_CASE("a lifted panel: the boss leans with the sheet around it, and keeps its shape",
          "[mesh][feature_regions]") {
  const Lifted c(40);
  FeatureRegionDeformer hard = c.deformer(options_of(Kind::Hard));
  const Points p = hard.deform(c.estimate, c.moves);
  const Similarity fit = fit_similarity(c.panel.mesh.points(), p, hard.vertices(0));
  CHECK(fit.max_error < 1e-12);
  CHECK(fit.scale == Approx(1).epsilon(1e-12));
  CHECK((fit.R - hard.region_rotations()[0]).norm() < 1e-12);
  const double boss = tilt_degrees(p, c.panel.boss), ring = tilt_degrees(p, c.panel.ring);
  CHECK(boss > 20);
  CHECK(std::abs(boss - ring) < 1);

  DeformProblem problem;
  problem.fixed = c.panel.fixed;
  problem.handles = c.panel.handles;
  problem.features = {{"boss", hard.vertices(0)}};
  FormFeatureDeformer harmonic(c.panel.mesh, problem);
  DeformEdit edit;
  edit.handles = c.moves;
  CHECK(tilt_degrees(harmonic.deform(edit), c.panel.boss) < 1e-9);
}

TEST_CASE("estimate, rough, soft, hard: each keeps the boss better than the one before",
          "[mesh][feature_regions]") {
  const Lifted c(20);
  FeatureRegionDeformer soft = c.deformer(options_of(Kind::Soft));
  FeatureRegionDeformer hard = c.deformer(options_of(Kind::Hard));
  std::vector<char> inside(c.panel.mesh.vertex_count(), 0);
  for (const int v : soft.vertices(0)) inside[v] = 1;
  const auto change = [&](const Points& p) { return edge_change(c.panel.mesh, p, inside).mean; };
  const double estimate = change(c.estimate),
               deform_per_face = change(soft.deform_per_face(c.estimate, c.moves)),
               nearly = change(soft.deform(c.estimate, c.moves)),
               exact = change(hard.deform(c.estimate, c.moves));
  CHECK(deform_per_face < 0.5 * estimate);
  CHECK(nearly < 0.5 * deform_per_face);
  CHECK(exact < 1e-13);
  // The initial result with hard regions is that with soft ones.
  CHECK(relative(hard.deform_per_face(c.estimate, c.moves),
                 soft.deform_per_face(c.estimate, c.moves)) < 1e-12);
  CHECK(hard.face_rotations(0).size() == hard.faces(0).size());
}

TEST_CASE("soft regions of a large weight are hard ones", "[mesh][feature_regions]") {
  Lifted c(20);
  c.regions = {{"low", {}, disc_of(c.panel.mesh, 1, 1, 0.3)},
               {"boss", {}, c.panel.boss},
               {"wide", {}, disc_of(c.panel.mesh, 2.9, 3.4, 0.3)}};
  c.regions[2].scale = 1.2;
  FeatureRegionDeformer hard = c.deformer(options_of(Kind::Hard));
  const Points exact = hard.deform(c.estimate, c.moves);
  double before = 1;
  for (const double weight : {1e3, 1e6, 1e9}) {
    FeatureRegionOptions options = options_of(Kind::Soft);
    options.weight = weight;
    FeatureRegionDeformer soft = c.deformer(options);
    const Points p = soft.deform(c.estimate, c.moves);
    const double off = relative(p, exact);
    CHECK(off < before / 50);
    before = off;
    for (int r = 0; r < 3; ++r)
      CHECK((soft.region_rotations()[r] - hard.region_rotations()[r]).norm() < 1e-14);
  }
  CHECK(before < 1e-6);
}

TEST_CASE("hard regions are the dense least-squares problem with three unknowns a region",
          "[mesh][feature_regions]") {
  Lifted c(20, 0.8);
  const double scale = c.regions[0].scale = 1.25;
  FeatureRegionOptions options = options_of(Kind::Hard);
  for (const auto rhs :
       {FeatureRegionOptions::Rhs::Estimate, FeatureRegionOptions::Rhs::Original}) {
    options.rhs = rhs;
    FeatureRegionDeformer deformer = c.deformer(options);
    const Points p = deformer.deform(c.estimate, c.moves);
    const TriangleMesh& mesh = c.panel.mesh;
    const int n = mesh.vertex_count();
    // Unknowns: each free vertex, and the translation of the region. p = T u + known.
    std::vector<int> column(n, -2);
    for (const int v : c.panel.fixed) column[v] = -1;
    for (const int v : c.panel.handles[0].vertices) column[v] = -1;
    for (const int v : deformer.vertices(0)) column[v] = 0;
    int columns = 1;
    for (int v = 0; v < n; ++v)
      if (column[v] == -2) column[v] = columns++;
    MatX T = MatX::Zero(n, columns), known = MatX::Zero(n, 3);
    for (int v = 0; v < n; ++v) {
      if (column[v] >= 0) T(v, column[v]) = 1;
      if (column[v] == 0)
        known.row(v) = scale * (deformer.region_rotations()[0] * mesh.point(v)).transpose();
    }
    for (const int v : c.panel.fixed) known.row(v) = mesh.points().row(v);
    for (const int v : c.panel.handles[0].vertices)
      known.row(v) = c.moves[0](mesh.point(v)).transpose();
    const SparseMatrix lower = cotangent_laplacian(mesh);
    const VecX area = mixed_areas(mesh);
    MatX A = lower.selfadjointView<Eigen::Lower>() * MatX::Identity(n, n);
    for (int v = 0; v < n; ++v) A.row(v) /= 2 * std::sqrt(area[v]);
    MatX b =
        A * (rhs == FeatureRegionOptions::Rhs::Estimate ? MatX(c.estimate) : MatX(mesh.points()));
    for (const int v : deformer.vertices(0)) b.row(v) *= scale;
    const MatX AT = A * T;
    const MatX u = solve_symmetric(AT.transpose() * AT, AT.transpose() * (b - A * known));
    CHECK(relative(p, Points(T * u + known)) < 1e-8);
  }
}

TEST_CASE("the user's rotation and scale override the estimate's, without a new factor",
          "[mesh][feature_regions]") {
  Lifted c(20);
  const Mat3 wanted = Eigen::AngleAxisd(0.7, Vec3(1, -1, 2).normalized()).toRotationMatrix();
  for (const Kind kind : {Kind::Soft, Kind::Hard}) {
    FeatureRegionDeformer deformer = c.deformer(options_of(kind));
    deformer.deform(c.estimate, c.moves);
    const Mat3 own = deformer.region_rotations()[0];
    CHECK((own - wanted).norm() > 0.3);
    const ScopedOpCount work;
    deformer.set_rotation(0, wanted);
    deformer.set_scale(0, 1.25);
    const Points p = deformer.deform(c.estimate, c.moves);
    CHECK(work.of(OpCounter::Factorization) == 0);
    CHECK(work.of(OpCounter::Solve) == 1);
    const Similarity fit = fit_similarity(c.panel.mesh.points(), p, deformer.vertices(0));
    const double exact = kind == Kind::Hard ? 1e-12 : 0.02;
    CHECK((fit.R - wanted).norm() < exact);
    CHECK(std::abs(fit.scale - 1.25) < exact);
    CHECK(fit.max_error < exact);
    deformer.set_rotation(0, {});
    deformer.set_scale(0, 1);
    deformer.deform(c.estimate, c.moves);
    CHECK(deformer.region_rotations()[0] == own);
  }
  c.regions[0].rotation = wanted;
  FeatureRegionDeformer stated = c.deformer(options_of(Kind::Hard));
  stated.deform(c.estimate, c.moves);
  CHECK(stated.region_rotations()[0] == wanted);
}

TEST_CASE("one factor for any number of edits of feature regions", "[mesh][feature_regions]") {
  const Lifted c(20);
  const ScopedOpCount making;
  FeatureRegionDeformer deformer = c.deformer(options_of(Kind::Hard));
  CHECK(making.of(OpCounter::Factorization) == 1);
  const ScopedOpCount work;
  for (int edit = 0; edit < 4; ++edit) deformer.deform(c.estimate, c.moves);
  CHECK(work.of(OpCounter::Factorization) == 0);
  CHECK(work.of(OpCounter::Solve) == 4);
  // The region has three remaining unknowns: one per coordinate.
  FeatureRegionDeformer soft = c.deformer(options_of(Kind::Soft));
  CHECK(soft.unknowns() - deformer.unknowns() == isize(deformer.vertices(0)) - 1);
}

TEST_CASE("hard regions follow their constraints, and those that share vertices rotate as one",
          "[mesh][feature_regions]") {
  Lifted c(20);
  HandleTransform move = c.moves[0];
  move.rotation_vector = to_rotation_vector({0, 1, 0}, -0.5);
  move.about = {4, 2, 0};
  c.moves = {move};
  const TriangleMesh& mesh = c.panel.mesh;
  c.regions = {{"at the handle", {}, disc_of(mesh, 3.5, 1, 0.3)},
               {"fixed", {}, disc_of(mesh, 0.5, 3, 0.3)},
               {"a", {}, disc_of(mesh, 1.7, 3.4, 0.25)},
               {"b", {}, disc_of(mesh, 2.2, 3.4, 0.25)}};
  FeatureRegionDeformer deformer = c.deformer(options_of(Kind::Hard));
  const Points p = deformer.deform(c.estimate, c.moves);
  for (const int v : deformer.vertices(0))
    CHECK((p.row(v).transpose() - move(mesh.point(v))).norm() < 1e-12);
  for (const int v : deformer.vertices(1)) CHECK((p.row(v) - mesh.points().row(v)).norm() < 1e-12);
  REQUIRE(!intersection_of(deformer.vertices(2), deformer.vertices(3)).empty());
  CHECK(deformer.region_rotations()[2] == deformer.region_rotations()[3]);
  CHECK(fit_similarity(mesh.points(), p, union_of(deformer.vertices(2), deformer.vertices(3)))
            .max_error < 1e-12);
  // Two regions that share vertices, with different prescribed rotations.
  deformer.set_rotation(2, Mat3(Mat3::Identity()));
  deformer.deform(c.estimate, c.moves);
  CHECK(deformer.region_rotations()[3] == Mat3::Identity());
  deformer.set_rotation(3, Mat3(Eigen::AngleAxisd(0.3, Vec3::UnitZ())));
  CHECK_THROWS_AS(deformer.deform(c.estimate, c.moves), ConflictError);
  deformer.set_rotation(3, {});
  // Rotated against the fixed vertices: the conflict names the region.
  deformer.set_rotation(1, Mat3(Eigen::AngleAxisd(0.3, Vec3::UnitZ())));
  try {
    deformer.deform(c.estimate, c.moves);
    FAIL("no conflict");
  } catch (const ConflictError& error) {
    CHECK(std::string(error.what()).find("fixed") != std::string::npos);
  }
}

TEST_CASE("a robust mean of a region ignores a dent in the estimate", "[mesh][feature_regions]") {
  Lifted c(20, 0);
  c.estimate = c.panel.mesh.points();
  // A dent of a few faces in the flat sheet, which is one region.
  c.regions = {{"sheet", {}, disc_of(c.panel.mesh, 1.2, 1.2, 0.5)}};
  for (const int v : disc_of(c.panel.mesh, 1.4, 1.2, 0.25))
    c.estimate(v, 2) += 0.6 * (c.estimate(v, 0) - 1.0);
  FeatureRegionOptions squared, robust;
  robust.mean = FeatureRegionOptions::Mean::Robust;
  FeatureRegionDeformer a = c.deformer(squared), b = c.deformer(robust);
  a.deform(c.estimate, c.moves);
  b.deform(c.estimate, c.moves);
  CHECK(angle_between(a.region_rotations()[0], Mat3::Identity()) > 0.01);
  CHECK(angle_between(b.region_rotations()[0], Mat3::Identity()) < 1e-6);
}

TEST_CASE("feature regions: same bits on one thread and on several", "[mesh][feature_regions]") {
  const Lifted c(40);
  for (const Kind kind : {Kind::Soft, Kind::Hard}) {
    FeatureRegionDeformer deformer = c.deformer(options_of(kind));
    const Points many = deformer.deform(c.estimate, c.moves);
    const ThreadGuard one(1);
    FeatureRegionDeformer again = c.deformer(options_of(kind));
    CHECK(again.deform(c.estimate, c.moves) == many);
  }
}

TEST_CASE("feature regions: bad input is refused with what was found", "[mesh][feature_regions]") {
  const BossPanel panel(10);
  const auto refused = [&](const FeatureRegion& region, double weight = 1) {
    FeatureRegionOptions options;
    options.weight = weight;
    return error_message(
        [&] { FeatureRegionDeformer(panel.mesh, {region}, panel.fixed, panel.handles, options); });
  };
  CHECK(refused({"", {}, {1}}) == "found a feature region without a name");
  CHECK(refused({"a", {}, {}}) == "feature region 'a' has no triangles, expected at least one");
  CHECK(refused({"a", {}, {-1}}) == "feature region 'a': found vertex -1, expected 0 to 120");
  CHECK(refused({"a", {200}, {}}) == "feature region 'a': found triangle 200, expected 0 to 199");
  CHECK(refused({"a", {}, {1}}, 0) ==
        "the weight of feature regions is 0, expected a number above 0");
  FeatureRegion bad{"a", {}, {60}};
  bad.rotation = Mat3(-Mat3::Identity());
  CHECK(refused(bad).find("the rotation of feature region 'a' is not") == 0);
  bad.rotation.reset();
  bad.scale = -1;
  CHECK(refused(bad) == "the scale of feature region 'a' is -1, expected a number above 0");
  FeatureRegionDeformer deformer(panel.mesh, {{"a", {}, {60}}}, panel.fixed, panel.handles);
  CHECK(error_message([&] {
          deformer.deform(Points::Zero(4, 3), std::vector<HandleTransform>(1));
        }) == "the estimate has 4 points, expected 121 finite ones");
  CHECK(error_message([&] { deformer.deform(panel.mesh.points(), {}); }) ==
        "the edit has 0 transformations of handles, expected 1");
  CHECK(error_message([&] {
          FeatureRegionDeformer(panel.mesh, {{"a", {}, {60}}, {"a", {}, {61}}}, panel.fixed,
                                panel.handles);
        }) == "found two feature regions named 'a', expected unique names");
}

TEST_CASE("components of a mask", "[mesh][feature_regions]") {
  const TriangleMesh mesh = flat_square(8, 0, 3);
  std::vector<char> mask(81, 0);
  for (const int v : {0, 1, 2, 9, 40, 79, 80}) mask[v] = 1;
  const auto parts = components_of_mask(mesh, mask);
  REQUIRE(parts.size() == 3);
  CHECK(parts[0] == std::vector<int>{0, 1, 2, 9});
  CHECK(parts[1] == std::vector<int>{40});
  CHECK(parts[2] == std::vector<int>{79, 80});
  CHECK(components_of_mask(mesh, std::vector<char>(81, 0)).empty());
  CHECK(error_message([&] {
          components_of_mask(mesh, {1, 0});
        }) == "the mask has 2 marks, expected one for each of 81 vertices");
}

TEST_CASE("saliency: a bump stands out from the ball it is on, wherever and however large that is",
          "[mesh][feature_regions]") {
  TriangleMesh ball = sphere(5);
  Points p = ball.points();
  for (long v = 0; v < p.rows(); ++v)
    p.row(v) *=
        1 + 0.05 * std::exp(-(p.row(v) - Eigen::RowVector3d(0, 0, 1)).squaredNorm() / 0.005);
  const TriangleMesh mesh = ball.with_points(p);
  const VecX saliency = mesh_saliency(mesh);
  CHECK(saliency.minCoeff() >= 0);
  CHECK(saliency.maxCoeff() == 1);
  const int top = nearest_vertex(mesh, {0, 0, 1.05});
  CHECK(saliency[top] > 0.5);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.point(v).z() < 0.8) CHECK(saliency[v] < 0.02);
  const auto region = grown_region(mesh, saliency, top, 0.05);
  CHECK(region.size() > 20);
  for (const int v : region) CHECK(mesh.point(v).normalized().z() > 0.9);
  CHECK(error_message([&] {
          grown_region(mesh, saliency, nearest_vertex(mesh, {0, 0, -1}), 0.2);
        }).find("expected the threshold 0.2 or more") != std::string::npos);
  CHECK(error_message([&] { grown_region(mesh, VecX::Zero(3), 0, 0.2); }) ==
        "found 3 saliency values, expected 10242");
  // Translated, rotated, scaled and turned inside out.
  const Mat3 R = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Points moved = (1000 * p * R.transpose()).rowwise() + Eigen::RowVector3d(1e4, 0, 5);
  const TriangleMesh other = mesh.with_points(moved);
  // The bounding box of the rotated sphere is approximately the same.
  CHECK((mesh_saliency(other) - saliency).cwiseAbs().maxCoeff() < 0.05);
  {
    const ThreadGuard one(1);
    CHECK(mesh_saliency(mesh) == saliency);
  }
  CHECK(mesh_saliency(flat_square(20, 0.2, 5)).isZero(0));
}

TEST_CASE("a cut between two strokes follows the creases of a boss and of a closed solid",
          "[mesh][feature_regions]") {
  const BossPanel panel(40);
  // On the top, and on the sheet.
  const auto on = disc_of(panel.mesh, 2, 2, 0.12);
  const auto disjoint_union = vertices_where(panel.mesh, [](const Vec3& p) {
    return std::abs(p.x() - 1) < 0.01 && std::abs(p.y() - 2) < 0.3;
  });
  CutOptions options;  // the foot of the boss is concave
  const FeatureCut boss = stroke_cut(panel.mesh, on, disjoint_union, options);
  // A diagonal may cut off a corner of the foot.
  CHECK(difference_of(boss.vertices, panel.boss).empty());
  CHECK(difference_of(panel.boss, boss.vertices).size() <= 4);
  REQUIRE(boss.chains.size() == 1);
  CHECK(boss.chains[0].closed);

  const Bar bar(2, 10);  // its end, up to the edges
  const auto end = vertices_where(bar.mesh, [](const Vec3& p) {
    return p.x() < 1e-9 && p.tail<2>().cwiseAbs().maxCoeff() < 0.25;
  });
  const auto side = vertices_where(
      bar.mesh, [](const Vec3& p) { return std::abs(p.x() - 1) < 0.2 && p.z() > 0.49; });
  const FeatureCut cut = stroke_cut(bar.mesh, end, side);
  CHECK(cut.vertices == bar.fixed);
  double length = 0;
  for (size_t k = 0; k < cut.chains[0].vertices.size(); ++k) {
    const auto& v = cut.chains[0].vertices;
    length += (bar.mesh.point(v[k]) - bar.mesh.point(v[(k + 1) % v.size()])).norm();
  }
  CHECK(length == Approx(4).epsilon(1e-12));
  CHECK(cut.cost < length);
}

TEST_CASE("strokes that cannot be separated are refused with the position",
          "[mesh][feature_regions]") {
  const TriangleMesh square = flat_square(6, 0, 3);
  const TriangleMesh mesh = disjoint_union(square, square);
  const auto refused = [&](const std::vector<int>& in, const std::vector<int>& out) {
    return error_message([&] { stroke_cut(mesh, in, out); });
  };
  CHECK(refused({}, {3}) == "the stroke inside has no vertices, expected at least one");
  CHECK(refused({3}, {98}) == "the stroke outside: found vertex 98, expected 0 to 97");
  CHECK(refused({8, 16}, {24, 16}) ==
        "the strokes touch at vertex 16, expected triangles between them");
  CHECK(refused({8}, {9}).find("the strokes touch at triangle ") == 0);
  CHECK(refused({8}, {60}).find("vertices 8 and 60 of the strokes lie in parts of the mesh") == 0);
  CutOptions options;
  options.convex = -1;
  CHECK(error_message([&] { stroke_cut(mesh, {8}, {40}, options); }) ==
        "found the bend weight -1, expected 0 or more");
  CHECK_FALSE(stroke_cut(mesh, {8}, {40}).triangles.empty());
}
