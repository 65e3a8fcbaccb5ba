// SPDX-License-Identifier: MPL-2.0
// Form features in mesh deformation: properties of mesh/deform.
#include <algorithm>
#include <numbers>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/kkt_deformation.h"
#include "batten/tests/support/sample_meshes.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

template <class Inside>
std::vector<int> where(const TriangleMesh& mesh, const Inside& inside) {
  std::vector<int> found;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (inside(mesh.point(v))) found.push_back(v);
  return found;
}

std::vector<int> disc(const TriangleMesh& mesh, double x, double y, double radius) {
  return where(mesh, [&](const Vec3& p) { return std::hypot(p.x() - x, p.y() - y) < radius; });
}

int nearest_to(const TriangleMesh& mesh, const Vec3& point) {
  int nearest = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if ((mesh.point(v) - point).norm() < (mesh.point(nearest) - point).norm()) nearest = v;
  return nearest;
}

HandleTransform some_move() {
  HandleTransform move;
  move.about = {4, 2, 0};
  move.rotation_vector = to_rotation_vector({0.3, 1, 0.2}, 0.6);
  move.translation = {0.2, 0.1, 0.9};
  return move;
}

/// Left border fixed, right border a handle, three features (one keeps its orientation, one is
/// scaled), one point constrained to a plane and one to a line.
struct Case {
  TriangleMesh mesh;
  DeformProblem problem;
  DeformEdit edit;
  explicit Case(int n, bool point_constraints) : mesh(sheet(n)) {
    problem.fixed = where(mesh, [&](const Vec3& p) { return p.x() < 4.5 / n; });
    problem.handles = {{"right", where(mesh, [&](const Vec3& p) { return p.x() > 4 - 4.5 / n; })}};
    problem.features = {{"a", disc(mesh, 1.2, 1.2, 0.45), FormFeature::Kind::Free},
                        {"b", disc(mesh, 2.6, 1.1, 0.4), FormFeature::Kind::TranslationOnly},
                        {"c", disc(mesh, 2.0, 2.8, 0.5), FormFeature::Kind::Free}};
    if (point_constraints)
      problem.point_constraints = {{"plane",
                                    VertexCombination::mean_of(problem.features[0].vertices),
                                    PointConstraint::Kind::OnPlane,
                                    {0.1, 0.2, 1}},
                                   {"line",
                                    VertexCombination::mean_of(problem.features[2].vertices),
                                    PointConstraint::Kind::OnLine,
                                    {1, 0.2, 0.1}}};
    edit.handles = {some_move()};
    edit.feature_scales = {1, 1, 1.3};
  }
};

}  // namespace

