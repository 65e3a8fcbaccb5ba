// SPDX-License-Identifier: MPL-2.0
// Iterative deformers: properties of mesh/regions.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/op_counter.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/differential_operators.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/region_meshes.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

using Faces = std::vector<std::vector<int>>;

/// The squares of sheet(n).
Faces quads_of_sheet(int n) {
  Faces quads;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      quads.push_back({a, a + 1, a + n + 2, a + n + 1});
    }
  return quads;
}

struct ClampedSheet {
  TriangleMesh mesh;
  std::vector<int> left, right;
  explicit ClampedSheet(int n)
      : mesh(sheet(n)),
        left(vertices_where(mesh, [&](const Vec3& p) { return p.x() < 4.5 / n; })),
        right(vertices_where(mesh, [&](const Vec3& p) { return p.x() > 4 - 4.5 / n; })) {}
};

/// Every deformer of the module on one mesh.
std::vector<std::unique_ptr<IterativeDeformer>> all_kinds(const TriangleMesh& mesh,
                                                          const Faces& quads,
                                                          const std::vector<int>& fixed,
                                                          const std::vector<Handle>& handles) {
  DualLaplacianOptions middles, fitted;
  middles.border = DualLaplacianOptions::Border::EdgeMidpoints;
  fitted.lengths = DualLaplacianOptions::Lengths::Fitted;
  ArapOptions plain;
  plain.smoothing = 0;
  std::vector<std::unique_ptr<IterativeDeformer>> all;
  all.push_back(std::make_unique<DualLaplacianDeformer>(mesh, Faces{}, fixed, handles));
  all.push_back(std::make_unique<DualLaplacianDeformer>(mesh, Faces{}, fixed, handles, middles));
  all.push_back(std::make_unique<DualLaplacianDeformer>(mesh, Faces{}, fixed, handles, fitted));
  if (!quads.empty())
    all.push_back(std::make_unique<DualLaplacianDeformer>(mesh, quads, fixed, handles));
  all.push_back(std::make_unique<ArapDeformer>(mesh, fixed, handles));
  all.push_back(std::make_unique<ArapDeformer>(mesh, fixed, handles, plain));
  return all;
}

HandleTransform other_move() {
  HandleTransform move;
  move.about = {4, 2, 0};
  move.rotation_vector = to_rotation_vector({0.3, 1, 0.2}, 0.6);
  move.translation = {-0.2, 0.1, 0.9};
  return move;
}

}  // namespace

TEST_CASE("estimates: a rigid motion of all handles moves the mesh rigidly", "[mesh][estimates]") {
  const ClampedSheet c(12);
  for (const double angle : {0.4, 2.5, 3 * std::numbers::pi})
    for (const auto& deformer :
         all_kinds(c.mesh, quads_of_sheet(12), {}, {{"left", c.left}, {"right", c.right}})) {
      HandleTransform move;
      move.about = {1, 2, 3};
      move.rotation_vector = to_rotation_vector({1, 2, -0.5}, angle);
      move.translation = {-3, 1, 2};
      Points moved(c.mesh.vertex_count(), 3);
      for (int v = 0; v < c.mesh.vertex_count(); ++v) moved.row(v) = move(c.mesh.point(v));
      CHECK(relative(deformer->deform(std::vector{move, move}), moved) < 1e-11);
      CHECK(deformer->report().converged);
      CHECK(deformer->report().iterations <= 2);
      CHECK(deformer->report().energies.back() < 1e-20);
    }
}

TEST_CASE("fitted lengths follow a scale, original ones resist it", "[mesh][estimates]") {
  const ClampedSheet c(12);
  HandleTransform move;
  move.about = {1, 2, 3};
  move.rotation_vector = to_rotation_vector({1, 2, -0.5}, 0.5);
  move.scale = 1.3;
  Points moved(c.mesh.vertex_count(), 3);
  for (int v = 0; v < c.mesh.vertex_count(); ++v) moved.row(v) = move(c.mesh.point(v));
  for (const auto lengths :
       {DualLaplacianOptions::Lengths::Fitted, DualLaplacianOptions::Lengths::Original}) {
    DualLaplacianOptions options;
    options.lengths = lengths;
    options.tolerance = 1e-12;
    DualLaplacianDeformer deformer(c.mesh, {}, {}, {{"left", c.left}, {"right", c.right}}, options);
    const double off = relative(deformer.deform(std::vector{move, move}), moved);
    if (lengths == DualLaplacianOptions::Lengths::Fitted) {
      CHECK(off < 1e-9);
      CHECK(deformer.face_rotations()[0].determinant() == Approx(1.3 * 1.3 * 1.3));
    } else {
      CHECK(off > 1e-3);
      CHECK(deformer.face_rotations()[0].determinant() == Approx(1));
    }
  }
}

