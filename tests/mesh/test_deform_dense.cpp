// SPDX-License-Identifier: MPL-2.0
// The deformer against a dense reference implementation: every type of constraint, alone and
// combined.
#include <algorithm>
#include <numbers>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/differential_operators.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/kkt_deformation.h"
#include "batten/tests/support/sample_meshes.h"
#include "batten/tests/support/sampling.h"

using namespace batten;
using namespace batten_test;

namespace {

std::vector<int> box(int n, int i0, int i1, int j0, int j1) {
  std::vector<int> vertices;
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) vertices.push_back(j * (n + 1) + i);
  return vertices;
}

/// Constrained least squares by the null space method, all unknowns at once.
VecX least_squares(const MatX& A, const VecX& b, const MatX& C, const VecX& d, double* conflict) {
  const VecX particular = batten::least_squares(C, d);
  *conflict = (C * particular - d).norm();
  const MatX free = null_space(C);
  if (free.cols() == 0) return particular;
  const MatX reduced = A * free;
  const VecX rest = b - A * particular;
  return particular + free * batten::least_squares(reduced, rest);
}

struct Rows {
  std::vector<VecX> left;
  std::vector<Vec3> right;
  void add(int n, const std::vector<std::pair<int, double>>& entries, const Vec3& value) {
    VecX row = VecX::Zero(n);
    for (const auto& [v, c] : entries) row[v] += c;
    left.push_back(row);
    right.push_back(value);
  }
};

