// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fem/surface_projector.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

struct Draws : Random {
  using Random::Random;
  Location location(const ParametricMesh& mesh) {
    Vec3 L(between(0, 1), between(0, 1), between(0, 1));
    return {static_cast<int>(engine() % mesh.triangle_count()), L / L.sum()};
  }
};

std::shared_ptr<const ParametricMesh> shared_square(int n, unsigned seed) {
  return std::make_shared<ParametricMesh>(perturbed_square(n, seed));
}

struct Patch {
  Vec3 x, x_u, x_v;
};

// A cylinder of radius 2 and height 3 over 1.2 rad; x_u × x_v points away from its axis.
Patch cylinder(const Vec2& p) {
  const double a = 1.2 * p.x(), c = std::cos(a), s = std::sin(a);
  return {{2 * c, 2 * s, 3 * p.y()}, {-2.4 * s, 2.4 * c, 0}, {0, 0, 3}};
}

// A sphere of radius 3 between longitudes 0 and 1 and latitudes ±0.4, seen from outside.
Patch sphere(const Vec2& p) {
  const double a = p.x(), b = 0.8 * p.y() - 0.4;
  const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
  return {3 * Vec3(ca * cb, sa * cb, sb), 3 * Vec3(-sa * cb, ca * cb, 0),
          2.4 * Vec3(-ca * sb, -sa * sb, cb)};
}

// A saddle that is a polynomial in the space of the elements.
Patch saddle(const Vec2& p) {
  const double u = p.x(), v = p.y();
  return {{u, v, u * u - u * v * v}, {1, 0, 2 * u - v * v}, {0, 1, -2 * u * v}};
}

Surface random_surface(int n, TriangleElement kind, unsigned seed) {
  Draws random(seed);
  return interpolated(shared_square(n, seed), kind, [&](const Vec2& p) {
    return Patch{Vec3(p.x(), p.y(), 0) + 0.03 * random.point(),
                 Vec3(1, 0, 0) + 0.3 * random.point(), Vec3(0, 1, 0) + 0.3 * random.point()};
  });
}

}  // namespace

TEST_CASE("a surface holds polynomials of degree three with all derivatives", "[fem][surface]") {
  Draws random(1);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const Surface surface = interpolated(shared_square(3, 1), kind, saddle);
    for (int trial = 0; trial < 50; ++trial) {
      const Location where = random.location(surface.mesh());
      const Vec2 p = surface.mesh().shape(where.triangle).point(where.L);
      const SurfaceJet j = surface.jet(where);
      const Patch expected = saddle(p);
      CHECK((surface.position(where) - expected.x).norm() < 1e-14);
      CHECK((j.x - expected.x).norm() < 1e-14);
      CHECK((j.x_u - expected.x_u).norm() < 1e-12);
      CHECK((j.x_v - expected.x_v).norm() < 1e-12);
      CHECK((j.x_uu - Vec3(0, 0, 2)).norm() < 1e-10);
      CHECK((j.x_uv - Vec3(0, 0, -2 * p.y())).norm() < 1e-10);
      CHECK((j.x_vv - Vec3(0, 0, -2 * p.x())).norm() < 1e-10);
      CHECK((j.area_vector() - expected.x_u.cross(expected.x_v)).norm() < 1e-12);
      CHECK(std::abs(j.normal().norm() - 1) < 1e-15);
      CHECK(j.normal().dot(j.area_vector()) > 0);
      CHECK(j.normal().cross(j.area_vector()).norm() < 1e-15 * 10);
    }
  }
}

