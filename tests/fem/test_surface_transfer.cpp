// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/refinement.h"

#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;

namespace {

std::vector<char> random_marks(const ParametricMesh& mesh, unsigned seed) {
  Random random(seed);
  std::vector<char> marks(mesh.triangle_count());
  for (char& m : marks) m = random() > 0.4;
  return marks;
}

SurfaceJet wave(const Vec2& p) {
  const double u = p.x(), v = p.y(), s = std::sin(3 * u), c = std::cos(3 * u);
  return {{u, v + 0.1 * s, s * v}, {1, 0.3 * c, 3 * c * v}, {0, 1, s}, {}, {}, {}};
}

Surface random_surface(std::shared_ptr<const ParametricMesh> mesh, TriangleElement kind) {
  Random random(12);
  Points q(DofMap(*mesh).count(), 3);
  for (long i = 0; i < q.rows(); ++i) q.row(i) = random.point();
  return Surface(std::move(mesh), kind, q);
}

}  // namespace

TEST_CASE("along old edges a carried surface keeps its shape and its slope across",
          "[fem][transfer]") {
  for (const auto kind : kBothElements) {
    const auto coarse = std::make_shared<ParametricMesh>(perturbed_square(5, 3));
    const Surface from = random_surface(coarse, kind);
    const auto fine =
        std::make_shared<ParametricMesh>(bisected(*coarse, random_marks(*coarse, 4)).mesh);
    REQUIRE(fine->triangle_count() > coarse->triangle_count());
    const Surface to(fine, kind, interpolate_onto(from, *fine).dofs);
    double worst = 0;
    for (const auto& edge : coarse->edges())
      for (const double s : {0.1, 0.25, 0.37, 0.5, 0.81}) {
        const Vec2 p = (1 - s) * coarse->vertices()[edge.low] + s * coarse->vertices()[edge.high];
        const SurfaceJet a = from.jet(from.locate(p)), b = to.jet(to.locate(p));
        worst = std::max(
            {worst, (a.x - b.x).norm(), (a.x_u - b.x_u).norm() / 10, (a.x_v - b.x_v).norm() / 10});
      }
    CHECK(worst < 1e-12);
  }
}

TEST_CASE("surfaces transferred to the same mesh, and cubics, stay unchanged", "[fem][transfer]") {
  for (const auto kind : kBothElements) {
    const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(5, 3));
    const Surface any = random_surface(mesh, kind);
    const SurfaceTransfer same = interpolate_onto(any, *mesh);
    CHECK(same.dofs == any.dofs());
    CHECK(same.max_displacement == 0);
    // The same triangles with other numbers: edge normals may change their sign.
    std::vector<Vec2> vertices(mesh->vertices().rbegin(), mesh->vertices().rend());
    auto triangles = mesh->triangles();
    for (auto& t : triangles)
      for (int& v : t) v = mesh->vertex_count() - 1 - v;
    const auto turned = std::make_shared<ParametricMesh>(vertices, triangles);
    const Surface again(turned, kind, interpolate_onto(any, *turned).dofs);
    for (int t = 0; t < mesh->triangle_count(); ++t)
      CHECK((again.position({t, {0.2, 0.5, 0.3}}) - any.position({t, {0.2, 0.5, 0.3}})).norm() <
            1e-14);
    const Surface cubic = interpolated(mesh, kind, [](const Vec2& p) {
      const double u = p.x(), v = p.y();
      return SurfaceJet{
          {u, v, u * u * v - v * v * v}, {1, 0, 2 * u * v}, {0, 1, u * u - 3 * v * v}, {}, {}, {}};
    });
    const auto fine = bisected(*mesh, random_marks(*mesh, 7)).mesh;
    CHECK(interpolate_onto(cubic, fine).max_displacement < 1e-13);
  }
}

TEST_CASE("inside, a carried surface moves by the fourth power of the size", "[fem][transfer]") {
  for (const auto kind : kBothElements) {
    double before = 0;
    for (const int n : {8, 16, 32}) {
      const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(n, 3));
      const auto fine = bisected(*mesh, std::vector<char>(mesh->triangle_count(), 1)).mesh;
      const double moved = interpolate_onto(interpolated(mesh, kind, wave), fine).max_displacement;
      CHECK(moved > 0);
      if (before > 0) CHECK(before / moved > 11);
      before = moved;
    }
  }
}

TEST_CASE("the reported displacement is the actual one", "[fem][transfer]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(4, 3));
  const Surface from = random_surface(mesh, TriangleElement::HCT);
  const auto fine = std::make_shared<ParametricMesh>(bisected(*mesh, random_marks(*mesh, 9)).mesh);
  const SurfaceTransfer carried = interpolate_onto(from, *fine);
  const Surface to(fine, TriangleElement::HCT, carried.dofs);
  double largest = 0;
  Random random(3);
  for (int i = 0; i < 4000; ++i) {
    const Vec2 p(random.between(0, 1), random.between(0, 1));
    largest = std::max(largest, (from.position(from.locate(p)) - to.position(to.locate(p))).norm());
  }
  CHECK(carried.max_displacement > 0.7 * largest);
  CHECK(carried.max_displacement < 1.1 * largest);
}

TEST_CASE("a tube is carried around its seam, on any number of threads", "[fem][transfer]") {
  // 6 × 3 squares around, u from 0 to 6.
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i < 6; ++i) vertices.emplace_back(i, j);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 6; ++i) {
      const int a = 6 * j + i, b = 6 * j + (i + 1) % 6;
      triangles.push_back({a, b, b + 6});
      triangles.push_back({a, b + 6, a + 6});
    }
  const auto tube = std::make_shared<ParametricMesh>(vertices, triangles, 6.0);
  const Surface from = random_surface(tube, TriangleElement::HCT);
  const auto fine = bisected(*tube, random_marks(*tube, 2)).mesh;
  CHECK((interpolate_onto(from, *tube).dofs - from.dofs()).cwiseAbs().maxCoeff() < 1e-12);
  const ThreadGuard one(1);
  const SurfaceTransfer carried = interpolate_onto(from, fine);
  set_thread_count(2);
  const SurfaceTransfer again = interpolate_onto(from, fine);
  CHECK(carried.dofs == again.dofs);
  CHECK(carried.max_displacement == again.max_displacement);
}
