// SPDX-License-Identifier: MPL-2.0
// One frame with ARAP: invariants and result of the alternating minimisation.
#include "batten/mesh/sequence/frame_solver.h"

#include "batten/mesh/sequence/local_global_steps.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

/// A mesh and its two ends: one is fixed or a handle, the other one a handle.
struct Sample {
  std::string name;
  TriangleMesh mesh;
  std::vector<int> one, other;
  Points frame() const { return mesh.points().topRows(mesh.topology().node_count()); }
};

Sample sample(const std::string& name, const TriangleMesh& mesh, double low, double high) {
  const Points p = mesh.points().topRows(mesh.topology().node_count());
  return {name, mesh, nodes_where(p, [&](const Vec3& x) { return x.x() <= low; }),
          nodes_where(p, [&](const Vec3& x) { return x.x() >= high; })};
}

std::vector<Sample> samples() {
  return {sample("open", sheet(40), 0.05, 3.95), sample("closed", bar(40, 6, 4, 0.6), 0.01, 3.9),
          sample("sphere", sphere(4), -0.9, 0.9),
          sample("joint", plate_with_wall(20).mesh, 0.01, 1.99)};
}

FrameConstraints two_handles(const Sample& s) {
  FrameConstraints constraints;
  constraints.handles = {{"one", s.one}, {"other", s.other}};
  return constraints;
}

FrameTargets prescribed(const std::vector<RigidMotion>& motions) {
  FrameTargets targets;
  for (const auto& m : motions) targets.handles.push_back({m, false});
  return targets;
}

/// The other end lifted and rotated about its centroid.
RigidMotion bending(const Sample& s, double angle = 0.9) {
  const Vec3 c = centroid(s.frame(), s.other);
  return RigidMotion::about(c, rotation_matrix(to_rotation_vector(Vec3(0.3, 1, 0.2), angle)),
                            c + s.mesh.size() * Vec3(-0.1, 0.05, 0.2));
}

double highest_rise(const std::vector<double>& energies) {
  double rise = 0;
  for (size_t k = 1; k < energies.size(); ++k)
    rise = std::max(rise, (energies[k] - energies[k - 1]) / energies[0]);
  return rise;
}

}  // namespace

TEST_CASE("a frame without an edit stays, and one rigid motion moves all of it",
          "[mesh][sequences]") {
  Random random(41);
  for (const Sample& s : samples())
    for (const auto weights : {FrameOptions::Weights::Uniform, FrameOptions::Weights::Cotangent}) {
      FrameSolver solver(s.mesh, two_handles(s), {weights});
      const Points p = s.frame();
      const double size = s.mesh.size();
      solver.alternate(p, prescribed({{}, {}}));
      const double still = distance(solver.result().positions, p) / size;
      double rigid = 0;
      for (int k = 0; k < 3; ++k) {
        const RigidMotion m = random_motion(random);
        solver.alternate(p, prescribed({m, m}));
        rigid = std::max(rigid, distance(solver.result().positions, moved(m, p)) / size);
        CHECK(solver.report().converged);
        for (const Mat3& rotation : solver.result().rotations)
          rigid = std::max(rigid, (rotation - m.rotation).norm());
      }
      INFO(s.name << ": still " << still << ", rigid " << rigid);
      CHECK(still < 1e-13);
      CHECK(rigid < 1e-12);
    }
}

TEST_CASE("no round raises the energy, whatever is held", "[mesh][sequences]") {
  for (const Sample& s : samples())
    for (const auto weights : {FrameOptions::Weights::Uniform, FrameOptions::Weights::Cotangent})
      for (int kind = 0; kind < 4; ++kind) {
        FrameConstraints constraints;
        constraints.fixed = s.one;
        constraints.handles = {{"other", s.other}};
        if (kind == 1) constraints.penalty_weight = 3;
        if (kind >= 2)
          constraints.features = {{"middle", nodes_where(s.frame(), [&](const Vec3& x) {
                                     return std::abs(x.x() - 0.5 * s.mesh.box().max().x()) <
                                            0.1 * s.mesh.size();
                                   })}};
        FrameSolver solver(s.mesh, constraints, {weights, 60, 1e-9});
        FrameTargets targets = prescribed({bending(s)});
        targets.handles[0].free_rotation = kind == 3;
        solver.alternate(s.frame(), targets);
        const auto& energies = solver.report().energies;
        INFO(s.name << ", kind " << kind << ", rise " << highest_rise(energies));
        REQUIRE(energies.size() > 5);
        CHECK(highest_rise(energies) <= 1e-12);
        double drawn = 0;
        for (const int v : s.other)
          drawn +=
              (Vec3(solver.result().positions.row(v)) - bending(s)(s.frame().row(v))).squaredNorm();
        if (weights == FrameOptions::Weights::Uniform)
          CHECK(energies.back() - (kind == 1 ? 3 * drawn : 0) ==
                Approx(arap_energy(s.mesh, s.frame(), solver.result().positions,
                                   solver.result().rotations))
                    .epsilon(1e-9));
      }
}