/// The same problem from its equations. `conflict`: residual of contradictory constraints.
Points dense(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
             Points* logs, double* conflict) {
  const int n = mesh.vertex_count();
  const auto p = [&](int v) { return mesh.point(v); };
  std::vector<int> handle(n, -1), feature(n, -1);
  std::vector<char> held(n, problem.region ? 1 : 0);
  if (problem.region)
    for (const int v : *problem.region) held[v] = 0;
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices) {
      handle[v] = static_cast<int>(h);
      held[v] = 0;
    }
  for (const int v : problem.fixed) held[v] = 1;
  const auto scale_of = [&](size_t f) {
    return edit.feature_scales.empty() ? 1 : edit.feature_scales[f];
  };
  for (size_t f = 0; f < problem.features.size(); ++f)
    for (const int v : problem.features[f].vertices) feature[v] = static_cast<int>(f);

  const SparseMatrix lower = cotangent_laplacian(mesh);
  const MatX L = lower.selfadjointView<Eigen::Lower>() * MatX::Identity(n, n);
  const VecX area = mixed_areas(mesh);

  // Rotations: min qᵀ L q is min |G q|² with G = L^½.
  Rows turning;
  for (int v = 0; v < n; ++v) {
    if (held[v]) turning.add(n, {{v, 1}}, Vec3::Zero());
  }
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices)
      turning.add(n, {{v, 1}}, edit.handles[h].rotation_vector);
  for (const auto& f : problem.features)
    for (const int v : f.vertices)
      if (f.kind == FormFeature::Kind::TranslationOnly)
        turning.add(n, {{v, 1}}, Vec3::Zero());
      else
        turning.add(n, {{v, 1}, {f.vertices[0], -1}}, Vec3::Zero());
  if (turning.left.empty()) turning.add(n, {{0, 1}}, Vec3::Zero());
  const SymmetricEigen eigen = symmetric_eigen(L);
  const MatX root = eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose();
  MatX G(static_cast<long>(turning.left.size()), n), values(G.rows(), 3);
  for (long r = 0; r < G.rows(); ++r) {
    G.row(r) = turning.left[r].transpose();
    values.row(r) = turning.right[r].transpose();
  }
  logs->resize(n, 3);
  double rotations_conflict = 0;
  for (int c = 0; c < 3; ++c) {
    double miss = 0;
    logs->col(c) = least_squares(root, VecX::Zero(n), G, values.col(c), &miss);
    rotations_conflict = std::max(rotations_conflict, miss);
  }
  const auto turned = [&](int v, const Vec3& x) {
    const Vec3 q = logs->row(v).transpose();
    const double angle = q.norm();
    return angle > 0 ? Vec3(Eigen::AngleAxisd(angle, q.normalized()) * x) : x;
  };

  Rows soft, hard;
  const bool by_area = problem.weighting == DeformProblem::Weighting::Area;
  const auto size_at = [&](int v) {
    return feature[v] >= 0              ? scale_of(feature[v])
           : handle[v] >= 0 && !held[v] ? edit.handles[handle[v]].scale
                                        : 1.0;
  };
  for (int v = 0; v < n; ++v) {
    const double w = (by_area ? std::sqrt(area[v]) : 1) / (2 * area[v]);
    std::vector<std::pair<int, double>> entries;
    for (int u = 0; u < n; ++u)
      if (L(v, u) != 0) entries.emplace_back(u, w * L(v, u));
    const Vec3 delta = w * (L.row(v) * mesh.points()).transpose();
    soft.add(n, entries, size_at(v) * turned(v, delta));
  }
  for (const auto& chain : problem.chains) {
    const size_t count = chain.vertices.size();
    for (size_t k = 0; k < count; ++k) {
      if (!chain.closed && (k == 0 || k + 1 == count)) continue;
      const int a = chain.vertices[(k + count - 1) % count], b = chain.vertices[k],
                c = chain.vertices[(k + 1) % count];
      const double l0 = (p(b) - p(a)).norm(), l1 = (p(c) - p(b)).norm(), mean = (l0 + l1) / 2;
      // √(a width) κ by area; as many entries as the equations of a strip of that width otherwise.
      const double w =
          (by_area ? std::sqrt(mean * chain.width) : std::sqrt(chain.width / mean)) / mean;
      const Vec3 kappa = (p(c) - p(b)) / l1 - (p(b) - p(a)) / l0;
      soft.add(n, {{a, w / l0}, {b, -w / l0 - w / l1}, {c, w / l1}},
               size_at(b) * turned(b, w * kappa));
    }
  }
  for (size_t r = 0; r < problem.rows.size(); ++r) {
    const LinearConstraint& row = problem.rows[r];
    Vec3 target = edit.targets.empty() ? row.target : edit.targets[r];
    if (row.rotates_with >= 0) target = turned(row.rotates_with, target);
    std::vector<std::pair<int, double>> entries;
    const double w = row.weight ? std::sqrt(*row.weight) : 1;
    for (const auto& e : row.combination.entries) entries.emplace_back(e.vertex, w * e.coefficient);
    (row.weight ? soft : hard).add(n, entries, w * target);
  }
  for (int v = 0; v < n; ++v) {
    if (held[v]) hard.add(n, {{v, 1}}, p(v));
  }
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices) hard.add(n, {{v, 1}}, edit.handles[h](p(v)));
  for (size_t f = 0; f < problem.features.size(); ++f)
    for (const int v : problem.features[f].vertices) {
      const int first = problem.features[f].vertices[0];
      if (v != first)
        hard.add(n, {{v, 1}, {first, -1}}, scale_of(f) * turned(first, p(v) - p(first)));
    }

  // x, y and z stacked, for plane and line constraints.
  const auto m = static_cast<long>(hard.left.size());
  std::vector<std::pair<VecX, double>> constraint_origins;
  for (size_t k = 0; k < problem.point_constraints.size(); ++k) {
    const PointConstraint& g = problem.point_constraints[k];
    const Vec3 through =
        edit.constraint_origins.empty() ? g.point.at(mesh.points()) : edit.constraint_origins[k];
    const Vec3 d = g.direction.normalized(), l = d.unitOrthogonal();
    std::vector<Vec3> normals = {d};
    if (g.kind == PointConstraint::Kind::OnLine) normals = {l, d.cross(l)};
    for (const Vec3& normal : normals) {
      VecX row = VecX::Zero(3 * n);
      for (const auto& e : g.point.entries)
        for (int c = 0; c < 3; ++c) row[c * n + e.vertex] += e.coefficient * normal[c];
      constraint_origins.emplace_back(row, normal.dot(through));
    }
  }
  MatX A = MatX::Zero(3 * static_cast<long>(soft.left.size()), 3 * n);
  VecX b(A.rows());
  for (size_t r = 0; r < soft.left.size(); ++r)
    for (int c = 0; c < 3; ++c) {
      A.row(3 * static_cast<long>(r) + c).segment(c * n, n) = soft.left[r].transpose();
      b[3 * static_cast<long>(r) + c] = soft.right[r][c];
    }
  MatX C = MatX::Zero(3 * m + static_cast<long>(constraint_origins.size()), 3 * n);
  VecX d(C.rows());
  for (long r = 0; r < m; ++r)
    for (int c = 0; c < 3; ++c) {
      C.row(3 * r + c).segment(c * n, n) = hard.left[r].transpose();
      d[3 * r + c] = hard.right[r][c];
    }
  for (size_t k = 0; k < constraint_origins.size(); ++k) {
    C.row(3 * m + static_cast<long>(k)) = constraint_origins[k].first.transpose();
    d[3 * m + static_cast<long>(k)] = constraint_origins[k].second;
  }
  const VecX x = least_squares(A, b, C, d, conflict);
  *conflict = std::max(*conflict, rotations_conflict);
  return Eigen::Map<const Points>(x.data(), n, 3);
}

