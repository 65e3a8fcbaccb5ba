// SPDX-License-Identifier: MPL-2.0
#include <map>
#include <set>

#include "batten/fem/refinement.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

double area(const ParametricMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) sum += mesh.shape(t).area;
  return sum;
}

std::array<double, 3> angles(const TriangleShape& shape) {
  std::array<double, 3> found{};
  for (size_t i = 0; i < 3; ++i) {
    const Vec2 a = shape.vertex[(i + 1) % 3] - shape.vertex[i],
               b = shape.vertex[(i + 2) % 3] - shape.vertex[i];
    found[i] = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return found;
}

double smallest_angle(const ParametricMesh& mesh) {
  double smallest = pi;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const double a : angles(mesh.shape(t))) smallest = std::min(smallest, a);
  return smallest;
}

double boundary_length(const ParametricMesh& mesh) {
  double sum = 0;
  for (int e = 0; e < mesh.edge_count(); ++e)
    if (mesh.edges()[e].boundary()) sum += mesh.edge_length(e);
  return sum;
}

using Corners = std::set<std::pair<double, double>>;
Corners corners(const TriangleShape& shape) {
  Corners found;
  for (const Vec2& p : shape.vertex) found.insert({p.x(), p.y()});
  return found;
}

// Invariants of every bisection.
void check_bisection(const ParametricMesh& mesh, const std::vector<char>& marked,
                     const Bisection& b) {
  // Conforming: the length of the boundary is unchanged, so there are no hanging nodes.
  CHECK(area(b.mesh) == Approx(area(mesh)).epsilon(1e-13));
  CHECK(boundary_length(b.mesh) == Approx(boundary_length(mesh)).epsilon(1e-13));
  CHECK(b.mesh.vertex_count() - b.mesh.edge_count() + b.mesh.triangle_count() ==
        mesh.vertex_count() - mesh.edge_count() + mesh.triangle_count());
  bool kept = true;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    kept = kept && b.mesh.vertices()[v] == mesh.vertices()[v];
  CHECK(kept);
  REQUIRE(b.midpoint.size() == static_cast<size_t>(mesh.edge_count()));
  int next = mesh.vertex_count();
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const int m = b.midpoint[static_cast<size_t>(e)];
    if (m < 0) {
      CHECK(b.mesh.edge_between(edge.low, edge.high) >= 0);
      continue;
    }
    CHECK(m == next++);
    CHECK(b.mesh.edge_between(edge.low, edge.high) < 0);
    CHECK(b.mesh.edge_between(edge.low, m) >= 0);
    CHECK(b.mesh.edge_between(edge.high, m) >= 0);
    const Vec2 middle = 0.5 * (mesh.vertices()[edge.low] + mesh.vertices()[edge.high]);
    CHECK((b.mesh.vertices()[m] - middle).norm() < 1e-15);
  }
  CHECK(next == b.mesh.vertex_count());
  // Marked triangles are bisected, others keep their positions and order.
  int at = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape whole = mesh.shape(t);
    double covered = 0;
    int pieces = 0;
    while (at < b.mesh.triangle_count() && covered < (1 - 1e-9) * whole.area) {
      const TriangleShape piece = b.mesh.shape(at++);
      ++pieces;
      covered += piece.area;
      CHECK(whole.barycentric(piece.point(Vec3::Constant(1 / 3.))).minCoeff() > 0);
    }
    CHECK(covered == Approx(whole.area).epsilon(1e-12));
    CHECK(pieces <= 4);
    if (marked[static_cast<size_t>(t)]) CHECK(pieces >= 2);
    if (pieces == 1) CHECK(b.mesh.triangles()[at - 1] == mesh.triangles()[t]);
    int halved = 0;
    for (const int e : mesh.edges_of(t)) halved += b.midpoint[static_cast<size_t>(e)] >= 0;
    CHECK(pieces == halved + 1);
  }
  CHECK(at == b.mesh.triangle_count());
}

std::vector<char> near(const ParametricMesh& mesh, const Vec2& p, double distance) {
  std::vector<char> marked;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    const Vec3 L = shape.barycentric(p);
    marked.push_back(L.minCoeff() > -1e-9 ||
                     (shape.point(Vec3::Constant(1 / 3.)) - p).norm() < distance);
  }
  return marked;
}

}  // namespace

TEST_CASE("bisection conforms, covers the same, and divides what was marked", "[fem][bisection]") {
  Random random(4);
  for (unsigned trial = 0; trial < 40; ++trial) {
    ParametricMesh mesh = trial % 2 ? perturbed_square(5, trial) : ParametricMesh::unit_square(4);
    for (int round = 0; round < 4; ++round) {
      std::vector<char> marked;
      const double share = random.between(0, 1);
      for (int t = 0; t < mesh.triangle_count(); ++t)
        marked.push_back(random.between(0, 1) < share * share * share);
      INFO("trial " << trial << " round " << round);
      Bisection b = bisected(mesh, marked);
      check_bisection(mesh, marked, b);
      mesh = b.mesh;
    }
  }
}