TEST_CASE("a jet is the derivative of positions, by central differences", "[fem][surface]") {
  constexpr double step = 1e-6;
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const Surface surface = random_surface(3, kind, 2);
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      const TriangleShape shape = surface.mesh().shape(t);
      const Vec3 L(0.5, 0.2, 0.3);
      const auto at = [&](double u, double v) {
        return surface.jet({t, shape.barycentric(shape.point(L) + Vec2(u, v))});
      };
      const SurfaceJet j = at(0, 0), right = at(step, 0), left = at(-step, 0), up = at(0, step),
                       down = at(0, -step);
      CHECK(((right.x - left.x) / (2 * step) - j.x_u).norm() < 1e-8);
      CHECK(((up.x - down.x) / (2 * step) - j.x_v).norm() < 1e-8);
      CHECK(((right.x_u - left.x_u) / (2 * step) - j.x_uu).norm() < 1e-6);
      CHECK(((right.x_v - left.x_v) / (2 * step) - j.x_uv).norm() < 1e-6);
      CHECK(((up.x_v - down.x_v) / (2 * step) - j.x_vv).norm() < 1e-6);
    }
  }
}

TEST_CASE("points of a surface by its Bezier ordinates are the surface's", "[fem][surface]") {
  for (const auto kind : {TriangleElement::HCT, TriangleElement::Z12}) {
    const Surface surface = random_surface(4, kind, 7);
    const SurfaceEvaluator points(surface);
    Draws random(8);
    for (int i = 0; i < 200; ++i) {
      const Location where = random.location(surface.mesh());
      CHECK((points.position(where) - surface.position(where)).norm() < 1e-14);
      const Vec2 uv(random.between(0, 1), random.between(0, 1));
      CHECK((points.position(uv) - surface.position(points.locate(uv))).norm() < 1e-14);
    }
    for (const int i : {0, 1, 2})
      CHECK((points.position(Location{3, Vec3::Unit(i)}) - surface.position({3, Vec3::Unit(i)}))
                .norm() < 1e-14);
  }
}

TEST_CASE("an area vector is that of the jet", "[fem][surface]") {
  for (const auto kind : {TriangleElement::HCT, TriangleElement::Z12}) {
    const Surface surface = random_surface(4, kind, 7);
    Draws random(8);
    for (int i = 0; i < 200; ++i) {
      const Location where = random.location(surface.mesh());
      const Vec3 area = surface.jet(where).area_vector();
      CHECK((surface.area_vector(where) - area).norm() <= 1e-13 * area.norm());
    }
  }
}

TEST_CASE("a surface is C1 across every edge of its mesh", "[fem][surface]") {
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const Surface surface = random_surface(4, kind, 3);
    double worst = 0;
    for (const auto& edge : surface.mesh().edges()) {
      if (edge.boundary()) continue;
      for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
        SurfaceJet side[2];
        for (int k = 0; k < 2; ++k) {
          const auto& v = surface.mesh().triangles()[edge.triangle[k]];
          Vec3 L = Vec3::Zero();
          for (int i = 0; i < 3; ++i) L[i] = v[i] == edge.low ? 1 - s : v[i] == edge.high ? s : 0;
          side[k] = surface.jet({edge.triangle[k], L});
        }
        worst = std::max({worst, (side[0].x - side[1].x).norm(), (side[0].x_u - side[1].x_u).norm(),
                          (side[0].x_v - side[1].x_v).norm()});
      }
    }
    CHECK(worst < 1e-12);
  }
}