TEST_CASE("without features the deformer solves the dense least-squares problem",
          "[mesh][deform]") {
  const TriangleMesh mesh = sheet(9);
  for (const auto weighting : {DeformProblem::Weighting::Area, DeformProblem::Weighting::Uniform}) {
    DeformProblem problem;
    problem.fixed = where(mesh, [](const Vec3& p) { return p.x() < 0.1; });
    problem.handles = {{"h", disc(mesh, 3, 2, 0.6)}, {"k", disc(mesh, 1.5, 3.5, 0.5)}};
    problem.weighting = weighting;
    DeformEdit edit;
    edit.handles = {some_move(), {}};
    edit.handles[1].translation = {0, 0, -0.5};
    edit.handles[1].scale = 1.2;
    FormFeatureDeformer deformer(mesh, problem);
    const Points p = deformer.deform(edit);
    deformer.correct();

    // Dense reference: L_c and A_i, the harmonic field, the least squares problem.
    const int n = mesh.vertex_count();
    const SparseMatrix lower = cotangent_laplacian(mesh);
    const MatX L = lower.selfadjointView<Eigen::Lower>() * MatX::Identity(n, n);
    const VecX area = mixed_areas(mesh);
    std::vector<int> held = problem.fixed;
    MatX q_held = MatX::Zero(n, 3);
    Points x = mesh.points();
    std::vector<double> scale(n, 1);
    for (size_t h = 0; h < 2; ++h)
      for (const int v : problem.handles[h].vertices) {
        held.push_back(v);
        q_held.row(v) = edit.handles[h].rotation_vector;
        scale[v] = edit.handles[h].scale;
        x.row(v) = edit.handles[h](mesh.point(v));
      }
    std::vector<int> moving;
    for (int v = 0; v < n; ++v)
      if (std::find(held.begin(), held.end(), v) == held.end()) moving.push_back(v);
    MatX q = q_held;
    const MatX L_free = L(moving, moving), pull = -L * q_held;
    const MatX q_free = solve_symmetric(L_free, pull(moving, Eigen::all));
    q(moving, Eigen::all) = q_free;
    MatX A(n, n), b(n, 3);
    for (int i = 0; i < n; ++i) {
      const double w = weighting == DeformProblem::Weighting::Area ? std::sqrt(area[i]) : 1;
      A.row(i) = w / (2 * area[i]) * L.row(i);
      const Vec3 delta = (L.row(i) * mesh.points()).transpose() / (2 * area[i]);
      const double angle = q.row(i).norm();
      const Vec3 axis = angle > 0 ? Vec3(q.row(i).transpose().normalized()) : Vec3(Vec3::UnitX());
      b.row(i) = w * scale[i] * (Eigen::AngleAxisd(angle, axis) * delta).transpose();
    }
    MatX known = MatX::Zero(n, 3);
    known(held, Eigen::all) = x(held, Eigen::all);
    const MatX columns = A(Eigen::all, moving), target = b - A * known;
    const MatX free = least_squares(columns, target);
    x(moving, Eigen::all) = free;
    CHECK(relative(p, x) < 1e-10);
    CHECK(relative(deformer.positions(), x) < 1e-12);
    CHECK(deformer.hard_residual() < 1e-14);
    // Rows of fixed vertices, and of features with their whole one-ring, are constant: without them
    // the result is the same.
    CHECK(deformer.counts().moving == static_cast<int>(moving.size()));
  }
}

TEST_CASE("reduction, saddle point and dense elimination of all rows agree", "[mesh][deform]") {
  for (const bool point_constraints : {false, true}) {
    Case c(16, point_constraints);
    FormFeatureDeformer deformer(c.mesh, c.problem);
    const Points p = deformer.deform(c.edit);
    CHECK(deformer.hard_residual() < 1e-13);
    CHECK(relative(deform_by_kkt(deformer, c.edit), p) < 1e-9);
    const auto s = deformer.problem_matrices(c.edit);
    const SparseMatrix A = s.A;
    const SparseMatrix normal = SparseMatrix(A.transpose()) * A;
    const SparseMatrix lower = normal.triangularView<Eigen::Lower>();
    const Points x = solve_constrained(s.constraints, lower, Points(A.transpose() * s.b));
    Points moved = deformer.positions();
    for (size_t k = 0; k < s.vertices.size(); ++k)
      moved.row(s.vertices[k]) = x.row(static_cast<long>(k)) + s.origin.transpose();
    CHECK(relative(moved, p) < 1e-9);
  }
}

TEST_CASE("features are their originals up to one similarity", "[mesh][deform]") {
  for (const bool point_constraints : {false, true}) {
    Case c(24, point_constraints);
    FormFeatureDeformer deformer(c.mesh, c.problem);
    for (int event = 0; event < 5; ++event) {
      c.edit.handles[0].translation.z() += 0.3;
      c.edit.feature_scales[2] *= 1.1;
      deformer.deform(c.edit);
      if (event == 4) deformer.correct();
      for (size_t f = 0; f < 3; ++f) {
        const Similarity fit =
            fit_similarity(c.mesh.points(), deformer.positions(), c.problem.features[f].vertices);
        CHECK(fit.max_error < 1e-13);
        CHECK(fit.scale == Approx(c.edit.feature_scales[f]).epsilon(1e-12));
        if (f == 1) CHECK((fit.R - Mat3::Identity()).norm() < 1e-12);
        if (f == 0) CHECK((fit.R - Mat3::Identity()).norm() > 1e-3);
      }
      if (point_constraints) {
        const auto off = [&](int k) {
          const auto& g = c.problem.point_constraints[k];
          return Vec3(g.point.at(deformer.positions()) - g.point.at(c.mesh.points()));
        };
        CHECK(std::abs(off(0).dot(c.problem.point_constraints[0].direction.normalized())) < 1e-13);
        CHECK(off(1).cross(c.problem.point_constraints[1].direction.normalized()).norm() < 1e-13);
        CHECK(off(1).norm() > 1e-3);
      }
    }
  }
}

