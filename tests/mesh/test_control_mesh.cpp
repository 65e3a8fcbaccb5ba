// SPDX-License-Identifier: MPL-2.0
// Control meshes, mean value coordinates, initial shapes from few vertices, sessions on one frame.
#include "batten/mesh/sequence/control_mesh.h"

#include "batten/mesh/sequence/subspace_solver.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

/// Whether control meshes are available: not in builds without CGAL.
bool can_wrap() {
  try {
    control_mesh(sphere(2));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Winding number of a closed mesh around a point: 1 inside, 0 outside. Reference: van Oosterom
/// 1983.
double winding_number(const TriangleMesh& mesh, const Vec3& x) {
  double angle = 0;
  for (const auto& [i, j, k] : mesh.triangles()) {
    const Vec3 a = mesh.point(i) - x, b = mesh.point(j) - x, c = mesh.point(k) - x;
    angle +=
        2 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                              b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return angle / (4 * std::numbers::pi);
}

/// A closed mesh around a non-convex bar: its middle is bent up.
TriangleMesh around_bar() {
  const TriangleMesh straight = bar(6, 2, 3.4, 1);
  Points p = straight.points();
  for (int v = 0; v < p.rows(); ++v) p(v, 0) -= 0.2;
  return straight.with_points(p);
}

FrameTargets prescribed(const std::vector<RigidMotion>& motions) {
  FrameTargets targets;
  for (const auto& m : motions) targets.handles.push_back({m, false});
  return targets;
}

}  // namespace

TEST_CASE("mean value coordinates give points back, inside, outside and on the mesh",
          "[mesh][subdivision]") {
  Random random(51);
  TriangleMesh control = around_bar();
  Points bent_points = control.points();
  for (int v = 0; v < bent_points.rows(); ++v)
    bent_points(v, 2) += 0.3 * std::pow(bent_points(v, 0) - 1.5, 2);
  control = control.with_points(bent_points);
  std::vector<Vec3> points;
  for (int k = 0; k < 300; ++k)
    points.push_back(Vec3(1.5, 0, 0.3) + Vec3(2.5, 1, 1).cwiseProduct(random.point()));
  const size_t loose = points.size();
  std::vector<std::array<int, 3>> corners;
  std::vector<Vec3> shares;
  for (const auto& t : control.triangles()) {  // on faces, on edges
    for (const bool edge : {false, true}) {
      Vec3 w(random.between(0.1, 1), random.between(0.1, 1), edge ? 0 : random.between(0.1, 1));
      w /= w.sum();
      points.push_back(w[0] * control.point(t[0]) + w[1] * control.point(t[1]) +
                       w[2] * control.point(t[2]));
      corners.push_back(t);
      shares.push_back(w);
    }
  }
  for (int v = 0; v < control.vertex_count(); ++v) points.push_back(control.point(v));
  Points x(static_cast<int>(points.size()), 3);
  for (size_t k = 0; k < points.size(); ++k) x.row(static_cast<int>(k)) = points[k];
  const MatX W = mean_value_coordinates(control, x);
  const Eigen::VectorXd sums = W.rowwise().sum();
  CHECK((sums.array() - 1).abs().maxCoeff() < 1e-12);
  const double back = distance(W * control.points(), x);
  INFO("back " << back);
  CHECK(back < 1e-9);
  const Mat3 A = Mat3::Random();
  CHECK(distance((W * (control.points() * A)).rowwise() + Eigen::RowVector3d(1, 2, 3),
                 (x * A).rowwise() + Eigen::RowVector3d(1, 2, 3)) < 1e-8);
  for (size_t k = 0; k < corners.size(); ++k)
    for (int c = 0; c < 3; ++c)
      CHECK(std::abs(W(static_cast<long>(loose + k), corners[k][c]) - shares[k][c]) < 1e-6);
  CHECK(W.bottomRows(control.vertex_count()) ==
        MatX::Identity(control.vertex_count(), control.vertex_count()));
  CHECK(error_message([&] { mean_value_coordinates(sheet(3), x); }).find("closed") !=
        std::string::npos);
}

TEST_CASE("mean value coordinates inside a convex mesh are positive, and go over smoothly",
          "[mesh][subdivision]") {
  const TriangleMesh control = sphere(1);
  Random random(52);
  Points x(200, 3);
  for (int k = 0; k < x.rows(); ++k) x.row(k) = 0.5 * random.point();
  const MatX W = mean_value_coordinates(control, x);
  CHECK(W.minCoeff() > 0);
  // In the plane of a face, next to it and next to other points.
  Points near(3, 3);
  const auto& t = control.triangles()[0];
  const Vec3 disjoint_union = 3 * control.point(t[0]) - control.point(t[1]) - control.point(t[2]);
  const Vec3 normal = control.area_vector(0).normalized();
  near << disjoint_union.transpose(), (disjoint_union + 1e-6 * normal).transpose(),
      (disjoint_union - 1e-6 * normal).transpose();
  const MatX V = mean_value_coordinates(control, near);
  CHECK((V.row(1) - V.row(0)).norm() < 1e-4);
  CHECK((V.row(2) - V.row(0)).norm() < 1e-4);
}

TEST_CASE("a control mesh is closed around all of a mesh, in about as many vertices as asked",
          "[mesh][subdivision]") {
  if (!can_wrap()) return;
  for (const TriangleMesh& mesh :
       {sheet(20), bar(30, 5, 4, 0.6), sphere(3), flat_square(8, 0, 1), plate_with_wall(10).mesh})
    for (const int asked : {60, 150}) {
      ControlMeshOptions options;
      options.vertices = asked;
      const TriangleMesh control = control_mesh(mesh, options);
      INFO(control.vertex_count() << " of " << asked);
      CHECK(control.topology().boundary_loops().empty());
      CHECK(control.vertex_count() > asked / 3);
      CHECK(control.vertex_count() < 2 * asked);
      double least = 1;
      for (const auto& t : mesh.triangles())
        for (const Vec3& w : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 1)})
          least = std::min(
              least, winding_number(control, (w[0] * mesh.point(t[0]) + w[1] * mesh.point(t[1]) +
                                              w[2] * mesh.point(t[2])) /
                                                 w.sum()));
      CHECK(least > 0.999);
    }
  for (const int bad : {0, 19, 2001}) {
    ControlMeshOptions options;
    options.vertices = bad;
    CHECK(!error_message([&] { control_mesh(sphere(1), options); }).empty());
  }
  CHECK(!error_message([&] { control_mesh(TriangleMesh(Points::Zero(1, 3), {})); }).empty());
}

