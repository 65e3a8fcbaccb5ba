// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/refinement.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

double distance(const TriangleShape& shape, const Vec2& p) {
  if (shape.barycentric(p).minCoeff() >= 0) return 0;
  double nearest = 1e300;
  for (size_t i = 0; i < 3; ++i) {
    const Vec2 a = shape.vertex[i], d = shape.vertex[(i + 1) % 3] - a;
    const double s = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + s * d - p).norm());
  }
  return nearest;
}

// Brute force over all triangles: the first one that contains p, or the closest one.
void check_located(const ParametricMesh& mesh, const TriangleLocator& locator, const Vec2& p) {
  double nearest = 1e300;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    nearest = std::min(nearest, distance(mesh.shape(t), p));
  const Location where = locator.locate(p);
  REQUIRE(where.triangle >= 0);
  REQUIRE(where.triangle < mesh.triangle_count());
  INFO("p " << p.transpose() << " found " << where.triangle << " L " << where.L.transpose());
  CHECK(where.L.minCoeff() >= 0);
  CHECK(where.L.sum() == Approx(1).epsilon(1e-15));
  const double away = (mesh.shape(where.triangle).point(where.L) - p).norm();
  CHECK(away <= nearest * (1 + 1e-12) + 1e-13);
  if (nearest == 0)
    for (int t = 0; t < where.triangle; ++t)
      CHECK(mesh.shape(t).barycentric(p).minCoeff() < 0);  // none with a lower number contains it
}

std::vector<ParametricMesh> meshes() {
  std::vector<ParametricMesh> all{ParametricMesh::unit_square(1), ParametricMesh::unit_square(7),
                                  perturbed_square(9, 3)};
  // Graded by a factor of a thousand, and with a hole.
  ParametricMesh graded = perturbed_square(4, 5);
  for (int round = 0; round < 18; ++round) {
    std::vector<char> marked;
    for (int t = 0; t < graded.triangle_count(); ++t)
      marked.push_back(distance(graded.shape(t), {0.31, 0.62}) == 0);
    graded = bisected(graded, marked).mesh;
  }
  all.push_back(graded);
  std::vector<int> ring;
  const ParametricMesh square = perturbed_square(10, 6);
  for (int t = 0; t < square.triangle_count(); ++t)
    if ((square.shape(t).point(Vec3::Constant(1 / 3.)) - Vec2(0.5, 0.5)).norm() > 0.3)
      ring.push_back(t);
  all.push_back(extract_submesh(square, ring).mesh);
  // A strip a hundred times as long as wide, and one triangle.
  std::vector<Vec2> strip;
  const ParametricMesh six = perturbed_square(6, 2);
  for (const Vec2& p : six.vertices()) strip.emplace_back(-3 + p.x(), 40 + 0.01 * p.y());
  all.emplace_back(strip, six.triangles());
  // Only its ends: nothing in the middle.
  std::vector<int> ends;
  for (int t = 0; t < six.triangle_count(); ++t)
    if (std::abs(six.shape(t).point(Vec3::Constant(1 / 3.)).x() - 0.5) > 0.35) ends.push_back(t);
  all.push_back(extract_submesh(all.back(), ends).mesh);
  all.push_back(ParametricMesh({{5, 5}, {6, 5.2}, {5.1, 7}}, {{0, 1, 2}}));
  return all;
}

}  // namespace

TEST_CASE("every point is found in the triangle that holds it, others at the nearest point",
          "[fem][locator]") {
  Random random(31);
  for (const ParametricMesh& mesh : meshes()) {
    const TriangleLocator locator(mesh);
    Vec2 low = mesh.vertices()[0], high = low;
    for (const Vec2& p : mesh.vertices()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Vec2 centre = 0.5 * (low + high), half = 0.5 * (high - low);
    for (const double reach : {1.0, 1.5, 20.0})
      for (int i = 0; i < 400; ++i) {
        const double a = random(), b = random();
        check_located(mesh, locator, centre + reach * Vec2(a * half.x(), b * half.y()));
      }
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const Vec3 L = (random.point().array() + 1.01) / 6;
      const Vec2 p = mesh.shape(t).point(L / L.sum());
      const Location where = locator.locate(p);
      CHECK(where.triangle == t);
      CHECK((where.L - L / L.sum()).norm() < 1e-10);
    }
    check_located(mesh, locator, {1e6, -1e6});
    check_located(mesh, locator, {-1e6, centre.y()});
  }
}