TEST_CASE("a rigid motion of everything held moves the mesh rigidly", "[mesh][deform]") {
  for (const double angle : {0.4, 2.5, 3 * std::numbers::pi}) {
    Case c(20, false);
    c.problem.handles.push_back({"left", c.problem.fixed});
    c.problem.fixed.clear();
    c.problem.features[1].kind = FormFeature::Kind::Free;
    c.edit.handles.assign(2, {});
    c.edit.feature_scales.clear();
    for (auto& move : c.edit.handles) {
      move.about = {1, 2, 3};
      move.rotation_vector = to_rotation_vector({1, 2, -0.5}, angle);
      move.translation = {-3, 1, 2};
    }
    FormFeatureDeformer deformer(c.mesh, c.problem);
    deformer.deform(c.edit);
    deformer.correct();
    Points moved(c.mesh.vertex_count(), 3);
    for (int v = 0; v < c.mesh.vertex_count(); ++v)
      moved.row(v) = c.edit.handles[0](c.mesh.point(v));
    CHECK(relative(deformer.positions(), moved) < 1e-12);
  }
}

TEST_CASE("features in the dense problem: one translation and one rotation for all their vertices",
          "[mesh][deform]") {
  const TriangleMesh mesh = sheet(9);
  DeformProblem problem;
  problem.fixed = where(mesh, [](const Vec3& p) { return p.x() < 0.1; });
  problem.handles = {{"h", where(mesh, [](const Vec3& p) { return p.x() > 3.9; })}};
  problem.features = {{"a", disc(mesh, 1.3, 1.3, 0.7)}, {"b", disc(mesh, 2.6, 2.8, 0.7)}};
  DeformEdit edit;
  edit.handles = {some_move()};
  edit.feature_scales = {1.25, 0.9};
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  deformer.correct();

  // Unknowns: the position of each free vertex, one translation t_f per feature; likewise the
  // rotations with one q_f. x = T u + x_held + s R(q_f) p⁰.
  const int n = mesh.vertex_count();
  std::vector<int> owner(n, -1);  // 0, 1: features; 2: fixed
  for (int f = 0; f < 2; ++f)
    for (const int v : problem.features[f].vertices) owner[v] = f;
  MatX q0 = MatX::Zero(n, 3), x0 = MatX::Zero(n, 3);
  for (const int v : problem.fixed) {
    owner[v] = 2;
    x0.row(v) = mesh.point(v).transpose();
  }
  for (const int v : problem.handles[0].vertices) {
    owner[v] = 2;
    q0.row(v) = edit.handles[0].rotation_vector.transpose();
    x0.row(v) = edit.handles[0](mesh.point(v)).transpose();
  }
  std::vector<int> column(n, -1);
  int columns = 2;
  for (int v = 0; v < n; ++v) column[v] = owner[v] < 0 ? columns++ : owner[v] < 2 ? owner[v] : -1;
  MatX T = MatX::Zero(n, columns);
  for (int v = 0; v < n; ++v)
    if (column[v] >= 0) T(v, column[v]) = 1;
  const SparseMatrix lower = cotangent_laplacian(mesh);
  const MatX L = lower.selfadjointView<Eigen::Lower>() * MatX::Identity(n, n);
  const VecX area = mixed_areas(mesh);
  const MatX TLT = T.transpose() * L * T, pull = -T.transpose() * (L * q0);
  const MatX q = T * solve_symmetric(TLT, pull) + q0;
  MatX A(n, n), b(n, 3);
  for (int v = 0; v < n; ++v) {
    const Vec3 log = q.row(v).transpose();
    if (owner[v] == 0 || owner[v] == 1)
      x0.row(v) = edit.feature_scales[owner[v]] * rotated(log, mesh.point(v)).transpose();
    A.row(v) = L.row(v) / (2 * std::sqrt(area[v]));
    const double s = owner[v] == 0 || owner[v] == 1 ? edit.feature_scales[owner[v]] : 1;
    const Vec3 delta = (A.row(v) * mesh.points()).transpose();
    b.row(v) = s * rotated(log, delta).transpose();
  }
  const MatX AT = A * T, rest = b - A * x0;
  const MatX u = least_squares(AT, rest);
  const Points x = T * u + x0;
  CHECK(relative(deformer.positions(), x) < 1e-11);
  CHECK((deformer.rotation_logs() - q).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("contradictions are named, and the last good state stays", "[mesh][deform]") {
  Case c(16, false);
  // A feature from the fixed border to the handle.
  c.problem.features = {
      {"strut", where(c.mesh, [](const Vec3& p) { return std::abs(p.y() - 2) < 0.3; })}};
  c.edit.feature_scales.clear();
  FormFeatureDeformer deformer(c.mesh, c.problem);
  CHECK(deformer.counts().redundant_count > 0);
  DeformEdit still;
  still.handles = {{}};
  const Points before = deformer.deform(still);
  CHECK(relative(before, c.mesh.points()) < 1e-12);
  const auto names_of = [&](const DeformEdit& edit) {
    std::vector<std::string> names;
    try {
      deformer.deform(edit);
    } catch (const ConflictError& e) {
      for (const auto& conflict : e.conflicts())
        for (const auto& name : conflict.names)
          if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  };
  const std::vector<std::string> all = {"fixed", "right", "strut"};
  DeformEdit moved = still;
  moved.handles[0].translation = {0, 0, 1};
  CHECK(names_of(moved) == all);
  DeformEdit turned = still;
  turned.handles[0].rotation_vector = {0, 0, std::numbers::pi};  // full turn: the same position
  CHECK(names_of(turned) == all);
  CHECK(deformer.positions() == before);
  CHECK_THROWS_AS(deformer.correct(), InputError);
  CHECK(deformer.hard_residual() < 1e-13);
  CHECK(deformer.deform(still) == before);
}

TEST_CASE("features that touch merge, follow a handle, or stay with the fixed vertices",
          "[mesh][deform]") {
  Case c(16, false);
  c.problem.features = {{"a", disc(c.mesh, 1.2, 1.5, 0.5)},
                        {"b", disc(c.mesh, 1.8, 1.5, 0.5)},
                        {"at the handle", disc(c.mesh, 3.7, 3, 0.5)},
                        {"at the border", disc(c.mesh, 0.2, 3, 0.6)}};
  c.edit.feature_scales.clear();
  FormFeatureDeformer deformer(c.mesh, c.problem);
  const Points p = deformer.deform(c.edit);
  const auto both = [&](int i, int j) {
    std::vector<int> vertices = c.problem.features[i].vertices;
    for (const int v : c.problem.features[j].vertices) vertices.push_back(v);
    return vertices;
  };
  CHECK(fit_similarity(c.mesh.points(), p, both(0, 1), 1).max_error < 1e-13);
  for (const int v : c.problem.features[2].vertices)
    CHECK((p.row(v).transpose() - c.edit.handles[0](c.mesh.point(v))).norm() < 1e-12);
  for (const int v : c.problem.features[3].vertices)
    CHECK((p.row(v).transpose() - c.mesh.point(v)).norm() < 1e-12);
  // Two scales contradict each other if more than one vertex is shared.
  c.edit.feature_scales = {1.1, 1, 1, 1};
  CHECK_THROWS_AS(deformer.deform(c.edit), ConflictError);
}

TEST_CASE("guided points: redundant rows are dropped, impossible ones named, planes move",
          "[mesh][deform]") {
  Case c(16, true);
  c.problem.point_constraints.push_back(c.problem.point_constraints[0]);
  c.problem.point_constraints.back().name = "again";
  FormFeatureDeformer deformer(c.mesh, c.problem);
  deformer.deform(c.edit);
  CHECK(deformer.hard_residual() < 1e-13);
  CHECK(deformer.counts().point_equations == 4);
  c.edit.constraint_origins.clear();
  for (const auto& g : c.problem.point_constraints)
    c.edit.constraint_origins.push_back(g.point.at(c.mesh.points()));
  const Vec3 n = c.problem.point_constraints[0].direction.normalized();
  for (const int k : {0, 2}) c.edit.constraint_origins[k] += 0.3 * n + 0.7 * n.unitOrthogonal();
  deformer.deform(c.edit);
  const Vec3 off = c.problem.point_constraints[0].point.at(deformer.positions()) -
                   c.problem.point_constraints[0].point.at(c.mesh.points());
  CHECK(off.dot(n) == Approx(0.3).epsilon(1e-12));
  c.edit.constraint_origins[2] += 0.1 * n;
  try {
    deformer.deform(c.edit);
    FAIL("two different planes for one point");
  } catch (const ConflictError& e) {
    REQUIRE(e.conflicts().size() == 1);
    CHECK(e.conflicts()[0].names == std::vector<std::string>{"plane", "again"});
    CHECK(e.conflicts()[0].amount > 0.001);
  }
  // A fixed point outside its plane: the message names the fixed region and the constraint.
  Case d(16, false);
  d.problem.point_constraints = {{"guide", VertexCombination::mean_of(d.problem.fixed),
                                  PointConstraint::Kind::OnPlane, Vec3::UnitZ()}};
  FormFeatureDeformer held(d.mesh, d.problem);
  held.deform(d.edit);
  CHECK(held.hard_residual() < 1e-13);
  d.edit.constraint_origins = {d.problem.point_constraints[0].point.at(d.mesh.points()) +
                               Vec3(0, 0, 0.5)};
  try {
    held.deform(d.edit);
    FAIL("the fixed region cannot move");
  } catch (const ConflictError& e) {
    CHECK(e.conflicts()[0].names == std::vector<std::string>{"fixed", "guide"});
  }
}

TEST_CASE("many guided points: the Schur complement is the coupled reduction", "[mesh][deform]") {
  Case c(14, false);
  // A plane for 20 single vertices, a separate direction for each.
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const int v = 40 + 7 * k;
    if (std::find(c.problem.fixed.begin(), c.problem.fixed.end(), v) != c.problem.fixed.end())
      continue;
    c.problem.point_constraints.push_back(
        {"g" + std::to_string(k),
         VertexCombination{{{v, 1.0}}},
         k % 3 ? PointConstraint::Kind::OnPlane : PointConstraint::Kind::OnLine,
         {random(), random(), random() + 2}});
  }
  for (auto& h : c.problem.handles) std::erase_if(h.vertices, [](int v) { return v < 0; });
  c.edit.handles[0] = {};
  FormFeatureDeformer deformer(c.mesh, c.problem);
  const Points p = deformer.deform(c.edit);
  CHECK(deformer.hard_residual() < 1e-13);
  const auto s = deformer.problem_matrices(c.edit);
  const SparseMatrix A = s.A;
  const SparseMatrix normal = SparseMatrix(A.transpose()) * A;
  const SparseMatrix lower = normal.triangularView<Eigen::Lower>();
  const Points x = solve_constrained(s.constraints, lower, Points(A.transpose() * s.b));
  Points moved = p;
  for (size_t k = 0; k < s.vertices.size(); ++k)
    moved.row(s.vertices[k]) = x.row(static_cast<long>(k)) + s.origin.transpose();
  CHECK(relative(moved, p) < 1e-10);
}

TEST_CASE("rotations wind as far as they are asked to", "[mesh][deform]") {
  // On a flat strip of squares the harmonic field is linear from end to end.
  const TriangleMesh mesh = sheet(12, 0, 0);
  DeformProblem problem;
  problem.fixed = where(mesh, [](const Vec3& p) { return p.x() < 0.01; });
  problem.handles = {{"end", where(mesh, [](const Vec3& p) { return p.x() > 3.99; })}};
  FormFeatureDeformer deformer(mesh, problem);
  DeformEdit edit;
  edit.handles = {{}};
  edit.handles[0].rotation_vector = to_rotation_vector({1, 0, 0}, 3 * std::numbers::pi);
  edit.handles[0].about = {4, 2, 0};
  deformer.deform(edit);
  const Points q = deformer.rotation_logs();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double angle = 3 * std::numbers::pi * mesh.point(v).x() / 4;
    CHECK((q.row(v).transpose() - Vec3(angle, 0, 0)).norm() < 1e-12);
  }
}

TEST_CASE("a region of interest: nothing outside moves, the shape joins smoothly",
          "[mesh][deform]") {
  double last = 0;
  for (const int n : {40, 80}) {
    const TriangleMesh mesh = sheet(n, 0.4, 0.1);
    DeformProblem problem;
    problem.region = disc(mesh, 2, 2, 1.2);
    problem.handles = {{"h", disc(mesh, 2, 2, 0.2)}};
    FormFeatureDeformer deformer(mesh, problem);
    DeformEdit edit;
    edit.handles = {{}};
    edit.handles[0].translation = {0, 0, 0.3};
    const Points p = deformer.deform(edit);
    CHECK(deformer.counts().moving < static_cast<int>(problem.region->size()));
    std::vector<char> inside(mesh.vertex_count(), 0);
    for (const int v : *problem.region) inside[v] = 1;
    double largest = 0, first_ring = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const double moved = (p.row(v) - mesh.points().row(v)).norm();
      if (!inside[v]) {
        CHECK(moved == 0);
        continue;
      }
      largest = std::max(largest, moved);
      for (const int u : mesh.topology().neighbours(v))
        if (!inside[u]) first_ring = std::max(first_ring, moved);
    }
    CHECK(largest == Approx(0.3));
    // A crease at the edge would decrease linearly with the element size, a smooth edge
    // quadratically.
    if (last > 0) CHECK(last / first_ring > 3);
    last = first_ring;
  }
}