/// Results equal the dense ones, and conflicts are detected.
bool agrees(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit) {
  Points logs;
  double conflict = 0;
  const Points expected = dense(mesh, problem, edit, &logs, &conflict);
  try {
    FormFeatureDeformer deformer(mesh, problem);
    deformer.deform(edit);
    deformer.correct();
    deformer.correct();
    CHECK(conflict < 1e-8);
    CHECK((deformer.rotation_logs() - logs).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((deformer.positions() - expected).cwiseAbs().maxCoeff() < 1e-8 * mesh.size());
    CHECK(deformer.hard_residual() < 1e-12);
    CHECK((deform_by_kkt(deformer, edit) - expected).cwiseAbs().maxCoeff() < 1e-7 * mesh.size());
    return true;
  } catch (const ConflictError& e) {
    CHECK(conflict > 1e-9);
    CHECK(!e.conflicts().empty());
    return false;
  }
}

HandleTransform move_of(Random& random) {
  HandleTransform move;
  move.about = {4, 2, 0};
  move.translation = Vec3(random(), random(), random());
  move.rotation_vector = to_rotation_vector({random(), random() + 1, random()}, random());
  move.scale = 1 + 0.3 * random();
  return move;
}

}  // namespace

TEST_CASE("each kind of row against the dense problem, both weightings", "[mesh][deform]") {
  const int n = 7;
  const TriangleMesh mesh = sheet(n);
  Random random(3);
  using Kind = FormFeature::Kind;
  for (const auto weighting : {DeformProblem::Weighting::Area, DeformProblem::Weighting::Uniform}) {
    DeformProblem base;
    base.weighting = weighting;
    base.fixed = box(n, 0, 0, 0, n);
    base.handles = {{"h", box(n, n, n, 0, n)}};
    DeformEdit edit;
    edit.handles = {move_of(random)};
    const auto check_with = [&](const std::string& what, const auto& change) {
      INFO(what);
      DeformProblem problem = base;
      DeformEdit e = edit;
      change(problem, e);
      CHECK(agrees(mesh, problem, e));
    };
    check_with("two features side by side that share nothing", [&](auto& p, auto& e) {
      p.features = {{"a", box(n, 2, 3, 2, 4), Kind::Free}, {"b", box(n, 4, 5, 2, 4), Kind::Free}};
      e.feature_scales = {1.2, 0.9};
    });
    check_with("a feature that keeps its direction beside a handle", [&](auto& p, auto&) {
      p.features = {{"a", box(n, 4, 5, 1, 3), Kind::TranslationOnly}};
    });
    check_with("a chain, open, across a scaled feature", [&](auto& p, auto& e) {
      p.features = {{"a", box(n, 3, 4, 3, 4), Kind::Free}};
      e.feature_scales = {1.3};
      p.chains = {{"c", box(n, 1, 6, 3, 3), false, 0.7}};
    });
    check_with("a chain, closed", [&](auto& p, auto&) {
      p.chains = {{"c", {18, 19, 20, 28, 36, 35, 34, 26}, true, 2}};
    });
    check_with("soft rows, one of them turning", [&](auto& p, auto&) {
      p.rows = {{"s", {{{27, 0.5}, {28, 0.5}}}, mesh.point(27) + Vec3(0, 0, 1), -1, 3.0},
                {"t", {{{19, 1.0}, {20, -1.0}}}, {0.3, 0.2, 0.5}, 37, 8.0}};
    });
    check_with("hard rows, one of them turning", [&](auto& p, auto&) {
      p.rows = {{"s", {{{27, 0.5}, {28, 2.5}}}, {2, 1, 4}, -1, {}},
                {"t", {{{19, 1.0}, {20, -1.0}}}, {0.3, 0.2, 0.5}, 37, {}}};
    });
    check_with("guides that are neither parallel nor orthogonal, one of them implied",
               [&](auto& p, auto& e) {
                 const VertexCombination point{{{27, 0.3}, {36, 0.7}}};
                 using Guide = PointConstraint::Kind;
                 p.point_constraints = {
                     {"a", point, Guide::OnPlane, {1, 0, 1}},
                     {"b", point, Guide::OnPlane, {1, 1, 0}},
                     {"c", point, Guide::OnPlane, {2, 1, 1}},
                     {"d", VertexCombination{{{44, 1.0}}}, Guide::OnLine, {0.2, 1, 0}}};
                 const Vec3 at = point.at(mesh.points()) + Vec3(0.1, 0.2, 0.3);
                 e.constraint_origins = {at, at, at, mesh.point(44)};
               });
    check_with("a region, its handle inside, nothing else fixed", [&](auto& p, auto&) {
      p.fixed.clear();
      p.region = box(n, 1, 6, 1, 6);
      p.handles = {{"h", box(n, 3, 4, 3, 4)}};
    });
    check_with("a handle outside of the region moves",
               [&](auto& p, auto&) { p.region = box(n, 1, 5, 1, 6); });
    check_with("held by a hard row alone: nothing turns", [&](auto& p, auto& e) {
      p.fixed = {};
      p.handles = {{"h", {0}}};
      p.rows = {{"r", {{{63, 1.0}}}, mesh.point(63) + Vec3(0, 0, 1), -1, {}}};
      e.handles[0] = {};
    });
  }
}