TEST_CASE("a control mesh follows rigid motions exactly, and bends with its mesh",
          "[mesh][subdivision]") {
  const TriangleMesh mesh = bar(16, 4, 3, 0.6), control = around_bar();
  const ControlMeshTransfer transfer(mesh, control.points(),
                                     mean_value_coordinates(control, mesh.points()));
  CHECK(distance(transfer.at(mesh.points()), control.points()) < 1e-13);
  Random random(53);
  for (int k = 0; k < 5; ++k) {
    const RigidMotion m = random_motion(random);
    CHECK(distance(transfer.at(moved(m, mesh.points())), moved(m, control.points())) < 1e-13);
  }
  // Bent about y: each control vertex approximately follows its section.
  const auto bend = [](const Points& p) {
    Points q = p;
    for (int v = 0; v < p.rows(); ++v) {
      const double a = 0.3 * p(v, 0), r = 1 / 0.3 - p(v, 2);
      q.row(v) << r * std::sin(a), p(v, 1), 1 / 0.3 - r * std::cos(a);
    }
    return q;
  };
  CHECK(distance(transfer.at(bend(mesh.points())), bend(control.points())) < 0.06);
  CHECK(!error_message([&] {
           ControlMeshTransfer(mesh, control.points(), MatX::Zero(mesh.vertex_count(), 3));
         }).empty());
}