TEST_CASE("with area weights the shape does not depend on the mesh", "[mesh][deform]") {
  // Heights of the middle line under refinement: differences decrease. Uniform weights give another
  // shape on a mesh that is fine on one side.
  const auto height = [](int n, DeformProblem::Weighting weighting, bool graded) {
    TriangleMesh mesh = sheet(n, 0, 0);
    if (graded) {
      Points points = mesh.points();
      points.col(0) = 4 * (points.col(0).array() / 4).square();
      mesh = mesh.with_points(points);
    }
    DeformProblem problem;
    problem.weighting = weighting;
    problem.fixed = where(mesh, [](const Vec3& p) {
      return p.x() < 1e-9 || p.y() < 1e-9 || p.x() > 4 - 1e-9 || p.y() > 4 - 1e-9;
    });
    problem.rows = {{"lift", {{{0, 1.0}}}, {0, 0, 1}, -1, {}}};
    const int middle = nearest_to(mesh, {1, 2, 0});
    problem.rows[0].combination.entries[0].vertex = middle;
    problem.rows[0].target = mesh.point(middle) + Vec3(0, 0, 1);
    FormFeatureDeformer deformer(mesh, problem);
    const Points p = deformer.deform({});
    return p(nearest_to(mesh, {2.25, 2, 0}), 2);
  };
  using enum DeformProblem::Weighting;
  const double even = height(48, Area, false), graded = height(48, Area, true);
  const double uniform = height(48, Uniform, true);
  CHECK(std::abs(graded - even) < 0.02 * even);
  CHECK(std::abs(uniform - even) > 0.1 * even);
}