TEST_CASE("the global step is the least-squares solution of a dense reference implementation",
          "[mesh][sequences]") {
  Random random(42);
  const Sample s = sample("bar", bar(7, 2, 2, 0.5), 0.01, 1.99);
  const Points p = s.frame();
  std::vector<Mat3> rotations;
  for (int v = 0; v < p.rows(); ++v) rotations.push_back(random_rotation_matrix(random));
  const RigidMotion m = bending(s);
  const std::vector<int> left = nodes_where(
                             p, [](const Vec3&x) { return std::abs(x.x() - 0.6) < 0.2; }),
                         right = nodes_where(
                             p, [](const Vec3&x) { return std::abs(x.x() - 1.4) < 0.2; });
  const auto mean_turn = [&](const std::vector<int>& nodes) {
    Mat3 sum = Mat3::Zero();
    for (const int v : nodes) sum += rotations[v];
    return nearest_rotation(sum);
  };
  for (int kind = 0; kind < 6; ++kind) {
    FrameConstraints constraints;
    constraints.fixed = s.one;
    constraints.handles = {{"end", s.other}};
    FrameTargets targets = prescribed({m});
    std::vector<Mat3> all = rotations;
    std::optional<ReferenceFrameSolver> reference_solver;
    const auto rigid_turn = [&](const std::vector<int>& nodes) {
      const Mat3 R = mean_turn(nodes);
      for (const int v : nodes) all[v] = R;
    };
    if (kind == 2) {
      constraints.features = {{"left", left}, {"right", right, FormFeature::Kind::TranslationOnly}};
      rigid_turn(left);
      for (const int v : right) all[v] = Mat3::Identity();
    }
    if (kind == 3) {
      targets.handles[0].free_rotation = true;
      rigid_turn(s.other);
    }
    if (kind == 1) constraints.penalty_weight = 0.7;
    if (kind == 4) {
      constraints.point_constraints = {{"plane", VertexCombination::mean_of({left[0]}),
                                        PointConstraint::Kind::OnPlane, Vec3(1, 2, 0.5)},
                                       {"line", VertexCombination::mean_of({right[1]}),
                                        PointConstraint::Kind::OnLine, Vec3(-0.2, 0.4, 1)}};
      targets.constraint_origins = {Vec3(0.5, 0.3, 0.1), Vec3(1.4, -0.2, 0.3)};
    }
    if (kind == 5) {
      // Features that share nodes are one; with a fixed node they stay; with a handle they follow.
      constraints.features = {{"a", {left[0], left[1], left[2]}},
                              {"b", {left[2], left[3]}},
                              {"stays", {s.one[0], left.back()}},
                              {"goes", {s.other[0], right[0]}}};
      const std::vector<int> both(left.begin(), left.begin() + 4);
      rigid_turn(both);
    }
    reference_solver.emplace(s.mesh, p, all);
    for (const int v : s.one) reference_solver->fix(v, p.row(v));
    if (kind == 1)
      for (const int v : s.other) reference_solver->add_soft_target(v, m(p.row(v)), 0.7);
    else if (kind == 3)
      reference_solver->rigid(s.other, mean_turn(s.other)),
          reference_solver->mean(s.other, m(centroid(p, s.other)));
    else
      for (const int v : s.other) reference_solver->fix(v, m(p.row(v)));
    if (kind == 2)
      reference_solver->rigid(left, mean_turn(left)),
          reference_solver->rigid(right, Mat3::Identity());
    if (kind == 4) {
      reference_solver->on_plane(left[0], Vec3(1, 2, 0.5).normalized(),
                                 targets.constraint_origins[0]);
      const Vec3 d = Vec3(-0.2, 0.4, 1).normalized(), a = d.unitOrthogonal();
      reference_solver->on_plane(right[1], a, targets.constraint_origins[1]);
      reference_solver->on_plane(right[1], a.cross(d), targets.constraint_origins[1]);
    }
    if (kind == 5) {
      const std::vector<int> both(left.begin(), left.begin() + 4);
      reference_solver->rigid(both, mean_turn(both));
      reference_solver->fix(left.back(), p.row(left.back()));
      reference_solver->fix(right[0], m(p.row(right[0])));
    }
    FrameSolver solver(s.mesh, constraints);
    solver.reconstruct(p, targets, rotations);
    const double apart = distance(solver.result().positions, reference_solver->solve());
    INFO("kind " << kind << ": " << apart);
    CHECK(apart < 1e-12);
  }
}