TEST_CASE("estimates: the energy decreases in every iteration and is reported correctly",
          "[mesh][estimates]") {
  const ClampedSheet c(16);
  for (const auto& deformer : all_kinds(c.mesh, quads_of_sheet(16), c.left, {{"right", c.right}})) {
    const Points before = deformer->positions();
    CHECK(before == c.mesh.points());
    deformer->deform(std::vector{other_move()});
    const IterationReport report = deformer->report();
    CHECK(report.iterations > 3);
    REQUIRE(report.energies.size() == static_cast<size_t>(report.iterations));
    CHECK(report.energies.back() > 0);
    CHECK(report.energies.back() < 0.99 * report.energies.front());
    for (size_t k = 1; k < report.energies.size(); ++k)
      CHECK(report.energies[k] <= report.energies[k - 1] + 1e-12 * report.energies[0]);
    CHECK(report.converged == (report.last_change < 1e-6));
    // Fixed vertices are exact to the last bit.
    for (const int v : c.left) CHECK(deformer->positions().row(v) == c.mesh.points().row(v));
    for (const int v : c.right)
      CHECK(deformer->positions().row(v).transpose() == other_move()(c.mesh.point(v)));
  }
  ArapOptions few;
  few.max_iterations = 3;
  ArapDeformer deformer(c.mesh, c.left, {{"right", c.right}}, few);
  deformer.deform(std::vector{other_move()});
  CHECK(deformer.report().iterations == 3);
  CHECK_FALSE(deformer.report().converged);
  CHECK(deformer.report().last_change > 1e-6);
}

TEST_CASE("estimates: the energy falls for any moves", "[mesh][estimates]") {
  const ClampedSheet c(8);
  Random random(21);
  for (const auto& deformer :
       all_kinds(c.mesh, quads_of_sheet(8), c.left, {{"right", c.right}, {"one", {40}}})) {
    for (int edit = 0; edit < 12; ++edit) {
      std::vector<HandleTransform> moves(2);
      for (HandleTransform& move : moves) {
        move.about = {2, 2, 0};
        move.rotation_vector = 2 * random.point();
        move.translation = 3 * random.point();
      }
      deformer->deform(moves);
      const std::vector<double>& E = deformer->report().energies;
      for (size_t k = 1; k < E.size(); ++k) CHECK(E[k] <= E[k - 1] + 1e-12 * E[0]);
    }
  }
}

TEST_CASE("estimates: one factor for all rounds and edits, and rounds allocate nothing",
          "[mesh][estimates]") {
  const ClampedSheet c(20);
  const auto make = [&](int kind) -> std::unique_ptr<IterativeDeformer> {
    if (kind == 0)
      return std::make_unique<DualLaplacianDeformer>(c.mesh, Faces{}, c.left,
                                                     std::vector<Handle>{{"right", c.right}});
    return std::make_unique<ArapDeformer>(c.mesh, c.left, std::vector<Handle>{{"right", c.right}});
  };
  for (const int kind : {0, 1}) {
    const ScopedOpCount making;
    const auto deformer = make(kind);
    CHECK(making.of(OpCounter::Factorization) == 1);
    CHECK(making.of(OpCounter::Analysis) == 1);
    std::vector<HandleTransform> moves = {other_move()};
    deformer->deform(moves);
    const ScopedOpCount work;
    std::int64_t iterations = 0;
    for (int edit = 0; edit < 3; ++edit) {
      moves[0].translation.z() += 0.1;
      deformer->deform(moves);
      iterations += deformer->report().iterations;
    }
    const std::int64_t allocations = work.of(OpCounter::Allocation);
    CHECK(work.of(OpCounter::Factorization) == 0);
    CHECK(work.of(OpCounter::Solve) >=
          iterations);  // an accelerated iteration that increased the energy is repeated
    CHECK(work.of(OpCounter::Solve) <= iterations + iterations / 4);
    if (counts_allocations()) CHECK(allocations == 0);
  }
}