TEST_CASE("soft constraints: from nothing to hard as the weight grows, and rotating ones",
          "[mesh][deform]") {
  Case c(12, false);
  const int v = nearest_to(c.mesh, {2, 2.0, 0});
  const Vec3 target = c.mesh.point(v) + Vec3(0, 0.2, 1.5);
  const auto at = [&](std::optional<double> weight) {
    DeformProblem problem = c.problem;
    problem.features.clear();
    problem.rows = {{"pull", {{{v, 1.0}}}, target, -1, weight}};
    FormFeatureDeformer deformer(c.mesh, problem);
    DeformEdit edit = c.edit;
    edit.feature_scales.clear();
    deformer.deform(edit);
    return deformer.positions();
  };
  const Points hard = at({});
  CHECK((hard.row(v).transpose() - target).norm() < 1e-13);
  double last = 1e9;
  for (const double weight : {1e-2, 1.0, 1e2, 1e4}) {
    const double off = relative(at(weight), hard);
    CHECK(off < last);
    last = off;
  }
  const double far = relative(at(1e6), hard), farther = relative(at(1e7), hard);
  CHECK(far / farther == Approx(10).epsilon(0.05));  // 1/weight

  // A difference of two vertices that rotates with the field.
  DeformProblem problem = c.problem;
  problem.features.clear();
  const int w = c.mesh.topology().neighbours(v)[0];
  problem.rows = {{"stick", {{{w, 1.0}, {v, -1.0}}}, c.mesh.point(w) - c.mesh.point(v), v, {}}};
  FormFeatureDeformer deformer(c.mesh, problem);
  c.edit.feature_scales.clear();
  const Points p = deformer.deform(c.edit);
  const Vec3 q = deformer.rotation_logs().row(v).transpose();
  CHECK((p.row(w) - p.row(v) - rotated(q, problem.rows[0].target).transpose()).norm() < 1e-13);
  CHECK(q.norm() > 0.01);
}