TEST_CASE("random problems against the dense one: the result, or a true conflict",
          "[mesh][deform]") {
  const int n = 6;
  const TriangleMesh mesh = sheet(n);
  Random random(17);
  const auto pick = [&](int count) {
    return std::min(count - 1, static_cast<int>((random() + 1) / 2 * count));
  };
  const auto patch = [&] {
    const int i = pick(n), j = pick(n);
    return box(n, i, std::min(n, i + pick(3)), j, std::min(n, j + pick(3)));
  };
  int answers = 0, conflicts = 0;
  for (int trial = 0; trial < 150; ++trial) {
    INFO("trial " << trial);
    DeformProblem problem;
    DeformEdit edit;
    if (pick(2)) problem.weighting = DeformProblem::Weighting::Uniform;
    problem.fixed = box(n, 0, 0, 0, n);
    for (int h = 0; h <= pick(2); ++h) {
      problem.handles.push_back({"h" + std::to_string(h), h ? patch() : box(n, n, n, 0, n)});
      edit.handles.push_back(move_of(random));
      if (pick(2)) edit.handles.back().scale = 1;
    }
    for (int f = pick(4); f > 0; --f) {
      problem.features.push_back(
          {"f" + std::to_string(f), patch(),
           pick(3) ? FormFeature::Kind::Free : FormFeature::Kind::TranslationOnly});
      edit.feature_scales.push_back(pick(2) ? 1 : 1 + 0.3 * random());
      if (pick(3) == 0)
        problem.point_constraints.push_back(
            {"g" + std::to_string(f),
             VertexCombination::mean_of(problem.features.back().vertices),
             pick(2) ? PointConstraint::Kind::OnPlane : PointConstraint::Kind::OnLine,
             {random(), random(), random() + 1.5}});
    }
    if (pick(3) == 0) problem.chains = {{"c", box(n, 1, 5, pick(n), pick(n)), false, 1}};
    if (!problem.chains.empty() && problem.chains[0].vertices.size() < 3) problem.chains.clear();
    if (pick(3) == 0) problem.rows.push_back({"s", {{{pick(49), 1}}}, {1, 2, 1}, pick(49), 2.0});
    if (pick(4) == 0) problem.rows.push_back({"r", {{{pick(49), 1}}}, {1, 2, 1}, -1, {}});
    if (pick(5) == 0) problem.region = box(n, 0, 5, 1, 6);
    ++(agrees(mesh, problem, edit) ? answers : conflicts);
  }
  CHECK(answers > 40);
  CHECK(conflicts > 20);
}