TEST_CASE("the nonlinear energy is that of spokes and rims with cotangents", "[mesh][estimates]") {
  const ClampedSheet c(10);
  ArapOptions options;
  options.smoothing = 0.003;
  options.max_iterations = 5;
  ArapDeformer deformer(c.mesh, c.left, {{"right", c.right}}, options);
  const Points p = deformer.deform(std::vector{other_move()});
  const auto& R = deformer.vertex_rotations();
  const Eigen::Matrix3Xd half = half_cotangents(c.mesh);
  double energy = 0, area = 0;
  for (int t = 0; t < c.mesh.triangle_count(); ++t) {
    const auto& v = c.mesh.triangles()[t];
    area += c.mesh.area_vector(t).norm() / 2;
    for (int k = 0; k < 3; ++k) {
      const int a = v[(k + 1) % 3], b = v[(k + 2) % 3];
      for (const int owner : v)
        energy +=
            half(k, t) / 3 *
            ((p.row(b) - p.row(a)).transpose() - R[owner] * (c.mesh.point(b) - c.mesh.point(a)))
                .squaredNorm();
    }
  }
  const auto w = edge_cotangents(c.mesh);
  for (size_t e = 0; e < w.size(); ++e) {
    const auto& edge = c.mesh.topology().edges()[e];
    energy +=
        options.smoothing * area * std::max(0.0, w[e]) * (R[edge.low] - R[edge.high]).squaredNorm();
  }
  CHECK(deformer.report().energies.back() == Approx(energy / 2).epsilon(1e-10));
}

TEST_CASE(
    "the dual energy is that of its documentation, and Laplacian vectors keep their direction",
    "[mesh][estimates]") {
  const ClampedSheet c(8);
  DualLaplacianOptions options;
  options.border = DualLaplacianOptions::Border::EdgeMidpoints;
  options.poisson_ratio = 1;
  DualLaplacianDeformer deformer(c.mesh, {}, c.left, {{"right", c.right}}, options);
  const Points p = deformer.deform(std::vector{other_move()});
  const MeshTopology& topology = c.mesh.topology();
  const auto centre = [&](const Points& x, int t) {
    const auto& v = topology.triangles()[t];
    return Vec3((x.row(v[0]) + x.row(v[1]) + x.row(v[2])).transpose() / 3);
  };
  double energy = 0, membrane = 0, bent_membrane = 0, all_area = 0, bent = 0;
  for (int t = 0; t < c.mesh.triangle_count(); ++t) {
    const auto& v = topology.triangles()[t];
    const Mat3& R = deformer.face_rotations()[t];
    Mat3 to, after;  // neighbours relative to the face, before and after
    for (int k = 0; k < 3; ++k) {
      const int other = topology.across(t, k), a = v[(k + 1) % 3], b = v[(k + 2) % 3];
      const auto at = [&](const Points& x) {
        return other >= 0 ? centre(x, other) : Vec3((x.row(a) + x.row(b)).transpose() / 2);
      };
      to.col(k) = at(c.mesh.points()) - centre(c.mesh.points(), t);
      after.col(k) = at(p) - centre(p, t);
    }
    // Barycentric weights of the projection of the face onto the plane of its neighbours.
    const Vec3 n = (to.col(1) - to.col(0)).cross(to.col(2) - to.col(0)).normalized();
    const double height = n.dot(to.col(0));
    Eigen::Matrix4d conditions;  // Σ w to = height n + 0, Σ w = 1
    conditions.setZero();
    conditions.topLeftCorner<3, 3>() = to;
    conditions.topRightCorner<3, 1>() = -n;
    conditions.row(3).head<3>().setOnes();
    const Eigen::Vector4d solved = solve_dense(conditions, Eigen::Vector4d::Unit(3));
    const Vec3 weights = solved.head<3>(), l = to * weights;
    CHECK((l - height * n).norm() < 1e-12);
    const double scale = to.colwise().squaredNorm().mean() / 4, curvature = l.norm() / scale;
    const double area = c.mesh.area_vector(t).norm() / 2;
    energy += area * ((after * weights - R * l) / scale).squaredNorm();
    double edges = 0, squares = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = c.mesh.point(v[(k + 1) % 3]) - c.mesh.point(v[k]);
      edges += ((p.row(v[(k + 1) % 3]) - p.row(v[k])).transpose() - R * e).squaredNorm();
      squares += e.squaredNorm();
    }
    membrane += area * edges / squares;
    bent_membrane += curvature * curvature * area * edges / squares;
    all_area += area;
    bent += area * curvature;
  }
  const double mean = bent / all_area, size = c.mesh.size();
  energy += (options.membrane / (size * size) + mean * mean) * membrane + bent_membrane;
  CHECK(deformer.report().energies.back() == Approx(energy / 2).epsilon(1e-9));
}