TEST_CASE("curvatures are those of the second fundamental form, with the sign of the normal",
          "[fem][surface]") {
  const SurfaceJet bowl{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {0, 0, 0}, {0, 0, 0.5}};
  const Curvatures c = curvatures(bowl);  // bends towards its normal +z
  CHECK(c.k1 == Approx(2));
  CHECK(c.k2 == Approx(0.5));
  CHECK(c.mean == Approx(1.25));
  CHECK(c.gauss == Approx(1));
  // Neither a new parametrisation nor its orientation changes |mean| and Gauss.
  const double a = 1.3, b = 0.4, d = -0.2, e = 0.9;
  SurfaceJet other;
  other.x = bowl.x;
  other.x_u = a * bowl.x_u + b * bowl.x_v;
  other.x_v = d * bowl.x_u + e * bowl.x_v;
  other.x_uu = a * a * bowl.x_uu + 2 * a * b * bowl.x_uv + b * b * bowl.x_vv + Vec3(3, 1, 0);
  other.x_uv = a * d * bowl.x_uu + (a * e + b * d) * bowl.x_uv + b * e * bowl.x_vv;
  other.x_vv = d * d * bowl.x_uu + 2 * d * e * bowl.x_uv + e * e * bowl.x_vv;
  CHECK(curvatures(other).mean == Approx(1.25));
  CHECK(curvatures(other).gauss == Approx(1));
  std::swap(other.x_u, other.x_v);
  std::swap(other.x_uu, other.x_vv);
  CHECK(curvatures(other).mean == Approx(-1.25));
  CHECK(curvatures(other).gauss == Approx(1));
  // At a singular point there is no curvature, and no NaN.
  const SurfaceJet singular{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  CHECK(curvatures(singular).mean == 0);
  CHECK(singular.normal() == Vec3::Zero());
}

TEST_CASE("interpolated cylinders and spheres converge: area, curvature, recovered curvature",
          "[fem][surface]") {
  struct Case {
    const char* name;
    Patch (*patch)(const Vec2&);
    double mean, gauss, area;
  };
  const Case cases[] = {
      {"cylinder", cylinder, -0.25, 0, 2 * 1.2 * 3},
      {"sphere", sphere, -1.0 / 3, 1.0 / 9, 9 * 2 * std::sin(0.4)},
  };
  for (const auto kind : kBothElements)
    for (const Case& c : cases) {
      INFO(name(kind) << ", " << c.name);
      double area_before = 0, curvature_before = 0, recovered_before = 0;
      auto mesh = shared_square(4, 5);
      for (int level = 0; level < 3; ++level) {
        if (level > 0) mesh = std::make_shared<ParametricMesh>(mesh->refined());
        const Surface surface = interpolated(mesh, kind, c.patch);
        const double area = std::abs(surface.area() - c.area);
        double curvature = 0, recovered = 0;
        for (int t = 0; t < surface.mesh().triangle_count(); ++t)
          for (int sub = 0; sub < 3; ++sub) {
            Vec3 L = Vec3::Constant(4.0 / 9);
            L[sub] = 1.0 / 9;
            const Curvatures k = curvatures(surface.jet({t, L}));
            curvature =
                std::max({curvature, std::abs(k.mean - c.mean), std::abs(k.gauss - c.gauss)});
            CHECK(k.mean == Approx(0.5 * (k.k1 + k.k2)));
            CHECK(k.k1 >= k.k2);
          }
        const auto field = recovered_curvatures(surface, tessellate(surface.mesh(), 2));
        for (const Curvatures& k : field) {
          recovered = std::max({recovered, std::abs(k.mean - c.mean), std::abs(k.gauss - c.gauss)});
          CHECK(k.mean == Approx(0.5 * (k.k1 + k.k2)).margin(1e-12));
          CHECK(k.k1 >= k.k2);
        }
        if (level > 0) {
          CHECK(std::log2(area_before / area) > 3.5);
          CHECK(std::log2(curvature_before / curvature) > 1.7);
          CHECK(std::log2(recovered_before / recovered) > 1.7);
        }
        area_before = area;
        curvature_before = curvature;
        recovered_before = recovered;
      }
      CHECK(area_before < 1e-5 * c.area);
      CHECK(recovered_before < 1e-2);
    }
}

TEST_CASE("locate finds every point of the domain, and the nearest triangle outside",
          "[fem][surface]") {
  const auto mesh = shared_square(5, 6);
  const Surface surface = interpolated(mesh, TriangleElement::HCT, saddle);
  Draws random(6);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec2 uv(random.between(0, 1), random.between(0, 1));
    const Location where = surface.locate(uv);
    CHECK(where.L.minCoeff() >= 0);
    CHECK((mesh->shape(where.triangle).point(where.L) - uv).norm() < 1e-14);
  }
  for (const Vec2& uv : mesh->vertices())
    CHECK((mesh->shape(surface.locate(uv).triangle).point(surface.locate(uv).L) - uv).norm() <
          1e-14);
  // Outside: the triangle with the closest point of the (convex) domain.
  int wrong = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec2 uv(random.between(-0.5, 1.5), random.between(-0.5, 1.5));
    const Vec2 nearest = uv.cwiseMax(0).cwiseMin(1);
    const Location where = surface.locate(uv);
    CHECK(where.L.minCoeff() >= 0);
    CHECK(std::abs(where.L.sum() - 1) < 1e-14);
    wrong += mesh->shape(where.triangle).barycentric(nearest).minCoeff() < -1e-12;
  }
  CHECK(wrong == 0);
}