TEST_CASE("fixed vertices stay, whatever other constraints they have", "[mesh][deform]") {
  const int n = 6;
  const TriangleMesh mesh = sheet(n);
  DeformProblem problem;
  problem.fixed = box(n, 0, 0, 0, n);
  problem.handles = {{"h", box(n, n, n, 0, n)}};
  problem.handles[0].vertices.push_back(problem.fixed[2]);
  FormFeatureDeformer deformer(mesh, problem);
  DeformEdit edit;
  edit.handles = {{}};
  deformer.deform(edit);  // satisfies both
  edit.handles[0].translation = {0, 0, 1};
  try {
    deformer.deform(edit);
    FAIL("the handle cannot take a fixed vertex along");
  } catch (const ConflictError& e) {
    CHECK(e.conflicts()[0].names == std::vector<std::string>{"fixed", "h"});
    CHECK(e.conflicts()[0].amount == Approx(1));
  }
  edit.handles[0] = {};
  edit.handles[0].rotation_vector = to_rotation_vector({0, 0, 1}, std::numbers::pi / 6);
  edit.handles[0].about = mesh.point(problem.fixed[2]);
  try {
    deformer.deform(edit);
    FAIL("nor turn it");
  } catch (const ConflictError& e) {
    CHECK(e.conflicts()[0].amount == Approx(30));  // degrees
    CHECK(std::string(e.what()).find("30 degrees of rotation") != std::string::npos);
  }
}

TEST_CASE("a failed edit leaves positions, rotations and their check as they were",
          "[mesh][deform]") {
  const int n = 6;
  const TriangleMesh mesh = sheet(n);
  DeformProblem problem;
  problem.fixed = box(n, 0, 0, 0, n);
  problem.handles = {{"h", box(n, n, n, 0, n)}, {"k", box(n, n, n, 2, 3)}};
  problem.rows = {{"stick", {{{24, 1.0}, {17, -1.0}}}, {0.5, 0, 0.1}, 24, {}}};
  FormFeatureDeformer deformer(mesh, problem);
  DeformEdit edit;
  edit.handles.resize(2);
  for (auto& m : edit.handles) m.rotation_vector = {0.1, 0.2, 0};
  const Points before = deformer.deform(edit);
  const Points logs = deformer.rotation_logs();
  CHECK(deformer.hard_residual() < 1e-13);
  DeformEdit bad = edit;
  for (auto& m : bad.handles) m.rotation_vector = {0.4, 0, 0};
  bad.handles[0].translation = {0, 0, 1};
  CHECK_THROWS_AS(deformer.deform(bad), ConflictError);
  CHECK(deformer.positions() == before);
  CHECK(deformer.rotation_logs() == logs);
  CHECK(deformer.hard_residual() < 1e-13);
  CHECK_THROWS_AS(deformer.correct(), InputError);
  CHECK(deformer.deform(edit) == before);
}