TEST_CASE("a feature line keeps its shape better the wider its strip is", "[mesh][deform]") {
  Case c(24, false);
  c.problem.features.clear();
  c.edit.feature_scales.clear();
  std::vector<int> line;
  for (int i = 3; i <= 21; ++i) line.push_back(12 * 25 + i);
  const auto curvature = [&](const Points& p, size_t k) {
    const auto at = [&](size_t i) { return Vec3(c.mesh.point(line[i])); };
    const double l0 = (at(k) - at(k - 1)).norm(), l1 = (at(k + 1) - at(k)).norm();
    return Vec3(
        ((p.row(line[k + 1]) - p.row(line[k])) / l1 - (p.row(line[k]) - p.row(line[k - 1])) / l0) /
        ((l0 + l1) / 2));
  };
  const auto warp = [&](double width) {
    DeformProblem problem = c.problem;
    if (width > 0) problem.chains = {{"line", line, false, width}};
    FormFeatureDeformer deformer(c.mesh, problem);
    const Points p = deformer.deform(c.edit);
    const Points q = deformer.rotation_logs();
    double sum = 0;
    for (size_t k = 1; k + 1 < line.size(); ++k)
      sum += (curvature(p, k) - rotated(q.row(line[k]).transpose(), curvature(c.mesh.points(), k)))
                 .squaredNorm();
    return std::sqrt(sum);
  };
  double last = warp(0);
  CHECK(last > 0.1);
  for (const double width : {0.1, 1.0, 10.0, 100.0, 1000.0}) {
    const double now = warp(width);
    CHECK(now < last);
    last = now;
  }
  CHECK(last < 0.01 * warp(0));
}