namespace {

// Smallest distance by search: a lattice of every triangle, refined around its best points.
double distance_by_search(const Surface& surface, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::pair<double, Location>> starts;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    std::pair<double, Location> here{std::numeric_limits<double>::infinity(), {}};
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; i + j <= 8; ++j) {
        const Location where{t, Vec3(i, j, 8 - i - j) / 8};
        if (const double d = (surface.position(where) - p).norm(); d < here.first)
          here = {d, where};
      }
    starts.push_back(here);
  }
  std::sort(starts.begin(), starts.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  const size_t count = std::min<size_t>(10, starts.size());
  for (size_t s = 0; s < count; ++s) {
    // Pattern search along the triangle's six directions.
    auto [distance, where] = starts[s];
    for (double step = 1.0 / 8; step > 1e-9;) {
      bool moved = false;
      for (int from = 0; from < 3; ++from)
        for (int to = 0; to < 3; ++to) {
          const double shift = std::min(step, where.L[from]);
          if (from == to || shift <= 0) continue;
          Location next = where;
          next.L[from] -= shift;
          next.L[to] += shift;
          const double d = (surface.position(next) - p).norm();
          if (d >= distance) continue;
          distance = d;
          where = next;
          moved = true;
        }
      if (!moved) step /= 2;
    }
    best = std::min(best, distance);
  }
  return best;
}

}  // namespace

// A sheet with random bumps of a fifth of its size, without folds inside elements.
Surface bumpy_surface(int n, TriangleElement kind, unsigned seed) {
  const Surface random = random_surface(n, kind, seed);
  const auto flat = [](const Vec2& p) { return Patch{{p.x(), p.y(), 0}, {1, 0, 0}, {0, 1, 0}}; };
  const Surface sheet = interpolated(random.shared_mesh(), kind, flat);
  return {random.shared_mesh(), kind, sheet.dofs() + 0.2 * random.dofs()};
}

TEST_CASE("the closest point of a surface is the closest point", "[fem][surface]") {
  Draws random(7);
  for (const auto kind : kBothElements) {
    const Surface surfaces[] = {interpolated(shared_square(4, 7), kind, cylinder),
                                bumpy_surface(3, kind, 8)};
    for (const Surface& surface : surfaces) {
      const Vec3 middle = surface.position(surface.locate({0.5, 0.5}));
      double excess = 0, on_surface = 0;
      for (int trial = 0; trial < 40; ++trial) {
        const Vec3 p = middle + 1.5 * random.point();
        const auto closest = surface.closest_point(p);
        CHECK(closest.where.L.minCoeff() >= 0);
        CHECK(std::abs((surface.position(closest.where) - p).norm() - closest.distance) < 1e-14);
        excess = std::max(excess, closest.distance - distance_by_search(surface, p));

        const Vec3 q = surface.position(random.location(surface.mesh()));
        on_surface = std::max(on_surface, surface.closest_point(q).distance);
      }
      INFO(name(kind) << ", " << surface.mesh().triangle_count() << " triangles");
      CHECK(excess < 1e-9);
      CHECK(on_surface < 1e-12);
    }
  }
}