TEST_CASE("nothing marked changes nothing, a wrong count is refused", "[fem][bisection]") {
  const ParametricMesh mesh = perturbed_square(3, 1);
  const Bisection same = bisected(mesh, std::vector<char>(18, 0));
  CHECK(same.mesh.triangles() == mesh.triangles());
  CHECK(same.mesh.vertices() == mesh.vertices());
  CHECK(same.midpoint == std::vector<int>(mesh.edge_count(), -1));
  CHECK(error_message([&] { bisected(mesh, std::vector<char>(17, 0)); }) ==
        "found 17 refinement marks for 18 triangles, expected one for each");
}

TEST_CASE("all marked twice: right isosceles triangles in four of half the size",
          "[fem][bisection]") {
  ParametricMesh mesh = squares({-1, -1}, 0.25, 8, 8);
  for (int round = 1; round <= 6; ++round) {
    mesh = bisected(mesh, std::vector<char>(mesh.triangle_count(), 1)).mesh;
    CHECK(mesh.triangle_count() == 128 << round);
    CHECK(smallest_angle(mesh) == Approx(pi / 4).epsilon(1e-12));
  }
}

TEST_CASE("right isosceles triangles stay so, and a point draws few triangles a round",
          "[fem][bisection]") {
  // On a vertex, on an edge, and inside an element.
  for (const Vec2& p : {Vec2(0, 0), Vec2(0.1, 0), Vec2(0.1, 0.1), Vec2(0.137, 0.061)}) {
    ParametricMesh mesh = squares({-1, -1}, 0.25, 8, 8);
    for (int round = 0; round < 12; ++round) {
      const auto marked = near(mesh, p, 0);
      const Bisection b = bisected(mesh, marked);
      check_bisection(mesh, marked, b);
      mesh = b.mesh;
      INFO("p " << p.transpose() << " round " << round);
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        auto a = angles(mesh.shape(t));
        std::sort(a.begin(), a.end());
        CHECK(a[0] == Approx(pi / 4).epsilon(1e-9));
        CHECK(a[2] == Approx(pi / 2).epsilon(1e-9));
      }
    }
    // 12 bisections of 1/32, only close to the point: O(log of the size).
    CHECK(mesh.triangle_count() <= 128 + 12 * 16);
    const TriangleLocator locator(mesh);
    CHECK(mesh.shape(locator.locate(p).triangle).area == Approx(std::ldexp(1, -17)).epsilon(1e-9));
    CHECK(mesh.shape(locator.locate({-0.9, -0.9}).triangle).area > 1 / 65.);
  }
}

TEST_CASE("angles stay above half of the smallest, however often", "[fem][bisection]") {
  for (unsigned trial = 0; trial < 12; ++trial) {
    Random random(trial);
    ParametricMesh mesh = perturbed_square(4 + trial % 3, trial);
    if (trial % 3 == 2) {  // stretched: worse triangles
      std::vector<Vec2> vertices = mesh.vertices();
      for (Vec2& p : vertices) p.x() += 0.7 * p.y();
      mesh = ParametricMesh(vertices, mesh.triangles());
    }
    const double bound = 0.5 * smallest_angle(mesh);
    const Vec2 p(random.between(0.3, 1), random.between(0.1, 0.9));
    for (int round = 0; round < 14; ++round) {
      auto marked = near(mesh, p, std::pow(0.7, round));
      for (char& m : marked) m = m || random() > 0.95;
      mesh = bisected(mesh, marked).mesh;
      INFO("trial " << trial << " round " << round);
      CHECK(smallest_angle(mesh) >= bound - 1e-9);
    }
  }
}

TEST_CASE("equal lengths: neighbours agree, whatever the rounding", "[fem][bisection]") {
  // Equilateral triangles rotated and translated, so that lengths differ only in their last bits.
  std::vector<int> first;
  for (const double angle : {0., 0.3, 1.1}) {
    const double c = std::cos(angle), s = std::sin(angle);
    std::vector<Vec2> vertices;
    std::vector<ParametricMesh::Triangle> triangles;
    const int n = 6;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double u = i + 0.5 * j, v = std::sqrt(3.) / 2 * j;
        vertices.emplace_back(100 + c * u - s * v, -70 + s * u + c * v);
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i;
        triangles.push_back({a, a + 1, a + n + 1});
        triangles.push_back({a + 1, a + n + 2, a + n + 1});
      }
    ParametricMesh mesh(vertices, triangles);
    std::vector<char> marked(mesh.triangle_count(), 0);
    marked[2 * (3 * n + 3)] = 1;
    const Bisection b = bisected(mesh, marked);
    if (first.empty()) first = b.midpoint;
    CHECK(b.midpoint == first);
    CHECK(std::count_if(first.begin(), first.end(), [](int m) { return m >= 0; }) <= 12);
    for (int round = 0; round < 5; ++round)
      mesh = bisected(mesh, near(mesh, {100 + 3 * c, -70 + 3 * s}, 0.5)).mesh;
    CHECK(smallest_angle(mesh) >= pi / 6 - 1e-9);
    CHECK(mesh.triangle_count() < 400);
  }
}