TEST_CASE("unconstrained parts stay, and are reported", "[mesh][deform]") {
  // The sheet, a disconnected triangle, and a vertex without triangles.
  const TriangleMesh one = sheet(8);
  Points points(one.vertex_count() + 4, 3);
  points << one.points(), Points::Random(4, 3).array() + 10;
  auto triangles = one.triangles();
  const int n = one.vertex_count();
  triangles.push_back({n, n + 1, n + 2});
  const TriangleMesh mesh(points, triangles);
  DeformProblem problem;
  problem.fixed = where(one, [](const Vec3& p) { return p.x() < 0.1; });
  problem.handles = {{"h", where(one, [](const Vec3& p) { return p.x() > 3.9; })}};
  DeformEdit edit;
  edit.handles = {some_move()};
  {
    FormFeatureDeformer deformer(mesh, problem);
    REQUIRE(deformer.notes().size() == 1);
    const Points p = deformer.deform(edit);
    CHECK(p.bottomRows(4) == points.bottomRows(4));
  }
  // As members of one feature with a vertex of the sheet they move with it.
  problem.features = {{"together", {40, n, n + 1, n + 2, n + 3}}};
  FormFeatureDeformer deformer(mesh, problem);
  CHECK(deformer.notes().empty());
  const Points p = deformer.deform(edit);
  CHECK(fit_similarity(points, p, problem.features[0].vertices, 1).max_error < 1e-13);
  CHECK((p.row(n) - points.row(n)).norm() > 0.1);
}

