// SPDX-License-Identifier: MPL-2.0
// One frame with features, free rotations, plane and line constraints and a volume; and rejected
// input of a frame solver.
#include <functional>
#include <limits>

#include "batten/core/errors.h"
#include "batten/mesh/sequence/frame_solver.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"

using namespace batten;
using namespace batten_test;

namespace {

const FrameOptions kFine{FrameOptions::Weights::Uniform, 4000, 1e-12};

struct Bar {
  TriangleMesh mesh = bar(12, 3, 3, 0.6);
  Points p = mesh.points();
  std::vector<int> left = nodes_where(p, [](const Vec3&x) { return x.x() < 0.01; }),
                   right = nodes_where(p, [](const Vec3&x) { return x.x() > 2.99; }),
                   middle =
                       nodes_where(p, [](const Vec3&x) { return std::abs(x.x() - 1.5) < 0.3; });

  FrameConstraints constraints() const {
    FrameConstraints h;
    h.fixed = left;
    h.handles = {{"end", right}};
    return h;
  }
  FrameTargets targets(const Vec3& translation, double angle = 0) const {
    const Vec3 c = centroid(p, right);
    FrameTargets frame_targets;
    frame_targets.handles = {
        {RigidMotion::about(c, rotation_matrix(to_rotation_vector(Vec3(0.2, 1, 0.1), angle)),
                            c + translation),
         false}};
    return frame_targets;
  }
};

double volume(const TriangleMesh& mesh, const Points& p) {
  double six = 0;
  for (const auto& [a, b, c] : mesh.triangles())
    six += Vec3(p.row(a)).dot(Vec3(p.row(b)).cross(Vec3(p.row(c))));
  return six / 6;
}

}  // namespace

namespace {

/// The energy with a rigid part rotated about its centre, all other nodes fixed.
double energy_with_rotation(const TriangleMesh& mesh, const Points& p, FrameShape at,
                            const std::vector<int>& part, const Mat3& rotation) {
  const Vec3 c0 = centroid(p, part), c = centroid(at.positions, part);
  for (const int v : part) {
    at.positions.row(v) = c + rotation * (Vec3(p.row(v)) - c0);
    at.rotations[v] = rotation;
  }
  return arap_energy(mesh, p, at.positions, at.rotations);
}

/// Coordinate descent about three axes from many start rotations, with step halving: the optimal
/// rotation.
Mat3 rotation_by_search(const std::function<double(const Mat3&)>& energy) {
  Random random(45);
  Mat3 best = Mat3::Identity();
  double least = energy(best);
  for (int k = 0; k < 12; ++k) {
    Mat3 rotation = random_rotation_matrix(random);
    double e = energy(rotation);
    for (double step = 0.5; step > 1e-7;) {
      bool better = false;
      for (int d = 0; d < 6 && !better; ++d) {
        const Mat3 next = rotation_matrix((d % 2 ? -step : step) * Vec3::Unit(d / 2)) * rotation;
        const double there = energy(next);
        if (there < e) rotation = next, e = there, better = true;
      }
      if (!better) step /= 2;
    }
    if (e < least) least = e, best = rotation;
  }
  return best;
}

}  // namespace

TEST_CASE("features and handles that turn freely are rigid, turned as a search would turn them",
          "[mesh][sequences]") {
  const Bar b;
  for (const bool handle : {false, true}) {
    FrameConstraints constraints = b.constraints();
    if (!handle) constraints.features = {{"middle", b.middle}};
    const std::vector<int>& part = handle ? b.right : b.middle;
    FrameTargets targets = b.targets(Vec3(-0.4, 0.2, 0.8), 0.7);
    targets.handles[0].free_rotation = handle;
    FrameSolver solver(b.mesh, constraints, kFine);
    solver.alternate(b.p, targets);
    REQUIRE(solver.report().converged);
    const FrameShape& at = solver.result();
    CHECK(bent(b.p, at.positions, part) < 1e-12);
    const Mat3 rotation = at.rotations[part[0]];
    CHECK((rotation - Mat3::Identity()).norm() > 0.1);
    for (const int v : part) CHECK(at.rotations[v] == rotation);
    if (handle)
      CHECK((centroid(at.positions, part) - targets.handles[0].motion(centroid(b.p, part))).norm() <
            1e-13);
    const Mat3 best = rotation_by_search(
        [&](const Mat3& R) { return energy_with_rotation(b.mesh, b.p, at, part, R); });
    INFO((handle ? "handle: " : "feature: ") << (best - rotation).norm());
    CHECK((best - rotation).norm() < 1e-6);
  }
}