TEST_CASE("of equal edges the two triangles beside one choose the same", "[fem][bisection]") {
  const double w = std::sqrt(3.) / 2;
  const std::vector<Vec2> vertices{{0, 0}, {w, -0.5}, {w, 0.5}, {2 * w, 0}};
  // The shared edge is the first that the mesh numbers, wherever it is in the second triangle.
  for (const ParametricMesh::Triangle& second :
       {ParametricMesh::Triangle{1, 3, 2}, {2, 1, 3}, {3, 2, 1}}) {
    const ParametricMesh mesh(vertices, {{0, 1, 2}, second});
    for (const std::vector<char>& marked : {std::vector<char>{1, 0}, {0, 1}, {1, 1}}) {
      const Bisection b = bisected(mesh, marked);
      CHECK(b.mesh.triangle_count() == 4);
      CHECK(b.mesh.vertex_count() == 5);
    }
  }
}

TEST_CASE("bisection does not know where the mesh lies, nor its unit", "[fem][bisection]") {
  const ParametricMesh mesh = ParametricMesh::unit_square(4);
  std::vector<Vec2> moved;
  for (const Vec2& p : mesh.vertices()) moved.emplace_back(1000 * p + Vec2(137.3, -1e4));
  ParametricMesh a = mesh, b(moved, mesh.triangles());
  for (int round = 0; round < 6; ++round) {
    const auto marked = near(a, {0.3, 0.4}, 0.2);
    a = bisected(a, marked).mesh;
    b = bisected(b, marked).mesh;
    CHECK(a.triangles() == b.triangles());
  }
}

TEST_CASE("a tube is halved around its seam", "[fem][bisection]") {
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  const int n = 6;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i < n; ++i) vertices.emplace_back(2.0 * i / n, j / 3.0);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * n + i, b = j * n + (i + 1) % n;
      triangles.push_back({a, b, b + n});
      triangles.push_back({a, b + n, a + n});
    }
  ParametricMesh tube(vertices, triangles, 2);
  for (int round = 0; round < 4; ++round) {
    tube = bisected(tube, near(tube, {2, 0.5}, 0.4)).mesh;
    CHECK(tube.period() == 2);
    CHECK(area(tube) == Approx(2).epsilon(1e-13));
    CHECK(boundary_length(tube) == Approx(4).epsilon(1e-13));
    CHECK(tube.vertex_count() - tube.edge_count() + tube.triangle_count() == 0);
  }
  std::vector<int> lower;
  for (int t = 0; t < tube.triangle_count(); ++t)
    if (tube.shape(t).point(Vec3::Constant(1 / 3.)).y() < 1 / 3.) lower.push_back(t);
  const Submesh part = extract_submesh(tube, lower);
  CHECK(part.mesh.period() == 2);
  CHECK(area(part.mesh) == Approx(2 / 3.).epsilon(1e-12));
}

TEST_CASE("a part of a mesh keeps its triangles and the order of its vertices",
          "[fem][bisection]") {
  const ParametricMesh mesh = perturbed_square(4, 9);
  const std::vector<int> wanted{9, 2, 3, 17, 30};
  const Submesh part = extract_submesh(mesh, wanted);
  REQUIRE(part.mesh.triangle_count() == 5);
  REQUIRE(part.vertex.size() == static_cast<size_t>(mesh.vertex_count()));
  int next = 0;
  for (const int v : part.vertex)
    if (v >= 0) CHECK(v == next++);
  CHECK(next == part.mesh.vertex_count());
  for (int t = 0; t < 5; ++t) {
    for (size_t i = 0; i < 3; ++i) {
      const int old = mesh.triangles()[wanted[static_cast<size_t>(t)]][i];
      CHECK(part.mesh.triangles()[t][i] == part.vertex[static_cast<size_t>(old)]);
    }
    CHECK(corners(part.mesh.shape(t)) == corners(mesh.shape(wanted[static_cast<size_t>(t)])));
  }
  const Submesh all = extract_submesh(mesh, [&] {
    std::vector<int> numbers;
    for (int t = 0; t < mesh.triangle_count(); ++t) numbers.push_back(t);
    return numbers;
  }());
  CHECK(all.mesh.vertices() == mesh.vertices());
  CHECK(all.mesh.triangles() == mesh.triangles());
}