TEST_CASE("the same bits on one thread and on two, and no allocation while dragging",
          "[mesh][deform]") {
  Case c(80, true);
  Points first;
  {
    const ThreadGuard one(1);
    FormFeatureDeformer deformer(c.mesh, c.problem);
    first = deformer.deform(c.edit);
  }
  const ThreadGuard two(2);
  FormFeatureDeformer deformer(c.mesh, c.problem);
  CHECK(deformer.deform(c.edit) == first);
  if (!counts_allocations()) return;
  const ScopedOpCount work;
  for (int event = 0; event < 5; ++event) {
    c.edit.handles[0].translation.z() += 0.01;
    deformer.deform(c.edit);
  }
  CHECK(work.of(OpCounter::Allocation) == 0);
}

TEST_CASE("random problems: a result within the constraints, or a named error", "[mesh][deform]") {
  const TriangleMesh mesh = sheet(12);
  const int n = mesh.vertex_count();
  Random random(11);
  const auto pick = [&](int count) {
    return std::min(count - 1, static_cast<int>((random() + 1) / 2 * count));
  };
  const auto patch = [&] {
    std::vector<int> vertices;
    const int kind = pick(30);
    if (kind == 0) return vertices;  // empty
    if (kind == 1)
      for (int v = 0; v < n; ++v) vertices.push_back(v);  // everything
    if (kind == 2) vertices = {pick(n)};
    if (kind == 3) vertices = {pick(n), pick(n), pick(n), n + pick(2) * pick(3)};  // out of range?
    if (kind > 3)
      vertices = disc(mesh, 2 + 2 * random(), 2 + 2 * random(), 0.2 + 0.5 * (random() + 1));
    return vertices;
  };
  const auto direction = [&] { return Vec3(random(), random(), pick(20) ? random() + 2 : 0); };
  int answers = 0, conflicts = 0, refused = 0, unsolved = 0;
  for (int trial = 0; trial < 600; ++trial) {
    DeformProblem problem;
    DeformEdit edit;
    if (pick(4)) problem.fixed = patch();
    for (int h = pick(3); h >= 0; --h) {
      problem.handles.push_back({"h" + std::to_string(h), patch()});
      HandleTransform move;
      if (pick(3)) move.translation = Vec3(random(), random(), random());
      if (pick(2)) move.rotation_vector = to_rotation_vector({random(), random(), 1}, 4 * random());
      if (!pick(4)) move.scale = 1 + 0.5 * random();
      edit.handles.push_back(move);
    }
    for (int f = pick(4); f > 0; --f) {
      problem.features.push_back(
          {"f" + std::to_string(f), patch(),
           pick(3) ? FormFeature::Kind::Free : FormFeature::Kind::TranslationOnly});
      if (!problem.features.back().vertices.empty() && pick(3) == 0)
        problem.point_constraints.push_back(
            {"g" + std::to_string(f), VertexCombination::mean_of(problem.features.back().vertices),
             pick(2) ? PointConstraint::Kind::OnPlane : PointConstraint::Kind::OnLine,
             direction()});
      edit.feature_scales.push_back(pick(3) ? 1.0 : 1 + 0.4 * random());
    }
    if (pick(4) == 0) problem.rows.push_back({"r", {{{pick(n), 1.0}}}, Vec3(1, 1, 1), -1, {}});
    if (pick(4) == 0) problem.rows.push_back({"s", {{{pick(n), 1.0}}}, Vec3(1, 1, 1), -1, 3.0});
    if (pick(5) == 0) problem.region = patch();
    INFO("trial " << trial);
    try {
      FormFeatureDeformer deformer(mesh, problem);
      deformer.deform(edit);
      deformer.correct();
      REQUIRE(deformer.positions().allFinite());
      CHECK(deformer.hard_residual() < 1e-11);
      ++answers;
    } catch (const ConflictError& e) {
      REQUIRE(!e.conflicts().empty());
      for (const auto& conflict : e.conflicts()) CHECK(!conflict.names.empty());
      ++conflicts;
    } catch (const InputError&) {
      ++refused;
    } catch (const NoSolutionError& e) {
      WARN("trial " << trial << ": " << e.what());
      ++unsolved;
    }
  }
  CAPTURE(answers, conflicts, refused, unsolved);
  CHECK(answers > 100);
  CHECK(conflicts > 50);
  CHECK(refused > 50);
  CHECK(unsolved == 0);
}