TEST_CASE("a single row of vertices that is rotated bends a plate to a cylinder",
          "[mesh][estimates]") {
  // 400 × 200, thickness 0, bent to the radius 500 by its last row of vertices, or its last three.
  const int nx = 40, ny = 20;
  std::vector<Vec3> places;
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) places.emplace_back(10. * i, 10. * j, 0);
  Faces quads;
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = j * (nx + 1) + i;
      quads.push_back({a, a + 1, a + nx + 2, a + nx + 1});
      triangles.push_back({a, a + 1, a + nx + 2});
      triangles.push_back({a, a + nx + 2, a + nx + 1});
    }
  Points points(isize(places), 3);
  for (int v = 0; v < isize(places); ++v) points.row(v) = places[v].transpose();
  const TriangleMesh mesh(points, triangles);
  const double radius = 500, angle = 400 / radius;
  HandleTransform bend;
  bend.about = {400, 0, 0};
  bend.rotation_vector = {0, -angle, 0};
  bend.translation = {radius * std::sin(angle) - 400, 0, radius * (1 - std::cos(angle))};
  for (const double rows : {1, 3}) {
    const double width = 10 * (rows - 1) / 2 + 1;
    const auto fixed = vertices_where(mesh, [&](const Vec3& p) { return p.x() < width; });
    const std::vector<Handle> handles = {
        {"end", vertices_where(mesh, [&](const Vec3& p) { return p.x() > 400 - width; })}};
    std::vector<std::unique_ptr<IterativeDeformer>> deformers;
    deformers.push_back(std::make_unique<DualLaplacianDeformer>(mesh, quads, fixed, handles));
    deformers.push_back(std::make_unique<DualLaplacianDeformer>(mesh, Faces{}, fixed, handles));
    deformers.push_back(std::make_unique<ArapDeformer>(mesh, fixed, handles));
    for (const auto& deformer : deformers) {
      const Points p = deformer->deform(std::vector{bend});
      double deviation = 0;
      for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.point(v).x() > width && mesh.point(v).x() < 400 - width)
          deviation = std::max(deviation, std::abs(std::hypot(p(v, 0), p(v, 2) - radius) - radius));
      CHECK(deviation < 1);
    }
  }
}

TEST_CASE("a patch lifted without a turn gives a slope whose faces have turned",
          "[mesh][estimates]") {
  const BossPanel panel(40);
  const auto lift = panel.lift(1.2);
  DualLaplacianDeformer dual(panel.mesh, {}, panel.fixed, panel.handles);
  ArapDeformer nonlinear(panel.mesh, panel.fixed, panel.handles);
  for (IterativeDeformer* deformer : std::initializer_list<IterativeDeformer*>{&dual, &nonlinear}) {
    const Points p = deformer->deform(lift);
    const double boss = tilt_degrees(p, panel.boss), ring = tilt_degrees(p, panel.ring);
    CHECK(ring > 20);
    CHECK(std::abs(boss - ring) < 1.5);
  }
}