TEST_CASE("points beside the boundary and near vertices have their closest points too",
          "[fem][surface]") {
  const auto flat = [](const Vec2& p) { return Patch{{p.x(), p.y(), 0}, {1, 0, 0}, {0, 1, 0}}; };
  Draws random(9);
  const Surface surface = interpolated(shared_square(4, 9), TriangleElement::HCT, flat);
  double worst = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 p(random.between(-0.5, 1.5), random.between(-0.5, 1.5), random());
    const Vec3 nearest(std::clamp(p.x(), 0.0, 1.0), std::clamp(p.y(), 0.0, 1.0), 0);
    worst = std::max(worst, surface.closest_point(p).distance - (p - nearest).norm());
  }
  CHECK(worst < 1e-12);
  worst = 0;
  for (const Vec2& v : surface.mesh().vertices())
    for (int trial = 0; trial < 10; ++trial) {
      const Vec2 uv = (v + 0.03 * Vec2(random(), random())).cwiseMax(0).cwiseMin(1);
      worst = std::max(worst, surface.closest_point({uv.x(), uv.y(), 0}).distance);
    }
  CHECK(worst < 1e-12);
}

TEST_CASE("the evaluation operator is evaluation", "[fem][surface]") {
  Draws random(10);
  for (const auto kind : kBothElements) {
    INFO(name(kind));
    const Surface surface = random_surface(3, kind, 11);
    std::vector<Location> points;
    for (int i = 0; i < 20; ++i) points.push_back(random.location(surface.mesh()));
    for (int v = 0; v < 3; ++v) points.push_back({2, Vec3::Unit(v)});
    MatX values[kDerivatives];
    for (int d = 0; d < kDerivatives; ++d) {
      const SparseMatrix E =
          evaluation_operator(surface.mesh(), kind, points, static_cast<Derivative>(d));
      REQUIRE(E.rows() == static_cast<long>(points.size()));
      REQUIRE(E.cols() == surface.dof_map().count());
      values[d] = E * surface.dofs();
    }
    for (long p = 0; p < values[0].rows(); ++p) {
      const SurfaceJet j = surface.jet(points[p]);
      const Vec3 expected[kDerivatives] = {j.x, j.x_u, j.x_v, j.x_uu, j.x_uv, j.x_vv};
      for (int d = 0; d < kDerivatives; ++d)
        CHECK((values[d].row(p).transpose() - expected[d]).norm() <
              1e-13 * (1 + expected[d].norm()));
    }
    // At a vertex the position depends on that vertex alone.
    const SparseMatrix at_vertex = evaluation_operator(surface.mesh(), kind, {{0, Vec3::Unit(1)}});
    const int dof = surface.dof_map().vertex(surface.mesh().triangles()[0][1]);
    for (int d = 0; d < surface.dof_map().count(); ++d)
      CHECK(std::abs(at_vertex.coeff(0, d) - (d == dof ? 1 : 0)) < 1e-15);
  }
}

TEST_CASE("a tessellation is watertight, oriented, and covers the domain", "[fem][surface]") {
  const auto mesh = shared_square(4, 12);
  const Surface plane = interpolated(mesh, TriangleElement::HCT, [](const Vec2& p) {
    return Patch{{p.x(), p.y(), 0}, {1, 0, 0}, {0, 1, 0}};
  });
  int boundary_edges = 0;
  for (const auto& e : mesh->edges()) boundary_edges += e.boundary();
  for (const int n : {1, 2, 3, 5}) {
    INFO("n = " << n);
    const Tessellation t = tessellate(*mesh, n);
    REQUIRE(t.facets.size() == static_cast<size_t>(n) * n * mesh->triangle_count());
    REQUIRE(t.facet_triangle.size() == t.facets.size());
    // Each vertex, edge and inner lattice point once.
    CHECK(static_cast<int>(t.points.size()) == mesh->vertex_count() + (n - 1) * mesh->edge_count() +
                                                   (n - 1) * (n - 2) / 2 * mesh->triangle_count());
    std::vector<Vec2> uv;
    for (const Location& p : t.points) uv.push_back(mesh->shape(p.triangle).point(p.L));
    for (int v = 0; v < mesh->vertex_count(); ++v)
      CHECK((uv[v] - mesh->vertices()[v]).norm() < 1e-15);

    std::map<std::pair<int, int>, int> directed;
    double area = 0;
    bool inside = true, oriented = true;
    for (size_t f = 0; f < t.facets.size(); ++f) {
      const auto& facet = t.facets[f];
      const TriangleShape shape = mesh->shape(t.facet_triangle[f]);
      for (int i = 0; i < 3; ++i) {
        ++directed[{facet[i], facet[(i + 1) % 3]}];
        inside = inside && shape.barycentric(uv[facet[i]]).minCoeff() > -1e-12;
      }
      const Vec2 a = uv[facet[1]] - uv[facet[0]], b = uv[facet[2]] - uv[facet[0]];
      const double twice = a.x() * b.y() - a.y() * b.x();
      oriented = oriented && std::abs(twice / 2 - shape.area / (n * n)) < 1e-14;
      area += twice / 2;
    }
    CHECK(inside);
    CHECK(oriented);
    CHECK(std::abs(area - 1) < 1e-13);
    CHECK(std::abs(plane.area() - 1) < 1e-13);
    int once = 0, twice = 0;
    for (const auto& [edge, count] : directed) {
      CHECK(count == 1);
      const bool opposite = directed.count({edge.second, edge.first}) > 0;
      once += !opposite;
      twice += opposite;
    }
    CHECK(once == n * boundary_edges);
    CHECK((once + twice) == 3 * static_cast<int>(t.facets.size()));
  }
  CHECK_THROWS_AS(tessellate(*mesh, 0), InputError);
}

