// Form features in mesh deformation: the laws of mesh/deform.
#include <Eigen/Dense>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"
#include "batten/core/rotations.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/deform/similarity.h"
#include "batten/mesh/operators.h"
#include "batten/tests/catch.h"
#include "batten/tests/sampling.h"
#include "batten/tests/threads.h"

using namespace batten;
using namespace batten_test;

namespace {

/// n×n squares of a curved sheet over [0, 4]², diagonals turning about, vertices moved about.
TriangleMesh sheet(int n, double height = 0.4, double jitter = 0.15) {
  Random random(7);
  Points points((n + 1) * (n + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  const double h = 4.0 / n;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = h * (i + (i > 0 && i < n ? jitter * random() : 0));
      const double y = h * (j + (j > 0 && j < n ? jitter * random() : 0));
      points.row(j * (n + 1) + i) << x, y, height * std::sin(x) * std::cos(0.7 * y);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if ((i + j) % 2) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      } else {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      }
    }
  return TriangleMesh(points, triangles);
}

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

HandleMove some_move() {
  HandleMove move;
  move.about = {4, 2, 0};
  move.turn = rotation_log({0.3, 1, 0.2}, 0.6);
  move.shift = {0.2, 0.1, 0.9};
  return move;
}

/// Left border fixed, right border a handle, three features (one keeps its direction, one is
/// scaled), a guided one on a plane and one on a line.
struct Case {
  TriangleMesh mesh;
  DeformProblem problem;
  DeformEdit edit;
  explicit Case(int n, bool guided) : mesh(sheet(n)) {
    problem.fixed = where(mesh, [&](const Vec3& p) { return p.x() < 4.5 / n; });
    problem.handles = {{"right", where(mesh, [&](const Vec3& p) { return p.x() > 4 - 4.5 / n; })}};
    problem.features = {{"a", disc(mesh, 1.2, 1.2, 0.45), FormFeature::Kind::Free},
                        {"b", disc(mesh, 2.6, 1.1, 0.4), FormFeature::Kind::KeepsDirection},
                        {"c", disc(mesh, 2.0, 2.8, 0.5), FormFeature::Kind::Free}};
    if (guided)
      problem.guided = {{"plane",
                         VertexCombination::mean_of(problem.features[0].vertices),
                         GuidedPoint::Kind::OnPlane,
                         {0.1, 0.2, 1}},
                        {"line",
                         VertexCombination::mean_of(problem.features[2].vertices),
                         GuidedPoint::Kind::OnLine,
                         {1, 0.2, 0.1}}};
    edit.handles = {some_move()};
    edit.feature_scales = {1, 1, 1.3};
  }
};

double relative(const Points& a, const Points& b) {
  return (a - b).cwiseAbs().maxCoeff() / (b.colwise().maxCoeff() - b.colwise().minCoeff()).norm();
}

}  // namespace

TEST_CASE("without features the deformer solves the dense least-squares problem") {
  const TriangleMesh mesh = sheet(9);
  for (const auto weighting : {DeformProblem::Weighting::Area, DeformProblem::Weighting::Uniform}) {
    DeformProblem problem;
    problem.fixed = where(mesh, [](const Vec3& p) { return p.x() < 0.1; });
    problem.handles = {{"h", disc(mesh, 3, 2, 0.6)}, {"k", disc(mesh, 1.5, 3.5, 0.5)}};
    problem.weighting = weighting;
    DeformEdit edit;
    edit.handles = {some_move(), {}};
    edit.handles[1].shift = {0, 0, -0.5};
    edit.handles[1].scale = 1.2;
    FormFeatureDeformer deformer(mesh, problem);
    const Points p = deformer.deform(edit);
    deformer.correct();

    // From the formulas, dense: L_c and A_i, the harmonic field, the least squares problem.
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
        q_held.row(v) = edit.handles[h].turn;
        scale[v] = edit.handles[h].scale;
        x.row(v) = edit.handles[h](mesh.point(v));
      }
    std::vector<int> moving;
    for (int v = 0; v < n; ++v)
      if (std::find(held.begin(), held.end(), v) == held.end()) moving.push_back(v);
    MatX q = q_held;
    const MatX L_free = L(moving, moving), pull = -L * q_held;
    const MatX q_free = L_free.ldlt().solve(MatX(pull(moving, Eigen::all)));
    q(moving, Eigen::all) = q_free;
    MatX A(n, n), b(n, 3);
    for (int i = 0; i < n; ++i) {
      const double w = weighting == DeformProblem::Weighting::Area ? std::sqrt(area[i]) : 1;
      A.row(i) = w / (2 * area[i]) * L.row(i);
      const Vec3 delta = (L.row(i) * mesh.points()).transpose() / (2 * area[i]);
      const double angle = 2 * q.row(i).norm();
      const Vec3 axis = angle > 0 ? Vec3(q.row(i).transpose().normalized()) : Vec3(Vec3::UnitX());
      b.row(i) = w * scale[i] * (Eigen::AngleAxisd(angle, axis) * delta).transpose();
    }
    MatX known = MatX::Zero(n, 3);
    known(held, Eigen::all) = x(held, Eigen::all);
    const MatX columns = A(Eigen::all, moving), target = b - A * known;
    const MatX free = columns.colPivHouseholderQr().solve(target);
    x(moving, Eigen::all) = free;
    CHECK(relative(p, x) < 1e-10);
    CHECK(relative(deformer.positions(), x) < 1e-12);
    CHECK(deformer.hard_residual() < 1e-14);
    // Rows of held vertices and of features with all their ring are constants: they may be left
    // out, the answer is the same.
    CHECK(deformer.counts().moving == static_cast<int>(moving.size()));
  }
}

TEST_CASE("reduction, saddle point and dense elimination of all rows agree") {
  for (const bool guided : {false, true}) {
    Case c(16, guided);
    FormFeatureDeformer deformer(c.mesh, c.problem);
    const Points p = deformer.deform(c.edit);
    CHECK(deformer.hard_residual() < 1e-13);
    CHECK(relative(deform_by_kkt(deformer, c.edit), p) < 1e-9);
    const auto s = deformer.statement(c.edit);
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

TEST_CASE("features are their originals up to one similarity") {
  for (const bool guided : {false, true}) {
    Case c(24, guided);
    FormFeatureDeformer deformer(c.mesh, c.problem);
    for (int event = 0; event < 5; ++event) {
      c.edit.handles[0].shift.z() += 0.3;
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
      if (guided) {
        const auto off = [&](int k) {
          const auto& g = c.problem.guided[k];
          return Vec3(g.point.at(deformer.positions()) - g.point.at(c.mesh.points()));
        };
        CHECK(std::abs(off(0).dot(c.problem.guided[0].direction.normalized())) < 1e-13);
        CHECK(off(1).cross(c.problem.guided[1].direction.normalized()).norm() < 1e-13);
        CHECK(off(1).norm() > 1e-3);
      }
    }
  }
}

TEST_CASE("a rigid motion of everything held moves the mesh rigidly") {
  for (const double angle : {0.4, 2.5, 3 * std::numbers::pi}) {
    Case c(20, false);
    c.problem.handles.push_back({"left", c.problem.fixed});
    c.problem.fixed.clear();
    c.problem.features[1].kind = FormFeature::Kind::Free;
    c.edit.handles.assign(2, {});
    c.edit.feature_scales.clear();
    for (auto& move : c.edit.handles) {
      move.about = {1, 2, 3};
      move.turn = rotation_log({1, 2, -0.5}, angle);
      move.shift = {-3, 1, 2};
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