TEST_CASE("guided points are on their plane and line", "[mesh][sequences]") {
  const Bar b;
  FrameConstraints constraints = b.constraints();
  const Vec3 normal(1, 0.3, 2), along(0.1, -0.4, 1);
  constraints.point_constraints = {
      {"plane", VertexCombination::mean_of({b.middle[0]}), PointConstraint::Kind::OnPlane, normal},
      {"line", VertexCombination::mean_of({b.middle[9]}), PointConstraint::Kind::OnLine, along}};
  FrameTargets targets = b.targets(Vec3(-0.3, 0, 0.4), 0.5);
  targets.constraint_origins = {Vec3(1.4, 0.1, 0.5), Vec3(1.5, 0.4, -0.3)};
  FrameSolver solver(b.mesh, constraints, {FrameOptions::Weights::Cotangent});
  solver.alternate(b.p, targets);
  const Points v = solver.result().positions;
  CHECK(std::abs(
            (Vec3(v.row(b.middle[0])) - targets.constraint_origins[0]).dot(normal.normalized())) <
        1e-13);
  CHECK(
      (Vec3(v.row(b.middle[9])) - targets.constraint_origins[1]).cross(along.normalized()).norm() <
      1e-13);
  // A mean of nodes, one of which is fixed.
  FrameConstraints mean = b.constraints();
  const std::vector<int> some{b.middle[0], b.middle[5], b.right[0]};
  mean.point_constraints = {
      {"mean", VertexCombination::mean_of(some), PointConstraint::Kind::OnLine, along}};
  FrameTargets of_mean = b.targets(Vec3(-0.3, 0, 0.4), 0.5);
  of_mean.constraint_origins = {Vec3(2, 0.4, 0.3)};
  FrameSolver of_some(b.mesh, mean);
  of_some.alternate(b.p, of_mean);
  CHECK((centroid(of_some.result().positions, some) - of_mean.constraint_origins[0])
            .cross(along.normalized())
            .norm() < 1e-13);
  // Without origins, nodes stay on the planes and lines through them in the frame.
  targets.constraint_origins.clear();
  solver.alternate(b.p, targets);
  CHECK(std::abs((solver.result().positions.row(b.middle[0]) - b.p.row(b.middle[0]))
                     .dot(normal.normalized())) < 1e-13);
}

TEST_CASE("a closed surface keeps its volume, with the least energy", "[mesh][sequences]") {
  const Bar b;
  FrameConstraints constraints = b.constraints();
  for (const bool soft : {false, true}) {
    constraints.preserve_volume = true;
    if (soft) constraints.penalty_weight = 1;
    FrameSolver solver(b.mesh, constraints, {FrameOptions::Weights::Uniform, 3000, 1e-12});
    const FrameTargets targets = b.targets(Vec3(-0.7, 0.1, 0.2), 0.4);
    solver.alternate(b.p, targets);
    const Points v = solver.result().positions;
    CHECK(solver.report().converged);
    CHECK(std::abs(volume(b.mesh, v) / volume(b.mesh, b.p) - 1) < 1e-12);
    if (soft) continue;
    // ∂E = μ ∂V for free nodes.
    Points slope = Points::Zero(v.rows(), 3), gradient = slope;
    const auto& R = solver.result().rotations;
    for (const auto& [i, j] : node_edges(b.mesh)) {
      const Eigen::RowVector3d e =
          2 * (v.row(j) - v.row(i)) -
          ((R[i] + R[j]) * (b.p.row(j) - b.p.row(i)).transpose()).transpose();
      slope.row(j) += e, slope.row(i) -= e;
    }
    for (const auto& [a, c, d] : b.mesh.triangles()) {
      const auto add = [&](int x, int y, int z) {
        gradient.row(x) += Vec3(v.row(y)).cross(Vec3(v.row(z))).transpose() / 6;
      };
      add(a, c, d), add(c, d, a), add(d, a, c);
    }
    for (const auto* held : {&b.left, &b.right})
      for (const int n : *held) slope.row(n).setZero(), gradient.row(n).setZero();
    const double mu = slope.cwiseProduct(gradient).sum() / gradient.squaredNorm();
    INFO("mu " << mu << ", rest " << (slope - mu * gradient).norm() / slope.norm());
    CHECK(std::abs(mu) > 1e-3);
    CHECK((slope - mu * gradient).norm() < 1e-8 * slope.norm());
  }
}

TEST_CASE("unconnected parts stay, and are reported", "[mesh][sequences]") {
  const TriangleMesh two =
      disjoint_union(bar(6, 2, 2, 0.5), sphere(1).with_points(sphere(1).points().array() + 5));
  FrameConstraints constraints;
  constraints.handles = {{"end", {0, 1, 2}}};
  FrameSolver solver(two, constraints);
  REQUIRE(solver.notes().size() == 1);
  CHECK(solver.notes()[0].find("42 nodes") != std::string::npos);
  FrameTargets targets;
  targets.handles = {{{Mat3::Identity(), Vec3(0, 1, 0)}, false}};
  solver.alternate(two.points(), targets);
  const Points moved_by = solver.result().positions - two.points();
  CHECK(moved_by.bottomRows(42).norm() == 0);
  CHECK((moved_by.topRows(two.vertex_count() - 42).rowwise() - Eigen::RowVector3d(0, 1, 0)).norm() <
        1e-10);
}