TEST_CASE("facets converge to the surface's area", "[fem][surface]") {
  const Surface surface = interpolated(shared_square(3, 13), TriangleElement::HCT, sphere);
  double before = 0;
  for (const int n : {2, 4, 8}) {
    const Tessellation t = tessellate(surface.mesh(), n);
    double area = 0;
    for (const auto& f : t.facets) {
      const Vec3 a = surface.position(t.points[f[0]]), b = surface.position(t.points[f[1]]),
                 c = surface.position(t.points[f[2]]);
      area += 0.5 * (b - a).cross(c - a).norm();
    }
    const double error = surface.area() - area;
    CHECK(error > 0);
    if (before > 0) CHECK(std::log2(before / error) == Approx(2).margin(0.1));
    before = error;
  }
}

TEST_CASE("a surface shares its mesh with its copies and refuses dofs of another mesh",
          "[fem][surface]") {
  const Surface surface = random_surface(2, TriangleElement::Z12, 14);
  const Surface copy = surface;
  CHECK(&copy.mesh() == &surface.mesh());
  CHECK(copy.kind() == TriangleElement::Z12);
  const auto map = surface.dof_map().triangle(surface.mesh(), 3);
  for (int a = 0; a < 12; ++a) CHECK(surface.triangle_dofs(3).row(a) == surface.dofs().row(map[a]));
  CHECK_THROWS_AS(Surface(surface.shared_mesh(), TriangleElement::HCT, Points::Zero(7, 3)),
                  InputError);
}

namespace {

// The disc of radius 0.4 around (0.5, 0.5) with an eccentric hole, cut from n×n squares: a part of
// the surface over them. The reference is the same disc on a grid twice as fine.
Surface cut_disc(int n, Patch (*patch)(const Vec2&)) {
  const DomainLoops loops({{circle({0.5, 0.5}, 0.4, 32)}, {circle({0.6, 0.45}, 0.1, 16, true)}});
  const EmbeddedGrid grid(squares({0.01, -0.02}, 1.0 / n, n, n + 1), loops);
  const Surface plain = interpolated(grid.mesh, TriangleElement::HCT, patch);
  return {grid.mesh, plain.kind(), plain.dofs(), grid.trim};
}

}  // namespace

TEST_CASE("the area of a trimmed surface is that inside of its loops", "[fem][surface]") {
  const auto flat = [](const Vec2& p) { return Patch{{p.x(), p.y(), 0}, {1, 0, 0}, {0, 1, 0}}; };
  const Surface plane = cut_disc(9, flat);
  CHECK(plane.area() == Approx(plane.trim()->loops().area()).epsilon(1e-12));
  // The cylinder's area is 7.2 times that in (u, v); the sphere's is proportional to the cosine of
  // the latitude.
  const auto error = [](int n) {
    const Surface surface = cut_disc(n, cylinder);
    return std::abs(surface.area() - 7.2 * surface.trim()->loops().area());
  };
  const double coarse = error(4), fine = error(8);
  CHECK(coarse < 1e-3);
  CHECK(std::log2(coarse / fine) > 3.2);
}