TEST_CASE("parts that features join are one part, in whatever order", "[mesh][deform]") {
  // Three sheets at distances of 100; the first is fixed.
  const int n = 4, m = (n + 1) * (n + 1);
  const TriangleMesh one = sheet(n);
  Points points(3 * m + 1, 3);
  std::vector<std::array<int, 3>> triangles;
  for (int k = 0; k < 3; ++k) {
    points.middleRows(k * m, m) = one.points().rowwise() + Eigen::RowVector3d(0, 100.0 * k, 0);
    for (auto t : one.triangles()) {
      for (int& v : t) v += k * m;
      triangles.push_back(t);
    }
  }
  points.row(3 * m) << 7, 7, 7;  // not part of a triangle
  const TriangleMesh mesh(points, triangles);
  DeformProblem problem;
  problem.fixed = box(n, 0, 0, 0, n);
  problem.handles = {{"h", box(n, n, n, 0, n)}};
  DeformEdit edit;
  edit.handles = {{}};
  edit.handles[0].rotation_vector = to_rotation_vector({0, 0, 1}, 0.8);
  const std::vector<FormFeature> features = {{"BC", {m + 3, m + 4, 2 * m + 1}},
                                             {"A and the loose one", {12, 13, 3 * m}},
                                             {"B and the loose one", {m + 7, 3 * m}}};
  Points first;
  for (const auto& order : {std::array{0, 1, 2}, {2, 1, 0}, {1, 0, 2}}) {
    problem.features.clear();
    for (const int f : order) problem.features.push_back(features[f]);
    FormFeatureDeformer deformer(mesh, problem);
    CHECK(deformer.notes().empty());
    const Points p = deformer.deform(edit);
    CHECK(deformer.hard_residual() < 1e-12);
    const Points q = deformer.rotation_logs();
    for (int v = m; v < mesh.vertex_count(); ++v) CHECK((q.row(v) - q.row(12)).norm() < 1e-12);
    CHECK(q.row(12).norm() > 0.05);
    if (first.size() == 0) first = p;
    CHECK((p - first).cwiseAbs().maxCoeff() < 1e-9);
  }
  // A feature from the rotating handle to another part: that part rotates with it, without a
  // conflict.
  problem.features = {{"BC", {m + 3, 2 * m + 1}}, {"handle and B", {4, 9, m + 7}}};
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  CHECK((deformer.rotation_logs().row(2 * m) - edit.handles[0].rotation_vector.transpose()).norm() <
        1e-12);
  // A difference within a part does not fix it.
  problem.features.clear();
  problem.rows = {{"stick", {{{m, 1.0}, {m + 1, -1.0}}}, {-1, 0, 0}, -1, {}}};
  CHECK_THROWS_AS(FormFeatureDeformer(mesh, problem).deform(edit), ConflictError);
}

TEST_CASE("guided points that are nearly dependent, or only rounding is left of them",
          "[mesh][deform]") {
  const int n = 6;
  const TriangleMesh mesh = sheet(n);
  DeformProblem problem;
  problem.fixed = box(n, 0, 0, 0, n);
  problem.handles = {{"h", box(n, n, n, 0, n)}};
  using Guide = PointConstraint::Kind;
  const VertexCombination point{{{24, 1.0}}};
  problem.point_constraints = {
      {"other", VertexCombination{{{30, 1.0}}}, Guide::OnPlane, Vec3::UnitZ()},
      {"a", point, Guide::OnPlane, Vec3::UnitZ()},
      {"b", point, Guide::OnPlane, Vec3(2e-5, 0, 1)}};
  DeformEdit edit;
  edit.handles = {{}};
  edit.constraint_origins = {mesh.point(30), mesh.point(24), mesh.point(24) + Vec3(0.01, 0, 0)};
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  CHECK(deformer.hard_residual() < 1e-13);
  CHECK((deformer.positions()(24, 0) - mesh.point(24).x()) == Approx(0.01).epsilon(1e-6));

  // The combination .1 + .2 - .3 of a feature's vertices is rounding only: the point is that of the
  // fixed vertex.
  problem.features = {{"f", {23, 24, 25}}};
  problem.point_constraints = {
      {"noise", {{{23, 0.1}, {24, 0.2}, {25, -0.3}, {0, 1.0}}}, Guide::OnPlane, Vec3::UnitZ()}};
  edit.constraint_origins.clear();
  FormFeatureDeformer calm(mesh, problem);
  calm.deform(edit);
  CHECK(calm.hard_residual() < 1e-13);
}