TEST_CASE("a frame solver refuses invalid input", "[mesh][sequences]") {
  const Bar b;
  const auto refused = [&](const FrameConstraints& constraints, const TriangleMesh& mesh) {
    return error_message([&] { FrameSolver solver(mesh, constraints); });
  };
  FrameConstraints constraints = b.constraints();
  CHECK(refused(constraints, b.mesh).empty());
  for (const double penalty_weight : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                                      std::numeric_limits<double>::infinity()}) {
    constraints.penalty_weight = penalty_weight;
    CHECK(refused(constraints, b.mesh).find("penalty") != std::string::npos);
  }
  constraints = b.constraints();
  constraints.handles[0].vertices.clear();
  CHECK(refused(constraints, b.mesh).find("end") != std::string::npos);
  constraints.handles[0].vertices = {9999};
  CHECK(!refused(constraints, b.mesh).empty());
  CHECK(!refused({}, b.mesh).empty());
  constraints = {};
  constraints.fixed = {0};
  constraints.preserve_volume = true;
  CHECK(refused(constraints, sheet(4)).find("needs a closed surface") != std::string::npos);
  constraints = b.constraints();
  constraints.point_constraints = {{"point", {{{b.middle[0], 2.0}}}}};
  CHECK(refused(constraints, b.mesh).find("point") != std::string::npos);

  constraints = b.constraints();
  FrameSolver solver(b.mesh, constraints);
  const FrameTargets targets = b.targets(Vec3::Zero());
  const auto refused_frame = [&](const Points& p, const FrameTargets& frame_targets) {
    return error_message([&] { solver.alternate(p, frame_targets); });
  };
  CHECK(error_message([&] { solver.iterate(1); }).find("without a frame") != std::string::npos);
  CHECK(refused_frame(b.p, targets).empty());
  CHECK(!refused_frame(b.p.topRows(5), targets).empty());
  Points bad = b.p;
  bad(3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(refused_frame(bad, targets).find("finite") != std::string::npos);
  CHECK(error_message([&] { solver.alternate(b.p, targets, bad); }).find("finite") !=
        std::string::npos);
  CHECK(!refused_frame(b.p, {}).empty());
  FrameTargets wrong = targets;
  wrong.handles[0].motion.translation.x() = std::numeric_limits<double>::infinity();
  CHECK(refused_frame(b.p, wrong).find("finite") != std::string::npos);
  wrong = targets;
  wrong.constraint_origins = {Vec3::Zero()};
  CHECK(refused_frame(b.p, wrong).find("origins of point constraints") != std::string::npos);
  CHECK(!error_message([&] { solver.reconstruct(b.p, targets, {Mat3::Identity()}); }).empty());

  constraints.handles.push_back({"same", {b.right[0], b.middle[0]}});
  FrameSolver both(b.mesh, constraints);
  FrameTargets apart = targets;
  apart.handles.push_back({{Mat3::Identity(), Vec3(0, 0.1, 0)}, false});
  CHECK_THROWS_AS(both.alternate(b.p, apart), ConflictError);
  apart.handles[0].motion = apart.handles[1].motion;
  CHECK_NOTHROW(both.alternate(b.p, apart));
}

TEST_CASE("sequences are checked before they are edited", "[mesh][sequences]") {
  const TriangleMesh mesh = sphere(0);
  MeshSequence s;
  s.shells.points = mesh.points();
  for (const auto& t : mesh.triangles()) s.shells.add_face(t);
  const auto refused = [&] { return error_message([&] { check(s, "walk"); }); };
  CHECK(refused() == "walk: found no frames, expected one or more");
  s.frames = {mesh.points(), mesh.points()};
  CHECK(refused().find("times") != std::string::npos);
  s.times = {0, 0};
  CHECK(refused().starts_with("walk"));
  s.times = {0, 0.5};
  CHECK(refused().empty());
  CHECK(size_of(s) == Approx(mesh.size()));
  s.frames[1](3, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(refused() == "walk: frame 2: node 4 has a coordinate that is not finite, or above 1e100");
  s.frames[1] = mesh.points().topRows(5);
  CHECK(refused().find("frame 2 has 5 nodes, expected 12") != std::string::npos);
  // Second differences: for a motion with constant acceleration they equal it.
  std::vector<Points> frames;
  for (int k = 0; k < 5; ++k)
    frames.push_back(mesh.points().rowwise() + Eigen::RowVector3d(0, 0.5 * k * k, 0));
  const std::vector<double> second = second_differences(frames);
  REQUIRE(second.size() == 5);
  CHECK(second[0] == 0);
  CHECK(second[4] == 0);
  for (int k = 1; k < 4; ++k) CHECK(second[k] == Approx(1));
}