TEST_CASE("the closest point of a trimmed surface lies inside or on its loops", "[fem][surface]") {
  const auto flat = [](const Vec2& p) { return Patch{{p.x(), p.y(), 0}, {1, 0, 0}, {0, 1, 0}}; };
  const Surface plane = cut_disc(9, flat);
  Draws random(30);
  double worst = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 p(random.between(0, 1.1), random.between(0, 1.1), 0.3 * random());
    const Vec2 q = p.head<2>();
    // Cubics approximate circles to 1e-7.
    double in_plane = std::max(0.0, (q - Vec2(0.5, 0.5)).norm() - 0.4);
    in_plane = std::max(in_plane, 0.1 - (q - Vec2(0.6, 0.45)).norm());
    const auto closest = plane.closest_point(p);
    CHECK(closest.where.L.minCoeff() >= 0);
    CHECK(std::abs((plane.position(closest.where) - p).norm() - closest.distance) < 1e-14);
    worst = std::max(worst, std::abs(closest.distance - std::hypot(in_plane, p.z())));
  }
  CHECK(worst < 2e-6);

  // A curved one: no inner sample is closer, and its own points are found.
  const Surface bent = cut_disc(6, cylinder);
  double excess = -1, on_surface = 0;
  std::vector<Vec3> samples;
  for (int t = 0; t < bent.mesh().triangle_count(); ++t) {
    const TriangleRule rule = bent.trim()->rule(t, 4);
    for (long k = 0; k < rule.weights.size(); ++k)
      samples.push_back(bent.position({t, rule.L.row(k).transpose()}));
  }
  for (int trial = 0; trial < 60; ++trial) {
    const Vec3 p = Vec3(1.7, 1, 1.5) + 1.5 * random.point();
    const auto closest = bent.closest_point(p);
    for (const Vec3& s : samples) excess = std::max(excess, closest.distance - (s - p).norm());
    const Vec2 uv = bent.mesh().shape(closest.where.triangle).point(closest.where.L);
    const double out =
        std::max((uv - Vec2(0.5, 0.5)).norm() - 0.4, 0.1 - (uv - Vec2(0.6, 0.45)).norm());
    CHECK(out < 1e-5);
    on_surface =
        std::max(on_surface, bent.closest_point(samples[trial * 7 % samples.size()]).distance);
  }
  CHECK(excess < 1e-12);
  CHECK(on_surface < 1e-9);
}

TEST_CASE("elements outside of a trim do not reach the recovered curvatures inside",
          "[fem][surface]") {
  const Surface plain = cut_disc(16, sphere);
  // Values where only slivers are inside are meaningless.
  std::vector<double> share(plain.mesh().vertex_count(), 0);
  for (int t = 0; t < plain.mesh().triangle_count(); ++t)
    for (const int v : plain.mesh().triangles()[t])
      share[v] = std::max(share[v], plain.trim()->area_fraction(t));
  Points dofs = plain.dofs();
  int spoilt = 0;
  for (int v = 0; v < plain.mesh().vertex_count(); ++v)
    if (share[v] < 1e-2) {
      dofs.row(3 * v) += Vec3(0.01, 0.02, 0.01);
      ++spoilt;
    }
  REQUIRE(spoilt > 0);
  const Surface surface(plain.shared_mesh(), plain.kind(), dofs, plain.trim());
  Tessellation points;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    if (surface.trim()->side(t) != Trim::Side::Outside) {
      const TriangleRule rule = surface.trim()->rule(t, 2);
      for (long k = 0; k < rule.weights.size(); ++k)
        points.points.push_back({t, rule.L.row(k).transpose()});
    }
  double worst = 0;
  for (const Curvatures& c : recovered_curvatures(surface, points))
    worst = std::max(worst, std::abs(c.mean + 1.0 / 3));
  CHECK(worst < 0.03);
}