TEST_CASE("far from the origin, tiny and huge: the same shape", "[mesh][deform]") {
  const int n = 6;
  const auto deformed = [&](double size, const Vec3& far) {
    const TriangleMesh mesh =
        sheet(n).with_points(Points(size * (sheet(n).points().rowwise() + far.transpose())));
    DeformProblem problem;
    problem.fixed = box(n, 0, 0, 0, n);
    problem.handles = {{"h", box(n, n, n, 0, n)}};
    problem.features = {{"f", box(n, 2, 3, 2, 3)}};
    problem.point_constraints = {{"g",
                                  VertexCombination::mean_of(problem.features[0].vertices),
                                  PointConstraint::Kind::OnLine,
                                  {1, 1, 1}}};
    DeformEdit edit;
    edit.handles = {{}};
    edit.handles[0].rotation_vector = {0.1, 0.4, 0};
    edit.handles[0].translation = size * Vec3(0.1, 0, 1);
    edit.handles[0].about = size * (Vec3(4, 2, 0) + far);
    FormFeatureDeformer deformer(mesh, problem);
    return Points((deformer.deform(edit) / size).rowwise() - far.transpose());
  };
  const Points near = deformed(1, Vec3::Zero());
  for (const double size : {1e-6, 1e6})
    CHECK((deformed(size, Vec3::Zero()) - near).cwiseAbs().maxCoeff() < 1e-11);
  CHECK((deformed(1, {1e6, -2e6, 3e6}) - near).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("edits and problems that cannot be are refused by name", "[mesh][deform]") {
  const int n = 4;
  const TriangleMesh mesh = sheet(n);
  DeformProblem good;
  good.fixed = box(n, 0, 0, 0, n);
  good.handles = {{"h", box(n, n, n, 0, n)}};
  good.features = {{"f", {12, 13}}};
  good.point_constraints = {
      {"g", VertexCombination::mean_of({12}), PointConstraint::Kind::OnPlane, {0, 0, 1}}};
  good.rows = {{"r", {{{7, 1}}}, {1, 1, 1}, -1, 1.0}};
  const auto why = [&](const auto& change) {
    DeformProblem problem = good;
    change(problem);
    return error_message([&] { FormFeatureDeformer(mesh, problem); });
  };
  const auto has = [](const std::string& text, const std::string& part) {
    CAPTURE(part);
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
  };
  CHECK(why([](auto&) {}).empty());
  CHECK(why([](auto& p) { p.features[0].name = "h"; }).empty());
  CHECK(why([](auto& p) {
          p.fixed.clear();
          p.handles.clear();
          p.region = std::vector<int>{7, 12};
        }).empty());
  has(why([](auto& p) { p.handles.push_back(p.handles[0]); }), "two handles named 'h'");
  has(why([](auto& p) { p.handles[0].name.clear(); }), "without a name");
  has(why([](auto& p) { p.handles[0].vertices.clear(); }), "handle 'h' has no vertices");
  has(why([](auto& p) { p.features[0].vertices = {99}; }), "found vertex 99, expected 0 to 24");
  has(why([](auto& p) { p.point_constraints[0].point.entries[0].coefficient = 2; }), "sum to 2");
  has(why([](auto& p) { p.point_constraints[0].direction.setZero(); }),
      "direction of point constraint 'g' has length 0");
  has(why([](auto& p) { p.chains = {{"c", {1, 2, 1}, true, 1}}; }), "chain 'c'");
  has(why([](auto& p) { p.chains = {{"c", {1, 2}, false, 1}}; }), "at least three");
  has(why([](auto& p) { p.chains = {{"c", {1, 2, 3}, false, 0}}; }), "width");
  has(why([](auto& p) { p.rows[0].weight = -1; }), "weight -1");
  has(why([](auto& p) { p.rows[0].target[1] = NAN; }), "not finite");
  has(why([](auto& p) {
        p.fixed.clear();
        p.handles.clear();
        p.rows.clear();
      }),
      "no fixed nodes and no handles");
  // Position constraints determine a problem, too.
  CHECK(why([](auto& p) {
          p.fixed.clear();
          p.handles.clear();
        }).empty());

  FormFeatureDeformer deformer(mesh, good);
  const auto refused = [&](const auto& change) {
    DeformEdit edit;
    edit.handles = {{}};
    edit.feature_scales = {1};
    edit.constraint_origins = {Vec3::Zero()};
    edit.targets = {Vec3::Zero()};
    change(edit);
    return error_message([&] { deformer.deform(edit); });
  };
  has(refused([](auto& e) { e.handles.clear(); }), "0 transformations of handles, expected 1");
  has(refused([](auto& e) { e.handles[0].rotation_vector[0] = NAN; }), "handle 'h'");
  has(refused([](auto& e) { e.handles[0].rotation_vector[0] = 1e200; }), "handle 'h'");
  has(refused([](auto& e) { e.handles[0].scale = 0; }), "scale that is not above 0");
  has(refused([](auto& e) { e.handles[0].scale = -1; }), "scale that is not above 0");
  has(refused([](auto& e) { e.handles[0].scale = 1e300; }), "handle 'h'");
  has(refused([](auto& e) { e.feature_scales[0] = -1; }), "feature 'f'");
  has(refused([](auto& e) { e.feature_scales = {1, 2}; }), "2 scales");
  has(refused([](auto& e) { e.constraint_origins[0][2] = INFINITY; }),
      "origin of point constraint 'g'");
  has(refused([](auto& e) { e.targets[0][2] = NAN; }), "target of linear constraint 'r'");
}

TEST_CASE("the check of hard rows sees every kind of violation", "[mesh][deform]") {
  const int n = 5;
  const TriangleMesh mesh = sheet(n);
  DeformProblem problem;
  problem.fixed = {0};
  problem.handles = {{"h", {35}}};
  problem.features = {{"f", {14, 15, 20}}, {"d", {8, 9}, FormFeature::Kind::TranslationOnly}};
  problem.point_constraints = {{"p", {{{21, 1.0}}}, PointConstraint::Kind::OnPlane, {0, 0, 1}},
                               {"l", {{{22, 1.0}}}, PointConstraint::Kind::OnLine, {0, 0, 1}}};
  problem.rows = {{"r", {{{27, 1.0}}}, mesh.point(27), -1, {}},
                  {"soft", {{{28, 1.0}}}, mesh.point(28), -1, 5.0}};
  DeformEdit edit;
  edit.handles = {{}};
  const Points logs = Points::Zero(mesh.vertex_count(), 3);
  CHECK(hard_residual(mesh, problem, edit, mesh.points(), logs) < 1e-15);
  const auto moved = [&](int v, const Vec3& by) {
    Points p = mesh.points();
    p.row(v) += by.transpose();
    return hard_residual(mesh, problem, edit, p, logs) * mesh.size();
  };
  for (const int v : {0, 35, 27}) CHECK(moved(v, {0, 0, 0.1}) == Approx(0.1));
  CHECK(moved(14, {0, 0, 0.1}) > 0.01);
  CHECK(moved(21, {0, 0, 0.1}) == Approx(0.1));
  CHECK(moved(21, {0.1, 0.1, 0}) < 1e-15);
  CHECK(moved(22, {0.3, 0.4, 0}) == Approx(0.5));
  CHECK(moved(22, {0, 0, 0.1}) < 1e-15);
  CHECK(moved(28, {0, 0, 0.1}) < 1e-15);
  Points p = mesh.points();  // "d" rotated: its shape is the same
  const Vec3 between = mesh.point(9) - mesh.point(8);
  p.row(9) = p.row(8) + (Eigen::AngleAxisd(0.1, Vec3::UnitZ()) * between).transpose();
  CHECK(hard_residual(mesh, problem, edit, p, logs) > 1e-3);
  p(0, 1) = NAN;
  CHECK(std::isnan(hard_residual(mesh, problem, edit, p, logs)));
  problem.region = std::vector<int>{8};
  CHECK(moved(17, {0, 0, 0.1}) == Approx(0.1));  // outside the region
}