TEST_CASE("squares: primal rows keep vertices from moving to and fro", "[mesh][estimates]") {
  const int n = 20;
  const TriangleMesh mesh = sheet(n, 0.4, 0);
  const auto fixed = vertices_where(mesh, [](const Vec3& p) { return p.x() < 0.3; });
  const std::vector<Handle> handles = {
      {"right", vertices_where(mesh, [](const Vec3& p) { return p.x() > 3.7; })}};
  // Checkerboard amplitude: part of the pattern + - + - in the displacements of the vertices,
  // relative to the edge length; largest value.
  const auto to_and_fro = [&](double poisson_ratio) {
    DualLaplacianOptions options;
    options.poisson_ratio = poisson_ratio;
    DualLaplacianDeformer deformer(mesh, quads_of_sheet(n), fixed, handles, options);
    HandleTransform move;
    move.translation = {0, 0, 0.8};
    const Points d = deformer.deform(std::vector{move}) - mesh.points();
    double most = 0;
    for (int j = 2; j < n - 1; ++j)
      for (int i = 2; i < n - 1; ++i) {
        Vec3 sum = Vec3::Zero();
        for (int b = -1; b <= 1; ++b)
          for (int a = -1; a <= 1; ++a)
            sum += (a ? 1 : 2) * (b ? 1 : 2) * ((a + b) % 2 ? -1 : 1) *
                   d.row((j + b) * (n + 1) + i + a).transpose() / 16;
        most = std::max(most, sum.norm() / (4.0 / n));
      }
    return most;
  };
  const double kept = to_and_fro(DualLaplacianOptions().poisson_ratio);
  CHECK(kept < 0.005);
  CHECK(to_and_fro(1) > 5 * kept);
}

TEST_CASE("a bar twisted by half a turn keeps its section and its edges", "[mesh][estimates]") {
  const double length = 10;
  const Bar bar(length, 6);
  const auto twist = Bar::twist(180);
  ArapDeformer nonlinear(bar.mesh, bar.fixed, bar.handles);
  const Points p = nonlinear.deform(twist);
  CHECK(nonlinear.report().converged);
  DeformProblem problem;
  problem.fixed = bar.fixed;
  problem.handles = bar.handles;
  FormFeatureDeformer linear(bar.mesh, problem);
  DeformEdit edit;
  edit.handles = twist;
  const Points q = linear.deform(edit);

  const auto section = [&](const Points& x) {
    double before = 0, after = 0;
    for (int v = 0; v < bar.mesh.vertex_count(); ++v)
      if (std::abs(bar.mesh.point(v).x() - length / 2) < 1e-9) {
        before += bar.mesh.point(v).tail<2>().squaredNorm();
        after += x.row(v).tail<2>().squaredNorm();
      }
    return std::sqrt(after / before);
  };
  const auto volume = [&](const Points& x) {
    double sum = 0;
    for (const auto& t : bar.mesh.triangles())
      sum += Vec3(x.row(t[0])).dot(Vec3(x.row(t[1])).cross(Vec3(x.row(t[2])))) / 6;
    return sum;
  };
  const std::vector<char> all(bar.mesh.vertex_count(), 1);
  CHECK(section(p) > 0.97);
  CHECK(section(q) < section(p));
  CHECK(volume(p) > volume(q));
  CHECK(edge_change(bar.mesh, p, all).mean < edge_change(bar.mesh, q, all).mean);
  CHECK(edge_change(bar.mesh, p, all).most < edge_change(bar.mesh, q, all).most);
}

TEST_CASE("estimates: same bits on one thread and on several, and again after another edit",
          "[mesh][estimates]") {
  const ClampedSheet c(40);
  for (const int kind : {0, 1}) {
    const auto answer = [&] {
      std::unique_ptr<IterativeDeformer> deformer;
      const std::vector<Handle> handles = {{"right", c.right}};
      if (kind == 0)
        deformer = std::make_unique<DualLaplacianDeformer>(c.mesh, Faces{}, c.left, handles);
      else
        deformer = std::make_unique<ArapDeformer>(c.mesh, c.left, handles);
      const Points first = deformer->deform(std::vector{other_move()});
      deformer->deform(std::vector{HandleTransform{}});
      CHECK(relative(deformer->positions(), c.mesh.points()) < 1e-10);
      CHECK(deformer->deform(std::vector{other_move()}) == first);
      return first;
    };
    const Points many = answer();
    const ThreadGuard one(1);
    CHECK(answer() == many);
  }
}