TEST_CASE("on an edge or vertex the triangle of lowest number is returned", "[fem][locator]") {
  for (const ParametricMesh& mesh : meshes()) {
    const TriangleLocator locator(mesh);
    std::vector<int> lowest(mesh.vertex_count(), -1);
    for (int t = mesh.triangle_count() - 1; t >= 0; --t)
      for (const int v : mesh.triangles()[t]) lowest[v] = t;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Location where = locator.locate(mesh.vertices()[v]);
      CHECK(where.triangle == lowest[v]);
      CHECK(where.L.maxCoeff() > 1 - 1e-9);
    }
    for (const auto& edge : mesh.edges())
      for (const double s : {0.5, 0.3, 0.9}) {
        const Vec2 p = (1 - s) * mesh.vertices()[edge.low] + s * mesh.vertices()[edge.high];
        const Location where = locator.locate(p);
        const int first =
            edge.boundary() ? edge.triangle[0] : std::min(edge.triangle[0], edge.triangle[1]);
        // Rounding may put p slightly outside one of them, or both.
        if (mesh.shape(first).barycentric(p).minCoeff() >= -5e-14)
          CHECK(where.triangle == first);
        else
          CHECK((where.triangle == first || where.triangle == edge.triangle[0] ||
                 where.triangle == edge.triangle[1]));
        CHECK((mesh.shape(where.triangle).point(where.L) - p).norm() < 1e-13 * (1 + p.norm()));
      }
  }
}

TEST_CASE("triangles near a box are all whose boxes meet it", "[fem][locator]") {
  Random random(37);
  for (const ParametricMesh& mesh : meshes()) {
    const TriangleLocator locator(mesh);
    for (int i = 0; i < 50; ++i) {
      const Vec2 low = mesh.vertices()[static_cast<size_t>(i) % mesh.vertices().size()] +
                       0.1 * Vec2(random(), random());
      const Vec2 high = low + 0.2 * Vec2(random.between(0, 1), random.between(0, 1));
      const auto found = locator.near(low, high);
      CHECK(std::is_sorted(found.begin(), found.end()));
      CHECK(std::adjacent_find(found.begin(), found.end()) == found.end());
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        Vec2 a = mesh.shape(t).vertex[0], b = a;
        for (const Vec2& p : mesh.shape(t).vertex) {
          a = a.cwiseMin(p);
          b = b.cwiseMax(p);
        }
        const bool meets = (a - high).maxCoeff() <= 0 && (low - b).maxCoeff() <= 0;
        if (meets) CHECK(std::binary_search(found.begin(), found.end(), t));
      }
    }
  }
}

TEST_CASE("on a tube u comes around, whichever side of the seam an element is placed on",
          "[fem][locator]") {
  const int n = 6;
  const double period = 2;
  // The seam on a line of edges, and through elements whose first vertex is left or right of it.
  for (const double start : {0.0, 0.1, 0.3})
    for (const bool left_first : {true, false}) {
      std::vector<Vec2> vertices;
      std::vector<ParametricMesh::Triangle> triangles;
      for (int j = 0; j <= 3; ++j)
        for (int i = 0; i < n; ++i) vertices.emplace_back(start + period * i / n, j / 3.0);
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < n; ++i) {
          const int a = j * n + i, b = j * n + (i + 1) % n;
          if (left_first) {
            triangles.push_back({a, b, b + n});
            triangles.push_back({a, b + n, a + n});
          } else {
            triangles.push_back({b, b + n, a});
            triangles.push_back({b + n, a + n, a});
          }
        }
      const ParametricMesh tube(vertices, triangles, period);
      const TriangleLocator locator(tube);
      Random random(3);
      for (int i = 0; i < 500; ++i) {
        const Vec2 p(random.between(-5, 5), random.between(-0.2, 1.2));
        const Location where = locator.locate(p);
        const Vec2 found = tube.shape(where.triangle).point(where.L);
        INFO("start " << start << " left first " << left_first << " p " << p.transpose());
        CHECK(std::abs(std::remainder(found.x() - p.x(), period)) < 1e-12);
        CHECK(std::abs(found.y() - std::clamp(p.y(), 0.0, 1.0)) < 1e-12);
      }
      std::vector<int> lowest(tube.vertex_count(), -1);
      for (int t = tube.triangle_count() - 1; t >= 0; --t)
        for (const int v : tube.triangles()[t]) lowest[v] = t;
      for (int v = 0; v < tube.vertex_count(); ++v)
        CHECK(locator.locate(tube.vertices()[v]).triangle == lowest[v]);
    }
}