TEST_CASE("at convergence no one-ring and no node has a better position", "[mesh][sequences]") {
  const Sample s = sample("bar", bar(12, 3, 3, 0.6), 0.01, 2.99);
  const Points p = s.frame();
  FrameConstraints constraints;
  constraints.fixed = s.one;
  constraints.handles = {{"end", s.other}};
  FrameSolver solver(s.mesh, constraints, {FrameOptions::Weights::Uniform, 5000, 1e-13});
  solver.alternate(p, prescribed({bending(s)}));
  REQUIRE(solver.report().converged);
  const FrameShape& at = solver.result();
  std::vector<Mat3> rotations = local_rotations(s.mesh, p, at.positions);
  for (const auto* held : {&s.one, &s.other})
    for (const int v : *held) rotations[v] = at.rotations[v];
  CHECK(distance(rotations, at.rotations) < 1e-10);
  ReferenceFrameSolver reference_solver(s.mesh, p, at.rotations);
  for (const int v : s.one) reference_solver.fix(v, p.row(v));
  for (const int v : s.other) reference_solver.fix(v, bending(s)(p.row(v)));
  CHECK(distance(reference_solver.solve(), at.positions) < 1e-11);
}

TEST_CASE("softness tends to hard handles", "[mesh][sequences]") {
  const Sample s = sample("sheet", sheet(12), 0.05, 3.95);
  FrameConstraints constraints = two_handles(s);
  const FrameTargets targets = prescribed({{}, bending(s)});
  const FrameOptions options{FrameOptions::Weights::Uniform, 3000, 1e-11};
  FrameSolver hard(s.mesh, constraints, options);
  hard.alternate(s.frame(), targets);
  double before = 1e300;
  for (const double penalty_weight : {1e1, 1e3, 1e5, 1e7}) {
    constraints.penalty_weight = penalty_weight;
    FrameSolver soft(s.mesh, constraints, options);
    soft.alternate(s.frame(), targets);
    const double apart = distance(soft.result().positions, hard.result().positions);
    INFO("softness " << penalty_weight << ": " << apart);
    CHECK(apart < 0.05 * before);
    before = apart;
  }
  CHECK(before < 1e-6);
}

TEST_CASE("frames are the same bits on one thread and two, and go on where they stopped",
          "[mesh][sequences]") {
  const Sample s = sample("sheet", sheet(40), 0.05, 3.95);
  FrameConstraints constraints = two_handles(s);
  constraints.features = {{"middle", nodes_where(s.frame(), [](const Vec3& x) {
                             return (x - Vec3(2, 2, x.z())).norm() < 0.5;
                           })}};
  const FrameTargets targets = prescribed({{}, bending(s)});
  const auto solved = [&](int threads, int iterations, int more) {
    const ThreadGuard guard(threads);
    FrameSolver solver(s.mesh, constraints, {FrameOptions::Weights::Uniform, iterations, 1e-12});
    solver.alternate(s.frame(), targets);
    if (more > 0) CHECK_FALSE(solver.iterate(more));
    return solver.result().positions;
  };
  const Points one = solved(1, 12, 0);
  CHECK(solved(2, 12, 0) == one);
  CHECK(solved(1, 5, 7) == one);
}

TEST_CASE("the rotations of a shape at rest give it back in one linear step", "[mesh][sequences]") {
  for (const Sample& s : samples()) {
    FrameSolver solver(s.mesh, two_handles(s), {FrameOptions::Weights::Cotangent, 300, 1e-7});
    const FrameTargets targets = prescribed({{}, bending(s, 0.4)});
    solver.alternate(s.frame(), targets);
    const FrameShape at = solver.result();
    solver.reconstruct(s.frame(), targets, at.rotations);
    INFO(s.name << " " << solver.report().iterations << " " << solver.report().converged);
    CHECK(distance(solver.result().positions, at.positions) < 3e-7 * s.mesh.size());
    // It converges to the same shape from another start.
    solver.alternate(s.frame(), targets, at.positions);
    CHECK(solver.report().iterations <= 3);
    CHECK(distance(solver.result().positions, at.positions) < 1e-6 * s.mesh.size());
  }
}

TEST_CASE("edges where manifold patches meet are one edge between nodes, with their weights added",
          "[mesh][sequences]") {
  const TriangleMesh mesh = plate_with_wall(6).mesh;
  const size_t all = mesh.topology().edges().size();
  const NodeGraph plain = node_graph(mesh.topology()),
                  summed = node_graph(mesh.topology(), std::vector<double>(all, 1));
  REQUIRE(plain.edges.size() == node_edges(mesh).size());
  REQUIRE(all > plain.edges.size());
  double sum = 0;
  for (size_t e = 0; e < plain.edges.size(); ++e) {
    CHECK(std::pair(plain.edges[e].a, plain.edges[e].b) == node_edges(mesh)[e]);
    CHECK(plain.edges[e].weight == 1);
    sum += summed.edges[e].weight;
  }
  CHECK(sum == static_cast<double>(all));
}