TEST_CASE("estimates: from a guess to the same shape", "[mesh][estimates]") {
  const ClampedSheet c(14);
  HandleTransform move;
  move.translation = {0, 0, 0.8};
  for (const auto& deformer : all_kinds(c.mesh, {}, c.left, {{"right", c.right}})) {
    const Points p = deformer->deform(std::vector{move});
    const double energy = deformer->report().energies.back();
    const int iterations = deformer->report().iterations;
    CHECK(deformer->report().converged);
    const Points again = deformer->deform(std::vector{move}, p);
    CHECK(deformer->report().iterations <= iterations);
    CHECK(deformer->report().energies.back() <= energy * (1 + 1e-6));
    CHECK(relative(again, p) < 2e-5);
    CHECK(error_message([&] {
            deformer->deform(std::vector{move}, p.topRows(3));
          }).find("has 3 points, expected 225") != std::string::npos);
  }
}

TEST_CASE("estimates: a part of the mesh that nothing holds stays", "[mesh][estimates]") {
  const TriangleMesh square = flat_square(4, 0, 1);
  const TriangleMesh mesh = disjoint_union(square, square);
  const auto handle = vertices_where(square, [](const Vec3& p) { return p.x() > 0.9; });
  for (const auto& deformer : all_kinds(mesh, {}, {0}, {{"h", handle}})) {
    HandleTransform move;
    move.translation = {0, 0, 0.5};
    const Points p = deformer->deform(std::vector{move});
    CHECK(p.bottomRows(25) == mesh.points().bottomRows(25));
    CHECK(p.topRows(25) != mesh.points().topRows(25));
  }
}

TEST_CASE("estimates: bad input is refused with what was found", "[mesh][estimates]") {
  const ClampedSheet c(4);
  const std::vector<Handle> handles = {{"right", c.right}};
  const auto dual = [&](Faces faces) {
    return error_message([&] { DualLaplacianDeformer(c.mesh, std::move(faces), c.left, handles); });
  };
  CHECK(dual({{0, 1}}) == "face 0 has 2 corners, expected three or more");
  CHECK(dual({{0, 1, 6}, {0, 1, 99}}) == "face 1 uses vertex 99, expected 0 to 24");
  CHECK(dual({{0, 1, 1}}) == "face 0 has vertex 1 twice, expected distinct corners");
  CHECK(dual({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}) ==
        "the edge between vertices 0 and 1 has more than two faces, expected at most two");
  CHECK(error_message([&] { ArapDeformer(c.mesh, {}, {}); }) ==
        "found no fixed nodes and no handles, expected one of them");
  CHECK(error_message([&] { ArapDeformer(c.mesh, {77}, handles); }) ==
        "the fixed region: found vertex 77, expected 0 to 24");
  ArapOptions negative;
  negative.smoothing = -1;
  CHECK(error_message([&] {
          ArapDeformer(c.mesh, c.left, handles, negative);
        }).find("smoothing = -1") != std::string::npos);
  DualLaplacianOptions none;
  none.membrane = 0;
  CHECK(error_message([&] {
          DualLaplacianDeformer(c.mesh, {}, c.left, handles, none);
        }).find("membrane = 0") != std::string::npos);
  Points flat = c.mesh.points();
  flat.row(c.mesh.triangles()[3][0]) = flat.row(c.mesh.triangles()[3][1]);
  CHECK(error_message([&] {
          ArapDeformer(c.mesh.with_points(flat), c.left, handles);
        }).find("has no area") != std::string::npos);
  ArapDeformer deformer(c.mesh, c.left, handles);
  CHECK(error_message([&] { deformer.deform({}); }) ==
        "the edit has 0 transformations of handles, expected 1");
  HandleTransform move;
  move.translation.x() = std::nan("");
  CHECK(error_message([&] { deformer.deform(std::vector{move}); }).find("not finite") !=
        std::string::npos);
  // A vertex fixed twice: no conflict as long as both agree.
  ArapDeformer twice(c.mesh, c.left, {{"right", c.right}, {"both", {c.left[0], c.right[0]}}});
  twice.deform(std::vector<HandleTransform>(2));
  CHECK_THROWS_AS(twice.deform(std::vector{other_move(), HandleTransform{}}), ConflictError);
}