TEST_CASE("a few vertices carry no edit and rigid motions exactly, others about",
          "[mesh][subdivision]") {
  const TriangleMesh mesh = bar(20, 4, 3, 0.6), control = around_bar();
  const Points& p = mesh.points();
  FrameConstraints constraints;
  constraints.handles = {{"left", nodes_where(p, [](const Vec3& x) { return x.x() < 0.01; })},
                         {"right", nodes_where(p, [](const Vec3& x) { return x.x() > 2.99; })}};
  SubspaceSolver solver(mesh, constraints, control);
  solver.set_frame(p, control.points());
  CHECK(distance(solver.solve(prescribed({{}, {}})), p) < 1e-9);
  Random random(54);
  double rigid = 0;
  for (int k = 0; k < 4; ++k) {
    const RigidMotion m = random_motion(random);
    rigid = std::max(rigid, distance(solver.solve(prescribed({m, m})), moved(m, p)));
    CHECK(distance(solver.control(), moved(m, control.points())) < 1e-6);
  }
  INFO("rigid " << rigid);
  CHECK(rigid < 1e-6);
  // The result is W d, with handles close to their targets.
  const RigidMotion up{Mat3::Identity(), Vec3(-0.2, 0, 0.5)};
  const Points bent_up = solver.solve(prescribed({{}, up}));
  CHECK(distance(mean_value_coordinates(control, p) * solver.control(), bent_up) < 1e-10);
  CHECK((centroid(bent_up, constraints.handles[1].vertices) -
         up(centroid(p, constraints.handles[1].vertices)))
            .norm() < 0.05);
  const ThreadGuard guard(2);
  CHECK(solver.solve(prescribed({{}, up})) == bent_up);

  CHECK(!error_message([&] { solver.solve(prescribed({{}})); }).empty());
  CHECK(!error_message([&] { solver.set_frame(p.topRows(5), control.points()); }).empty());
  CHECK(!error_message([&] { SubspaceSolver(mesh, constraints, sheet(3)); }).empty());
  CHECK(!error_message([&] { SubspaceSolver(mesh, {}, control); }).empty());
  CHECK(!error_message([&] { SubspaceSolver(mesh, constraints, control, {0, 100}); }).empty());
  CHECK(!error_message([&] { SubspaceSolver(mesh, constraints, control, {8, -1}); }).empty());
}

TEST_CASE("a session updates at once and refines to the result of the solver",
          "[mesh][subdivision]") {
  const TriangleMesh mesh = bar(24, 4, 3, 0.6);
  const Points& p = mesh.points();
  FrameConstraints constraints;
  constraints.fixed = nodes_where(p, [](const Vec3& x) { return x.x() < 0.01; });
  constraints.handles = {{"right", nodes_where(p, [](const Vec3& x) { return x.x() > 2.99; })}};
  constraints.features = {
      {"middle", nodes_where(p, [](const Vec3& x) { return std::abs(x.x() - 1.5) < 0.2; })}};
  const FrameOptions fine{FrameOptions::Weights::Uniform, 3000, 1e-10};
  FrameSession session(mesh, constraints, around_bar(), fine);
  CHECK(!error_message([&] { session.solve_preview(prescribed({{}})); }).empty());
  // A frame other than that of the mesh.
  const Points frame = moved({rotation_matrix(Vec3(0.1, 0.3, 0.2)), Vec3(1, 2, 3)}, p);
  session.set_frame(frame);
  CHECK(session.positions() == frame);
  CHECK(!error_message([&] { session.refine(1); }).empty());
  const Vec3 c = centroid(frame, constraints.handles[0].vertices);
  FrameSolver solver(mesh, constraints, fine);
  for (const double angle : {0.3, 0.8}) {
    const RigidMotion m = RigidMotion::about(
        c, rotation_matrix(to_rotation_vector(Vec3(0.2, 1, 0), angle)), c + Vec3(-0.1, 0.2, 0.3));
    const Points solve_preview = session.solve_preview(prescribed({m}));
    const double first =
        arap_energy(mesh, frame, solve_preview, local_rotations(mesh, frame, solve_preview));
    bool rests = session.refine(5);
    CHECK(session.report().iterations == 5);
    // Starting from the result, as the solver would.
    FrameSolver direct(mesh, constraints, {FrameOptions::Weights::Uniform, 1, 1e-10});
    direct.alternate(frame, prescribed({m}), solve_preview);
    CHECK_FALSE(direct.iterate(4));
    CHECK(session.positions() == direct.result().positions);
    CHECK(bent(frame, session.positions(), constraints.features[0].vertices) < 1e-12);
    double before = 1e300;
    for (const double e : session.report().energies) {
      CHECK(e <= before * (1 + 1e-12));
      before = e;
    }
    for (int k = 0; k < 300 && !rests; ++k) rests = session.refine(20);
    CHECK(rests);
    solver.alternate(frame, prescribed({m}));
    const double apart = distance(session.positions(), solver.result().positions);
    INFO("first " << first << ", last " << session.report().energies.back() << ", apart " << apart);
    CHECK(session.report().energies.back() ==
          Approx(solver.report().energies.back()).epsilon(1e-9));
    CHECK(apart < 1e-6);
  }
  CHECK(error_message([&] { session.set_frame(p.topRows(4)); }).find("4 nodes") !=
        std::string::npos);
}
